"""SMART: words of motion and how near they are, logs told in them, what is seen, what is remembered, how words are drawn."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.geometry import box_corners, rotate
from drivegen.core.scenario import Scenario
from drivegen.core.signals import Signals, SignalState
from drivegen.generators._smart.around import LOOK, OTHER_FEATURES, PIECE, others, pose
from drivegen.generators._smart.driving import drawn, velocities
from drivegen.generators._smart.learning import Examples, Slips, SmartObjective, tokenise
from drivegen.generators._smart.net import Past, Seen, SmartNet
from drivegen.generators._smart.tokens import RADIUS, SPAN, STILL, Vocabulary, codes, disks, gone, motions, pace, ways
from drivegen.generators.shared.closed_loop import Tracks
from drivegen.generators.shared.lanes import PACE, REACH, LaneVectors, Logs
from drivegen.store.columns import joined
from tests.generators.rivals import same, scenes, trained
from tests.scenes import any_scenario, busy_crossing, drive, scenario, stack, straight_road

PLAIN = Slips(0.0, 1, 0.0)
COUNTS = (200, 6)  # more than there are pieces of lanes: of the nearest there may be several equally near


def random(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def words_of(tracks: Tracks, count: int = 256) -> Vocabulary:
    return Vocabulary(disks(motions(tracks), count, random()))


def straight(speed: float) -> np.ndarray:
    """The way of who goes straight on at `speed`."""
    way = np.zeros((SPAN, 3), np.float32)
    way[:, 0] = 0.1 * speed * np.arange(1, SPAN + 1)
    return way


@given(x=st.floats(-3, 17), y=st.floats(-3, 3), turn=st.floats(-1, 1), other=st.floats(-1, 1))
@settings(max_examples=50, deadline=None)
def test_ways_are_as_far_apart_as_the_corners_of_the_box_that_goes_them(x, y, turn, other):
    share = np.arange(1, SPAN + 1)[:, None] / SPAN
    one, two = share * np.array([x, y, turn]), share * np.array([5.0, 0.0, other])
    size = np.full((2, 1), 2 * RADIUS / np.sqrt(2))  # of the square whose corners are RADIUS away
    corners = [box_corners(way[:, :2], way[:, 2], *np.broadcast_to(size, (2, SPAN))) for way in (one, two)]
    apart = np.sqrt(np.square(corners[0] - corners[1]).sum(-1).mean())
    assert np.linalg.norm(codes(one) - codes(two)) == pytest.approx(apart, abs=1e-4)


@given(x=st.floats(-500, 500), heading=st.floats(-3, 3), turn=st.floats(-1, 1))
@settings(max_examples=50, deadline=None)
def test_who_goes_the_way_to_some_poses_gets_there(x, heading, turn):
    pose = np.array([x, 2 * x, heading])
    way = straight(12.0) + np.linspace(0, turn, SPAN)[:, None] * np.array([0, 1, 1])
    np.testing.assert_allclose(ways(pose, gone(pose, way)), way, atol=2e-4)
    assert pace(straight(12.0)) == pytest.approx(12.0, abs=1e-4)
    assert pace(-straight(12.0)) == 0.0


def test_every_motion_of_the_vocabulary_is_matched_to_itself():
    words = words_of(Tracks.of_logs([busy_crossing(101), any_scenario(3)]))
    real = np.flatnonzero((words.way != 0).any(axis=(1, 2)))
    assert len(real) > 50
    np.testing.assert_array_equal(words.distances(words.way[real]).argmin(axis=1), real)


def test_who_stands_still_is_matched_to_the_token_that_does_and_spare_tokens_are_nobodys():
    words = Vocabulary(disks(np.stack([straight(5.0), straight(10.0)]), 8, random()))
    assert sorted(words.way[:, -1, 0].tolist()) == [0, 0, 0, 0, 0, 0, 2.5, 5.0]
    assert words.distances(np.zeros((1, SPAN, 3))).argmin() == STILL
    assert set(words.distances(np.stack([straight(v) for v in np.linspace(0, 12, 50)])).argmin(axis=1).tolist()) == {0, 1, 2}


def test_disks_leave_no_motion_far_from_all_and_are_the_same_for_the_same_seed():
    speeds = random(1).uniform(0, 20, 3000)
    way = np.stack([straight(v) for v in speeds])
    found = disks(way, 64, random())
    np.testing.assert_array_equal(found, disks(way, 64, random()))
    assert not (found == disks(way, 64, random(5))).all()
    assert np.sqrt(Vocabulary(found).distances(way).min(axis=1)).max() < 0.25  # half of it with 64 tokens evenly spread
    assert not found[STILL].any()


def winding(count: int = 60, steps: int = 101) -> Tracks:
    """One scene of cars that speed up, brake and wind their way as cars can."""
    chance, time = random(3), np.arange(steps) * 0.1
    wave = chance.uniform(0.2, 1.0, (2, count, 1)) * time + chance.uniform(0, 6, (2, count, 1))
    speed = chance.uniform(0, 15, (count, 1)) * (1 + 0.5 * np.sin(wave[0]))
    heading = np.cumsum(np.minimum(0.02 * speed, 0.1) * np.sin(wave[1]) * 0.1, axis=1)
    velocity = np.stack([speed * np.cos(heading), speed * np.sin(heading)], axis=-1)
    boxes, seen = np.ones(count, np.bool_), np.ones((count, steps), np.bool_)
    size, kind = np.tile(np.array([4.8, 2.0], np.float32), (count, 1)), np.zeros(count, np.uint8)
    moving = [a.astype(np.float32) for a in (np.cumsum(velocity * 0.1, axis=1), velocity, heading)]
    return Tracks(np.array([0, count]), boxes, size, kind, *moving, seen)


def told_of(share: float, count: int = 512) -> tuple[np.ndarray, np.ndarray]:
    """[m] (V, T) how far from their ways those are who go them in words of which a `share` are slips, and the words."""
    tracks = winding()
    box, step = np.arange(60), np.tile(np.arange(20) * SPAN, (60, 1))
    sequences = tokenise(words_of(tracks, count), tracks, box, step, np.zeros(60, int), Slips(share, 8, 0.0), random())
    assert (sequences.fresh == (step == 0)).all()
    assert (sequences.target >= 0).all()
    return np.linalg.norm(sequences.pose[..., :2] - tracks.position[box[:, None], step], axis=-1), sequences.token


def test_logs_in_words_are_the_logs_the_nearer_the_more_words():
    gap, token = told_of(0.0)
    assert gap.mean() < 0.25
    assert np.percentile(gap, 95) < 1.0
    assert len(np.unique(token)) > 100
    assert gap.mean() < 0.6 * told_of(0.0, 128)[0].mean()


def test_who_slips_is_beside_the_log_and_comes_back():
    gap, token = told_of(0.5)
    assert 1.5 * told_of(0.0)[0].mean() < gap.mean() < 0.6  # of twenty tokens, ten of which are slips
    assert (token != told_of(0.0)[1])[:, 1:].mean() > 0.3


def test_the_word_to_learn_leads_back():
    """A car that its first word has led too far is to say a shorter one than the log."""
    lane = np.stack([np.arange(0, 301, 10.0), np.zeros(31)], axis=1)
    tracks = Tracks.of_logs([scenario(straight_road(), stack([drive(lane, 0, 10.0, 11)]))])
    words = Vocabulary(np.stack([straight(v) for v in (0.0, 9.0, 10.0, 11.0)]))
    step = np.array([[0, 5]])
    plain = tokenise(words, tracks, np.zeros(1, int), step, np.zeros(1, int), PLAIN, random())
    assert plain.target.tolist() == [[2, 2]]
    for seed in range(9):
        sequences = tokenise(words, tracks, np.zeros(1, int), step, np.zeros(1, int), Slips(1.0, 3, 0.0), random(seed))
        assert sequences.target[0, 1] == {1: 3, 2: 2, 3: 1}[int(sequences.token[0, 1])]
        assert sequences.speed[0, 1] == pytest.approx(8 + sequences.token[0, 1], abs=1e-3)


def batch(scene: Scenario, cut: int = 0) -> tuple[Seen, torch.Tensor]:
    logs = Logs.of([scene], PIECE)
    zero = np.zeros(1, int)
    return Examples(logs, words_of(logs.tracks), COUNTS).batch(zero, zero, zero + cut, PLAIN, random())


def test_a_vehicle_sees_the_lane_ahead_and_the_car_before_it_in_its_own_frame():
    lane = np.stack([np.arange(0, 101, 10.0), np.zeros(11)], axis=1)
    seen, _ = batch(scenario(straight_road(100.0, 1), stack([drive(lane, 20.0, 5.0, 11), drive(lane, 45.0, 10.0, 11)])))
    ends = seen.road[0, 0][seen.road_there[0, 0]][:, :4].numpy() * REACH
    np.testing.assert_allclose(ends[:, 0].min(), -20, atol=1e-3)
    np.testing.assert_allclose(ends[:, 2].max(), 80, atol=1e-3)
    np.testing.assert_allclose(ends[:, 1::2], 0, atol=1e-3)
    assert seen.other_there[0, 0].tolist() == [True, True] + [False] * 4
    np.testing.assert_allclose(seen.other[0, 0, 1, [0, 1, 6]] * torch.tensor([REACH, REACH, PACE]), [25, 0, 10], atol=1e-3)
    assert seen.who[0, 0, :2].tolist() == [0, 1]
    assert seen.who[1, 0, :2].tolist() == [1, 0]
    assert seen.other[1, 0, 1, 0] * REACH == pytest.approx(-25, abs=1e-3)


def test_the_nearest_others_are_seen_and_a_context_actor_has_no_row():
    state = np.zeros((4, 1, 4), np.float32)
    state[:, 0, 0] = (0, 30, 10, 20)
    driven = np.array([True, True, False, True])
    out, there, which = others(
        np.array([[0, 4]]), np.zeros(1, int), state, np.array([[1], [1], [1], [0]], bool), np.ones((4, 2), np.float32), driven, 3
    )
    assert which[0, 0, : there.sum()].tolist() in ([0, 1, 2], [0, 2, 1])
    assert there.all()
    assert dict(zip(which[0, 0].tolist(), out[0, 0, :, OTHER_FEATURES - 1].tolist(), strict=True)) == {0: 1, 1: 1, 2: 0}


def test_a_cut_is_another_first_frame_with_the_signals_of_then():
    roads = straight_road(100.0, 1)
    lane = np.stack([np.arange(0, 101, 10.0), np.zeros(11)], axis=1)
    state = np.full((1, 31), SignalState.GREEN, np.uint8)
    state[0, 8:] = SignalState.RED
    scene = replace(scenario(roads, stack([drive(lane, 20.0, 5.0, 31)])), signals=Signals(np.array([0], np.int32), state))
    for cut, first in ((0, [True] + [False] * 5), (2, [True, False, True, False, False, False])):
        seen, target = batch(scene, cut)
        assert seen.fresh[0].tolist() == first
        shows = seen.road[0, :, 0, 11:13].tolist()
        assert shows == [[0, 1]] * 2 + [[0, 1] if cut == 0 else [1, 0]] * 4
        assert seen.own[0, :, 1].tolist() == pytest.approx([0, 0.05, *np.arange(4) * 0.05 + (0.1 if cut == 0 else 0)])
        assert (target >= 0).all()


@given(turn=st.floats(-3, 3), x=st.floats(-200, 200), y=st.floats(-200, 200))
@settings(max_examples=10, deadline=None)
def test_what_is_seen_does_not_depend_on_where_the_scene_lies(turn, x, y):
    vehicles, roads, zero = scenes()[0].vehicles[:3], LaneVectors.of(scenes()[:1], PIECE), np.zeros(3, int)
    shift = np.array([x, y])
    here = np.column_stack([vehicles.position, vehicles.heading, vehicles.speed])
    there = np.column_stack([rotate(here[:, :2], np.full(3, turn)) + shift, here[:, 2] + turn, here[:, 3]])
    ends = rotate(roads.ends.reshape(-1, 2).astype(np.float64), np.float64(turn)) + shift
    other = replace(roads, ends=ends.reshape(-1, 4).astype(np.float32))
    count = len(roads.ends)
    one, two = (
        on.around(pose(state.astype(np.float32)), zero, zero, count, LOOK) for on, state in ((roads, here), (other, there))
    )
    np.testing.assert_array_equal(one[1], two[1])
    np.testing.assert_allclose(one[0], two[0], atol=3e-3)


def test_roads_join_to_the_roads_of_all():
    parts = [busy_crossing(11, "a"), any_scenario(3, "b"), busy_crossing(41, "c")]
    one = joined(LaneVectors, [LaneVectors.of(parts[:2], PIECE), LaneVectors.of(parts[2:], PIECE)])
    other = LaneVectors.of(parts, PIECE)
    for name in ("start", "ends", "static", "signal", "state"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert len(joined(LaneVectors, []).start) == 1


def network(memory: int) -> SmartNet:
    torch.manual_seed(0)
    return SmartNet(256, 32, 2, 2, memory).eval()


@pytest.mark.parametrize("cut", [0, 3])
def test_moment_by_moment_the_same_is_said_as_all_at_once(cut: int):
    """What is remembered of earlier moments is all that counts of them."""
    seen, _ = batch(busy_crossing(61), cut)
    net, past, said = network(4), None, list[torch.Tensor]()
    net.code.normal_()
    with torch.inference_mode():
        whole, _ = net(seen)
        for t in range(seen.token.shape[1]):
            logit, past = net(Seen(*(part[:, t : t + 1] for part in seen)), past)
            said.append(logit)
    assert isinstance(past, Past)
    assert past.pose.shape[1] == 3
    torch.testing.assert_close(torch.cat(said, dim=1), whole, atol=1e-4, rtol=1e-4)


def test_a_first_frame_remembers_nothing_and_no_more_than_memory_is_remembered():
    seen, _ = batch(busy_crossing(61))
    net = network(3)
    net.code.normal_()

    def changed(moment: int, fresh: int | None = None) -> list[int]:
        """Moments at which something else is said where all are told another speed at `moment`."""
        first = seen.fresh.clone()
        if fresh is not None:
            first[:, fresh] = True
        own = seen.own.clone()
        own[:, moment, 0] += 1.0
        with torch.inference_mode():
            one, other = (net(seen._replace(own=o, fresh=first))[0] for o in (seen.own, own))
        return torch.unique((one != other).any(dim=2).nonzero()[:, 1]).tolist()

    last = seen.token.shape[1] - 1
    assert changed(last) == [last]  # nothing that is to come is seen
    assert changed(2) == [2, 3, 4, 5, 6]  # two layers, two tokens back each
    assert changed(2, fresh=4) == [2, 3]


def test_the_likeliest_words_are_drawn_by_their_odds():
    logit = np.log(np.array([[0.1, 0.6, 0.3]]))
    assert [int(drawn(logit, np.array([c]), 1.0, 1.0)[0]) for c in (0.0, 0.59, 0.61, 0.89, 0.91)] == [1, 1, 2, 2, 0]
    assert [int(drawn(logit, np.array([c]), 1.0, 0.8)[0]) for c in (0.0, 0.66, 0.67, 0.999)] == [1, 1, 2, 2]
    assert {int(drawn(logit, np.array([c]), 1.0, 0.0)[0]) for c in (0.0, 0.5, 0.999)} == {1}
    assert {int(drawn(logit, np.array([c]), 0.01, 1.0)[0]) for c in (0.0, 0.5, 0.999)} == {1}


def test_velocities_are_those_of_the_way():
    position = np.stack([np.arange(6) * 1.5, np.zeros(6)], axis=-1)[None].astype(np.float32)
    np.testing.assert_allclose(velocities(position), np.broadcast_to([15.0, 0.0], (1, 5, 2)), rtol=1e-5)


def test_nothing_that_signals_show_later_changes_a_future():
    generator, scene = trained("smart")[0], busy_crossing()
    red = np.full((1, scene.steps), SignalState.RED, np.uint8)
    green = np.where(np.arange(scene.steps) == 0, red, SignalState.GREEN).astype(np.uint8)
    lane = np.arange(len(scene.map), dtype=np.int32)
    states = [np.repeat(state, len(lane), axis=0) for state in (red, green, green[:, ::-1])]
    sequences = [replace(scene, signals=Signals(lane, state)) for state in states]
    now_red, turns_green, now_green = (generator.generate([one], 2, 7) for one in sequences)
    assert same(now_red, turns_green)
    assert not same(now_red, now_green)  # what they show now does


def test_it_learns_and_the_vocabulary_is_saved_with_the_weights():
    generator, before, after = trained("smart")
    assert after < before
    assert {"way", "code"} <= set(generator.net.state_dict())
    assert generator.net.way.abs().max() > 0


def test_how_likely_logs_are_is_the_loss_of_training_turned_round_and_who_jumps_is_less_likely():
    made, _, _ = trained("smart")
    logs = [(s, s.log) for s in scenes()]
    odds = made.log_likelihood(*zip(*logs, strict=True))
    zero = np.zeros(1, np.int64)
    for (logged, _), own in zip(logs, odds, strict=True):
        sequences = made.examples(made.settings, [logged])
        examples = Examples(sequences, Vocabulary(made.net.way.numpy()), (made.settings.lanes, made.settings.boxes))
        known = (examples.batch(zero, zero, zero, PLAIN, random())[1] >= 0).sum(1).numpy()
        assert len(own) == len(logged.vehicles)
        loss = SmartObjective(examples, examples, PLAIN).validation(made.net)
        assert np.nansum(own * known) / known.sum() == pytest.approx(-loss, rel=1e-4)
    logged, log = logs[0]
    aside = 3 * np.sin(np.arange(log.steps, dtype=np.float32))[:, None]
    (odd,) = made.log_likelihood([logged], [replace(log, position=log.position + aside)])
    assert np.nanmean(odd) < np.nanmean(odds[0]) - 1
