"""Until when collisions could have been avoided, and how long they could be seen coming: handmade cases with known answers."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.core.scenario import DT
from drivegen.corner_cases.avoidance import RESPONSE, Avoidable, Avoidance, judge
from drivegen.corner_cases.failures import replayed_case
from drivegen.simulators.batch import Plugin as Batch
from drivegen.world.reactive import Reaction
from tests.corner_cases.handmade import LINE, NEXT, ROAD, Blind, collision
from tests.scenes import drive, joined, scenario, stack, straight_road

LAW = Reaction(delay=0.75, braking=6.0, headway=0.6, min_gap=1.0, acceleration=1.5, comfort=3.0)
ONE_LANE = straight_road(600, lanes=1)


def shifting(line, start, speed, begin, seconds, steps=101, way=-3.5):
    """A car along `line` that goes `way` [m] to its left within `seconds` from `begin` [s] on, at an even rate."""
    motion = drive(line, start, speed, steps)
    motion.position[:, 1] += way * np.clip((np.arange(steps) * DT - begin) / seconds, 0, 1)
    motion.velocity[:, 1] += np.gradient(motion.position[:, 1]) / DT
    return motion


def braking_distance(speed, braking, ramp):
    """[m] until it stands, in steps of 0.1 s."""
    way, k = 0.0, 0
    while speed > 0:
        k += 1
        speed = max(speed - braking * min(k * DT / ramp if ramp else 1, 1) * DT, 0)
        way += speed * DT
    return way


def test_who_stands_in_the_only_lane_can_be_avoided_as_long_as_the_way_to_stop_is_there():
    log = stack([drive(LINE, 20, 10, 101), drive(LINE, 80, 0, 101)])
    case = collision(log, roads=ONE_LANE)
    (found,) = judge([case])
    gap = 60 - 4.6  # at 10 m/s; the boxes overlap at the first step beyond it
    for seconds, way in (
        (found.latest, braking_distance(10, 6.0, 0)),
        (found.latest_braking, braking_distance(10, 0.774 * 9.81, 0.6)),
    ):
        begin = case.step - round(seconds / DT)
        assert begin * 1.0 + way <= gap < (begin + 1) * 1.0 + way
    assert found.cue == pytest.approx(3.0, abs=0.11)
    assert found.verdict == Avoidable.WARNED


@pytest.mark.parametrize(("length", "whole"), [(1200, True), (900, False), (900, True)])
def test_who_evades_and_then_leaves_the_map_is_not_off_the_road(length, whole):
    road, edge = straight_road(length, 2, whole=whole), np.array([[0.0, -1.0], [900.0, -1.0]])
    log = stack([drive(joined(road, 0), 700, 25, 101), drive(edge, 885, 0, 101)])
    log.valid[1, :60] = False  # seen 1.3 s before the collision, 15 m before the end of the road
    (found,) = judge([collision(log, roads=road)])
    assert found.verdict == Avoidable.SUDDEN
    assert found.latest == pytest.approx(0.7)


def test_a_collision_that_only_its_first_step_avoids_is_sudden():
    (found,) = judge([collision(stack([drive(LINE, 20, 16, 101), drive(LINE, 46.6, 0, 101)]), roads=ONE_LANE)])
    assert 1.6 + braking_distance(16, 6.0, 0) > 22 >= braking_distance(16, 6.0, 0)
    assert (found.latest, found.cue) == pytest.approx((1.4, 1.4))
    assert found.verdict == Avoidable.SUDDEN


def test_a_scene_that_is_shorter_than_one_driven_beside_it_is_judged_as_alone():
    short, long = (
        stack([drive(LINE, 20, 10, 61), drive(LINE, 60, 0, 61)]),
        stack([drive(LINE, 20, 10, 101), drive(NEXT, 60, 0, 101)]),
    )
    scenes = [scenario(ROAD, short), scenario(ROAD, long)]
    run = Batch().run(Blind(), scenes, [short, long])
    assert judge([replayed_case(scenes[0], short, run, 0, "blind")]) == judge([collision(short)])


def test_beside_a_free_lane_it_can_be_avoided_for_longer_and_the_kerb_is_no_free_lane():
    log = stack([drive(LINE, 20, 20, 101), drive(LINE, 120, 0, 101)])
    narrow, wide = judge([collision(log, roads=ONE_LANE), collision(log)])
    assert wide.latest < narrow.latest
    taken = stack([*(log[i] for i in range(2)), drive(NEXT, 120, 0, 101)])
    assert judge([collision(taken)])[0].latest == narrow.latest


def test_who_comes_over_from_abreast_at_once_cannot_be_avoided_and_who_takes_time_can():
    rushed, calm = (
        collision(stack([drive(LINE, 20, 12, 101), shifting(NEXT, 22, 12, 3.0, seconds)]), roads=straight_road(600))
        for seconds in (0.6, 6.0)
    )
    at_once, in_time = judge([rushed, calm])
    assert at_once.verdict == Avoidable.NO
    assert at_once.cue < 0.5
    assert in_time.verdict == Avoidable.WARNED


def test_a_short_gap_to_one_who_brakes_at_once_is_sudden():
    calm = drive(LINE, 32, 15, 101)
    hard = drive(LINE, 32 + 45, 15, 71, -5.0)
    for name in ("position", "velocity"):
        getattr(calm, name)[30:] = getattr(hard, name)
    (found,) = judge([collision(stack([drive(LINE, 20, 15, 101), calm]), roads=ONE_LANE)])
    assert found.verdict == Avoidable.SUDDEN
    assert 0 <= found.budget < 1.2


def test_what_is_avoided_among_replays_may_end_in_a_follower_who_cannot_brake_in_time():
    cars = [drive(LINE, 20, 15, 101), drive(LINE, 100, 0, 101), drive(LINE, 12, 15, 101)]
    case = collision(stack(cars), roads=ONE_LANE)
    replayed, reacting = judge([case])[0], judge([case], LAW)[0]
    assert replayed.latest < 1.6
    assert np.isnan(reacting.latest) or reacting.latest > replayed.latest


def test_cases_are_judged_alike_alone_and_among_others():
    cases = [collision(stack([drive(LINE, 20, v, 101), drive(LINE, 80, 0, 101), drive(NEXT, 30, 12, 101)])) for v in (8, 18)]
    for law in (None, LAW):
        assert repr(judge(cases, law)) == repr([judge([case], law)[0] for case in cases])


def test_on_a_path_that_comes_back_who_stands_on_the_second_visit_is_seen_at_the_first():
    angle = np.linspace(0, 4 * np.pi, 400)
    spiral = (12 - 0.8 * angle / (2 * np.pi))[:, None] * np.stack([np.sin(angle), -np.cos(angle)], 1)
    stands = drive(spiral, 88, 0, 101)  # 0.8 m beside a place that is passed after 16 m, too
    case = collision(stack([drive(spiral, 0, 10, 101), stands]))
    assert case.step < 25
    assert judge([case])[0].cue > 1.0


def test_a_follower_who_runs_into_it_does_not_hide_that_it_hits_whom_it_should_avoid():
    ahead = [drive(LINE, 20, 15, 101), drive(LINE, 100, 0, 101)]
    alone, *followed = judge(
        [collision(stack(ahead), roads=ONE_LANE)]
        + [collision(stack([*ahead, drive(LINE, 20 - 4.6 - gap, 15, 101)]), roads=ONE_LANE) for gap in (0.2, 2.0, 8.0)]
    )
    assert [case.latest for case in followed] == [alone.latest] * 3


def test_putting_it_off_until_the_scenario_ends_avoids_nothing():
    long, short = (collision(stack([drive(LINE, 20, 15, n), drive(LINE, 100, 0, n)]), roads=ONE_LANE) for n in (101, 53))
    assert short.step == long.step == 51
    assert repr(judge([short])) == repr(judge([long]))


def test_as_long_as_a_careful_driver_takes_is_with_warning():
    for latest in range(1, 39):
        found = Avoidance((latest + RESPONSE) * DT, latest * DT, float("nan"))
        assert found.verdict == Avoidable.WARNED
        assert replace(found, cue=(latest + RESPONSE - 1) * DT).verdict == Avoidable.SUDDEN
