"""The path that a target follows: its logged or generated route, continued along the lanes.

A driver may drive farther than the log did, so the path goes on along the likeliest lanes for as far as the target could
get, and straight on where the map ends. A target that hardly moved gets the likeliest route from where it stands.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import Floats, arc_length, interpolate, line_heading, project, unit
from drivegen.core.scenario import DT, TARGET, Scenario, Trajectories
from drivegen.roads.graph import LaneGraph
from drivegen.roads.routes import SPACING, Route, feasible_routes, match_route
from drivegen.world.observation import PATH_SPACING

CRUISE = 20.0
"""A path is long enough for this speed [m/s], or the target's first speed if that is higher ..."""

FASTER = 1.25
"""... and for so much more, since drivers go faster than the log did."""

KEPT_STEP = 1.5
"""Points of the driven line closer together than this [m] are noise of a vehicle that stands."""

STAYED = 3.0
"""A target that came less far than this [m] has no driven line to follow."""

ASTRAY = 20.0
"""What was driven is longer or shorter than the route beside it by less than this [m]."""

BLEND = 15.0
"""The offset from the lane at the end of the driven line fades out over this distance [m]."""


@dataclass(frozen=True)
class TargetPaths:
    """The paths of S targets: the line each follows, from abreast of its first position on.

    Attributes:
        point: (S, P, 2) float32 [m] a point every PATH_SPACING; rows padded by repeating the end.
        speed_limit: (S, P) float32 [m/s], NaN where unknown.
        length: (S,) float32 [m] valid length of each path.
    """

    point: NDArray[np.float32]
    speed_limit: NDArray[np.float32]
    length: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.length)


def target_paths(scenarios: Sequence[Scenario], traffic: Sequence[Trajectories]) -> TargetPaths:
    """Paths of the targets of S scenarios, each along row TARGET of its `traffic` (N, T)."""
    graphs: dict[int, LaneGraph] = {}
    lines, limits = [], []
    for scenario, motion in zip(scenarios, traffic, strict=True):
        if id(scenario.map) not in graphs:
            graphs[id(scenario.map)] = LaneGraph.of(scenario.map)
        line, limit = _path(graphs[id(scenario.map)], motion[TARGET], int(scenario.vehicles.kind[TARGET]))
        lines.append(line)
        limits.append(limit)
    return packed(lines, limits)


def route_paths(scenarios: Sequence[Scenario], traffic: Sequence[Trajectories]) -> TargetPaths:
    """Routes of the targets of S scenarios: the middles of the lanes along which row TARGET of its `traffic` (N, T) goes.

    Where no lanes fit, that is its path as `target_paths` has it.
    """
    graphs = {id(scenario.map): LaneGraph.of(scenario.map) for scenario in {id(s.map): s for s in scenarios}.values()}
    pairs = []
    for scenario, motion in zip(scenarios, traffic, strict=True):
        own, graph, kind = motion[TARGET], graphs[id(scenario.map)], int(scenario.vehicles.kind[TARGET])
        reach = FASTER * max(CRUISE, float(own.speed[own.valid].max())) * own.steps * DT
        route = match_route(graph, own.position[own.valid], own.heading[own.valid], reach, kind)
        pairs.append(_path(graph, own, kind) if route is None else (route.line, route.speed_limit))
    lines, limits = zip(*pairs, strict=True)
    return packed(lines, limits)


def packed(lines: Sequence[Floats], limits: Sequence[Floats]) -> TargetPaths:
    """Lines (P_i, 2) [m] with speed limits (P_i,) [m/s] as one struct of arrays, a point every PATH_SPACING."""
    even = [
        _every_metre(np.asarray(line, np.float64), np.asarray(limit, np.float64))
        for line, limit in zip(lines, limits, strict=True)
    ]
    count = max(len(line) for line, _ in even)
    point = np.stack([np.pad(line, ((0, count - len(line)), (0, 0)), mode="edge") for line, _ in even])
    limit = np.stack([np.pad(value, (0, count - len(value)), mode="edge") for _, value in even])
    length = np.array([(len(line) - 1) * PATH_SPACING for line, _ in even], np.float32)
    return TargetPaths(point.astype(np.float32), limit.astype(np.float32), length)


