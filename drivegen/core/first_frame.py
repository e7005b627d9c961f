"""What is known of a scenario when its traffic begins: nothing that its log shows later reaches who makes futures of it."""

from dataclasses import replace

import numpy as np

from drivegen.core.scenario import DT, Actors, Scenario, Trajectories
from drivegen.core.signals import Signals, SignalState

FORESEEN = 2.0
"""[s] for which who moves on foot or bicycle is taken to keep its velocity; for longer it would ride through waiting cars."""

STANDING = 0.5
"""Slower than this [m/s] is standing."""


def first_frame(scenario: Scenario) -> Scenario:
    """The scenario as its first frame shows it: map and vehicles, no log, and of the rest what can be assumed.

    Signals show their state at step 0 and are UNKNOWN from then on (see `Signals.held`). Context actors that are there go
    on for a while (see `going_on`); those that come later are left out.
    """
    now = replace(scenario, log=None, context=_going_on(scenario.context), signals=_shown_now(scenario.signals))
    return replace(now, per_hour=0.0)  # how many others drive on is part of the future


def _shown_now(signals: Signals) -> Signals:
    state = np.full_like(signals.state, SignalState.UNKNOWN)
    state[:, :1] = signals.state[:, :1]
    return Signals(signals.lane, state)


def _going_on(actors: Actors) -> Actors:
    there = actors.motion.valid[:, 0]
    return Actors(actors.track_id[there], actors.kind[there], actors.size[there], going_on(actors.motion[there]))


def going_on(motion: Trajectories) -> Trajectories:
    """(..., T) what is assumed of boxes whose states at step 0 are known.

    Whoever stands stays. Whoever moves keeps velocity and heading for FORESEEN seconds, and is nowhere after that.
    """
    step = np.arange(motion.steps)
    velocity = np.broadcast_to(motion.velocity[..., :1, :], motion.velocity.shape)
    stands = motion.speed[..., :1] < STANDING
    return Trajectories(
        motion.position[..., :1, :] + velocity * (step * DT).astype(np.float32)[:, None],
        np.repeat(motion.heading[..., :1], motion.steps, axis=-1),
        velocity.copy(),
        motion.valid[..., :1] & (stands | (step <= round(FORESEEN / DT))),
    )
