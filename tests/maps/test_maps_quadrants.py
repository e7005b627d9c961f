"""Cloverleaves, trumpets and single loops: their ramps, what they lead to, and vehicles that drive them."""

import math
from functools import cache
from itertools import product
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from drivegen.core import seeds
from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import wrap_angle
from drivegen.core.safe_xml import parse
from drivegen.layouts.compile import draw
from drivegen.layouts.quadrants import QUADRANTS, QuadrantInterchange
from drivegen.layouts.spec import MapSpec
from drivegen.maps.build import BuiltMap, build_spec
from drivegen.maps.checks import failures
from drivegen.maps.examine import NETWORK, examine
from drivegen.maps.overlaps import overlapping
from drivegen.maps.structure import measure
from drivegen.sumo.demand import Demand, draw_demand
from drivegen.sumo.network import Network
from drivegen.sumo.plain import Edge, PlainNetwork
from drivegen.sumo.traffic import Run, simulate
from drivegen.words.edits import edited
from drivegen.words.read import read

NO_RAMPS = dict.fromkeys(QUADRANTS, "none")
TRUMPET = {"north_leg": False, "south_west": "direct", "south_east": "direct"}
FORMS: dict[str, dict[str, Any]] = {
    "cloverleaf": {},
    "partial": {"north_west": "direct", "south_east": "direct", "loop_radius": 30.0},
    "partial without outer ramps": {**NO_RAMPS, "north_west": "loop", "south_east": "loop"},
    "exit loop": {**NO_RAMPS, "south_east": "loop", "road_lanes": 1},
    "entry loop": {**NO_RAMPS, "south_west": "loop", "ramp_lanes": 2, "loop_radius": 60.0},
    "trumpet": {**TRUMPET, "north_east": "none"},
    "trumpet with its loop in the east": {**TRUMPET, "north_west": "none", "road_lanes": 1, "ramp_lanes": 2},
    "trumpet from the north": {
        "south_leg": False,
        "north_west": "direct",
        "north_east": "direct",
        "south_west": "none",
        "lanes": 3,
        "road_lanes": 4,
    },
    "wide": {"lanes": 6, "road_lanes": 4, "ramp_lanes": 2, "loop_radius": 80.0, "median": 12.0},
}
STREET = {"control": "signals", "road_lanes": 1, "road_speed": 50 / 3.6}
FORMS |= {
    "partial over a street": {**STREET, "north_west": "direct", "south_east": "direct"},
    "two quadrants over a street": {**STREET, "north_west": "none", "south_east": "none", "control": "stop"},
    "exit loop to a street": {**STREET, **NO_RAMPS, "south_east": "loop"},
    "wide over a street": {**STREET, "lanes": 6, "road_lanes": 4, "ramp_lanes": 2, "loop_radius": 80.0, "median": 12.0},
    "small over a street": {**STREET, "lanes": 1, "loop_radius": 25.0, "median": 2.0, "control": "yield"},
}
COMPASS = {"south": (0, -1), "east": (1, 0), "north": (0, 1), "west": (-1, 0)}
LEGS = tuple(COMPASS)
NAMES = {"e": "east", "w": "west"}
SIDES = pytest.mark.parametrize("left_hand", [False, True], ids=["right-hand", "left-hand"])


def specified(form: dict[str, Any], left_hand: bool = False) -> MapSpec:
    return MapSpec.model_validate({"road": {"kind": "quadrant_interchange", **form}, "left_hand": left_hand})


@cache
def built(form: str, left_hand: bool = False) -> BuiltMap:
    """Made once for all tests."""
    return build_spec(specified(FORMS[form], left_hand), {})


def ramps(plain: PlainNetwork, kind: str) -> list[Edge]:
    return [edge for edge in plain.edges if edge.id.startswith(kind)]


