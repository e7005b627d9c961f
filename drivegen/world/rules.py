"""Signals, stop signs and right of way on the targets' paths; a signal's last known state lasts until another is known.

A line is where a path enters a way across a junction, or any lane with a signal or a sign. Behind it lie the ways that cross or
join the target's (`right_of_way.py`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from drivegen.core.geometry import Floats, project, wrap_angle
from drivegen.core.roadmap import LaneControl, RoadMap
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.core.signals import SignalState
from drivegen.roads.graph import LaneGraph
from drivegen.world.observation import PATH_SPACING, STANDING, Rules
from drivegen.world.right_of_way import PASSED, Way, fill_distances, ways_of
from drivegen.world.scenes import Scenes

if TYPE_CHECKING:
    from drivegen.world.world import World

ON_PATH = 1.5
"""Both ends of a lane that a path follows are this near to it [m] ..."""

ALIGNED = np.deg2rad(30)
"""... and run its way within this angle."""

BEFORE_IT = 30.0
"""A lane's stop line lies so far [m] before it at most."""

SAME_PLACE = 0.5
"""Lanes that begin on the path no farther [m] apart begin at one place: it takes one of them."""

REACH = 20.0
"""Who is within this distance [m] of a red light has come to it."""

BEFORE = 6.0
"""Who stands within this distance [m] of a line has halted there."""


@dataclass(frozen=True)
class Lookout:
    """Lines of S scenes, G at most on a path, and who comes there.

    Attributes:
        place: (S, G) float32 [m] of the lines along the paths, rising, inf for none. control: (S, G) int64 LaneControl.
        signal: (S * T, G) int64 SignalState. distance: (S * T, G, M) float32 [m] that each other who has right of way is from
            where its way meets the target's, inf for the rest; row s * T + t is scene s at step t.
        ways: (S,) by which somebody with right of way comes.
    """

    place: Tensor
    control: Tensor
    signal: Tensor
    distance: Tensor
    ways: "list[list[Way]]"

    @classmethod
    def of(cls, scenes: Scenes, scenarios: Sequence[Scenario], traffic: Sequence[Trajectories], arrivals: bool = True) -> Self:
        """Look along the paths of `scenes`, which are `scenarios` with `traffic` (N, T); without `arrivals` nobody comes."""
        graphs = {id(s.map): s.map for s in scenarios}
        graph_of = {number: LaneGraph.of(road_map) for number, road_map in graphs.items()}
        lines = [_lines(scenes, s, graph_of[id(scenario.map)]) for s, scenario in enumerate(scenarios)]
        count, shape = max(map(len, lines), default=0), scenes.replay.valid.shape
        place = np.full((len(scenes), max(count, 1)), np.inf, np.float32)
        control = np.zeros(place.shape, np.int64)
        signal = np.zeros((*shape[:2], place.shape[1]), np.int64)
        distance = np.full((*shape[:2], place.shape[1], shape[2]), np.inf, np.float32)
        ways: list[list[Way]] = [[] for _ in range(len(scenes))]
        for s, (scenario, motion) in enumerate(zip(scenarios, traffic, strict=True)):
            held = scenario.signals.held()
            for g, (at, lane) in enumerate(lines[s]):
                place[s, g], control[s, g] = at, scenario.map.control[lane]
                shown = held.of_lane(lane)[: motion.steps]
                signal[s, : len(shown), g] = shown
                if arrivals:
                    ways[s] += ways_of(graph_of[id(scenario.map)], held, g, lane)
            fill_distances(distance, scenes.replay, ways[s], np.full(shape[2], s), np.arange(shape[2]))
        flat = signal.reshape(-1, place.shape[1]), distance.reshape(-1, *distance.shape[2:])
        places, controls, signals, away = (torch.from_numpy(a).to(scenes.steps.device) for a in (place, control, *flat))
        return cls(places, controls, signals, away, ways)

    def exchanged(self, scenes: Scenes, chosen: NDArray[np.intp], row: NDArray[np.integer], vehicle: NDArray[np.integer]) -> Self:
        """Of `scenes` (R,), which are copies of those `chosen` (R,) but for the motion of `vehicle` (E,) of copy `row` (E,)."""
        device, count = scenes.steps.device, len(self.ways)
        at = torch.from_numpy(chosen).to(device)
        signal, distance = (table.view(count, -1, *table.shape[1:])[at].flatten(0, 1) for table in (self.signal, self.distance))
        lines = distance.view(len(chosen), -1, *distance.shape[1:]).cpu().numpy()
        for s in np.unique(chosen[row]).tolist():
            mine = chosen[row] == s
            lines[row[mine], :, :, vehicle[mine] - 1] = np.inf
            fill_distances(lines, scenes.replay, self.ways[s], row[mine], vehicle[mine] - 1)
        distance = torch.from_numpy(lines).to(device).flatten(0, 1)
        ways = [self.ways[s] for s in chosen.tolist()]
        return type(self)(self.place[at], self.control[at], signal, distance, ways)

    def red_lights(self, front: Tensor, valid: Tensor) -> tuple[Tensor, Tensor]:
        """How many red lights S targets came near, and how many of these they ran: (S,) each.

        `front` (S, T) [m] is how far along its path each target's front is, `valid` (S, T) whether its run is not over. Near is
        within REACH before the line while the light is red; who crosses the line then has run it.
        """
        ahead = self.place[:, None] - front[..., None]
        red = (self.signal.view(*front.shape, -1) == SignalState.RED) & valid[..., None] & (ahead > 0)
        ran = (red[:, :-1] & (ahead[:, 1:] <= 0) & valid[:, 1:, None]).any(1)
        return (red & (ahead < REACH)).any(1).sum(1), ran.sum(1)


