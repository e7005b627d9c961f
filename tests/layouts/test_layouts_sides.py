"""The outer side and the right of way where traffic keeps left; dead ends with a junction near the end."""

import numpy as np
import pytest

from drivegen.layouts.compile import compile_map
from drivegen.layouts.spec import MapSpec
from drivegen.maps.build import build_spec
from drivegen.maps.checks import failures
from drivegen.sumo.network import Network
from drivegen.words.read import read

SIDES = pytest.mark.parametrize("left_hand", [False, True], ids=["right-hand", "left-hand"])


@SIDES
def test_whoever_comes_from_the_right_goes_first_whatever_side_traffic_keeps_to(left_hand):
    arms = [{"angle": angle, "lanes_in": 1, "lanes_out": 1} for angle in (0, 90, 180, 270)]
    road = {"kind": "crossing", "control": "uncontrolled", "arms": arms}
    net = Network.read(compile_map(MapSpec.model_validate({"road": road, "left_hand": left_hand})), "crossing")
    links, inside = net.map.links.tolist(), net.map.in_junction
    arm_of = {b: net.lane_names[a].split("_")[0] for a, b in links if inside[b] and not inside[a]}
    to = {a: net.lane_names[b].split("_")[0] for a, b in links if inside[a] and not inside[b]}
    opposite = {"a0": "a2", "a1": "a3", "a2": "a0", "a3": "a1"}
    straight = {way for way in to if opposite[arm_of[way]] == to[way]}
    waits = {(arm_of[a], arm_of[b]) for a, b in net.map.yields_to.tolist() if a in straight and b in straight}
    assert waits == {("a0", "a1"), ("a1", "a2"), ("a2", "a3"), ("a3", "a0")}  # who comes from the east has the north on the right


@pytest.mark.parametrize("event", ["a lane ends at 600 m", "a lane is added at 400 m", "an exit-only off-ramp at 600 m"])
def test_lanes_end_and_begin_on_the_outer_side(event):
    right, left = (build_spec(read(f"{side}motorway, {event}", 7).road, {}) for side in ("", "left-hand traffic, "))
    for built in (right, left):
        assert failures(list(built.checks)) == []
    ends = [np.array([line[[0, -1], 1] for line in built.road_map.centreline.lines()]) for built in (right, left)]
    assert np.sort(ends[1].ravel()) == pytest.approx(np.sort(-ends[0].ravel()), abs=0.02)


@SIDES
@pytest.mark.parametrize("position", [200, 240, 270, 279])
def test_the_road_goes_on_behind_the_last_junction_of_a_dead_end(position, left_hand):
    junctions = [{"position": position, "sides": ["left"], "control": "yield"}]
    road = {"kind": "corridor", "alignment": {"length": 300}, "dead_end": True, "junctions": junctions}
    built = build_spec(MapSpec.model_validate({"road": road, "left_hand": left_hand}), {})
    assert failures(list(built.checks)) == []
    net = Network.read(built.network, "dead end")
    behind = net.map.centreline[net.lane_names.index("m1_0")]
    assert behind[-1, 0] - behind[0, 0] > 8.0
    assert np.ptp(behind[:, 1]) < 0.1