@SIDES
@pytest.mark.parametrize("form", FORMS)
def test_every_form_is_built_as_asked(form: str, left_hand: bool) -> None:
    made = built(form, left_hand)
    assert failures(list(made.checks)) == []
    assert {"loops", "bridges", "arms", "signals"} <= {check.name for check in made.checks}
    made.road_map.validate()


@SIDES
@pytest.mark.parametrize("form", FORMS)
def test_loops_lie_in_the_quadrants_that_were_asked_for_and_are_circles(form: str, left_hand: bool) -> None:
    spec = specified(FORMS[form], left_hand)
    assert isinstance(spec.road, QuadrantInterchange)
    middles, lanes = set(), min(spec.road.ramp_lanes, spec.road.road_lanes if spec.road.trumpet else 2)
    for loop in ramps(draw(spec), "loop"):
        line = circle(loop, spec)
        middle = (line.max(axis=0) + line.min(axis=0)) / 2
        outer = spec.road.loop_radius + lanes * 3.5 / 2
        assert np.hypot(*(line - middle).T) == pytest.approx(outer, abs=0.1)
        middles.add(f"{'north' if middle[1] > 0 else 'south'}_{'east' if middle[0] > 0 else 'west'}")
        turns = np.diff(np.unwrap(np.arctan2(*np.diff(line, axis=0).T[::-1])))
        assert math.degrees(turns.sum()) == pytest.approx(270 if left_hand else -270, abs=6)
    assert middles == set(spec.road.loops)


def circle(loop: Edge, spec: MapSpec) -> np.ndarray:
    """The part of a loop that turns the way it does most; on a street it has a bend the other way before or behind."""
    line = np.array(loop.shape)
    turns = np.diff(np.unwrap(np.arctan2(*np.diff(line, axis=0).T[::-1])))
    most = np.flatnonzero(turns > 1e-3 if spec.left_hand else turns < -1e-3)
    return line[most[0] : most[-1] + 3]


def heading(lane: ElementTree.Element, end: int) -> float:
    points = [tuple(map(float, p.split(",")[:2])) for p in lane.get("shape", "").split()]
    (ax, ay), (bx, by) = points[:2] if end == 0 else points[-2:]
    return math.atan2(by - ay, bx - ax)


def place(lane: ElementTree.Element, end: int) -> np.ndarray:
    return np.array([float(v) for v in lane.get("shape", "").split()[end].split(",")[:2]])


@SIDES
@pytest.mark.parametrize("form", [form for form in FORMS if "street" not in form])
def test_lanes_go_on_without_a_gap_or_a_kink(form: str, left_hand: bool) -> None:
    root = ElementTree.fromstring(built(form, left_hand).network)
    lanes = {lane.get("id", ""): lane for lane in root.iter("lane")}
    for link in (one for one in root.iter("connection") if not one.get("from", "").startswith(":")):
        source, target = (lanes[f"{link.get(a)}_{link.get(b)}"] for a, b in (("from", "fromLane"), ("to", "toLane")))
        across = lanes[link.get("via", "")] if link.get("via") else target
        assert math.dist(place(source, -1), place(across, 0)) < 0.2
        assert math.dist(place(across, -1 if link.get("via") else 0), place(target, 0)) < 12.0
        assert abs(math.remainder(heading(target, 0) - heading(source, -1), math.tau)) < math.radians(12)