class Watch:
    """What the drivers of R rows see of a `Lookout`; it remembers who has halted before the line ahead."""

    def __init__(self, lookout: Lookout, rows: int) -> None:
        self._lookout = lookout
        self._line = torch.zeros(rows, dtype=torch.int64, device=lookout.place.device)
        self._halted = torch.zeros(rows, dtype=torch.bool, device=lookout.place.device)

    def reset(self, world: "World", rows: Tensor | None) -> None:
        """All rows, or `rows` alone, have begun anew: who stands before the line ahead has halted there, nobody else."""
        some = torch.arange(len(self._line), device=self._line.device) if rows is None else rows
        ego = world.ego[some]
        self._line[some], distance = self._ahead(world.scene[some], ego.along + 0.5 * world.size[some, 0])
        self._halted[some] = _stands(ego.speed, distance)

    def rules(self, world: "World", frame: Tensor) -> Rules:
        """What holds ahead of each target; `frame` (R, 6, M) is that of the others now."""
        lookout, ego, at = self._lookout, world.ego, world.at
        line, distance = self._ahead(world.scene, ego.along + 0.5 * world.size[:, 0])
        none = distance.isinf()
        self._halted = _stands(ego.speed, distance) | (self._halted & (line == self._line) & ~none)
        self._line = line
        away = lookout.distance[world.neighbours.rows(world), line[:, None], torch.arange(frame.shape[2], device=line.device)]
        speed = torch.hypot(frame[:, 4], frame[:, 5]).clamp_min(STANDING)
        return Rules(
            distance=distance,
            signal=torch.where(none, int(SignalState.UNKNOWN), lookout.signal[at].gather(1, line[:, None])[:, 0]),
            control=torch.where(none, int(LaneControl.UNKNOWN), lookout.control[world.scene].gather(1, line[:, None])[:, 0]),
            halted=self._halted,
            arrives=torch.where(none[:, None], torch.inf, away.clamp_min(0.0) / speed),
        )

    def _ahead(self, scene: Tensor, front: Tensor) -> tuple[Tensor, Tensor]:
        """Number of the line ahead of fronts (R,) [m] in `scene` (R,), and how far it is [m]: inf where there is none."""
        ahead = self._lookout.place[scene] - front[:, None]
        ahead = torch.where(ahead > -PASSED, ahead, torch.inf)
        line = ahead.argmin(dim=1)
        return line, ahead.gather(1, line[:, None])[:, 0]


