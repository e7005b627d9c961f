"""What is known of a scenario when its traffic begins: nothing that its log shows later reaches who makes futures of it."""

from dataclasses import replace

import numpy as np

from drivegen.core.scenario import DT, Actors, Scenario, Signals, SignalState, Trajectories


def first_frame(scenario: Scenario) -> Scenario:
    """The scenario as its first frame shows it: map and vehicles, no log, and of the rest what can be assumed.

    Signals show their state at step 0 and are UNKNOWN from then on (see `Signals.held`). Context actors that are there go
    on at their velocity, whoever stands stays; those that come later are left out.
    """
    return replace(scenario, log=None, context=_going_on(scenario.context), signals=_shown_now(scenario.signals))


def _shown_now(signals: Signals) -> Signals:
    state = np.full_like(signals.state, SignalState.UNKNOWN)
    state[:, :1] = signals.state[:, :1]
    return Signals(signals.lane, state)


def _going_on(actors: Actors) -> Actors:
    there = actors.motion.valid[:, 0]
    return Actors(actors.track_id[there], actors.kind[there], actors.size[there], at_constant_velocity(actors.motion[there]))


def at_constant_velocity(motion: Trajectories) -> Trajectories:
    """(..., T) from the states at step 0 on, along a line each, headings kept; valid throughout."""
    time = (np.arange(motion.steps) * DT).astype(np.float32)[:, None]
    velocity = np.broadcast_to(motion.velocity[..., :1, :], motion.velocity.shape)
    return Trajectories(
        motion.position[..., :1, :] + velocity * time,
        np.repeat(motion.heading[..., :1], motion.steps, axis=-1),
        velocity.copy(),
        np.ones_like(motion.valid),
    )