def led_to(road: QuadrantInterchange, left_hand: bool) -> set[tuple[str, str]]:
    """Which leg leads to which other or the same, by what ramps are for; in left-hand traffic each leads the other way."""
    on: dict[str, set[str]] = {f"{part} {leg}": set() for part, leg in product(("in", "bridge", "out"), LEGS)}
    for i, leg in enumerate(LEGS):  # carriageway i comes from that leg and leaves over the next but one
        on[f"in {leg}"].add(f"bridge {leg}")
        on[f"bridge {leg}"].add(f"out {LEGS[(i + 2) % 4]}")
    for name in road.directs:
        vertical, horizontal = name.split("_")
        clockwise = (LEGS.index(horizontal) - LEGS.index(vertical)) % 4 == 1
        a, b = (vertical, horizontal) if clockwise else (horizontal, vertical)
        on[f"in {a}"].add(f"out {b}")  # to the right
    for name in road.loops:
        vertical, horizontal = name.split("_")
        opposite = {"north": "south", "south": "north", "east": "west", "west": "east"}
        clockwise = (LEGS.index(horizontal) - LEGS.index(vertical)) % 4 == 1
        a, b = (horizontal, vertical) if clockwise else (vertical, horizontal)
        on[f"bridge {opposite[a]}"].add(f"bridge {b}")
    found = set()
    for leg in LEGS:
        seen, todo = set(), [f"in {leg}"]
        while todo:
            if (here := todo.pop()) not in seen:
                seen.add(here)
                todo += on.get(here, ())
        found |= {(leg, there.split()[1]) for there in seen if there.startswith("out")}
    return {(b, a) for a, b in found} if left_hand else found


def ways(network: bytes) -> set[tuple[str, str]]:
    """Which leg of the network leads to which, read from its connections."""
    root = ElementTree.fromstring(network)
    edges = {e.get("id", ""): e for e in root.iter("edge") if not e.get("function")}
    on: dict[str, set[str]] = {name: set() for name in edges}
    for link in root.iter("connection"):
        if link.get("from") in edges:
            on[link.get("from", "")].add(link.get("to", ""))
    entered = {name for after in on.values() for name in after}

    def leg(name: str, end: int) -> str:
        x, y = place(edges[name][0], end)
        return max(LEGS, key=lambda one: x * COMPASS[one][0] + y * COMPASS[one][1])

    found = set()
    for start in set(edges) - entered:
        seen, todo = set(), [start]
        while todo:
            if (here := todo.pop()) not in seen:
                seen.add(here)
                todo += on[here]
        found |= {(leg(start, 0), leg(here, -1)) for here in seen if not on[here]}
    return found


@SIDES
def test_a_cloverleaf_leads_from_everywhere_to_everywhere(left_hand: bool) -> None:
    assert ways(built("cloverleaf", left_hand).network) == set(product(LEGS, LEGS))


@SIDES
@pytest.mark.parametrize("form", [form for form in FORMS if form.startswith("trumpet")])
def test_a_trumpet_leads_from_each_leg_to_the_two_others(form: str, left_hand: bool) -> None:
    stem = "north" if "north" in form else "south"
    legs = ("east", "west", stem)
    assert ways(built(form, left_hand).network) == {(a, b) for a, b in product(legs, legs) if a != b}


def test_one_loop_adds_one_way() -> None:
    straight = {("east", "west"), ("west", "east"), ("north", "south"), ("south", "north")}
    assert ways(built("exit loop").network) == {*straight, ("west", "north")}


@SIDES
def test_a_partial_cloverleaf_over_a_street_leads_from_each_leg_to_all_others(left_hand: bool) -> None:
    others = {(a, b) for a, b in product(LEGS, LEGS) if a != b}
    for form in ("partial over a street", "two quadrants over a street"):
        assert others <= ways(built(form, left_hand).network)


def test_an_exit_loop_to_a_street_leads_both_ways_along_it() -> None:
    straight = {("east", "west"), ("west", "east"), ("north", "south"), ("south", "north")}
    assert ways(built("exit loop to a street").network) == {*straight, ("west", "north"), ("west", "south")}


