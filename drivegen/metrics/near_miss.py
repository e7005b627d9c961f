"""Near misses of a driven target: how soon it would have run into the box ahead of it, at both their speeds.

Scenes rich in encounters are chosen by the same measure, taken of the logged target: no driver that is tested has a say in it.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import FIRST_SECOND, TARGET, Scenario, Trajectories
from drivegen.metrics.encroachment import post_encroachment
from drivegen.metrics.surroundings import Boxes, surroundings

NEAR = 1.5
"""[s] A time to collision below this is a near miss."""

CLOSE, SOON = 4.0, 5.0
"""[s] A scene is rich in encounters if the logged target's time to collision falls below CLOSE, or if somebody was logged on its
way, coming from another direction, less than SOON before or after it."""


def near_misses(motion: Trajectories, scenarios: Sequence[Scenario], traffic: Sequence[Trajectories]) -> NDArray[np.bool_]:
    """(S,) whether the time to collision of S driven targets (S, T) fell below NEAR after the first second (`surroundings`).

    `traffic` are the motions (N, T) that were replayed around them. Steps after a run's end do not count. Who is
    hit from the side need not have been near anybody ahead: whoever wants collisions, too, adds them.
    """
    return np.array([_near(motion[s], scenario, traffic[s], NEAR) for s, scenario in enumerate(scenarios)], np.bool_)


def rich_in_encounters(scenarios: Sequence[Scenario], logs: Sequence[Trajectories]) -> NDArray[np.bool_]:
    """(S,) whether a scene is rich in encounters, by its log (N, T) alone."""
    return np.array(
        [_near(log[TARGET], scenario, log, CLOSE) or _crosses(log) for scenario, log in zip(scenarios, logs, strict=True)],
        np.bool_,
    )


def _crosses(log: Trajectories) -> bool:
    pairs = (log[[TARGET, other]][np.newaxis] for other in range(TARGET + 1, len(log.valid)))
    return any((post_encroachment(pair, pair.valid)[0] < SOON).any() for pair in pairs)


def _near(target: Trajectories, scenario: Scenario, traffic: Trajectories, within: float) -> bool:
    together = Trajectories.empty(1, len(scenario.vehicles), traffic.steps)
    for name in ("position", "heading", "velocity", "valid"):
        into = getattr(together, name)[0]
        into[:] = getattr(traffic, name)
        into[TARGET] = getattr(target, name)[: traffic.steps]
    context = replace(scenario.context, motion=scenario.context.motion.until(traffic.steps))
    around = surroundings(Boxes.of(together, scenario.vehicles.size, context), 1)
    return bool((around.time_to_collision[0, 0, FIRST_SECOND + 1 :] < within).any())
