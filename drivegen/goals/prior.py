"""How likely a vehicle is to end at each distance along a route, before any learning: what candidates are spread by.

A mixture for each route: drive freely (towards the limit, slower in bends), keep the present speed, do anything that
dynamics allow, follow the vehicle ahead or stop behind it, stop at a red light or before a junction, stay. It only has
to put candidates where vehicles end; ranking them is the selectors' business.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from math import prod

import numpy as np
from numpy.typing import NDArray

from drivegen.goals.traffic import HALTED, Ahead
from drivegen.roads.line import SPACING, Route
from drivegen.roads.reach import Dynamics, speed_caps, stopping_distance, travelled

FREE, STEADY, FOLLOW, ANY, BEHIND, RED, ENTRY = 0.4, 0.3, 0.3, 0.4, 0.5, 1.0, 0.3
"""Weights of the parts of the mixture; those that stop count only where there is something to stop for."""

COMFORTABLE = 1.3
"""Usual acceleration [m/s2]."""

USUAL_LIMIT = 1.0
"""Share of the limit that vehicles approach."""

HEADWAY = 1.2
"""Time gap to a moving vehicle ahead [s]."""

GAP = 2.5
"""Gap to a standing vehicle ahead [m]."""

STOP_WIDTH = 1.5
"""Standard deviation of where a vehicle stops about a place to stop at [m]."""

CHANGE = 0.06
"""A route counts this much less for each lane change."""


@dataclass(frozen=True)
class Places:
    """Q places along one route where a vehicle may end.

    Attributes:
        s: (Q,) [m]. mass: (Q,) prior weight. cap: (Q,) [m/s] most speed there.
        stop: (Q,) bool places made for stopping (red light, junction, behind a leader).
    """

    s: NDArray[np.float64]
    mass: NDArray[np.float64]
    cap: NDArray[np.float32]
    stop: NDArray[np.bool_]


def places(route: Route, speed: float, ahead: Ahead, dynamics: Dynamics, step: float, seconds: float) -> Places:
    """Places every `step` [m] on `route` that can be reached in `seconds` from `speed` [m/s], with their prior mass."""
    caps = speed_caps(route, speed, dynamics)
    usual = np.minimum(caps, np.maximum(caps * USUAL_LIMIT / dynamics.limit_factor, 1.0))
    nearest = stopping_distance(speed, dynamics.braking, seconds)
    farthest = travelled(caps, speed, dynamics.acceleration, dynamics.braking, seconds)
    farthest = max(min(farthest, route.length), nearest)
    free = travelled(usual, speed, COMFORTABLE, dynamics.braking, seconds)
    steady = travelled(caps, speed, 0.0, dynamics.braking, seconds)
    stops = [(s, w) for s, w in _stops(ahead) if nearest <= s <= farthest]
    s = np.concatenate([np.arange(nearest, farthest + step / 2, step), [s for s, _ in stops]])
    ways = _ways(free, steady, ahead, seconds)
    middle, width = np.array([way[1:] for way in ways] + [(place, STOP_WIDTH) for place, _ in stops]).T[..., None]
    bells = np.exp(-0.5 * ((s - middle) / width) ** 2) / (width * np.sqrt(2 * np.pi))
    density = np.zeros(len(s))
    for (weight, _, _), bell in zip(ways, bells, strict=False):
        density += weight * bell
    mass = density * step + ANY * step / max(farthest - nearest, step)
    for (_, weight), bell in zip(stops, bells[len(ways) :], strict=True):
        mass += weight * step * bell
    at = np.minimum((s / SPACING).astype(int), len(caps) - 1)
    kind = np.arange(len(s)) >= len(s) - len(stops)
    return Places(s, mass, caps[at], kind)


def shares(routes: Sequence[Route]) -> list[float]:
    """Prior of each route: halved (thirded, ...) wherever ways part, so that a way is worth no more for forking later.

    Routes are compared with those of as many lane changes; each lane change costs the factor CHANGE.
    """
    branch_of: dict[tuple[int, int], int] = {}  # of a tree, by the branch before and the lane
    onward: Counter[int] = Counter()
    forks = []
    for route in routes:
        branch, passed = -1 - route.lane_changes, []
        for lane in route.lanes:
            if (branch, lane) not in branch_of:
                branch_of[branch, lane] = len(branch_of)
                onward[branch] += 1
            branch = branch_of[branch, lane]
            passed.append(branch)
        forks.append(passed[:-1])
    return [
        CHANGE**route.lane_changes / prod(onward[branch] for branch in passed)
        for route, passed in zip(routes, forks, strict=True)
    ]


def _stops(ahead: Ahead) -> list[tuple[float, float]]:
    """Where the vehicle may stop, with weights."""
    behind = max(ahead.leader_gap - GAP, 0.0)
    halts = [(behind, BEHIND)] if ahead.leader_speed < HALTED else []
    return [*halts, (ahead.red_s, RED), (ahead.entry_s, ENTRY)]


def _ways(free: float, steady: float, ahead: Ahead, seconds: float) -> list[tuple[float, float, float]]:
    """Weight, middle, width [m] of the densities of who does not stop: at the present speed, behind the leader, freely."""
    ways = [(STEADY, steady, 3.0 + 0.06 * steady)]
    if np.isfinite(ahead.leader_gap):
        spare = ahead.leader_gap - GAP - HEADWAY * ahead.leader_speed
        following = max(ahead.leader_speed * seconds + 0.5 * spare, 0.0)
        ways.append((FOLLOW, following, 3.0 + 0.06 * following))
        free = min(free, 0.5 * (following + free))
    return [*ways, (FREE, free, 3.0 + 0.12 * free)]