@given(
    st.lists(st.sampled_from(["none", "direct", "loop", "both"]), min_size=4, max_size=4).filter(lambda r: set(r) != {"none"}),
    *(st.integers(1, 6), st.integers(1, 4), st.integers(1, 2)),
    *(st.floats(25, 80), st.floats(2, 30), st.booleans()),
)
@settings(max_examples=12, deadline=None)
def test_any_quadrants_lead_where_their_ramps_do(
    kinds: list[str], lanes: int, road_lanes: int, ramp_lanes: int, radius: float, median: float, left_hand: bool
) -> None:
    form = {**dict(zip(QUADRANTS, kinds, strict=True)), "lanes": lanes, "road_lanes": road_lanes, "ramp_lanes": ramp_lanes}
    spec = specified({**form, "loop_radius": radius, "median": median}, left_hand)
    assert isinstance(spec.road, QuadrantInterchange)
    examined = examine(spec)
    assert failures(list(examined.checks)) == []
    assert ways(examined.network) == led_to(spec.road, left_hand)


@given(
    *(st.integers(1, 6), st.integers(1, 4), st.integers(1, 2)),
    *(st.floats(25, 80), st.floats(2, 30), st.booleans(), st.booleans(), st.booleans()),
)
@settings(max_examples=12, deadline=None)
def test_any_trumpet_is_built_as_asked(
    lanes: int, road_lanes: int, ramp_lanes: int, radius: float, median: float, north: bool, east: bool, left_hand: bool
) -> None:
    stem, behind, side, other = *(("north", "south") if north else ("south", "north")), *("ew" if east else "we")
    quadrants = {f"{stem}_east": "direct", f"{stem}_west": "direct", f"{behind}_{NAMES[side]}": "both"}
    form = {**quadrants, f"{behind}_{NAMES[other]}": "none", f"{behind}_leg": False, "lanes": lanes, "road_lanes": road_lanes}
    examined = examine(specified({**form, "ramp_lanes": ramp_lanes, "loop_radius": radius, "median": median}, left_hand))
    assert failures(list(examined.checks)) == []
    legs = ("east", "west", stem)
    assert ways(examined.network) == {(a, b) for a, b in product(legs, legs) if a != b}


@given(
    st.lists(st.sampled_from(["none", "direct", "loop", "both"]), min_size=4, max_size=4).filter(lambda r: set(r) != {"none"}),
    *(st.integers(1, 6), st.integers(1, 4), st.integers(1, 2), st.floats(25, 80), st.floats(2, 30)),
    *(st.sampled_from(["signals", "stop", "yield", "all_way_stop"]), st.booleans()),
)
@settings(max_examples=10, deadline=None)
def test_any_quadrants_over_a_street_are_built_as_asked(
    kinds: list[str], lanes: int, road_lanes: int, ramp_lanes: int, radius: float, median: float, control: str, left_hand: bool
) -> None:
    form = {**dict(zip(QUADRANTS, kinds, strict=True)), "lanes": lanes, "road_lanes": road_lanes, "ramp_lanes": ramp_lanes}
    spec = specified({**form, "loop_radius": radius, "median": median, "control": control, "road_speed": 14.0}, left_hand)
    assert failures(list(examine(spec).checks)) == []


@pytest.mark.parametrize(
    "wrong",
    [
        NO_RAMPS,
        {"north_leg": False},
        {"north_leg": False, "south_leg": False},
        {"north_leg": False, "north_east": "none", "south_west": "both"},
        {"north_leg": False, "north_east": "none", "north_west": "loop", "south_west": "none", "south_east": "none"},
        {**TRUMPET, "north_east": "none", "control": "signals"},
        {"loop_radius": 10.0},
        {"loop_radius": math.nan},
    ],
)
def test_what_is_no_interchange_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        specified(wrong)


def test_without_its_height_the_road_would_lie_on_the_highway() -> None:
    network = built("cloverleaf").network
    assert (overlapping(parse(network, NETWORK), NETWORK), measure(parse(network, NETWORK), NETWORK).bridges) == ((), 1)
    low = network.replace(b",6.00", b",1.00")
    assert overlapping(parse(low, NETWORK), NETWORK) != ()
    assert measure(parse(low, NETWORK), NETWORK).bridges == 0