def _every_metre(line: Floats, limit: Floats) -> tuple[Floats, Floats]:
    """At least two points, exactly PATH_SPACING apart along the line; the rest of a metre at the end is cut off."""
    along = arc_length(line)
    places = np.arange(0.0, max(float(along[-1]), 2 * PATH_SPACING), PATH_SPACING)
    nearest = np.clip(np.searchsorted(along, places, side="right") - 1, 0, len(limit) - 1)
    points = interpolate(line, places)
    beyond = np.maximum(places - along[-1], 0.0)[:, None]
    return points + beyond * unit(line_heading(line)[-1:]), limit[nearest]


def _path(graph: LaneGraph, motion: Trajectories, kind: int) -> tuple[Floats, Floats]:
    driven, heading, speed = _driven(motion)
    along = arc_length(driven)
    left = max(FASTER * max(CRUISE, speed) * motion.steps * DT - float(along[-1]), BLEND)
    seen = motion.position[motion.valid], motion.heading[motion.valid]
    route = match_route(graph, *seen, left, kind) if len(driven) > 1 else None
    if route is not None:  # both begin abreast of the first position
        limits = route.speed_limit[np.clip(along / SPACING, 0, len(route.line) - 1).astype(np.int64)]
        begin = _abreast(route, driven[-1], float(along[-1]))
        onward, limit = _joined(driven[-1], route, min(begin, len(route.line) - 2))
        return np.concatenate([driven, onward]), np.concatenate([limits, limit])
    limits = _limits_under(graph, driven)
    routes = feasible_routes(graph, driven[-1], heading, speed, left, most_routes=1, most_changes=0, kind=kind)
    onward, limit = _joined(driven[-1], routes[0], 0) if routes else (driven[-1] + left * unit(np.array([heading])), limits[-1:])
    return np.concatenate([driven, onward]), np.concatenate([limits, limit])


def _abreast(route: Route, place: Floats, driven: float) -> int:
    """The first point of a route beyond `place`, near `driven` [m] along it: on a ring it comes by there more than once."""
    first = min(max(int((driven - ASTRAY) / SPACING), 0), len(route.line) - 2)
    near = route.line[first : int((driven + ASTRAY) / SPACING) + 2].astype(np.float64)
    return first + int(np.ceil(project(near, place)[0] / SPACING))


def _driven(motion: Trajectories) -> tuple[Floats, float, float]:
    """The line that was driven (P, 2), the heading at its end [rad], and the first speed [m/s]."""
    position = motion.position[motion.valid].astype(np.float64)
    steps = [0]
    for i, point in enumerate(position):
        if np.hypot(*(point - position[steps[-1]])) >= KEPT_STEP:
            steps.append(i)
    speed = float(motion.speed[motion.valid][0])
    first = float(motion.heading[motion.valid][0])
    if np.hypot(*(position[steps[-1]] - position[0])) < STAYED:
        return position[:1], first, speed
    line = position[steps]
    return line, float(line_heading(line)[-1]), speed


def _joined(end: Floats, route: Route, begin: int) -> tuple[Floats, Floats]:
    """The route after its point `begin`, moved so that it starts at `end` and fades into the lane."""
    line = route.line[begin:].astype(np.float64)
    fade = np.maximum(1.0 - np.arange(len(line)) * SPACING / BLEND, 0.0)[:, None]
    return (line + fade * (end - line[0]))[1:], route.speed_limit[begin + 1 :].astype(np.float64)


def _limits_under(graph: LaneGraph, line: Floats) -> NDArray[np.float64]:
    """Speed limits (P,) of the lanes under a line (P, 2), NaN where there is no lane or no limit."""
    headings = line_heading(line) if len(line) > 1 else None
    lane, _ = graph.nearest(line, headings, radius=4.0, max_angle=np.pi / 3 if headings is not None else np.pi)
    return np.where(lane >= 0, graph.map.speed_limit[lane], np.nan).astype(np.float64)
