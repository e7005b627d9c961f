"""What kind of scene it is: road, the vehicles' manoeuvres, the target's conflict with the others, density.

Labels are read off geometry with the thresholds below; they sort scenes in tables, and of
metrics the distance of manoeuvres alone counts them, by the speeds that a method reports.
"""

from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import Floats, to_vehicle_frame, wrap_angle
from drivegen.core.roadmap import RoadMap
from drivegen.core.scenario import DT, TARGET, Scenario, Trajectories

ON_LANE = 3.0
"""A lane whose centreline comes this near the target's path is a lane that it drives on [m]."""
FAST = 22.0
"""Roads from this speed limit on are fast roads [m/s]; about 80 km/h."""
STATIONARY = 2.0
"""A vehicle that never gets farther than this from where it began is stationary [m]."""
TURN = np.deg2rad(40)
U_TURN = np.deg2rad(150)
SHIFT = 2.5
"""A vehicle that ends with about its first heading, but this far to the side, shifted lanes [m]."""
SAME_HEADING = np.deg2rad(12)
STOPPED, WAS_MOVING = 0.5, 2.0
"""Speeds [m/s] at the end and at most, for a vehicle that came to a stop."""
CONFLICT_DISTANCE = 2.5
"""Paths that come this near each other ... [m]"""
CONFLICT_TIME = 3.0
"""... at times this close are in conflict [s] (post-encroachment time)."""
NEARBY = 50.0
"""Radius around the target within which vehicles make density [m]."""


@dataclass(frozen=True)
class Labels:
    """Labels of one scene.

    Attributes:
        road: "signalised junction", "junction", "fast road" or "road": where the target drives.
        manoeuvre: the target's: stationary, stop, straight, left, right, u_turn, shift_left, shift_right.
        conflict: "crossing", "oncoming", "merging", "following" or "none": the target's gravest with any vehicle.
        density: "sparse" (under 4 others within 50 m at the first step), "medium" or "dense" (8 and more).
        manoeuvres: number of vehicles by manoeuvre, the target included.
    """

    road: str
    manoeuvre: str
    conflict: str
    density: str
    manoeuvres: dict[str, int]

    def as_rows(self) -> dict[str, float]:
        """Numeric metrics for long rows: `label.<aspect>.<label>` is 1, `manoeuvre.<name>` a number of vehicles."""
        aspects = {"road": self.road, "manoeuvre": self.manoeuvre, "conflict": self.conflict, "density": self.density}
        rows = {f"label.{aspect}.{label.replace(' ', '_')}": 1.0 for aspect, label in aspects.items()}
        return rows | {f"manoeuvre.{name}": float(count) for name, count in sorted(self.manoeuvres.items())}


def label(scenario: Scenario, motion: Trajectories) -> Labels:
    """Labels of a scenario whose vehicles move as `motion` (N, T): its log or one sample."""
    manoeuvres = [manoeuvre(motion[i]) for i in range(len(scenario.vehicles))]
    signalised = np.zeros(len(scenario.map), np.bool_)
    signalised[scenario.signals.lane] = True
    return Labels(
        road_kind(scenario.map, signalised, motion[TARGET]),
        manoeuvres[TARGET],
        conflict_type(motion),
        _density(motion),
        dict(Counter(manoeuvres)),
    )


def manoeuvre(motion: Trajectories) -> str:
    """The manoeuvre of one vehicle's trajectory (T,); "stationary" if it was seen once or never."""
    seen = np.flatnonzero(motion.valid)
    if len(seen) < 2:
        return "stationary"
    first, last = seen[0], seen[-1]
    path = to_vehicle_frame(motion.position[seen], motion.position[first], motion.heading[first])
    if np.hypot(path[:, 0], path[:, 1]).max() < STATIONARY:
        return "stationary"
    turned = float(np.sum(wrap_angle(np.diff(motion.heading[seen]))))
    speed = motion.speed
    if abs(turned) > TURN:
        return "u_turn" if abs(turned) > U_TURN else ("left" if turned > 0 else "right")
    if speed[last] < STOPPED and speed[seen].max() > WAS_MOVING:
        return "stop"
    if abs(turned) < SAME_HEADING and abs(path[-1, 1]) > SHIFT:
        return "shift_left" if path[-1, 1] > 0 else "shift_right"
    return "straight"


