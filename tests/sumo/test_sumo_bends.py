"""Speeds in bends, lane lengths, smooth tracks and cyclists: what makes simulated traffic drive as people do."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core import seeds
from drivegen.core.errors import UnusableInput
from drivegen.core.safe_xml import parse
from drivegen.core.scenario import DT, Trajectories
from drivegen.layouts.compile import compile_map
from drivegen.layouts.spec import MapSpec
from drivegen.sumo.bends import COMFORTABLE, bend_speed, with_human_speeds
from drivegen.sumo.demand import Demand, draw_demand
from drivegen.sumo.network import Network
from drivegen.sumo.traffic import LAG, smoothed, tracked
from tests.sumo.nets import CROSS


@given(st.floats(12, 200), st.floats(-180, 180), st.floats(5, 20))
@settings(max_examples=50, deadline=None)
def test_an_arc_is_driven_with_comfortable_lateral_acceleration_however_it_lies(radius, at, limit):
    around = np.radians(at) + np.linspace(0.0, np.pi / 2, 400)
    line = radius * np.stack([np.cos(around), np.sin(around)], axis=-1)
    assert bend_speed(line, limit) ** 2 / radius == pytest.approx(COMFORTABLE, rel=0.15)
    assert bend_speed(line[::-1], limit) == pytest.approx(bend_speed(line, limit), rel=0.05)


def test_a_straight_line_has_no_speed_of_its_own_and_a_kink_of_a_motorway_hardly_slows():
    assert bend_speed(np.array([[0.0, 0.0], [100.0, 0.0]]), 30.0) == np.inf
    kink = np.array([[0.0, 0.0], [300.0, 0.0], [600.0, 300.0 * np.tan(np.radians(4.0))]])
    assert bend_speed(kink, 33.0) > 33.0


def test_lanes_of_an_edge_are_as_long_as_their_shapes_and_no_lane_gets_faster():
    root = parse(with_human_speeds(CROSS.encode(), "cross"), "cross")
    lanes = {lane.get("id"): lane for lane in root.iter("lane")}
    assert float(lanes[":c_1_0"].get("length")) == pytest.approx(np.hypot(7, 3.6), abs=0.01)
    assert float(lanes["w_in_1"].get("speed")) == 13.89
    before = {lane.get("id"): float(lane.get("speed")) for lane in parse(CROSS.encode(), "cross").iter("lane")}
    assert all(float(lane.get("speed")) <= before[name] for name, lane in lanes.items())
    assert (
        Network.read(with_human_speeds(CROSS.encode(), "cross"), "cross").lane_names
        == Network.read(CROSS.encode(), "c").lane_names
    )
    with pytest.raises(UnusableInput, match="no XML"):
        with_human_speeds(b"<html/>", "no XML")


def line_of(position: np.ndarray, heading: np.ndarray, valid: np.ndarray) -> Trajectories:
    return Trajectories(position.astype(np.float32), heading.astype(np.float32), np.zeros_like(position, np.float32), valid)


def test_smoothing_keeps_uniform_motion_ends_and_gaps_and_rounds_a_corner():
    time = np.arange(40) * DT
    straight = np.stack([10 * time, -3 * time], axis=-1)[None]
    valid = np.ones((1, 40), bool)
    valid[0, :5] = False
    kept = smoothed(line_of(straight, np.full((1, 40), 3.1), valid))
    assert np.allclose(kept.position, straight, atol=1e-4)
    assert np.allclose(kept.heading, 3.1, atol=1e-5)
    assert np.array_equal(kept.valid, valid)
    heading = np.where(time < 2.0, 3.0, -3.0)[None]  # by 0.28 rad across the seam at pi, in one step
    turned = smoothed(line_of(straight, heading, np.ones((1, 40), bool))).heading
    steps = (np.diff(turned) + np.pi) % (2 * np.pi) - np.pi
    assert np.abs(steps).max() < 0.05
    assert turned[0, [0, -1]] == pytest.approx([3.0, -3.0])


def test_a_track_tells_nothing_of_what_is_driven_later():
    random = np.random.default_rng(5)
    position, heading = random.normal(size=(3, 80, 2)).cumsum(1), random.uniform(-3, 3, (3, 80))
    other_position, other_heading = position.copy(), heading.copy()
    valid, other_valid = np.ones((2, 3, 80), bool)
    valid[1, :30] = other_valid[1, :30] = False
    other_position[:, 41:] += 7.0
    other_heading[:, 41:] -= 1.0
    other_valid[2, 41:] = False
    one, two = (tracked(line_of(*raw)) for raw in ((position, heading, valid), (other_position, other_heading, other_valid)))
    assert one.steps == 80 - LAG
    now = 41 - LAG  # what it knows then reaches to step 40 of what is driven
    for name in ("position", "heading", "velocity", "valid"):
        assert np.array_equal(getattr(one, name)[:, :now], getattr(two, name)[:, :now])
    assert not np.array_equal(one.velocity[:, now], two.velocity[:, now])


def test_cyclists_keep_to_slow_roads():
    def kinds(speed: float) -> set[str]:
        arms = [{"angle": angle, "speed": speed} for angle in (0, 120, 240)]
        network = Network.read(compile_map(MapSpec.model_validate({"road": {"kind": "crossing", "arms": arms}})), "y")
        root = parse(draw_demand(network, Demand(300, 14.0, 1.0), seeds.rng(1, "demand")), "demand")
        return {vehicle.get("type", "").partition("-")[0] for vehicle in root.iter("vehicle")}

    assert "cyclist" in kinds(13.9)
    assert kinds(22.0) == kinds(13.9) - {"cyclist"}
