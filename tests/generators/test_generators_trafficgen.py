"""TrafficGen: what a vehicle sees, how a mode is driven, what is learnt, how vehicles are placed."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.geometry import boxes_overlap, rotate
from drivegen.core.scenario import Scenario
from drivegen.core.signals import Signals, SignalState
from drivegen.generators._trafficgen.driving import between_knots
from drivegen.generators._trafficgen.learning import RECOVERY, Disturbance, MotionExamples, motion_loss
from drivegen.generators._trafficgen.net import ACCELERATION, BRAKING, CURVATURE, DT_KNOT, LATERAL, Gates, Modes, driven
from drivegen.generators._trafficgen.placement import PlacementExamples
from drivegen.generators._trafficgen.vectors import Surroundings
from drivegen.generators.shared.closed_loop import Tracks
from drivegen.generators.shared.lanes import REACH, LaneVectors, Logs, nearest
from drivegen.generators.trafficgen import _around_target
from tests.generators.rivals import trained
from tests.scenes import busy_crossing, drive, scenario, stack, straight_road

COUNTS = (200, 6)  # more than there are pieces of lanes: of the nearest there may be several equally near


def surroundings(scene: Scenario, step: int = 0, piece: float = 10.0) -> Surroundings:
    crowd = Tracks.of_logs([scene]).at(np.zeros(1, int), np.array([step]))
    return Surroundings.of(LaneVectors.of([scene], piece), crowd, np.flatnonzero(crowd.planned & crowd.there), COUNTS, 1.0)


def moved(scene: Scenario, turn: float, shift: np.ndarray) -> Scenario:
    """The scene turned about the origin, then shifted."""

    def put(points):
        return (rotate(points.astype(np.float64), np.float64(turn)) + shift).astype(np.float32)

    vehicles = replace(scene.vehicles, position=put(scene.vehicles.position), heading=scene.vehicles.heading + np.float32(turn))
    log = replace(
        scene.log,
        position=put(scene.log.position),
        heading=scene.log.heading + np.float32(turn),
        velocity=rotate(scene.log.velocity, np.float32(turn)).astype(np.float32),
    )
    lines = replace(scene.map.centreline, points=put(scene.map.centreline.points))
    return replace(scene, map=replace(scene.map, centreline=lines), vehicles=vehicles, log=log)


def test_of_no_boxes_that_are_asked_for_none_is_the_nearest():
    assert len(nearest.py_func(np.array([3.0, 1.0], np.float32), 0)) == 0  # compiled, it would write where it may not


def test_a_vehicle_sees_the_lane_ahead_and_the_car_before_it_in_its_own_frame():
    roads = straight_road(100.0, 1)
    lane = np.stack([np.arange(0, 101, 10.0), np.zeros(11)], axis=1)
    scene = scenario(roads, stack([drive(lane, 20.0, 5.0, 11), drive(lane, 45.0, 10.0, 11)]))
    seen = surroundings(scene)
    ends = seen.lanes[0, seen.lane_there[0], :4] * REACH
    np.testing.assert_allclose(np.sort(ends[:, 0]), np.arange(-20, 80, 10.0), atol=1e-4)  # all ten pieces of the road
    np.testing.assert_allclose(ends[:, 1::2], 0, atol=1e-4)
    assert seen.box_there[0].tolist() == [True, True] + [False] * 4
    np.testing.assert_allclose(seen.boxes[0, 0, :4], [0, 0, 0.5, 0], atol=1e-6)
    np.testing.assert_allclose(seen.boxes[0, 1, :4] * [REACH, REACH, 10, 10], [25, 0, 10, 0], atol=1e-4)


def test_a_closed_signal_is_seen_while_it_is_closed():
    roads = straight_road(100.0, 1)
    lane = np.stack([np.arange(0, 101, 10.0), np.zeros(11)], axis=1)
    scene = scenario(roads, stack([drive(lane, 20.0, 5.0, 11)]))
    state = np.full((1, 11), SignalState.GREEN, np.uint8)
    state[0, :5] = SignalState.RED
    scene = replace(scene, signals=Signals(np.array([0], np.int32), state))
    closed = [surroundings(scene, step).lanes[0, :10, 11:13].mean(axis=0).tolist() for step in (4, 5)]
    assert closed == [[1, 0], [0, 1]]


@settings(max_examples=20, deadline=None)
@given(turn=st.floats(-3, 3), x=st.floats(-200, 200), y=st.floats(-200, 200))
def test_what_is_seen_does_not_depend_on_where_the_scene_lies(turn, x, y):
    scene = busy_crossing(11)
    one, other = (surroundings(s, piece=9.7) for s in (scene, moved(scene, turn, np.array([x, y]))))  # no lane is n * 9.7 long
    np.testing.assert_array_equal(one.box_there, other.box_there)
    np.testing.assert_allclose(one.boxes, other.boxes, atol=2e-4)
    np.testing.assert_array_equal(one.lane_there, other.lane_there)
    np.testing.assert_allclose(one.lanes, other.lanes, atol=1e-3)


def test_of_many_pieces_the_nearest_are_seen():
    lane = np.stack([np.arange(0, 401, 10.0), np.zeros(41)], axis=1)
    scene = scenario(straight_road(400.0, 3), stack([drive(lane, 200.0, 0.0, 11)]))
    crowd = Tracks.of_logs([scene]).at(np.zeros(1, int), np.zeros(1, int))
    seen = Surroundings.of(LaneVectors.of([scene], 10.0), crowd, np.zeros(1, int), (9, 6), 1.0)
    middle = (seen.lanes[0, :, 0:2] + seen.lanes[0, :, 2:4]) / 2 * REACH
    all_pieces = np.hypot(*np.meshgrid(np.arange(-195.0, 200.0, 10.0), [0.0, 3.5, 7.0]))
    np.testing.assert_allclose(np.sort(np.hypot(*middle.T)), np.sort(all_pieces.ravel())[:9], atol=1e-3)


def test_gates_do_not_mind_the_order_and_ignore_what_is_not_there():
    torch.manual_seed(0)
    gates = Gates(2, 8).eval()
    members, context = torch.randn(3, 5, 8), torch.randn(3, 8)
    there = torch.tensor([[True] * 4 + [False]] * 3)
    _, found = gates(members, context, there)
    order = torch.tensor([3, 0, 4, 1, 2])
    _, shuffled = gates(members[:, order], context, there[:, order])
    torch.testing.assert_close(found, shuffled)
    members[:, 4] = 100.0
    torch.testing.assert_close(gates(members, context, there)[1], found)


def test_a_mode_is_driven_from_the_state_through_its_knots():
    state = np.array([[3.0, 4.0, np.pi / 2, 0.0, 6.0]], np.float32)
    velocity = np.array([[[8.0, 0.0], [10.0, 0.0]]], np.float32)  # 2 m/s more every half second, ahead
    motion = between_knots(state, velocity, np.zeros((1, 2), np.float32), 10)
    np.testing.assert_allclose(motion.velocity[0, :, 1], 6 + 0.4 * np.arange(1, 11), atol=1e-5)
    np.testing.assert_allclose(motion.position[0, -1], [3, 4 + 6 + 0.5 * 4], atol=1e-4)
    np.testing.assert_allclose(motion.heading, np.pi / 2, atol=1e-6)


@settings(max_examples=50, deadline=None)
@given(speed=st.floats(0, 50), seed=st.integers(0, 1000), force=st.floats(0.1, 100))
def test_whatever_the_network_says_a_vehicle_could_do_it(speed, seed, force):
    pedals = force * torch.randn(1, 3, 10, 2, generator=torch.Generator().manual_seed(seed))
    velocity, place, turn = (part.numpy() for part in driven(torch.tensor([speed]), pedals))
    pace = np.concatenate([np.full((1, 3, 1), speed), np.linalg.norm(velocity, axis=-1)], axis=-1)
    gain = np.diff(pace, axis=-1) / DT_KNOT
    assert (gain <= ACCELERATION + 1e-3).all()
    assert (gain >= -BRAKING - 1e-3).all()
    ahead = np.stack([np.cos(turn), np.sin(turn)], axis=-1) * pace[..., 1:, None]
    np.testing.assert_allclose(velocity, ahead, atol=1e-3)  # it never slides sideways
    middle = (pace[..., 1:] + pace[..., :-1]) / 2
    turning = np.abs(np.diff(turn, axis=-1, prepend=0.0)) / DT_KNOT
    assert (turning <= CURVATURE * middle + 1e-3).all()
    assert (turning * np.maximum(middle, 1.0) <= LATERAL + 1e-2).all()
    assert (np.linalg.norm(np.diff(place, axis=-2), axis=-1) <= (middle * DT_KNOT)[..., 1:] + 1e-3).all()


def test_who_stands_learns_to_go_on():
    pedals = torch.full((1, 1, 4, 2), -1.0, requires_grad=True)
    velocity, _, _ = driven(torch.tensor([0.0]), pedals)
    assert (velocity == 0).all()
    velocity[..., 0].sum().backward()
    assert (pedals.grad[..., 0] > 0).all()


def test_of_the_examples_a_share_is_disturbed_and_who_stands_is_left_alone():
    logged = np.array([[1.0, 2.0, 0.5, 8 * np.cos(0.5), 8 * np.sin(0.5)], [3.0, 4.0, 0.0, 0.0, 0.0]], np.float32).repeat(
        200, axis=0
    )
    chance = np.random.default_rng(0).random((400, 3)).astype(np.float32)
    off = Disturbance(0.5, 0.8, 0.1).of(logged, chance) - logged
    np.testing.assert_allclose(off[200:], 0, atol=1e-6)
    left = off[:200, :2] @ np.array([-np.sin(0.5), np.cos(0.5)])
    np.testing.assert_allclose(off[:200, :2] @ np.array([np.cos(0.5), np.sin(0.5)]), 0, atol=1e-5)  # aside, not ahead
    assert 70 < (np.abs(off[:200, 2]) > 1e-6).sum() < 130
    assert 0.5 < np.abs(left).max() <= 0.8
    assert 0.05 < np.abs(off[:200, 2]).max() <= 0.1
    np.testing.assert_array_equal(Disturbance(0.0, 0.8, 0.1).of(logged, chance), logged)


def test_who_was_disturbed_gets_back_to_the_logged_way():
    lane = np.stack([np.arange(0, 301, 10.0), np.zeros(31)], axis=1)
    scene = scenario(straight_road(300.0, 1), stack([drive(lane, 20.0, 10.0, 61)]))
    examples = MotionExamples(logs_of([scene]), 10, COUNTS, 1.0)
    rows = np.array([0])
    state = examples.logged(rows)
    place, velocity, turn, seen = (part.numpy() for part in examples.future(rows, state))
    np.testing.assert_allclose(place[0], np.stack([5.0 * np.arange(1, 11), np.zeros(10)], axis=1), atol=1e-3)
    np.testing.assert_allclose(velocity[0], [[10.0, 0.0]] * 10, atol=1e-3)
    assert seen.all()
    disturbed = state + np.array([[0.0, 0.8, 0.1, 0.0, 1.0]], np.float32)
    place, velocity, turn, _ = (part.numpy() for part in examples.future(rows, disturbed))
    on_map = disturbed[0, :2] + rotate(place[0], np.float32(0.1))
    back = round(RECOVERY / DT_KNOT)
    np.testing.assert_allclose(on_map[back - 1 :, 1], 0.0, atol=1e-3)
    assert (np.diff(on_map[:back, 1]) < 0.6).all()
    assert 0.5 < on_map[0, 1] < 1.3
    np.testing.assert_allclose(turn[0, back - 1 :] + 0.1, 0.0, atol=1e-3)
    slant = np.arctan2(velocity[0, 1, 1], velocity[0, 1, 0])
    assert turn[0, 1] == pytest.approx(slant, abs=1e-3)  # it heads where it goes


def logs_of(logged: list[Scenario]):
    generator, _, _ = trained("trafficgen")
    return generator.examples(generator.settings, logged)


def test_the_mode_that_ends_nearest_wins_and_the_others_are_left_alone():
    place = torch.tensor([[[1.0, 0.0], [2.0, 0.0]]])
    modes = Modes(
        torch.tensor([[0.0, 3.0]], requires_grad=True),
        torch.zeros(1, 2, 2, 2),
        torch.stack([place, place + 5], dim=1).requires_grad_(),
        torch.zeros(1, 2, 2),
    )
    loss = motion_loss(modes, place, torch.zeros(1, 2, 2), torch.zeros(1, 2), torch.ones(1, 2, dtype=torch.bool))
    assert loss.item() == pytest.approx(np.log(1 + np.exp(3.0)))  # the motion is perfect; the odds favoured the other one
    loss.backward()
    assert (modes.place.grad[0, 1] == 0).all()
    assert modes.logit.grad[0, 0] < 0


def test_unseen_steps_teach_nothing():
    place = torch.tensor([[[1.0, 0.0], [99.0, 0.0]]])
    modes = Modes(torch.zeros(1, 1), torch.zeros(1, 1, 2, 2), torch.tensor([[[[1.0, 0.0], [2.0, 0.0]]]]), torch.zeros(1, 1, 2))
    assert motion_loss(modes, place, torch.zeros(1, 2, 2), torch.zeros(1, 2), torch.tensor([[True, False]])).item() == 0.0


def test_it_learns():
    _, before, after = trained("trafficgen")
    assert after < before


def test_the_vehicles_that_are_to_be_placed_are_those_not_given():
    scene = busy_crossing(11)
    examples = PlacementExamples(Logs.of([scene], 8.0), (96, 12))
    inputs, wanted = examples.of(np.array([0]), np.array([0.0]))
    assert inputs[3].sum() == 1  # the target alone is given
    found = wanted.attributes[wanted.there]
    assert 3 <= len(found) <= len(scene.vehicles) - 1
    assert ((found[:, 0] >= 0) & (found[:, 0] <= 1)).all()
    assert (found[:, 1].abs() < 2.5).all()
    assert len(set(wanted.region[wanted.there].tolist())) == len(found)


def test_there_are_regions_as_far_as_scenes_reach():
    """Of a road of twelve lanes: whoever is logged 145 m from the target could be placed there."""
    generator, _, _ = trained("trafficgen")
    roads = straight_road(400.0, 12)
    places = [(0, 200.0), (0, 55.0), (5, 345.0), (11, 60.0), (11, 340.0)]
    scene = scenario(roads, stack([drive(roads.centreline[lane].astype(np.float64), s, 0.0, 11) for lane, s in places]))
    counts = _around_target(generator.settings)
    _, wanted = PlacementExamples(Logs.of([scene], generator.settings.piece), counts).of(np.array([0]), np.array([0.0]))
    assert wanted.there.sum() == len(places) - 1


def test_vehicles_are_placed_on_lanes_around_the_target_and_overlap_nobody():
    generator, _, _ = trained("trafficgen")
    scene = replace(busy_crossing(11), log=None)
    placed = generator.place(scene, 9, 7)
    assert len(placed) == 9
    placed.validate()
    assert placed.track_id[0] == scene.vehicles.track_id[0]
    np.testing.assert_array_equal(placed.position[0], scene.vehicles.position[0])
    hit = boxes_overlap(
        placed.position[:, None],
        placed.heading[:, None],
        placed.size[:, None, :2],
        placed.position,
        placed.heading,
        placed.size[:, :2],
    )
    assert (hit == np.eye(9, dtype=bool)).all()
    points = np.concatenate([scene.map.centreline.points])
    assert (np.hypot(*(placed.position[:, None] - points).transpose(2, 0, 1)).min(axis=1) < 12).all()
    np.testing.assert_array_equal(placed.position, generator.place(scene, 9, 7).position)
    assert (placed.position[1:] != generator.place(scene, 9, 8).position[1:]).any()
