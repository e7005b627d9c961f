"""Two recordings that begin alike and go on otherwise: whoever knows the first frame alone can't tell them apart."""

from dataclasses import asdict, replace

import numpy as np
import orjson

from drivegen.core.scenario import Actors, Scenario, Trajectories, VehicleKind
from drivegen.core.signals import Signals, SignalState


def otherwise(motion: Trajectories) -> Trajectories:
    """(..., T) with the same states at step 0 and others from then on; every third track is lost half-way."""
    time = np.arange(motion.steps, dtype=np.float32)[:, None] * np.float32(0.1)
    push = np.float32([3.0, -2.0])
    later = time > 0
    valid = motion.valid.copy()
    valid[::3, motion.steps // 2 :] = False
    return Trajectories(
        motion.position + push * time**2,
        motion.heading + np.float32(0.2) * time[:, 0],
        motion.velocity + np.where(later, 2 * push * time, 0).astype(np.float32),
        valid,
    )


def with_riders(scenario: Scenario) -> Scenario:
    """`scenario` with a cyclist that rides beside the target and somebody on foot who comes later."""
    assert scenario.log is not None
    beside = scenario.log[:2]
    motion = replace(beside, position=beside.position + np.float32([0.0, 6.0]), valid=beside.valid.copy())
    motion.valid[1, :20] = False
    kind = np.array([VehicleKind.CYCLIST, VehicleKind.PEDESTRIAN], np.uint8)
    return replace(scenario, context=Actors(np.array(["rider", "late"]), kind, np.full((2, 3), 0.8, np.float32), motion))


def other_future(scenario: Scenario) -> Scenario:
    """The same first frame; then everybody moves otherwise, signals change, and nobody comes later."""
    assert scenario.log is not None
    there = scenario.context.motion.valid[:, 0]
    state = scenario.signals.state.copy()
    state[:, 1:] = np.where(state[:, 1:] == SignalState.RED, SignalState.GREEN, SignalState.RED)
    actors = scenario.context
    context = Actors(actors.track_id[there], actors.kind[there], actors.size[there], otherwise(actors.motion[there]))
    return replace(
        scenario, log=otherwise(scenario.log), context=context, signals=Signals(scenario.signals.lane, state.astype(np.uint8))
    )


def bytes_of(scenario: Scenario) -> bytes:
    """All that it holds."""
    return orjson.dumps(asdict(scenario), default=lambda array: array.tolist())
