"""What a specification has, in the terms in which descriptions speak of roads: what is said can be looked up in it."""

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import combinations

from drivegen.maps.spec import MapSpec
from drivegen.maps.spec_alignment import Alignment
from drivegen.maps.spec_crossings import Arm, Crossing, Roundabout
from drivegen.maps.spec_highways import Fork, Highway, Interchange
from drivegen.maps.spec_quadrants import QuadrantInterchange
from drivegen.maps.spec_streets import Corridor, Grid, Junction, TurnLanes

_BESIDE = ("on_ramp", "off_ramp", "weaving")
ISLAND = 8.0
"""By how much the island in the middle of a roundabout is smaller than its outer edge, per lane of the ring [m]."""


@dataclass
class Built:
    """A specification as sets of what occurs in it, wherever that is.

    Attributes:
        lanes: numbers of lanes in one direction of any road, ring, ramp or part of one. totals: of both directions together.
        changes: by how many lanes a road becomes wider or narrower, and how many a turn lane adds.
        speeds: [m/s]. lengths: [m] of roads, distances, radii and diameters. angles: [degrees]; gaps: those between
            neighbouring arms of a crossing.
        positions: distances [m] from the start of a road to what lies along it. distances: those between two
            such things. between: those and all from and to the road's ends.
        branches: lanes of a fork's branches by their sides.
        arms: roads that meet at each junction. counts: how many there are of each thing, by its name.
        controls: how junctions are controlled.
    """

    lanes: set[int] = field(default_factory=set)
    totals: set[int] = field(default_factory=set)
    changes: set[int] = field(default_factory=lambda: {1})
    speeds: set[float] = field(default_factory=set)
    lengths: set[float] = field(default_factory=set)
    positions: set[float] = field(default_factory=set)
    distances: set[float] = field(default_factory=set)
    between: set[float] = field(default_factory=set)
    angles: set[float] = field(default_factory=lambda: {90.0, 180.0})
    branches: dict[str, int] = field(default_factory=dict)
    gaps: list[float] = field(default_factory=list)
    arms: list[int] = field(default_factory=list)
    counts: Counter[str] = field(default_factory=Counter)
    controls: Counter[str] = field(default_factory=Counter)

    def road(self, forward: int, back: int, speed: float) -> None:
        """Note one road's lanes and limit."""
        self.lanes |= {forward, back} - {0}
        self.totals.add(forward + back)
        self.speeds.add(speed)
        self.counts["two_way" if forward and back else "one_way"] += 1


def built(spec: MapSpec) -> Built:
    """What occurs in the specification; nothing for a free graph, of which descriptions do not speak in these terms."""
    found, road = Built(), spec.road
    if isinstance(road, Crossing):
        _arms(found, road.arms)
        _place(found, len(road.arms), road.control)
    elif isinstance(road, Roundabout):
        _arms(found, road.arms)
        _ring(found, len(road.arms), road.diameter)
        found.lanes.add(road.ring_lanes)
        found.speeds.add(road.ring_speed)
        found.lengths |= {road.diameter - ISLAND * road.ring_lanes, (road.diameter - ISLAND * road.ring_lanes) / 2}
    elif isinstance(road, Corridor):
        _corridor(found, road)
    elif isinstance(road, Grid):
        _grid(found, road)
    elif isinstance(road, Highway):
        _highway(found, road)
    elif isinstance(road, Fork):
        _fork(found, road)
    elif isinstance(road, Interchange):
        _interchange(found, road)
    elif isinstance(road, QuadrantInterchange):
        _quadrants(found, road)
    found.counts["left_hand"] = int(spec.left_hand)
    return found


def _place(found: Built, arms: int, control: str) -> None:
    found.arms.append(arms)
    found.counts["crossing"] += 1
    found.controls[control] += 1


def _ring(found: Built, arms: int, diameter: float) -> None:
    found.arms.append(arms)
    found.counts["roundabout"] += 1
    found.controls["yield"] += 1
    found.lengths |= {diameter, diameter / 2}


def _arms(found: Built, arms: Iterable[Arm]) -> None:
    arms = tuple(arms)
    for arm in arms:
        found.road(arm.lanes_in, arm.lanes_out, arm.speed)
        found.lengths |= {arm.length, 2 * arm.length}
        pockets = arm.left_turn_lane + arm.right_turn_lane
        found.lanes.add(arm.lanes_in + pockets)
        found.totals.add(arm.lanes_in + arm.lanes_out + pockets)
        found.counts["pocket"] += pockets
        found.lengths |= {min(arm.pocket, arm.length / 2)} if pockets else set()
    around = sorted(arm.angle % 360.0 for arm in arms)
    found.gaps = [b - a for a, b in zip(around, [*around[1:], around[0] + 360.0], strict=True)]
    found.lengths |= {a.length + b.length for a, b in combinations(arms, 2)}
    found.angles |= {abs(a.angle - b.angle) % 360.0 for a, b in combinations(arms, 2)}


def _line(found: Built, line: Alignment, straight: float) -> None:
    found.lengths |= {line.length, straight}
    found.counts["bend"] = len(line.turns)
    if line.turns:
        found.lengths |= {size for _, radius in line.curves for size in (radius, 2 * radius)}
        found.angles |= {abs(angle) for angle in line.turns} | {sum(map(abs, line.turns))}
        legs = len(line.turns) + 1 if line.shape == "hairpin" else 2
        arcs = [math.radians(abs(angle)) * radius for angle, radius in line.curves]
        found.lengths |= {line.length - sum(arcs), (line.length - sum(arcs)) / legs, *arcs}
        found.counts["left_bend"] = sum(turn > 0 for turn in line.turns)


