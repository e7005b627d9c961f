"""Corner cases until no gain: one round after another, stopping when the driver's collision rate stops rising.

The rounds are stages of dvc.yaml (`corner@0`, `corner@1`, ...), each built on what the one before it found, so they
are cached like any stage; only whether to go on is decided here.
"""

from prefect import flow, get_run_logger
from prefect.artifacts import create_table_artifact

from flows import FlowFailed, pipeline
from flows.bring_up import bring_up, by_a_sentence

ROUNDS = "corner@"
GAIN = "collision"
"""The number, in each round's metrics, that must rise: the share of runs that end in a collision."""


@flow(name="iterate")
@by_a_sentence
def iterate(min_gain: float = 0.0) -> list[float]:
    """The collision rate of each round that was run; a round follows only if the last raised it by more than `min_gain`."""
    plan = pipeline.read()
    rounds = [stage for stage in plan.needs if stage.startswith(ROUNDS)]
    if not rounds:
        raise FlowFailed(f"dvc.yaml has no stage {ROUNDS}0: list rounds in params.yaml")
    rates: list[float] = []
    done: set[str] = set()
    for stage in rounds:
        for name in plan.up_to(stage):
            if name in plan.stale and name not in done:
                bring_up(name)
            done.add(name)
        rates.append(float(pipeline.metrics(stage)[GAIN]))
        get_run_logger().info("%s: %s %.3f", stage, GAIN, rates[-1])
        if not gains(rates, min_gain):
            break
    rows = [{"round": stage, GAIN: f"{rate:.4f}"} for stage, rate in zip(rounds, rates, strict=False)]
    create_table_artifact(rows, key="rounds", description="Corner-case rounds until no gain")
    return rates


def gains(rates: list[float], min_gain: float) -> bool:
    """Whether another round is worth it: there is nothing to compare yet, or the last one raised the rate enough."""
    return len(rates) < 2 or rates[-1] - rates[-2] > min_gain
