"""BITS: what a vehicle's raster shows, how actions are driven, where goals are, which plans break rules, what is learnt."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.scenario import Scenario
from drivegen.core.signals import Signals, SignalState
from drivegen.generators._bits.learning import way_loss
from drivegen.generators._bits.net import CELLS, HOLD, BitsNet, Plan, cell_of, numbers_of, unicycle
from drivegen.generators._bits.raster import BEHIND, COLUMNS, PIXEL, ROWS, Painted, rasters
from drivegen.generators._bits.rules import broken
from drivegen.generators.shared.closed_loop import Crowd, Tracks
from drivegen.store.columns import joined
from tests.generators.rivals import trained
from tests.scenes import any_scenario, busy_crossing, drive, road_map, scenario, stack

HORIZON = 4.0


def on_a_road(*places: float, speed: float = 0.0) -> Scenario:
    """Cars in one lane along +y, the first at x = 0, y = 100."""
    lane = np.stack([np.zeros(31), np.arange(0, 301, 10.0)], axis=1)
    return scenario(road_map([lane]), stack([drive(lane, s, speed, 11) for s in (100.0, *places)]))


def crowd_of(scene: Scenario) -> Crowd:
    return Tracks.of_logs([scene]).at(np.zeros(1, int), np.zeros(1, int))


def raster_of(scene: Scenario, step: int = 0) -> np.ndarray:
    zero = np.zeros(1, int)
    return rasters(Painted.of([scene]), replace(crowd_of(scene), step=zero + step), zero, HORIZON)[0]


def pixel(along: float, across: float) -> tuple[int, int]:
    return ROWS - 1 - int((along + BEHIND) // PIXEL[0]), COLUMNS // 2 - 1 - int(across // PIXEL[1])


def test_the_raster_shows_the_lane_ahead_and_the_car_on_it():
    seen = raster_of(on_a_road(130.0))
    lane = seen[0] > 0
    assert lane[:, COLUMNS // 2 - 1 : COLUMNS // 2 + 1].all()  # 100 m ahead and 20 m behind there is road
    assert not lane[:, : COLUMNS // 2 - 2].any()
    np.testing.assert_allclose(seen[1][lane], 1, atol=1e-5)  # along the vehicle, not across
    np.testing.assert_allclose(seen[2][lane], 0, atol=1e-5)
    boxes = np.argwhere(seen[6])
    assert set(boxes[:, 0]) == {pixel(27.8, 0)[0], pixel(30, 0)[0], pixel(32.2, 0)[0]}
    assert set(boxes[:, 1]) == {COLUMNS // 2 - 1, COLUMNS // 2}


def test_the_raster_of_a_fast_vehicle_reaches_farther():
    """40 m/s lead 160 m ahead, twice FAST."""
    slow, fast = raster_of(on_a_road(160.0)), raster_of(on_a_road(160.0, speed=40.0))
    assert slow[6, pixel(60, 0)[0]].any()
    assert fast[6, pixel(30, 0)[0]].any()
    assert not fast[6, pixel(60, 0)[0]].any()
    np.testing.assert_allclose(fast[7][fast[6] > 0], 4.0)


def test_a_closed_signal_is_drawn_while_it_is_closed():
    state = np.full((1, 11), SignalState.GREEN, np.uint8)
    state[0, :5] = SignalState.YELLOW
    scene = replace(on_a_road(), signals=Signals(np.array([0], np.int32), state))
    shown = [raster_of(scene, step) for step in (4, 5, 99)]
    assert [bool((s[5] == (s[0] > 0)).all()) for s in shown] == [True, False, False]
    assert not shown[1][5].any()


def test_painted_scenes_join_to_the_scenes_painted_together():
    parts = [busy_crossing(11, "a"), any_scenario(3, "b"), on_a_road()]
    one, other = joined(Painted, [Painted.of(parts[:2]), Painted.of(parts[2:])]), Painted.of(parts)
    for name in ("first", "shape", "origin", "number", "planes", "signal", "state"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert (one.planes[:, 0] > 0).all()
    assert len(joined(Painted, []).shape) == 0


def test_unicycle_goes_straight_round_a_circle_and_never_backward():
    actions = torch.zeros(3, 8)
    bend, gain = actions.clone(), actions.clone()
    bend[1], gain[2] = 0.1, -5.0
    plan = unicycle(torch.full((3,), 10.0), gain, bend)
    torch.testing.assert_close(plan.place[0, -1], torch.tensor([40.0, 0.0]))
    centre = torch.tensor([0.0, 10.0])  # of a circle with a radius of 10 m
    torch.testing.assert_close((plan.place[1] - centre).norm(dim=-1), torch.full((8 * HOLD,), 10.0), atol=0.02, rtol=0)
    torch.testing.assert_close(plan.turn[1, -1], torch.tensor(4.0))
    assert plan.speed[2, -1] == 0
    torch.testing.assert_close(plan.place[2, -1], torch.tensor([10.0, 0.0]))


@settings(max_examples=50, deadline=None)
@given(speed=st.floats(0, 30), a=st.floats(-20, 20), k=st.floats(-1, 1))
def test_unicycle_moves_where_it_heads_within_its_bounds(speed, a, k):
    plan = unicycle(torch.tensor([speed]), torch.full((1, 4), a), torch.full((1, 4), k))
    before = torch.cat([torch.zeros(1, 1, 2), plan.place[:, :-1]], dim=1)
    way = (plan.place - before).norm(dim=-1)
    assert (plan.speed >= 0).all()
    assert (plan.turn.diff(dim=1).abs() <= 0.2 * way[:, 1:] + 1e-5).all()
    assert (plan.speed.diff(dim=1).abs() <= 0.8 + 1e-5).all()


def test_every_cell_holds_its_centre_and_the_edge_what_lies_beyond():
    net = BitsNet(32, 40)
    one = torch.ones(CELLS)
    assert cell_of(net.centres, one).tolist() == list(range(CELLS))
    assert cell_of(net.centres * torch.tensor([2.0, 1.0]), 2 * one).tolist() == list(range(CELLS))
    assert cell_of(torch.tensor([[999.0, 0.1], [-999.0, 999.0]]), one[:2]).tolist() == [7, 23 * 16]


def test_a_goal_is_driven_to_before_anything_is_learnt():
    """The policy is a correction of the actions that the goal itself tells."""
    torch.manual_seed(0)
    net = BitsNet(32, 40).eval()
    numbers = numbers_of(torch.tensor([10.0]), torch.tensor([[4.5, 1.9]]), torch.tensor([0]))
    goals = torch.tensor([[[60.0, 0.0, 0.0, 20.0], [20.0, 0.0, 0.0, 0.0], [30.0, 6.0, 0.4, 8.0]]])
    plan = net.plan(torch.zeros(1, 32), numbers, goals)
    torch.testing.assert_close(plan.place[0, :, -1], goals[0, :, :2], atol=2.5, rtol=0)


def test_a_plan_through_a_standing_car_or_off_the_lane_breaks_a_rule():
    scene = on_a_road(130.0)
    crowd = crowd_of(scene)
    looks = np.arange(1, 9) * 5.0
    there = np.stack([np.zeros(8), 100 + looks, np.full(8, np.pi / 2)], axis=1)  # 40 m along the lane, through the car
    aside = there + np.array([8.0, 0, 0])
    short = there * np.array([1, 0, 1]) + np.array([0, 100, 0]) + np.stack([0 * looks, looks / 2, 0 * looks], axis=1)
    plans = np.stack([there, aside, short])[None].astype(np.float32)
    predicted = np.repeat(crowd.state[:, None, :3], 8, axis=1)
    hit, off = broken(plans, predicted, crowd, Painted.of([scene]), np.zeros(1, int), 0.3)
    assert hit[0].tolist() == [pytest.approx(1 / 8), 0.0, 0.0]  # the look at 30 m; 25 m and 35 m are free
    assert off[0].tolist() == [0.0, pytest.approx(1.0), 0.0]


def test_a_look_at_which_a_plan_touches_several_counts_once():
    scene = on_a_road(126.0, 134.0)
    crowd = crowd_of(scene)
    plans = np.repeat(crowd.state[:1, None, None, :3], 8, axis=2)
    plans[0, 0, 3, 1] = 130.0  # between both, whose bumpers are closer than the plan is long
    predicted = np.repeat(crowd.state[:, None, :3], 8, axis=1)
    hit, _ = broken(plans, predicted, crowd, Painted.of([scene]), np.zeros(1, int), 0.3)
    assert hit.tolist() == [[pytest.approx(1 / 8)]]


def test_who_overlaps_at_the_beginning_is_not_held_against_a_plan():
    scene = on_a_road(102.0)
    crowd = crowd_of(scene)
    plans = np.repeat(crowd.state[:1, None, None, :3], 8, axis=2)
    predicted = np.repeat(crowd.state[:, None, :3], 8, axis=1)
    hit, _ = broken(plans, predicted, crowd, Painted.of([scene]), np.zeros(1, int), 0.3)
    assert hit.tolist() == [[0.0]]


def test_unseen_steps_teach_nothing():
    plan = Plan(torch.zeros(1, 10, 2), torch.zeros(1, 10), torch.zeros(1, 10))
    place = torch.tensor([[[0.0, 0.0], [50.0, 0.0]]])
    assert way_loss(plan, place, torch.zeros(1, 2), torch.tensor([[True, False]])).item() == 0
    assert way_loss(plan, place, torch.zeros(1, 2), torch.tensor([[True, True]])).item() == pytest.approx(49.5 / 2)


def test_it_learns():
    _, before, after = trained("bits")
    assert after < before
