"""Whether a network has what its specification asks for: arms, lanes, controls, lengths, ramps, and nobody stuck.

Not looked at are the widths of lanes, the lengths of turn lanes, what a free graph's nodes are controlled by, the limits and
lanes of a crossing's and a roundabout's arms one by one, and those of side roads, unless they are the most that there is.
"""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from drivegen.layouts.crossings import Crossing, Roundabout
from drivegen.layouts.graph import Graph
from drivegen.layouts.highways import Fork, Highway, Interchange
from drivegen.layouts.quadrants import QuadrantInterchange
from drivegen.layouts.spec import MapSpec
from drivegen.layouts.streets import Corridor, Grid
from drivegen.maps.structure import Structure

T = TypeVar("T", int, float)

_TOLERANCE = 0.15
_LONG_ARM = 100.0
_LONG_BRANCH = 180.0
"""Shorter branches [m] may be longer than asked: they need their bend."""

_CLEARLY = 0.85
"""Of the length with one value, all others together have less: junctions take something of each."""

_TURNING_PLACE = 80.0
"""Length of a turning place at most [m]."""

_NARROW = 1.0
"""A median below this [m] is not looked at."""

_TITLES = {"left_hand": "left-hand traffic"}

_SHARP = 60.0
"""Arms nearer to one another than this [degrees] share their surface for longer than a corner takes."""


@dataclass(frozen=True)
class Check:
    """One thing that was asked, and what the network has."""

    name: str
    asked: Any
    got: Any
    passed: bool


def check_sound(structure: Structure, overlaps: Sequence[str]) -> list[Check]:
    """What every network must be, whatever was asked: each way in has a way out, no two roads lie on one another."""
    return [
        Check("nobody stuck", "none", list(structure.stuck[:5]), not structure.stuck),
        Check("no overlapping roads", "none", list(overlaps), not overlaps),
    ]


def check(spec: MapSpec, structure: Structure) -> list[Check]:
    """Checks of a specification against its network's structure, the failed ones included."""
    return check_asked({"left_hand": spec.left_hand, **_EXPECTED[spec.road.kind](spec.road)}, structure)


def check_asked(asked: Mapping[str, Any], structure: Structure) -> list[Check]:
    """One check per name of `asked`, which are names of `Structure`."""
    return [
        Check(_TITLES.get(n, n.replace("_", " ")), w, getattr(structure, n), _agrees(w, getattr(structure, n)))
        for n, w in asked.items()
    ]


def failures(checks: Sequence[Check]) -> list[str]:
    """The failed checks as sentences, for a person or for the writer that repairs."""
    return [f"{c.name}: asked {c.asked}, got {c.got}" for c in checks if not c.passed]


def _agrees(want: Any, got: Any) -> bool:
    if isinstance(want, float):
        return bool(abs(got - want) <= _TOLERANCE * want)
    return bool(want == got)


def _crossing(road: Crossing) -> dict[str, Any]:
    count = len(road.arms)
    lit = int(road.control == "signals")
    if parts := _parts(road):
        return {"arms": (), "roundabouts": (), "signals": lit, **parts}
    expected = {
        **_way_across(road),
        "turns": _turns([road]),
        "arms": (count,),
        "signals": lit,
        "controls": (road.control,),
        "median": None if any(sum(road.turn_lanes(i)[:2]) for i in range(count)) else _clear(max(a.median for a in road.arms)),
        "roundabouts": (),
        "max_lanes": max(max(arm.lanes_out, arm.lanes_in + sum(road.turn_lanes(i)[:2])) for i, arm in enumerate(road.arms)),
        "merges": 0,
        "diverges": 0,
    }
    return {name: value for name, value in expected.items() if value is not None}


def _parts(road: Crossing) -> dict[str, int]:
    """Merges and diverges, where ways only join or only part at the crossing; empty where any of them cross."""
    on = {i: set(road.turns(i)) for i, arm in enumerate(road.arms) if arm.lanes_in}
    back = {j: {i for i in on if j in on[i]} for j in set().union(*on.values())}
    merges = sum(len(before) > 1 and all(on[i] == {j} for i in before) for j, before in back.items())
    diverges = sum(len(after) > 1 and all(back[j] == {i} for j in after) for i, after in on.items())
    return {"merges": merges, "diverges": diverges} if merges or diverges else {}


