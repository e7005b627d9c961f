"""Specifications become networks that have what they ask for, whatever side traffic keeps to."""

import math
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from drivegen.checker.limits import LATERAL_ACCELERATION, OFF_ROAD
from drivegen.checker.scene import SceneChecker
from drivegen.core import seeds
from drivegen.layouts.compile import compile_map, draw
from drivegen.layouts.spec import MapSpec
from drivegen.layouts.streets import Corridor
from drivegen.maps.build import build_map, build_spec
from drivegen.maps.checks import failures
from drivegen.sumo.demand import Demand, draw_demand
from drivegen.sumo.network import Network
from drivegen.sumo.traffic import Run, simulate
from drivegen.words.writer import Writer
from tests.checking import LIMITS
from tests.scenes import drive, joined, scenario, stack

FOUR = [{"angle": angle} for angle in (0, 90, 180, 270)]
ROADS: dict[str, dict[str, Any]] = {
    "crossing": {"kind": "crossing", "arms": FOUR, "control": "signals"},
    "turn_bans": {
        "kind": "corridor",
        "lanes": 2,
        "lane_width": 3.5,
        "junctions": [
            {"position": 200, "sides": ["left", "left", "right"], "turn_bans": ["left"], "side_turn_bans": ["left"]},
            {"position": 400, "sides": ["right"], "side_turn_bans": ["left"], "right_turn_lanes": 1},
        ],
    },
    "pockets": {
        "kind": "crossing",
        "control": "stop",
        "arms": [{"angle": a, "lanes_in": 2, "left_turn_lanes": 1, "right_turn_lanes": 1} for a in (0, 180, 270)],
    },
    "roundabout": {"kind": "roundabout", "arms": FOUR, "ring_lanes": 2, "diameter": 60},
    "corridor": {
        "kind": "corridor",
        "lanes": 2,
        "lanes_back": 2,
        "junctions": [{"position": 150}, {"position": 330, "form": "roundabout"}, {"position": 500, "sides": ["left"]}],
    },
    "turn_lanes_in_a_row": {
        "kind": "corridor",
        "lanes": 2,
        "lanes_back": 2,
        "alignment": {"length": 700},
        "junctions": [{"position": p, "control": "signals", "left_turn_lanes": 1} for p in (150, 350, 550)],
    },
    "turn_lanes_of_all_sorts": {
        "kind": "corridor",
        "alignment": {"length": 600},
        "junctions": [
            {"position": 40, "sides": ["left"], "left_turn_lanes": 1, "right_turn_lanes": 1, "side_lanes": 2},
            {"position": 200, "form": "roundabout"},
            {"position": 450, "sides": ["right"], "control": "stop", "right_turn_lanes": 1, "pocket": 500},
        ],
        "dead_end": True,
    },
    "turn_lanes_one_way": {
        "kind": "corridor",
        "lanes_back": 0,
        "junctions": [{"position": 300, "left_turn_lanes": 1, "right_turn_lanes": 1}],
    },
    "junctions_along_bends": {
        "kind": "corridor",
        "alignment": {"shape": "s_curve", "length": 700, "angle": 70, "radius": 80},
        "lanes": 2,
        "junctions": [
            {"position": 120, "sides": ["left"], "left_turn_lanes": 1},
            {"position": 350, "sides": ["left", "right"], "control": "signals", "left_turn_lanes": 1, "side_length": 60},
            {"position": 580, "sides": ["right"], "form": "roundabout"},
        ],
    },
    "five_roads_in_a_row": {
        "kind": "corridor",
        "junctions": [
            {"position": 200, "sides": ["left", "right", "left"], "form": "roundabout"},
            {"position": 420, "sides": ["right", "left", "right"], "control": "signals", "right_turn_lanes": 1},
        ],
    },
    "mini_roundabout": {"kind": "roundabout", "arms": FOUR, "diameter": 14},
    "mini_roundabouts_in_a_row": {
        "kind": "corridor",
        "alignment": {"length": 300},
        "junctions": [{"position": p, "form": "roundabout", "diameter": 14} for p in (100, 200)],
    },
    "walking_pace": {
        "kind": "corridor",
        "speed": 1.0,
        "junctions": [{"position": 300, "side_speed": 7 / 3.6, "dead_end": True}],
        "dead_end": True,
    },
    "long_street": {"kind": "corridor", "alignment": {"length": 10000}, "junctions": [{"position": 9900, "side_length": 10000}]},
    "long_highway": {"kind": "highway", "alignment": {"length": 10000}, "events": [{"kind": "off_ramp", "position": 9700}]},
    "dead_end": {"kind": "corridor", "alignment": {"length": 150}, "dead_end": True},
    "s_curve": {"kind": "corridor", "alignment": {"shape": "s_curve", "angle": -50, "radius": 80}},
    "uneven_s_curve": {
        "kind": "corridor",
        "alignment": {"shape": "s_curve", "length": 400, "arcs": [[90, 50], [-70, 75]]},
    },
    "hairpins_of_two_sizes": {
        "kind": "highway",
        "carriageways": 1,
        "alignment": {"shape": "hairpin", "length": 900, "arcs": [[180, 30], [-170, 60]]},
    },
    "grid": {"kind": "grid", "rows": 2, "columns": 3, "one_way": True, "control": "uncontrolled"},
    "ramps": {
        "kind": "highway",
        "alignment": {"shape": "curve", "angle": 40, "radius": 600, "length": 1100},
        "events": [{"kind": "on_ramp", "position": 250}, {"kind": "weaving", "position": 600, "length": 250, "lanes": 2}],
    },
    "lane_changes": {
        "kind": "highway",
        "lanes": 4,
        "both": True,
        "events": [{"kind": "lane_drop", "position": 300, "lanes": 2}, {"kind": "lane_gain", "position": 600, "side": "left"}],
    },
    "fork": {"kind": "fork", "lanes": 3, "left_lanes": 2, "right_lanes": 1},
    "fork_with_a_stem": {"kind": "fork", "lanes": 3, "left_lanes": 2, "right_lanes": 1, "length": 400, "stem": 600},
    "join_with_a_stem": {"kind": "fork", "joins": True, "length": 900, "stem": 40},
    "graph": {
        "kind": "graph",
        "nodes": [{"name": "a", "x": 0, "y": 0}, {"name": "b", "x": 200, "y": 0}, {"name": "c", "x": 300, "y": 150}],
        "roads": [
            {"name": "ab", "start": "a", "end": "b", "lanes": 2},
            {"name": "bc", "start": "b", "end": "c", "shape": [[260, 20]]},
        ],
    },
}


