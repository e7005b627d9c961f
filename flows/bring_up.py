"""A stage as a Prefect task, for flows that run one after another; whether it is needed is theirs to say."""

from pathlib import Path

from prefect import get_run_logger, task
from prefect.cache_policies import NO_CACHE

from flows import pipeline


@task(cache_policy=NO_CACHE, task_run_name="{stage}")
def bring_up(stage: str, root: Path = Path()) -> None:
    """Run one stage of the workspace `root`, its lines in the log. Raises StageFailed where it ends with an error."""
    pipeline.reproduce(stage, get_run_logger().info, root)
