"""The published tables: the pipeline once for every run of a part (`rooms.py`), then one door that pools them.

Each run is a workspace of its own beside this one (`workspace.py`) with other parameters. They share DVC's cache, so what two
of them have in common (the corpus, models that only the measured data set or the sampling seed tells apart) is computed
once, and a run that was interrupted goes on where it was.
"""

import shutil
from pathlib import Path
from typing import Any

from prefect import flow, get_run_logger
from prefect.artifacts import create_table_artifact
from prefect.states import Completed, Failed

from flows import pipeline, workspace
from flows.bring_up import by_a_sentence
from flows.experiment import RUNNER, submit
from flows.provenance import Times, note_code
from flows.rooms import DOORS, MEASURED, QUALITY, ROOMS, Room, left_out, rooms

PUBLISHED = Path("reports/published")


@flow(name="tables", task_runner=RUNNER)  # type: ignore[arg-type]  # Prefect's own generics disagree
@by_a_sentence
def tables(real: Path, part: str = QUALITY) -> Any:
    """Run every room of a part and pool them into reports/published; `real` is the folder of real recordings."""
    rows: list[dict[str, str]] = []
    done: list[Room] = []
    with workspace.alone(f"tables-{part}"):
        values = workspace.read_yaml(Path("params.yaml"))
        for room in rooms(part, values, real.resolve()):
            rows.append({"run": room.name, "why": _bring_up(room, done)})
            done.append(room)
            if rows[-1]["why"]:
                break
        create_table_artifact(rows, key="tables", description="Runs behind the published tables")
        if failed := [f"{row['run']}: {row['why']}" for row in rows if row["why"]]:
            return Failed(message="; ".join(failed))
        for results in list(left_out(part, values, real)):  # DVC's cache keeps them for when their data set is there again
            shutil.rmtree(results)
        door, finished = DOORS[part]
        pipeline.run_door(door, [finished, PUBLISHED], get_run_logger().info)
    return Completed(message=f"{PUBLISHED} from {len(rows)} runs")


def nearest(room: Room, done: list[Room]) -> Room | None:
    """Of the rooms that are done with everything the last one with the same training seed, else the last one."""
    complete = [other for other in done if other.measured == MEASURED]
    alike = [other for other in complete if other.params["run.training_seed"] == room.params["run.training_seed"]]
    return next(reversed(alike or complete), None)


def _bring_up(room: Room, done: list[Room]) -> str:
    """Run the stages that the room's tables need; returns "" if all succeeded, else what failed.

    The workspace is deleted and made again; DVC's cache and the checkpoints of interrupted trainings stay. It starts from the
    outputs of the nearest room, so stages that both share are not run again, and from all code compiled so far. Other stages are
    neither in it nor in its dvc.lock.
    Recorded times are carried over for every output that has not changed.
    """
    root = ROOMS / room.name
    times = Times.of(root)
    times.keep(root)
    workspace.renew(Path(), root, room.params)
    note_code(Path(), root)
    if like := nearest(room, done):
        shutil.copy2(ROOMS / like.name / "dvc.lock", root / "dvc.lock")
    if done:
        workspace.share_compiled(ROOMS / done[-1].name, root)
    pipeline.restore(root)
    plan = pipeline.read(root, measures=True)
    measuring = [stage for stage in plan.needs if stage.rpartition(":")[2].partition("@")[0] in room.measured]
    needed = {name for stage in measuring for name in plan.up_to(stage)}
    stale, idle = needed & plan.stale, set(plan.needs) - needed
    pipeline.discard((stale & set(measuring)) | idle, root)  # a run that is stopped must not be pooled with another's figures
    pipeline.forget_all_but(needed, root)
    get_run_logger().info("%s: %d stages, %d to run", room.name, len(needed), len(stale))
    futures = submit(plan, stale, root)
    try:
        for future in futures.values():
            future.wait()
    finally:  # also of a run that is stopped: what it has made is not timed again either
        times.put_back(root)
        workspace.bring_home(root, Path())  # the rooms to come need not pay for it again
    ended = [future.state for future in futures.values() if not future.state.is_completed()]
    return "; ".join(str(state.message) for state in ended if not state.is_pending())  # those behind a failed one wait for ever