@pytest.mark.parametrize("left_hand", [False, True], ids=["right-hand", "left-hand"])
@pytest.mark.parametrize("name", ROADS)
def test_every_kind_of_road_is_built_as_asked(name: str, left_hand: bool) -> None:
    built = build_spec(MapSpec.model_validate({"road": ROADS[name], "left_hand": left_hand}), {})
    assert failures(list(built.checks)) == []
    built.road_map.validate()


def test_left_hand_traffic_keeps_the_arms_where_they_were_asked_for() -> None:
    road = {"kind": "crossing", "arms": [{"angle": 10}, {"angle": 120}, {"angle": 250}]}
    ends = []
    for left_hand in (False, True):
        nodes = draw(MapSpec.model_validate({"road": road, "left_hand": left_hand})).nodes
        ends.append(sorted(round(math.degrees(math.atan2(n.y, n.x)) % 360) for n in nodes if n.id != "c"))
    assert ends == [[10, 120, 250], [10, 120, 250]]


@pytest.mark.parametrize("joins", [False, True], ids=["divides", "joins"])
@pytest.mark.parametrize(("stem", "lengths"), [(600, [400, 400, 600]), (None, [400, 400, 400])])
def test_the_road_of_a_fork_is_as_long_as_its_stem(stem: float | None, lengths: list[float], joins: bool) -> None:
    road = {"kind": "fork", "length": 400, "stem": stem, "joins": joins}
    network = ElementTree.fromstring(compile_map(MapSpec.model_validate({"road": road})))
    edges = [edge for edge in network.iter("edge") if not edge.get("function")]
    found = sorted(float(edge[0].get("length", "0")) for edge in edges)
    assert found == pytest.approx(lengths, abs=15)  # less what the node takes of each