def _along(found: Built, places: list[float], end: float) -> None:
    """Distances along a road between what lies at `places` and the road's ends."""
    found.positions |= set(places)
    found.distances |= {b - a for a, b in combinations(places, 2)}
    marks = [0.0, *places, end]
    found.between |= {b - a for a, b in combinations(marks, 2)}


def _corridor(found: Built, road: Corridor) -> None:
    found.road(road.lanes, road.lanes_back, road.speed)
    _line(found, road.alignment, road.alignment.length)
    bends = [end for span in road.alignment.spans for end in span] if road.junctions else []
    _along(found, sorted([*bends, *(j.position for j in road.junctions)]), road.alignment.length)
    found.counts["dead_end"] += road.dead_end
    for number, junction in enumerate(road.junctions):
        _joined(found, junction)
        for back, lanes in ((False, road.lanes), (True, road.lanes_back)):
            _turn_lanes(found, road.turn_lanes(number, back), lanes, road.lanes + road.lanes_back)


def _turn_lanes(found: Built, turns: TurnLanes, lanes: int, both_ways: int) -> None:
    if count := turns.left + turns.right:
        found.lanes.add(lanes + count)
        found.totals.add(both_ways + count)
        found.counts["pocket"] += count
        found.lengths.add(turns.length)


def _joined(found: Built, junction: Junction) -> None:
    found.road(junction.side_lanes, junction.side_lanes, junction.side_speed)
    found.lengths.add(junction.side_length)
    found.counts["dead_end"] += junction.dead_end * len(junction.sides)
    if junction.form == "roundabout":
        _ring(found, 2 + len(junction.sides), junction.diameter)
        found.lanes.add(junction.ring_lanes)
    else:
        _place(found, 2 + len(junction.sides), junction.control)


def _grid(found: Built, road: Grid) -> None:
    found.road(road.lanes, 0 if road.one_way else road.lanes, road.speed)
    found.counts["grid"] = 1
    found.lengths |= {road.spacing * k for k in range(1, max(road.rows, road.columns) + 2)} | {road.beyond or road.spacing}
    for _ in range(road.rows * road.columns):
        _place(found, 4, road.control)


def _highway(found: Built, road: Highway) -> None:
    _line(found, road.alignment, road.alignment.length)
    lanes, marks = road.lanes, list[float]()
    found.road(lanes, lanes if road.carriageways == 2 else 0, road.speed)
    found.counts["median"] = road.carriageways - 1
    found.lengths |= {road.median} if road.carriageways == 2 else set()
    for event in road.events:
        ramp = event.kind in _BESIDE
        marks.append(event.position)
        found.counts[event.kind] += 1
        found.lengths |= {event.length} if ramp else set()
        found.speeds |= {event.ramp_speed} if ramp else set()
        found.changes.add(event.lanes)
        found.lanes |= {lanes + event.lanes, event.lanes} if ramp else set()
        lanes += event.change
        found.lanes.add(lanes)
        found.totals.add(lanes + road.lanes * (road.carriageways - 1))
    for kind in ("on_ramp", "off_ramp"):
        found.counts[kind] += found.counts["weaving"]
    found.changes |= {abs(lanes - road.lanes)} - {0}
    _along(found, marks, road.alignment.length)
    found.positions |= {event.position + event.length for event in road.events if event.kind in _BESIDE}
    ends = [event.position + (event.length if event.kind in _BESIDE else 0.0) for event in road.events]
    following = [*marks[1:], road.alignment.length][: len(ends)]  # without events there is nothing before the road's end
    between = {after - before for before, after in zip(ends, following, strict=True)}
    found.lengths |= between
    found.distances |= between | {event.length for event in road.events if event.kind == "weaving"}


def _fork(found: Built, road: Fork) -> None:
    for lanes in (road.lanes, road.left_lanes, road.right_lanes):
        found.road(lanes, 0, road.speed)
    found.totals.add(road.left_lanes + road.right_lanes)
    found.branches = {"left": road.left_lanes, "right": road.right_lanes}
    found.lengths |= {road.stem_length, road.length, road.stem_length + road.length}
    found.angles |= {road.angle, road.angle / 2}
    found.counts["fork"] = 1


def _interchange(found: Built, road: Interchange) -> None:
    found.road(road.lanes, 0, road.speed)
    found.totals.add(2 * road.lanes)
    found.road(road.road_lanes, road.road_lanes, road.road_speed)
    found.road(road.ramp_lanes, 0, road.ramp_speed)
    found.lengths.add(road.road_length)
    off_ramps, on_ramps = {"diamond": (2, 2), "half_diamond": (1, 1), "side": (1, 1), "terminal": (1, 0)}[road.form]
    found.counts.update({"interchange": 1, "off_ramp": off_ramps, "on_ramp": on_ramps})
    for arms in {"diamond": (4, 4), "half_diamond": (3, 3), "side": (4,), "terminal": (3,)}[road.form]:
        _place(found, arms, road.control)


def _quadrants(found: Built, road: QuadrantInterchange) -> None:
    for lanes, speed in ((road.lanes, road.speed), (road.road_lanes, road.road_speed), (road.ramp_lanes, road.ramp_speed)):
        found.road(lanes, 0, speed)
        found.totals.add(2 * lanes)
    found.speeds.add(road.loop_speed)
    found.lengths |= {road.loop_radius, 2 * road.loop_radius, road.median}
    ramps = len(road.loops) + len(road.directs) - road.trumpet
    found.counts.update({"interchange": 1, "median": 1, "on_ramp": ramps, "off_ramp": ramps})
    for arms in road.terminals:
        _place(found, arms, road.control or "yield")