def _way_across(road: Crossing) -> dict[str, Any]:
    """The longest way over two arms, less what the junction takes of each: its corners, and more the wider it is."""
    pairs = [(a, b) for a in road.arms for b in road.arms if a is not b and a.lanes_in and b.lanes_out]
    if not pairs or min(arm.length for arm in road.arms) < _LONG_ARM or _sharpest(road) < _SHARP:
        return {}  # the junction's own size would decide
    widest = max(max(arm.lanes_in, arm.lanes_out) for arm in road.arms)
    return {"length": max(a.length + b.length for a, b in pairs) - 2 * (6.0 + 2.0 * widest)}


def _sharpest(road: Crossing) -> float:
    """The least angle between two neighbouring arms [degrees]: roads that part slowly are one junction for long."""
    angles = sorted(arm.angle % 360.0 for arm in road.arms)
    return min((after - before) % 360.0 for before, after in zip(angles, [*angles[1:], angles[0] + 360.0], strict=True))


def _turns(crossings: Iterable[Crossing | None]) -> int:
    """Ways over crossings from arm to arm, those left out that are banned."""
    return sum(len(c.turns(i)) for c in crossings if c is not None for i, arm in enumerate(c.arms) if arm.lanes_in)


def _roundabout(road: Roundabout) -> dict[str, Any]:
    return {"arms": (), "signals": 0, "roundabouts": (len(road.arms),), "ring_lanes": road.ring_lanes}


def _corridor(road: Corridor) -> dict[str, Any]:
    crossings = [j for j in road.junctions if j.form == "crossing"]
    rings = [2 + len(j.sides) for j in road.junctions if j.form == "roundabout"]
    expected: dict[str, Any] = {
        "arms": tuple(sorted((2 + len(j.sides) for j in crossings), reverse=True)),
        "turns": _turns(road.crossings),
        "signals": sum(j.control == "signals" for j in crossings),
        "controls": tuple(sorted(j.control for j in crossings)),
        "roundabouts": tuple(rings),
        "one_way": road.lanes_back == 0 and not road.junctions,
    }
    widest, rings_lanes = _widest_approach(road), [j.ring_lanes for j in road.junctions if j.form == "roundabout"]
    expected["max_lanes"] = max(widest, road.lanes, road.lanes_back, *rings_lanes, *(j.side_lanes for j in road.junctions))
    expected |= {"lanes": _commonest_lanes(road), "speed": _commonest_speed(road), "median": _median(road)}
    if not road.junctions and not road.dead_end:
        expected |= {"turn": _turn(road), "length": _line_length(road)}
    return {name: value for name, value in expected.items() if value is not None}


def _median(road: Corridor) -> float | None:
    """The gap between the road's directions [m]; None where turn lanes open in it, or a turning place's two ways count as one."""
    turned = road.dead_end or any(junction.dead_end for junction in road.junctions)
    return None if turned or _widest_approach(road) else _clear(road.median)


def _clear(median: float) -> float | None:
    """The median [m], None of one that is so narrow that a network's rounded numbers may hide it."""
    return None if 0 < median < _NARROW else median


def _commonest_lanes(road: Corridor) -> int | None:
    """Lanes of most of the road and its side roads; None where that is not clear, or turn lanes take some of the way."""
    if _widest_approach(road):
        return None
    length = road.alignment.length
    sides = [(j.side_lanes, 2 * j.side_length * len(j.sides)) for j in road.junctions]
    return _clearly([(road.lanes, length), (road.lanes_back, length * (road.lanes_back > 0)), *sides], road)


def _commonest_speed(road: Corridor) -> float | None:
    """The limit on most of the road and its side roads [m/s]; None where that is not clear."""
    length = road.alignment.length * (2 if road.lanes_back else 1)
    return _clearly([(road.speed, length), *((j.side_speed, 2 * j.side_length * len(j.sides)) for j in road.junctions)], road)


def _clearly(pairs: list[tuple[T, float]], road: Corridor) -> T | None:
    """The value with the greatest weight [m], where all others have less together, rings and turning places included."""
    weight: Counter[T] = Counter()
    for value, metres in pairs:
        weight[value] += metres  # type: ignore[assignment]
    value, most = weight.most_common(1)[0]
    others = sum(weight.values()) - most + sum(math.pi * j.diameter for j in road.junctions if j.form == "roundabout")
    others += _TURNING_PLACE * (road.dead_end + sum(len(j.sides) for j in road.junctions if j.dead_end))
    return value if others < _CLEARLY * most else None