@pytest.mark.parametrize("left_hand", [False, True], ids=["right-hand", "left-hand"])
@pytest.mark.parametrize(
    ("event", "alignment"),
    [
        ({"kind": "off_ramp", "position": 400}, {"length": 1100}),
        ({"kind": "off_ramp", "position": 400}, {"length": 1100, "shape": "curve", "angle": -20, "radius": 2000}),
        ({"kind": "lane_gain", "position": 300}, {"length": 900}),
        ({"kind": "lane_gain", "position": 300, "side": "left"}, {"length": 900}),
    ],
    ids=["exit", "exit-in-a-bend", "lane-gain", "lane-gain-left"],
)
def test_one_can_drive_into_a_lane_that_opens_at_the_limit(
    event: dict[str, Any], alignment: dict[str, Any], left_hand: bool
) -> None:
    road = {"kind": "highway", "carriageways": 1, "lanes": 2, "speed": 30, "alignment": alignment, "events": [event]}
    roads = build_spec(MapSpec.model_validate({"road": road, "left_hand": left_hand}), {}).road_map
    forks = [lane for lane in range(len(roads)) if np.count_nonzero(roads.links[:, 0] == lane) > 1]
    ways = [
        (lane, inside, on)
        for lane in forks
        for inside in roads.links[roads.links[:, 0] == lane, 1]
        for on in roads.links[roads.links[:, 0] == inside, 1]
    ]
    assert len(ways) == 2
    tracks = stack([drive(joined(roads, *way), 150.0, 30.0, 101) for way in ways])
    judged = SceneChecker(scenario(roads, tracks), LIMITS).alone(np.arange(2), tracks)
    assert judged.worst[:, LATERAL_ACCELERATION].max() < LIMITS.lateral_acceleration
    assert judged.worst[:, OFF_ROAD].max() < LIMITS.off_road


@pytest.mark.parametrize("left_hand", [False, True], ids=["right-hand", "left-hand"])
@pytest.mark.parametrize("bend", [{}, {"shape": "curve", "angle": 40, "radius": 200}], ids=["straight", "in-a-bend"])
def test_one_can_drive_into_a_turn_lane_at_the_limit(bend: dict[str, Any], left_hand: bool) -> None:
    junction = {"position": 300, "left_turn_lanes": 1, "right_turn_lanes": 1}
    road = {"kind": "corridor", "alignment": {"length": 500, **bend}, "junctions": [junction]}
    network = Network.read(compile_map(MapSpec.model_validate({"road": road, "left_hand": left_hand})), "turn lanes")
    roads, edge = network.map, [name.rpartition("_")[0] for name in network.lane_names]
    links = roads.links.tolist()
    ways = [(a, b, d) for a, b in links if edge[a] == "m0" for c, d in links if c == b and edge[d] == "m0_e"]
    assert len(ways) == 3
    tracks = stack([drive(joined(roads, *way), 125.0, 50 / 3.6, 101) for way in ways])
    judged = SceneChecker(scenario(roads, tracks), LIMITS).alone(np.arange(3), tracks)
    assert judged.worst[:, LATERAL_ACCELERATION].max() < LIMITS.lateral_acceleration
    assert judged.worst[:, OFF_ROAD].max() < LIMITS.off_road


def test_turn_lanes_in_a_row_open_ahead_of_each_crossing_and_lead_only_into_side_roads() -> None:
    network = ElementTree.fromstring(compile_map(MapSpec.model_validate({"road": ROADS["turn_lanes_in_a_row"]})))
    pockets = {e.get("id", ""): e.findall("lane") for e in network.iter("edge") if len(e.findall("lane")) == 3}
    pockets = {name: lanes for name, lanes in pockets.items() if not name.startswith(":")}
    assert sorted(pockets) == ["-m1_w", "-m2_w", "-m3_w", "m0_e", "m1_e", "m2_e"]
    assert all(35 < float(lanes[0].get("length", "0")) < 60 for lanes in pockets.values())
    for name, side in (("m1_e", "j1_left_out"), ("-m2_w", "j1_right_out")):
        ways = [link for link in network.iter("connection") if link.get("from") == name]
        assert [link.get("to") for link in ways if link.get("fromLane") == "2"] == [side]
        assert [link.get("fromLane") for link in ways if link.get("to") == side] == ["2"]