def road_kind(roads: RoadMap, signalised: NDArray[np.bool_], path: Trajectories) -> str:
    """Kind of road under the valid steps of one vehicle's path (T,); `signalised` (L,) are lanes behind a signal."""
    near = _lanes_near(roads, path.position[path.valid][::5]) & roads.for_vehicles
    if (near & signalised).any():
        return "signalised junction"
    if (near & roads.in_junction).any():
        return "junction"
    limits = roads.speed_limit[near]
    return "fast road" if np.isfinite(limits).any() and np.nanmax(limits) >= FAST else "road"


def _lanes_near(roads: RoadMap, places: Floats) -> NDArray[np.bool_]:
    """(L,) whether a lane's centreline, which may have a point every hundred metres only, comes near any of `places` (P, 2)."""
    points = roads.centreline.points
    lane = np.repeat(np.arange(len(roads)), np.diff(roads.centreline.start))
    pieces = np.flatnonzero(lane[1:] == lane[:-1])
    start, along = points[pieces, None], (points[1:] - points[:-1])[pieces, None]
    share = ((places - start) * along).sum(-1) / np.maximum((along**2).sum(-1), 1e-9)
    gap = ((places - start - np.clip(share, 0.0, 1.0)[..., None] * along) ** 2).sum(-1).min(axis=1, initial=np.inf)
    near = np.zeros(len(roads), np.bool_)
    near[lane[pieces[gap < ON_LANE**2]]] = True
    return near


def conflict_type(motion: Trajectories) -> str:
    """The target's gravest conflict in motion (N, T), by the angle between the paths where they come near each other."""
    order = ("crossing", "oncoming", "merging", "following")
    found = {_conflict(motion[TARGET], motion[i]) for i in range(1, len(motion.valid))}
    return next((kind for kind in order if kind in found), "none")


def _conflict(a: Trajectories, b: Trajectories) -> str:
    steps_a, steps_b = np.flatnonzero(a.valid)[::2], np.flatnonzero(b.valid)[::2]
    if len(steps_a) == 0 or len(steps_b) == 0:
        return "none"
    gap = ((a.position[steps_a][:, None] - b.position[steps_b][None]) ** 2).sum(-1)
    soon = np.abs(steps_a[:, None] - steps_b[None]) * DT <= CONFLICT_TIME
    gap = np.where(soon, gap, np.inf)
    i, j = np.unravel_index(np.argmin(gap), gap.shape)
    if gap[i, j] > CONFLICT_DISTANCE**2 or a.speed[steps_a].max() < STOPPED:
        return "none"
    angle = abs(float(wrap_angle(a.heading[steps_a[i]] - b.heading[steps_b[j]])))
    if angle > np.deg2rad(150):
        return "oncoming"
    if angle > np.deg2rad(30):
        return "crossing"
    at_first = abs(float(wrap_angle(a.heading[steps_a[0]] - b.heading[steps_b[0]])))
    beside = abs(float(to_vehicle_frame(b.position[steps_b[:1]], a.position[steps_a[0]], a.heading[steps_a[0]])[0, 1]))
    return "merging" if at_first > np.deg2rad(30) or beside > CONFLICT_DISTANCE else "following"


def _density(motion: Trajectories) -> str:
    gap = np.hypot(*(motion.position[1:, 0] - motion.position[TARGET, 0]).T)
    near = int((gap[motion.valid[1:, 0]] < NEARBY).sum())
    return "sparse" if near < 4 else ("medium" if near < 8 else "dense")
