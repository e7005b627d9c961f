"""The published tables: the pipeline once for every data set, training seed and temperature, then one door that pools them.

Each run is a workspace of its own beside this one (`workspace.py`) with other parameters: `publish.data` of params.yaml says
which. They share DVC's cache, so what two of them have in common (the corpus, models that only the measured data set tells
apart) is computed once, and a run that was interrupted goes on where it was. Real recordings are looked for in one folder;
data sets that are not there are left out, and the tables say so.
"""

import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from prefect import flow, get_run_logger
from prefect.artifacts import create_table_artifact
from prefect.states import Completed, Failed

from flows import pipeline, workspace
from flows.experiment import RUNNER, submit
from flows.provenance import Times, note_code

ROOMS = Path(".drivegen/tables")
PUBLISHED = Path("reports/published")

MEASURED = ("evaluate", "evaluate_rival", "evaluate_baseline", "goals", "train_selector", "train_planner", "train_generator")
"""Stages whose results the tables show; what they need is run, too."""

ALL, MAPS = PARTS = ("all", "maps")
"""What can be asked for: the paper's tables, or those of single pieces, maps from words first."""

PIECES = "pieces"
"""The workspace of the second part."""

OF_PIECES = ("map_suite", "map_diversity", "initial_states", "asked")
"""Stages that measure nothing but a piece; they are in a file of their own, `pipeline.MEASURES`."""

FRONT = ("evaluate",)
"""Those of a run at another temperature."""


@dataclass(frozen=True)
class Room:
    """One run: `<data set>/<what varies>`, the parameters by which it differs from params.yaml, and what is wanted of it."""

    name: str
    params: dict[str, Any]
    measured: tuple[str, ...]


@flow(name="tables", task_runner=RUNNER)  # type: ignore[arg-type]  # Prefect's own generics disagree
def tables(real: Path, part: str = ALL) -> Any:
    """Run every room of a part and pool them into reports/published; `real` is the folder of real recordings."""
    values = yaml.safe_load(Path("params.yaml").read_text())
    rows: list[dict[str, str]] = []
    done: list[Room] = []
    wanted = [pieces(values["publish_maps"])] if part == MAPS else rooms(values["publish"], real.resolve())
    for room in wanted:
        rows.append({"run": room.name, "why": _bring_up(room, done)})
        done.append(room)
        if rows[-1]["why"]:
            break
    create_table_artifact(rows, key="tables", description="Runs behind the published tables")
    if failed := [f"{row['run']}: {row['why']}" for row in rows if row["why"]]:
        return Failed(message="; ".join(failed))
    if part == MAPS:
        pipeline.run_door("publish_maps", [ROOMS / PIECES / "reports", PUBLISHED], get_run_logger().info)
    else:
        pipeline.run_door("publish", [ROOMS, PUBLISHED], get_run_logger().info)
    return Completed(message=f"{PUBLISHED} from {len(rows)} runs")


def pieces(publish: dict[str, Any]) -> Room:
    """The run that measures single pieces: maps and traffic from words, placement, planners and selectors that nothing uses."""
    return Room(PIECES, publish["params"], (*OF_PIECES, "train_planner", "goals"))


def rooms(publish: dict[str, Any], real: Path) -> Iterator[Room]:
    """Every data set that is there with every training seed, then DriveGen alone at other temperatures with the first seed."""
    data_sets = publish["data"]
    if isinstance(data_sets, str):  # the name of a file stands for what is in it
        data_sets = yaml.safe_load(Path(data_sets).read_text())
    for name, data in data_sets.items():
        folder = real / data["folder"]
        if data["folder"] and not folder.is_dir():
            continue
        params = {**publish["params"], **data["params"]}
        if data["folder"]:
            params |= {key: _placed(value, str(folder)) for key, value in data["folders"].items()}
        for seed in publish["seeds"]:
            yield Room(f"{name}/{seed}", {**params, "run.training_seed": seed}, MEASURED)
        for temperature in publish["temperatures"] if data["front"] else ():
            alone = {"run.own": ["drivegen"], "rollout.generation.temperature": temperature}
            yield Room(f"{name}/t{temperature}", {**params, "run.training_seed": publish["seeds"][0], **alone}, FRONT)


def _placed(value: Any, folder: str) -> Any:
    """`value` with the folder of real recordings where it says FOLDER, one level deep."""
    if isinstance(value, dict):
        return {key: _placed(item, folder) for key, item in value.items()}
    return folder if value == "FOLDER" else value


def nearest(room: Room, done: list[Room]) -> Room | None:
    """Of the rooms that are done with everything the last one with the same training seed, else the last one."""
    complete = [other for other in done if other.measured == MEASURED]
    alike = [other for other in complete if other.params["run.training_seed"] == room.params["run.training_seed"]]
    return next(reversed(alike or complete), None)


def _bring_up(room: Room, done: list[Room]) -> str:
    """Run what the room's tables need; "" if it went well, else what failed. Its workspace is made anew, its cache is not.

    It begins with what the nearest room made, so that stages which both share need not even be asked for, and with all code
    that was compiled before. What its tables do not need is neither there nor in its dvc.lock. Of the workspace that was there
    the times stay of what is the same.
    """
    root = ROOMS / room.name
    times = Times.of(root)
    shutil.rmtree(root, ignore_errors=True)
    workspace.duplicate(Path(), root, room.params)
    note_code(Path(), root)
    if like := nearest(room, done):
        shutil.copy2(ROOMS / like.name / "dvc.lock", root / "dvc.lock")
        workspace.share_compiled(ROOMS / done[-1].name, root)
    pipeline.restore(root)
    plan = pipeline.read(root, measures=room.name == PIECES)
    wanted = [stage for stage in plan.needs if stage.rpartition(":")[2].partition("@")[0] in room.measured]
    needed = {name for stage in wanted for name in (*plan.upstream(stage), stage)}
    stale, idle = needed & plan.stale, set(plan.needs) - needed
    pipeline.discard((stale & set(wanted)) | idle, root)  # a run that is stopped must not be pooled with another's figures
    pipeline.forget_all_but(needed, root)
    get_run_logger().info("%s: %d stages, %d to run", room.name, len(needed), len(stale))
    futures = submit(plan, stale, root)
    for future in futures.values():
        future.wait()
    times.put_back(root)
    ended = [future.state for future in futures.values() if not future.state.is_completed()]
    return "; ".join(str(state.message) for state in ended if not state.is_pending())  # those behind a failed one wait for ever