@pytest.mark.parametrize("left_hand", [False, True], ids=["right-hand", "left-hand"])
def test_two_turn_lanes_lead_into_two_lanes_and_a_banned_turn_has_no_way(left_hand: bool) -> None:
    arms = [{**arm, "lanes_in": 2, "lanes_out": 2} for arm in FOUR]
    arms[0] |= {"left_turn_lanes": 2, "turn_bans": ["right"]}
    road = {"kind": "crossing", "arms": arms, "lane_width": 3.0}
    network = ElementTree.fromstring(compile_map(MapSpec.model_validate({"road": road, "left_hand": left_hand})))
    entering = next(e for e in network.iter("edge") if e.get("to") == "c" and e.get("id", "").startswith("a0"))
    assert [lane.get("width") for lane in entering.iter("lane")] == ["3.00"] * 4
    ways: dict[str, list[tuple[str | None, str | None]]] = {}
    for link in network.iter("connection"):
        if link.get("from") == entering.get("id"):
            ways.setdefault(link.get("to", ""), []).append((link.get("fromLane"), link.get("toLane")))
    left, straight = ("01", "23") if left_hand else ("23", "01")  # lane 0 is the outermost
    assert sorted(ways["a3_out"]) == [(left[0], "0"), (left[1], "1")]
    assert "".join(sorted(str(lane) for lane, _ in ways["a2_out"])) == straight
    assert set(ways) - {"a0_out"} == {"a3_out", "a2_out"}


def test_a_turn_lane_needs_a_lane_to_turn_into_and_a_road_some_way_on() -> None:
    for arm, why in (({"left_turn_lanes": 2}, "2 lanes to turn into"), ({"turn_bans": ["left", "right"]}, "nowhere")):
        with pytest.raises(ValidationError, match=why):
            MapSpec.model_validate({"road": {"kind": "crossing", "arms": [*FOUR[:1], FOUR[2], {"angle": 270, **arm}]}})


@pytest.mark.parametrize("left_hand", [False, True], ids=["right-hand", "left-hand"])
def test_each_arc_turns_to_its_own_side_with_its_own_radius(left_hand: bool) -> None:
    plain = draw(MapSpec.model_validate({"road": ROADS["uneven_s_curve"], "left_hand": left_hand}))
    steps = np.diff(np.array(plain.edges[0].shape), axis=0)
    heading = np.degrees(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0])))
    assert (heading.max(), heading[-1]) == (pytest.approx(90, abs=3), pytest.approx(20, abs=3))
    curvature = np.radians(np.diff(heading)) / np.hypot(*steps[1:].T)
    assert 1 / np.median(curvature[curvature > 0]) == pytest.approx(50, rel=0.05)
    assert 1 / np.median(curvature[curvature < 0]) == pytest.approx(-75, rel=0.05)


@pytest.mark.parametrize("more", [{"angle": 60}, {"radius": 20}, {"bends": 2}, {"shape": "straight"}])
def test_bends_are_told_one_by_one_or_all_alike(more: dict[str, Any]) -> None:
    line = {"shape": "s_curve", "arcs": [[90, 50], [-70, 75]], **more}
    with pytest.raises(ValidationError, match="arcs stand for the angle, radius and number of bends"):
        MapSpec.model_validate({"road": {"kind": "corridor", "alignment": line}})


def test_there_are_turn_lanes_only_where_a_road_leaves_on_that_side() -> None:
    road = {"kind": "corridor", "lanes_back": 2, "junctions": [{"position": 300, "sides": ["left"], "left_turn_lanes": 1}]}
    spec = MapSpec.model_validate({"road": road}).road
    assert isinstance(spec, Corridor)
    assert spec.turn_lanes(0) == (1, 0, 60.0)
    assert spec.turn_lanes(0, back=True)[:2] == (0, 0)
    assert "max lanes" in {c.name for c in build_spec(MapSpec(road=spec), {}).checks}