@pytest.mark.parametrize("form", ["cloverleaf", "trumpet", "exit loop", "exit loop to a street"])
def test_vehicles_drive_through_its_loops(form: str) -> None:
    spec = specified(FORMS[form])
    raw = built(form).network
    network = Network.read(raw, form)
    run = Run(seed=3, warm_up=30.0, seconds=120.0, lateral_resolution=0.8, time_limit=120.0)
    motion = simulate(raw, draw_demand(network, Demand(40, 14.0, 150.0), seeds.rng(3, form)), network.map.origin, run).motion
    for loop in ramps(draw(spec), "loop"):
        line = circle(loop, spec)
        middle = (line.max(axis=0) + line.min(axis=0)) / 2
        distance = np.hypot(*np.moveaxis(motion.position + network.map.origin - middle, -1, 0))
        on_it = motion.valid & (abs(distance - 45.0) < 2.5)
        turned = wrap_angle(np.diff(motion.heading, axis=1)) * (on_it[:, 1:] & on_it[:, :-1])
        assert np.count_nonzero(np.degrees(turned.sum(axis=1)) < -200) >= 5


def test_edits_reach_the_highway_of_an_interchange() -> None:
    road = edited(specified({}), "three lanes in each direction, limit 100 km/h").road
    assert isinstance(road, QuadrantInterchange)
    assert (road.lanes, road.speed, road.ramp_lanes) == (3, pytest.approx(100 / 3.6), 1)


def test_edits_of_signals_need_crossings() -> None:
    road = edited(specified(FORMS["partial over a street"]), "remove the signals").road
    assert isinstance(road, QuadrantInterchange)
    assert road.control == "yield"
    with pytest.raises(UnusableInput, match="no crossing that could be controlled"):
        edited(specified({}), "remove the signals")


@pytest.mark.parametrize(
    ("text", "loop", "ramp"),
    [
        ("cloverleaf, 50 km/h on the loops", 50, 60),
        ("a cloverleaf with ramps limited to 70 km/h, loops limited to 30 km/h", 30, 70),
    ],
)
def test_limits_of_loops_are_not_those_of_other_ramps(text: str, loop: int, ramp: int) -> None:
    spec = read(text, 7).road
    assert isinstance(spec, MapSpec)
    assert isinstance(spec.road, QuadrantInterchange)
    assert (spec.road.loop_speed, spec.road.ramp_speed) == (pytest.approx(loop / 3.6), pytest.approx(ramp / 3.6))


@pytest.mark.parametrize(
    ("text", "loops"),
    [
        ("partial cloverleaf", ("north_east", "south_west")),
        ("cloverleaf with three loops", ("south_east", "north_east", "south_west")),
        ("a trumpet interchange", ("north_west",)),
        ("a cloverleaf", QUADRANTS),
    ],
)
def test_words_put_loops_into_quadrants(text: str, loops: tuple[str, ...]) -> None:
    spec = read(text, 7).road
    assert isinstance(spec, MapSpec)
    assert isinstance(spec.road, QuadrantInterchange)
    assert spec.road.loops == loops


@SIDES
def test_a_trumpet_keeps_its_height_where_lanes_open(left_hand: bool) -> None:
    form = {**FORMS["trumpet"], "road_lanes": 3}
    mirrored = {**form, "north_east": form.get("north_west", "both"), "north_west": form["north_east"]}
    for road in (form, mirrored):
        root = parse(build_spec(specified(road, left_hand), {}).network, "trumpet")
        ends = {lane.get("id"): _heights(lane.get("shape", "")) for lane in root.iter("lane")}
        for link in root.iter("connection"):
            before, after = f"{link.get('from')}_{link.get('fromLane')}", f"{link.get('to')}_{link.get('toLane')}"
            if link.get("via") and not before.startswith(":") and ends[before][-1] == ends[after][0]:
                assert set(ends[link.get("via")]) == {ends[after][0]}, link.attrib


def _heights(shape: str) -> list[float]:
    return [float([*point.split(","), "0"][2]) for point in shape.split()]
