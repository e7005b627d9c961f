"""Medians between the directions of roads with junctions: how wide they are, where they end, and that nobody drives on them."""

import numpy as np
import pytest
from pydantic import ValidationError

from drivegen.layouts.spec import MapSpec
from drivegen.maps.build import build_spec
from drivegen.maps.checks import failures
from drivegen.sumo.network import Network
from drivegen.words.read import read

HANDS = pytest.mark.parametrize("left_hand", [False, True], ids=["right-hand", "left-hand"])
CROSSED = {
    "kind": "crossing",
    "control": "signals",
    "arms": [{"angle": a, "lanes_in": 2, "lanes_out": 2} for a in (0, 90, 180, 270)],
}
BETWEEN = 6.0


def network(road, left_hand=False):
    built = build_spec(MapSpec.model_validate({"road": road, "left_hand": left_hand}), {})
    assert failures(list(built.checks)) == []
    return Network.read(built.network, "median")


def offsets(net, edge):
    """How far the middles of the edge's lanes lie beside the x-axis along them: (lanes, points)."""
    return [net.map.centreline[i][:, 1] for i, name in enumerate(net.lane_names) if name.rpartition("_")[0] == edge]


@HANDS
@pytest.mark.parametrize("pockets", [{}, {"left_turn_lanes": 1, "right_turn_lanes": 1, "pocket": 40.0}], ids=["plain", "pockets"])
def test_the_innermost_lanes_of_an_arm_are_a_median_and_a_lane_apart(left_hand, pockets):
    arms = [arm | ({"median": BETWEEN, **pockets} if arm["angle"] in (0, 180) else {}) for arm in CROSSED["arms"]]
    net = network({**CROSSED, "arms": arms}, left_hand)
    nearest = {edge: min(np.abs(line).min() for line in offsets(net, edge)) for edge in ("a0_out", "a2_in", "a1_out")}
    turns_left = 3.2 if pockets else 0.0
    assert nearest["a0_out"] == pytest.approx(BETWEEN / 2 + 1.6, abs=0.02)
    assert nearest["a2_in"] == pytest.approx(BETWEEN / 2 + 1.6 + turns_left, abs=0.02)
    if pockets:
        assert min(np.abs(line).min() for line in offsets(net, "a2_pocket")) == pytest.approx(BETWEEN / 2 + 1.6, abs=0.02)


@HANDS
def test_a_road_that_is_divided_is_so_between_its_junctions_and_comes_together_at_rings(left_hand):
    inner = "right_turn_lanes" if left_hand else "left_turn_lanes"
    junctions = [{"position": 200.0, "control": "signals", inner: 1}, {"position": 450.0, "form": "roundabout"}]
    road = {"kind": "corridor", "alignment": {"length": 650}, "junctions": junctions, "median": BETWEEN}
    net = network(road, left_hand)
    (before,), (behind,) = offsets(net, "m0"), offsets(net, "-m0")
    turning = BETWEEN / 2 + 1.6 + 3.2
    assert np.abs(before) == pytest.approx(turning, abs=0.02)
    assert np.abs(behind) == pytest.approx(turning, abs=0.02)
    assert np.sign(before[0]) == -np.sign(behind[0])
    (to_ring,) = offsets(net, "m1")
    assert abs(to_ring[0]) == pytest.approx(turning, abs=0.02)
    assert abs(to_ring[-1]) < 3.0


@pytest.mark.parametrize(
    ("road", "why"),
    [
        ({"kind": "corridor", "lanes_back": 0, "median": 4.0}, "one-way road has no median"),
        (
            {**CROSSED, "arms": [*CROSSED["arms"][:3], {"angle": 270, "lanes_out": 0, "median": 4.0}]},
            "one-way road has no median",
        ),
        ({"kind": "roundabout", "arms": [{"angle": a, "median": 4.0} for a in (0, 120, 240)]}, "no median here"),
        ({"kind": "corridor", "median": -1.0}, "greater than or equal to 0"),
    ],
)
def test_a_median_that_cannot_be_is_refused(road, why):
    with pytest.raises(ValidationError, match=why):
        MapSpec.model_validate({"road": road})


@pytest.mark.parametrize(
    ("text", "medians"),
    [
        ("a divided road with two lanes each way crossing a side street", [4, 0, 4, 0]),
        ("a boulevard with a 6 m wide median and three lanes per direction, crossing a street at traffic lights", [6, 0, 6, 0]),
        (
            "a divided arterial with three lanes each way crossing a two-lane side street at a signalised intersection",
            [4, 0, 4, 0],
        ),
        ("two dual carriageways that cross", [4, 4, 4, 4]),
        ("a four-way intersection, the main road is divided by a median of 5 m", [5, 0, 5, 0]),
        ("a crossing where every arm has a median of 3 m", [3, 3, 3, 3]),
        ("a divided avenue with two lanes in each direction meeting a side street at a T", [4, 4, 0]),
    ],
)
def test_words_say_which_roads_are_divided(text, medians):
    assert [arm.median for arm in read(text, 7).road.road.arms] == medians


def test_a_divided_road_alone_or_with_ramps_is_a_highway_and_one_with_crossings_a_street():
    assert read("a divided road, 500 m long", 7).road.road.kind == "highway"
    assert read("a divided highway with an on-ramp", 7).road.road.kind == "highway"
    street = read("a divided boulevard with three signalised intersections 200 m apart", 7).road.road
    assert (street.kind, street.median, len(street.junctions)) == ("corridor", 4.0, 3)