@pytest.mark.parametrize(
    "change",
    [
        {"arms": FOUR[:2]},
        {"arms": [*FOUR, {"angle": 5}]},
        {"arms": [{**arm, "lanes_in": 0} for arm in FOUR]},
        {"arms": [{**arm, "lanes_in": 9} for arm in FOUR]},
        {"arms": [{**arm, "speed": math.nan} for arm in FOUR]},
        {"control": "police"},
        {"colour": "red"},
    ],
)
def test_specifications_out_of_bounds_are_refused(change: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        MapSpec.model_validate({"road": {**ROADS["crossing"], **change}})


def test_a_ring_too_small_for_its_roads_is_refused_with_the_size_it_needs() -> None:
    arms = [{"angle": 45 * i} for i in range(8)]
    with pytest.raises(ValidationError, match="8 roads need a roundabout of at least 24 m across"):
        MapSpec.model_validate({"road": {"kind": "roundabout", "arms": arms, "diameter": 22}})


@pytest.mark.parametrize("lanes", [2, 3, 4])
def test_a_ring_of_several_lanes_is_no_mini_roundabout(lanes: int) -> None:
    ring = {"ring_lanes": lanes, "diameter": 23.9}
    message = f"a ring with {lanes} lanes must be at least 24 m across"
    with pytest.raises(ValidationError, match=message):
        MapSpec.model_validate({"road": {"kind": "roundabout", "arms": FOUR, **ring}})
    junction = {"position": 150, "form": "roundabout", "ring_lanes": min(lanes, 3), "diameter": 23.9}
    with pytest.raises(ValidationError, match="must be at least 24 m across"):
        MapSpec.model_validate({"road": {"kind": "corridor", "junctions": [junction]}})


def test_a_free_graph_cannot_have_more_lanes_than_can_be_checked() -> None:
    far = [{"name": "a", "x": -9000, "y": 0}, {"name": "b", "x": 9000, "y": 0}]
    roads = [{"name": f"r{i}", "start": "a", "end": "b", "lanes": 8, "lanes_back": 8} for i in range(4)]
    MapSpec.model_validate({"road": {"kind": "graph", "nodes": far, "roads": roads[:3]}})
    with pytest.raises(ValidationError, match="1152 km of lanes together, more than 1000 km"):
        MapSpec.model_validate({"road": {"kind": "graph", "nodes": far, "roads": roads}})


@pytest.mark.parametrize("arms", [3, 4])
def test_vehicles_drive_through_the_smallest_ring(arms: int) -> None:
    road = {"kind": "roundabout", "diameter": 14, "arms": [{"angle": 360 / arms * i} for i in range(arms)]}
    raw = compile_map(MapSpec.model_validate({"road": road}))
    network = Network.read(raw, "mini-roundabout")
    run = Run(seed=3, warm_up=30.0, seconds=30.0, lateral_resolution=0.8, time_limit=60.0)
    motion = simulate(raw, draw_demand(network, Demand(20, 14.0, 40.0), seeds.rng(3, "ring")), network.map.origin, run).motion
    distance = np.hypot(*np.moveaxis(motion.position + network.map.origin, -1, 0))
    inside = motion.valid & (distance < 7.0)
    last = np.argmax(np.cumsum(motion.valid, axis=1), axis=1)
    through = inside.any(axis=1) & (distance[np.arange(len(last)), last] > 20.0)
    assert np.count_nonzero(through) >= 5


@given(st.lists(st.integers(0, 17), min_size=3, max_size=8, unique=True), st.integers(1, 4), st.booleans())
@settings(max_examples=8, deadline=None)
def test_any_arms_that_are_apart_meet_at_one_crossing(sectors: list[int], lanes: int, signals: bool) -> None:
    ring = sorted(sectors)
    nearest = min((after - before) % 18 for before, after in zip(ring, [*ring[1:], ring[0] + 18], strict=True))
    assume(lanes <= 2 * nearest)  # wider roads at 20 degrees lie on top of one another, which the checks say
    arms = [{"angle": 20.0 * s, "lanes_in": lanes, "lanes_out": lanes, "left_turn_lanes": s % 2 == 0} for s in sectors]
    control = "signals" if signals else "yield"
    built = build_spec(MapSpec.model_validate({"road": {"kind": "crossing", "arms": arms, "control": control}}), {})
    assert failures(list(built.checks)) == []


@pytest.mark.parametrize(
    ("text", "merges", "diverges"),
    [
        ("T-junction of one-way streets", 1, 0),
        ("T-junction with signals, all roads one-way", 1, 0),
    ],
)
def test_where_roads_only_join_or_part_no_arms_are_expected(text: str, merges: int, diverges: int) -> None:
    built = build_map(text, 7, Writer())
    assert failures(list(built.checks)) == []
    assert (built.structure.merges, built.structure.diverges, built.structure.signals) == (merges, diverges, "signals" in text)


def test_a_bend_with_a_ramp_in_it_is_as_asked() -> None:
    text = "one-way motorway with a 60 degree bend to the left with a radius of 300 m and an off-ramp at 560 m, 1100 m long"
    assert failures(list(build_map(text, 7, Writer()).checks)) == []
