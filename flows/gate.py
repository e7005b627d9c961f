"""The release gate: bring what it drives in up to date, drive both drivers, and fail where the new one is worse.

Which drivers is said in stages/params.yaml, section `gate`. The stage is one of stages/dvc.yaml, so nothing is driven again
that has not changed.
"""

from prefect import State, flow, get_run_logger
from prefect.artifacts import create_table_artifact
from prefect.states import Completed, Failed

from flows import FlowFailed, pipeline
from flows.bring_up import bring_up, by_a_sentence

STAGE = f"{pipeline.MEASURES}:gate"
WORSE = "worse"
"""What the record calls a driver that must not be released."""


@flow(name="gate")
@by_a_sentence
def gate() -> State:
    """Completed or, where the new driver is worse, failed, with what is said of it."""
    plan = pipeline.read(measures=True)
    if STAGE not in plan.needs:
        raise FlowFailed(f"{pipeline.MEASURES} has no stage gate")
    for stage in plan.up_to(STAGE):
        if stage in plan.stale:
            bring_up(stage)
    record = pipeline.metrics(STAGE)
    create_table_artifact([record["collisions"]], key="gate", description=record["sentence"])
    get_run_logger().info(record["sentence"])
    state = Failed if record["finding"] == WORSE else Completed
    return state(message=record["sentence"])
