"""Whose fault a collision is, by nuPlan's classes, and how fast the two met.

Source: nuPlan devkit, `no_ego_at_fault_collisions`: a target that runs into somebody with its front, or into somebody who stands,
is at fault; one that touches another sideways is, where it is not within one lane and those connected with it; one that
stands or is run into from behind is not. Its thresholds are kept.
"""

from collections.abc import Sequence
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import Floats, box_corners, boxes_overlap, unit
from drivegen.core.roadmap import RoadMap
from drivegen.core.scenario import TARGET, Scenario, Trajectories
from drivegen.roads.graph import LaneGraph
from drivegen.world.replay import Replay

STOPPED = 0.05
"""Slower than this [m/s] a vehicle stands."""

BEHIND = np.deg2rad(150)
"""Whose centre is seen from the target's rear axle at more than this angle from its heading is behind it."""

REAR_AXLE = 0.28
"""The rear axle is this share of the length behind the centre."""

BUMPER = 0.05
"""The front bumper is a box of this length [m]."""

IN_LANE = 2.0
"""A corner this near to a lane's centreline [m] is in that lane."""


class Contact(IntEnum):
    """nuPlan's types of collisions."""

    NONE = 0
    STOPPED_EGO = 1
    STOPPED_TRACK = 2
    ACTIVE_FRONT = 3
    ACTIVE_REAR = 4
    ACTIVE_LATERAL = 5


def contact_of(target: Trajectories, size: Floats, others: Replay, s: int, t: int, m: int) -> Contact:
    """The type of the collision of one target (T,) of `size` (2,) with other number m of scene s at step t."""
    position, heading = target.position[t], target.heading[t]
    if target.speed[t] <= STOPPED:
        return Contact.STOPPED_EGO
    if np.hypot(*others.frame[s, t, 4:, m]) <= STOPPED:
        return Contact.STOPPED_TRACK
    forward = unit(heading)
    gap = others.position[s, t, m] - (position - REAR_AXLE * size[0] * forward)
    if np.cos(BEHIND) * np.hypot(*gap) > gap @ forward:
        return Contact.ACTIVE_REAR
    bumper = position + 0.5 * (size[0] - BUMPER) * forward
    touches = boxes_overlap(
        bumper, heading, np.array([BUMPER, size[1]]), others.position[s, t, m], others.heading[s, t, m], others.size[s, m]
    )
    return Contact.ACTIVE_FRONT if touches else Contact.ACTIVE_LATERAL


def at_fault(contact: Contact, scenario: Scenario, position: Floats, heading: Floats) -> bool:
    """Whether the target of a scenario, at `position` (2,) and `heading`, is at fault for a contact."""
    if contact != Contact.ACTIVE_LATERAL:
        return contact in (Contact.STOPPED_TRACK, Contact.ACTIVE_FRONT)
    length, width, _ = scenario.vehicles.size[TARGET]
    return not within_lane(scenario.map, box_corners(position, heading, length, width))


def within_lane(road_map: RoadMap, corners: Floats) -> bool:
    """Whether all `corners` (4, 2) of a box are in one lane and those connected with it; off the road they are in none."""
    graph = LaneGraph.of(road_map)
    common: set[int] | None = None
    for corner in corners:
        lanes = set(graph.near(corner, IN_LANE).lane.tolist())
        links = [graph.successors, graph.predecessors]
        reached = lanes.union(*(set(link[lane].tolist()) for link in links for lane in lanes))
        common = reached if common is None else common & reached
    return bool(common)


def impact_speed(target: Trajectories, others: Replay, s: int, t: int, m: int) -> float:
    """[m/s] of the two relative to one another, the other moving the way that it faces."""
    speed = np.hypot(*others.frame[s, t, 4:, m])
    return float(np.hypot(*(target.velocity[t] - speed * unit(others.heading[s, t, m]))))


def judge(
    motion: Trajectories,
    others: Replay,
    scenarios: Sequence[Scenario],
    step: NDArray[np.int16],
    partner: NDArray[np.int32],
) -> tuple[NDArray[np.uint8], NDArray[np.bool_], NDArray[np.float32]]:
    """Contact (S,), fault (S,) and impact speed (S,) [m/s], NaN without a collision, of the first collisions of S targets."""
    count = len(scenarios)
    contact, fault, speed = np.zeros(count, np.uint8), np.zeros(count, np.bool_), np.full(count, np.nan, np.float32)
    for s in np.flatnonzero(step[:count] >= 0).tolist():
        t, m = int(step[s]), int(partner[s]) - 1
        kind = contact_of(motion[s], others.target_size[s], others, s, t, m)
        contact[s], speed[s] = kind, impact_speed(motion[s], others, s, t, m)
        fault[s] = at_fault(kind, scenarios[s], motion.position[s, t], motion.heading[s, t])
    return contact, fault, speed