def _stands(speed: Tensor, distance: Tensor) -> Tensor:
    """Who has halted before a line so far [m] ahead."""
    return (speed < STANDING) & (distance < BEFORE)


def _lines(scenes: Scenes, s: int, graph: LaneGraph) -> list[tuple[float, int]]:
    """Where the path of scene s crosses a line [m] and the lane that it enters there, in order."""
    road_map, last = graph.map, int(scenes.paths.length[s] / PATH_SPACING) + 1
    path = scenes.paths.point[s, :last].cpu().numpy().astype(np.float64)
    heading = scenes.paths.heading[s, :last].cpu().numpy()
    guarded = road_map.in_junction | np.isin(road_map.control, (LaneControl.YIELD, LaneControl.STOP, LaneControl.SIGNAL))
    lanes = np.flatnonzero(guarded & road_map.for_vehicles)
    found = []
    for lane in lanes[_near(path, road_map, lanes)].tolist():
        if road_map.in_junction[graph.predecessors[lane]].any():
            continue  # the second half of a way across
        line = road_map.centreline[lane]
        begin, end = (_foot(path, heading, line[i], graph.heading[lane, i]) for i in (0, -1))
        if begin is not None and end is not None and end > begin:
            found.append((begin, lane))
    taken: list[tuple[float, int]] = []
    for begin, lane in sorted(found):
        if not taken or begin - taken[-1][0] > SAME_PLACE:
            taken.append((begin, lane))
        elif _strays(path, graph, lane) < _strays(path, graph, taken[-1][1]):
            taken[-1] = taken[-1][0], lane
    return sorted((min([begin, *_stop_lines(road_map, lane, path, begin)]), lane) for begin, lane in taken)


def _strays(path: Floats, graph: LaneGraph, lane: int) -> float:
    """How far [m] a lane, and the best of those that it leads to, lie from the path, up to the path's end."""
    ends = [graph.map.centreline[each][-1] for each in (lane, *graph.successors[lane])]
    feet = [project(path, end.astype(np.float64)) for end in ends]
    here, *ahead = (abs(left) if along < len(path) - 2 else 0.0 for along, left in feet)
    return max(here, min(ahead, default=0.0))


def _near(path: Floats, road_map: RoadMap, lanes: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Which of some lanes have both ends so near to a point of the path that they may lie on it."""
    start = road_map.centreline.start
    ends = road_map.centreline.points[np.stack([start[lanes], start[lanes + 1] - 1])]
    away = np.square(ends[:, :, None] - path.astype(np.float32)).sum(-1).min(-1, initial=np.inf)
    return np.asarray((away < (ON_PATH + PATH_SPACING) ** 2).all(0))


def _foot(path: Floats, heading: Floats, point: Floats, direction: float) -> float | None:
    """How far along the path [m] a lane's end first lies on it, None if it never does."""
    away = np.hypot(*(path - point.astype(np.float64)).T)
    there = (away < ON_PATH + PATH_SPACING) & (np.abs(wrap_angle(heading - direction)) < ALIGNED)
    if not there.any():
        return None
    first = int(np.argmax(there))
    last = first + int(np.argmin(np.append(there[first:], False)))
    begin = max(first - 1, 0)
    along, left = project(path[begin : last + 1], point.astype(np.float64))
    return begin * PATH_SPACING + along if abs(left) < ON_PATH else None


def _stop_lines(road_map: RoadMap, lane: int, path: Floats, begin: float) -> Iterator[float]:
    """Where the lane's stop lines are before it, which begins at `begin` on the path [m]."""
    first, last = max(int((begin - BEFORE_IT) / PATH_SPACING), 0), int(begin / PATH_SPACING) + 2
    for line in road_map.stop_lines[road_map.stop_lane == lane]:
        yield first * PATH_SPACING + project(path[first:last], line.mean(0).astype(np.float64))[0]