def _widest_approach(road: Corridor) -> int:
    """Most lanes of the main road ahead of a crossing with turn lanes, 0 where none has any."""
    ways = [(road.turn_lanes(i, back), back) for i in range(len(road.junctions)) for back in (False, True)]
    return max((t.left + t.right + (road.lanes_back if b else road.lanes) for t, b in ways if t.left + t.right), default=0)


def _turn(road: Corridor | Highway) -> float | None:
    return sum(map(abs, road.alignment.turns)) or None


def _line_length(road: Corridor | Highway) -> float | None:
    """The length that was asked for; None of bent roads, whose lanes differ in length, unless the bends take more than that.

    The usual length is nobody's wish: where bends take more than it the road is as long as they need.
    """
    line = road.alignment
    wished = line.length != type(line).model_fields["length"].default
    return float(line.length) if line.shape == "straight" or (line.too_short and wished) else None


def _grid(road: Grid) -> dict[str, Any]:
    crossings = road.rows * road.columns
    lit = crossings if road.control == "signals" else 0
    expected = {"arms": (4,) * crossings, "signals": lit, "lanes": road.lanes, "speed": road.speed, "one_way": road.one_way}
    return {**expected, "controls": (road.control,) * crossings}


def _highway(road: Highway) -> dict[str, Any]:
    kinds = [event.kind for event in road.events] * (2 if road.both and road.carriageways == 2 else 1)
    expected: dict[str, Any] = {
        "arms": (),
        "signals": 0,
        "merges": sum(kind in ("on_ramp", "weaving") for kind in kinds),
        "diverges": sum(kind in ("off_ramp", "weaving") for kind in kinds),
        "speed": road.speed,
        "one_way": True,
        "length": _line_length(road),
    }
    if not kinds or (road.carriageways == 2 and not road.both):  # a bend is measured up to the first ramp
        expected["turn"] = _turn(road)
    if not kinds:
        expected["lanes"] = road.lanes
    return {name: value for name, value in expected.items() if value is not None}


def _fork(road: Fork) -> dict[str, Any]:
    place = "merges" if road.joins else "diverges"
    expected: dict[str, Any] = {"arms": (), "signals": 0, place: 1, "one_way": True, "max_lanes": road.lanes, "speed": road.speed}
    if road.length < _LONG_BRANCH:
        return expected
    return {**expected, "length": road.stem_length + road.length}


def _interchange(road: Interchange) -> dict[str, Any]:
    arms = {"diamond": (4, 4), "half_diamond": (3, 3), "side": (4,), "terminal": (3,)}[road.form]
    ramps = 2 if road.form == "diamond" else 1
    lit = len(arms) if road.control == "signals" else 0
    joined = {"diverges": ramps, "merges": 0 if road.form == "terminal" else ramps, "bridges": 1}
    return {"arms": arms, "signals": lit, "controls": (road.control,) * len(arms), **joined}


def _quadrants(road: QuadrantInterchange) -> dict[str, Any]:
    ramps = len(road.loops) + len(road.directs)
    ends = ramps - road.trumpet  # a trumpet's loop begins or ends with its carriageway, and so does the ramp around it
    expected = {"arms": road.terminals, "bridges": 1, "loops": len(road.loops), "one_way": road.control is None}
    if road.control is None:
        expected |= {"merges": ends, "diverges": ends}
    else:
        expected["controls"] = (road.control,) * len(road.terminals)
    return {**expected, "signals": len(road.terminals) if road.control == "signals" else 0}


def _graph(road: Graph) -> dict[str, Any]:
    edges = sum((r.lanes > 0) + (r.lanes_back > 0) for r in road.roads)
    return {"max_lanes": max(max(r.lanes, r.lanes_back) for r in road.roads), "edges": edges}


_EXPECTED: dict[str, Any] = {
    "crossing": _crossing,
    "roundabout": _roundabout,
    "corridor": _corridor,
    "grid": _grid,
    "highway": _highway,
    "fork": _fork,
    "interchange": _interchange,
    "quadrant_interchange": _quadrants,
    "graph": _graph,
}
