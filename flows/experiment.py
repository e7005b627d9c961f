"""All tables: one Prefect task per DVC stage that is out of date, in the order of DVC's graph, independent ones at once.

Stages that are up to date are rows of the table and no tasks: a task costs the server a quarter of a CPU-second.
"""

import time
from collections.abc import Collection
from pathlib import Path
from typing import Any
from uuid import UUID

from prefect import flow, get_run_logger
from prefect.artifacts import create_progress_artifact, create_table_artifact, update_progress_artifact
from prefect.client.schemas.objects import State
from prefect.futures import PrefectFuture, as_completed
from prefect.states import Completed, Failed
from prefect.task_runners import ThreadPoolTaskRunner

from flows import FlowFailed, pipeline, workspace
from flows.bring_up import by_a_sentence, run_stage


def stages_at_once(params: Path) -> int:
    """`run.stages` of the file `params`; each may itself use `run.workers` processes. Raises FlowFailed if it is no count."""
    stages = (workspace.read_yaml(params).get("run") or {}).get("stages")
    if not isinstance(stages, int) or stages < 1:
        raise FlowFailed(f"{params}: run.stages is {stages!r}: say how many stages run at once, 1 or more")
    return stages


RUNNER: ThreadPoolTaskRunner[Any] = ThreadPoolTaskRunner(max_workers=stages_at_once(Path(__file__).parent.parent / "params.yaml"))


@flow(name="experiment", task_runner=RUNNER)  # type: ignore[arg-type]  # Prefect's own generics disagree
@by_a_sentence
def experiment() -> State[list[dict[str, str]]]:
    """Bring every stage of dvc.yaml up to date; records one row a stage. Fails, naming them, if stages do."""
    began = time.monotonic()
    if gone := pipeline.discard_gone():
        get_run_logger().info("params.yaml names these no longer, their outputs are removed: %s", ", ".join(gone))
    plan = pipeline.read()
    get_run_logger().info(
        "%d stages, %d to run (asked DVC in %.1f s)", len(plan.needs), len(plan.stale), time.monotonic() - began
    )
    futures = submit(plan, plan.stale)
    _follow(list(futures.values()))
    rows = [_row(stage, futures.get(stage)) for stage in plan.needs]
    create_table_artifact(rows, key="stages", description="Every stage of dvc.yaml, in running order")
    failed = [row["why"] for row in rows if row["state"] == "Failed"]
    if failed:
        return Failed(message="; ".join(failed))
    return Completed(data=rows, message=f"{len(rows)} stages, {sum(row['state'] == 'Cached' for row in rows)} unchanged")


def submit(plan: pipeline.Pipeline, stages: Collection[str], root: Path = Path()) -> dict[str, PrefectFuture[Any]]:
    """Start `stages` of the workspace `root` in the plan's order, each as soon as those it needs are done."""
    futures: dict[str, PrefectFuture[Any]] = {}
    for stage in plan.needs:
        if stage in stages:
            behind = [futures[name] for name in plan.needs[stage] if name in futures]
            futures[stage] = run_stage.submit(stage, root, wait_for=behind, return_state=False)
    return futures


def _follow(futures: list[PrefectFuture[Any]]) -> None:
    """Keep a progress artifact while the stages run."""
    progress = create_progress_artifact(0.0, key="progress", description="Stages done")
    assert isinstance(progress, UUID)  # a coroutine only where a loop runs
    for done, _ in enumerate(as_completed(futures), 1):
        update_progress_artifact(progress, 100.0 * done / len(futures))


def _row(stage: str, future: PrefectFuture[Any] | None) -> dict[str, str]:
    """What became of a stage, without a future of one that was up to date. Those behind a failed one end as NotReady."""
    if future is None:
        return {"stage": stage, "state": "Cached", "seconds": "0.0", "why": ""}
    future.wait()
    state = future.state
    seconds = f"{future.result():.1f}" if state.is_completed() else ""
    return {"stage": stage, "state": str(state.name), "seconds": seconds, "why": state.message or ""}
