"""A stage as a Prefect task, and flows that fail by a sentence; whether a stage is needed is theirs to say."""

import functools
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, ParamSpec

from prefect import get_run_logger, task
from prefect.cache_policies import NO_CACHE
from prefect.client.schemas.objects import State
from prefect.states import Completed, Failed

from flows import FlowFailed, pipeline

P = ParamSpec("P")


def by_a_sentence(flow: Callable[P, Any]) -> Callable[P, Any]:
    """The function of a flow that fails with what is said of a fault, and without a traceback in its log."""

    @functools.wraps(flow)
    def run(*arguments: P.args, **named: P.kwargs) -> Any:
        try:
            return flow(*arguments, **named)
        except (FlowFailed, OSError) as error:
            return Failed(message=str(error))

    return run


def bring_up(stage: str, root: Path = Path()) -> None:
    """Run one stage of the workspace `root` now. Raises StageFailed where it ends with an error."""
    state = run_stage(stage, root, return_state=True)
    if not state.is_completed():
        raise pipeline.StageFailed(str(state.message))


@task(cache_policy=NO_CACHE, task_run_name="{stage}")
def run_stage(stage: str, root: Path = Path()) -> State[float]:
    """One stage of the workspace `root`, its lines in the log; the state is called Cached if its inputs came out unchanged.

    The result is seconds. It fails by a state, for Prefect logs the traceback of whatever a task raises.
    """
    began = time.monotonic()
    try:
        ran = pipeline.reproduce(stage, get_run_logger().info, root)
    except FlowFailed as error:
        return Failed(message=str(error))
    seconds = time.monotonic() - began
    return Completed(data=seconds) if ran else Completed(name="Cached", data=seconds)
