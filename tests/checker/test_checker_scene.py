from dataclasses import replace

import numpy as np
import pytest

from drivegen.checker.limits import NEVER, RULES
from drivegen.checker.scene import SceneChecker, check_samples
from drivegen.core.roadmap import LaneControl
from drivegen.core.samples import Violation
from drivegen.core.scenario import Actors, Trajectories
from drivegen.core.signals import Signals, SignalState
from tests.checking import LIMITS, two_way_road
from tests.scenes import (
    LANE_WIDTH,
    beside,
    busy_crossing,
    crossing,
    drive,
    joined,
    noisy_samples,
    scenario,
    stack,
    straight_road,
)  # fmt: skip

ROAD = straight_road()
LINE = ROAD.centreline[0].astype(np.float64)
STEPS = 101


def judge(roads, *motions, limits=LIMITS, signals=None):
    """Flags of several vehicles judged as one sample, and their first illegal steps."""
    log = stack(list(motions))
    violation, first = check_samples(scenario(roads, log, signals=signals), log[np.newaxis], limits)
    return [Violation(v) for v in violation[0].tolist()], first[0].tolist()


def severity(roads, rule, *motions, signals=None):
    log = stack(list(motions))
    return SceneChecker(scenario(roads, log, signals=signals), LIMITS).severities(log[np.newaxis]).worst[0, 0, RULES.index(rule)]


def first_of(roads, rule, motion):
    log = stack([motion])
    return SceneChecker(scenario(roads, log), LIMITS).severities(log[np.newaxis]).first[0, 0, RULES.index(rule)]


def lights(lane, states):
    return Signals(np.array([lane], np.int32), np.array([states], np.uint8))


def reversed_line(line):
    return line[::-1].copy()


def test_a_car_that_keeps_its_lane_is_legal():
    assert judge(ROAD, drive(LINE, 10, 10, STEPS)) == ([Violation.NONE], [-1])


def test_head_on_cars_collide_at_the_step_when_their_fronts_meet():
    # 55.4 m between the fronts, closing at 20 m/s
    flags, first = judge(two_way_road(), drive(LINE, 50, 10, STEPS), drive(reversed_line(LINE), 190, 10, STEPS))
    assert Violation.COLLISION in flags[0]
    assert Violation.COLLISION in flags[1]
    assert first[0] == 28
    assert Violation.WRONG_WAY in flags[1]


def test_a_rear_end_collision_is_charged_to_both_and_to_nobody_else():
    flags, first = judge(ROAD, drive(LINE, 10, 12, STEPS), drive(LINE, 40, 4, STEPS), drive(LINE, 200, 4, STEPS))
    assert [bool(f & Violation.COLLISION) for f in flags] == [True, True, False]
    assert first[0] == first[1] == 32


def test_an_overlap_in_the_first_frame_is_inherited_until_the_boxes_part():
    slow, fast = drive(LINE, 50, 5, STEPS), drive(LINE, 52, 12, STEPS)
    assert judge(ROAD, slow, fast) == ([Violation.NONE] * 2, [-1, -1])
    # one that parts and meets again is a collision
    position = fast.position.copy()
    position[60:, 0] = slow.position[60:, 0]
    flags, first = judge(ROAD, slow, replace(fast, position=position))
    assert all(Violation.COLLISION in f for f in flags)
    assert first[0] == 60


def test_a_vehicle_that_is_left_out_collides_with_nobody():
    a, b = drive(LINE, 50, 10, STEPS), drive(LINE, 52, 0, STEPS)
    assert judge(ROAD, a, replace(b, valid=np.zeros(STEPS, np.bool_)))[0][0] == Violation.NONE


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("name", ["position", "heading", "velocity"])
def test_one_number_that_is_not_finite_makes_a_trajectory_illegal(name, value):
    broken = drive(LINE, 10, 10, STEPS)
    getattr(broken, name)[37] = value
    flags, first = judge(ROAD, broken, drive(LINE, 100, 10, STEPS))
    assert flags == [Violation.NOT_FINITE, Violation.NONE]
    assert first[0] == 37


def test_what_is_not_finite_at_a_step_that_is_not_valid_is_nobodys_business():
    motion = drive(LINE, 10, 10, STEPS)
    motion.position[80:], motion.valid[80:] = np.nan, False
    assert judge(ROAD, motion)[0] == [Violation.NONE]


def test_a_committed_vehicle_that_is_not_finite_is_no_obstacle_and_no_crash():
    checker = SceneChecker(scenario(ROAD, stack([drive(LINE, 10, 10, STEPS)] * 2)), LIMITS)
    nowhere = drive(LINE, 20, 10, STEPS)
    nowhere.position[:] = np.nan
    violation, _ = checker.check(0, drive(LINE, 10, 10, STEPS)[np.newaxis], stack([nowhere]), checker.size[1:])
    assert violation.tolist() == [Violation.NONE]


def test_people_are_avoided():
    walker = Trajectories.empty(1, STEPS)
    walker.position[:] = [80.0, 0.5]
    walker.valid[:] = True
    people = Actors(np.array(["p"]), np.array([5], np.uint8), np.float32([[0.6, 0.6, 1.8]]), walker)
    log = stack([drive(LINE, 50, 10, STEPS)])
    violation, first = check_samples(replace(scenario(ROAD, log), context=people), log[np.newaxis], LIMITS)
    assert violation.tolist() == [[Violation.COLLISION_WITH_CONTEXT]]
    assert first.tolist() == [[28]]  # 27.4 m from its front to theirs


def test_corners_off_the_road_are_seen_and_a_short_touch_is_not():
    off = drive(beside(LINE, -1.5), 10, 10, STEPS)  # right side 0.7 m off the road from the start on
    onto = replace(off, position=off.position + np.float32([0, 1.5]) * (np.arange(STEPS) < 50)[:, None])
    assert judge(ROAD, off)[0] == [Violation.NONE]  # starts there: not judged
    assert judge(ROAD, onto)[0][0] & Violation.OFF_ROAD
    assert 54 <= first_of(ROAD, "off_road", onto) <= 56
    short = replace(
        off, position=off.position + np.float32([0, 1.5]) * ((np.arange(STEPS) < 50) | (np.arange(STEPS) > 52))[:, None]
    )
    assert not judge(ROAD, short)[0][0] & Violation.OFF_ROAD


def test_a_turned_car_leaves_the_road_with_its_corner_only():
    along = drive(LINE, 50, 0, STEPS)
    turned = replace(along, heading=np.where(np.arange(STEPS) < 20, 0, np.pi / 2).astype(np.float32))
    assert judge(straight_road(300, 1), turned)[0][0] & Violation.OFF_ROAD


def test_driving_against_the_lane_is_wrong_after_a_second_and_overtaking_at_once_is_not():
    roads = two_way_road()
    against = drive(reversed_line(LINE), 100, 8, STEPS)
    assert judge(roads, against)[0] == [Violation.WRONG_WAY]
    assert first_of(roads, "wrong_way", against) == pytest.approx(10, abs=2)
    there = drive(LINE, 20, 8, STEPS)
    swerve = np.float32(LANE_WIDTH) * ((np.arange(STEPS) > 40) & (np.arange(STEPS) < 45))
    brief = replace(there, position=there.position + np.stack([0 * swerve, swerve], axis=1))
    assert not judge(roads, brief)[0][0] & Violation.WRONG_WAY


def test_inside_a_junction_every_direction_is_right():
    roads = crossing(control=LaneControl.FREE)
    reverse_turn = drive(reversed_line(joined(roads, 9)), 1, 2, 50)
    assert not judge(roads, reverse_turn)[0][0] & Violation.WRONG_WAY


@pytest.mark.parametrize(("speed", "flag"), [(13.0, 0), (16.0, 0), (18.0, Violation.SPEED)])
def test_speeding_is_measured_from_the_lanes_limit(speed, flag):
    assert judge(ROAD, drive(LINE, 10, speed, STEPS))[0] == [flag]


def test_without_a_limit_only_the_absolute_one_holds():
    free = replace(ROAD, speed_limit=np.full(len(ROAD), np.nan, np.float32))
    assert judge(free, drive(LINE, 10, 27, STEPS))[0] == [Violation.NONE]
    assert judge(free, drive(LINE, 10, 45, STEPS))[0] == [Violation.SPEED]


@pytest.mark.parametrize(
    ("acceleration", "flag"), [(3.0, 0), (5.0, Violation.ACCELERATION), (-5.0, 0), (-7.0, Violation.ACCELERATION)]
)
def test_acceleration_and_braking_have_their_own_limits(acceleration, flag):
    start = 10.0 if acceleration < 0 else 0.0
    free = replace(ROAD, speed_limit=np.full(len(ROAD), np.nan, np.float32))
    motion = drive(LINE, 10, start, 30, acceleration)
    assert judge(free, motion)[0] == [flag]
    assert severity(free, "braking" if acceleration < 0 else "acceleration", motion) == pytest.approx(abs(acceleration), rel=0.02)


def circle(radius, speed, steps=60):
    turned = speed * np.arange(steps) * 0.1 / radius
    position = radius * np.stack([np.sin(turned), 1 - np.cos(turned)], axis=1)
    velocity = speed * np.stack([np.cos(turned), np.sin(turned)], axis=1)
    return Trajectories(*(a.astype(np.float32) for a in (position, turned, velocity)), np.ones(steps, np.bool_))


@pytest.mark.parametrize(
    ("radius", "speed", "flag"),
    [(10, 5, 0), (4, 3.5, Violation.CURVATURE), (20, 12, Violation.ACCELERATION), (3, 1.0, 0)],
)
def test_curves_are_limited_by_radius_and_by_speed(radius, speed, flag):
    """v^2 / r across, 1 / r curvature; creeping slower than the steering speed is not judged."""
    roads = replace(two_way_road(), speed_limit=np.full(2, np.nan, np.float32))
    log = stack([circle(radius, speed)])
    found = SceneChecker(scenario(roads, log), LIMITS).severities(log[np.newaxis])
    assert Violation(int(found.violation[0, 0])) & (Violation.CURVATURE | Violation.ACCELERATION) == flag
    assert found.worst[0, 0, RULES.index("lateral_acceleration")] == pytest.approx(speed**2 / radius, rel=0.05)


def test_sideways_motion_and_a_velocity_that_positions_do_not_share_are_impossible():
    straight = drive(LINE, 10, 10, STEPS)
    drifting = replace(straight, heading=np.full(STEPS, 0.3, np.float32))
    assert judge(ROAD, drifting)[0][0] & Violation.CURVATURE
    lying = replace(straight, velocity=straight.velocity * np.float32(0.5))
    assert judge(ROAD, lying)[0] == [Violation.ACCELERATION]


def test_noise_of_a_tracked_log_passes():
    random = np.random.default_rng(3)
    clean = drive(LINE, 10, 10, STEPS)
    noisy = replace(
        clean,
        position=clean.position + random.normal(0, 0.1, (STEPS, 2)).astype(np.float32),
        velocity=clean.velocity + random.normal(0, 0.5, (STEPS, 2)).astype(np.float32),
        heading=clean.heading + random.normal(0, 0.02, STEPS).astype(np.float32),
    )
    noisiest = replace(LIMITS, velocity_step=3.0)  # the one limit that such logs raise
    assert judge(ROAD, noisy, limits=noisiest)[0] == [Violation.NONE]


CROSS = crossing()
STRAIGHT = joined(CROSS, 0, 8, 4)


@pytest.mark.parametrize(
    ("state", "flag"),
    [(SignalState.RED, Violation.RED_LIGHT), (SignalState.GREEN, 0), (SignalState.YELLOW, 0), (SignalState.UNKNOWN, 0)],
)
def test_entering_on_red_is_illegal(state, flag):
    flags, first = judge(CROSS, drive(STRAIGHT, 50, 10, STEPS), signals=lights(8, [state] * STEPS))
    assert flags == [flag]
    # the front, 2.3 m ahead of the centre, is 1 m beyond the line at 81 m - 2.3 m
    assert first == ([29] if flag else [-1])


def test_a_light_that_turned_red_a_moment_ago_is_forgiven():
    motion = drive(STRAIGHT, 50, 10, STEPS)
    for since, flag in ((26, 0), (20, Violation.RED_LIGHT)):
        states = np.where(np.arange(STEPS) < since, SignalState.GREEN, SignalState.RED)
        assert judge(CROSS, motion, signals=lights(8, states))[0] == [flag]


def test_stopping_at_red_is_legal_even_a_little_beyond_the_line():
    # stops with its front 0.6 m over the line
    motion = drive(STRAIGHT, 80 + 0.6 - 2.3 - 25, 10, STEPS, -2.0)
    assert judge(CROSS, motion, signals=lights(8, [SignalState.RED] * STEPS))[0] == [Violation.NONE]


def test_a_red_light_for_going_straight_does_not_hold_who_turns_right():
    right = drive(joined(CROSS, 0, 10, 7), 55, 5, STEPS)
    assert not judge(CROSS, right, signals=lights(8, [SignalState.RED] * STEPS))[0][0] & Violation.RED_LIGHT
    assert judge(CROSS, right, signals=lights(10, [SignalState.RED] * STEPS))[0][0] & Violation.RED_LIGHT


def stop_crossing():
    """The way in from the west must stop or yield, those from south and north go first."""
    roads = crossing(control=LaneControl.FREE)
    roads.control[8:11] = LaneControl.STOP
    return roads


@pytest.mark.parametrize(("acceleration", "flag"), [(0.0, Violation.STOP_OR_YIELD), (-1.6, 0)])
def test_a_stop_line_asks_for_a_stop(acceleration, flag):
    roads = stop_crossing()
    approach = drive(STRAIGHT, 44, 10, 70, acceleration)
    leaving = drive(STRAIGHT, 44 + 10**2 / 3.2, 0, 60, 2.0)
    motion = approach if not acceleration else stack_in_time(approach, leaving)
    assert judge(roads, motion)[0] == [flag]


def stack_in_time(a, b):
    return Trajectories(*(np.concatenate([getattr(a, n), getattr(b, n)]) for n in ("position", "heading", "velocity", "valid")))


@pytest.mark.parametrize(("start", "illegal"), [(36.0, True), (0.0, False)])
def test_giving_way_is_a_matter_of_time_between_leaving_and_arriving(start, illegal):
    roads = stop_crossing()
    roads.control[8:11] = LaneControl.YIELD
    own = drive(STRAIGHT, 66, 6, STEPS)
    priority = drive(joined(roads, 1, 11, 5), start, 10, STEPS)
    flags, _ = judge(roads, own, priority)
    assert bool(flags[0] & Violation.STOP_OR_YIELD) == illegal
    assert flags[1] & Violation.STOP_OR_YIELD == 0
    assert not flags[0] & Violation.COLLISION


@pytest.mark.parametrize(("start", "illegal"), [(60.0, False), (47.2, True)])
def test_who_went_first_is_past_and_who_comes_at_the_same_step_has_priority(start, illegal):
    """The boxes reach the conflict point, 91.75 m and 88.25 m along, at step 39, and at step 26 or 39."""
    roads = stop_crossing()
    roads.control[8:11] = LaneControl.YIELD
    flags, _ = judge(roads, drive(STRAIGHT, 66, 6, STEPS), drive(joined(roads, 1, 11, 5), start, 10, STEPS))
    assert bool(flags[0] & Violation.STOP_OR_YIELD) == illegal


def test_who_follows_through_the_same_gate_has_no_priority():
    roads = stop_crossing()
    roads.control[8:11] = LaneControl.YIELD
    # it reaches the point where other ways join about 0.3 s after the first has left it; who has priority is owed 0.5 s
    assert judge(roads, drive(STRAIGHT, 66, 6, STEPS), drive(STRAIGHT, 59, 6, STEPS))[0] == [0, 0]


def test_candidates_are_judged_against_what_is_committed_only():
    base = scenario(ROAD, stack([drive(LINE, 10, 10, STEPS), drive(LINE, 60, 2, STEPS)]))
    checker = SceneChecker(base, LIMITS)
    candidates = stack([drive(LINE, 10, speed, STEPS) for speed in (2, 5, 12)])
    size = base.vehicles.size[:, :2]
    nobody, _ = checker.check(0, candidates, base.log[:0], size[:0])
    assert nobody.tolist() == [0, 0, 0]
    violation, first = checker.check(0, candidates, base.log[1:], size[1:])
    assert violation.tolist() == [0, 0, Violation.COLLISION]
    assert first.tolist() == [-1, -1, 46]


def test_the_target_can_be_left_out_as_a_partner():
    motion = stack([drive(LINE, 10, 12, STEPS), drive(LINE, 40, 4, STEPS), drive(LINE, 50, 1, STEPS)])
    checker = SceneChecker(scenario(ROAD, motion), LIMITS)
    both, _ = checker.check_samples(motion[np.newaxis])
    without, _ = checker.check_samples(motion[np.newaxis], ignore_target=True)
    assert (both & Violation.COLLISION > 0).tolist() == [[True, True, True]]
    assert (without & Violation.COLLISION > 0).tolist() == [[False, True, True]]


def test_samples_are_judged_one_by_one_and_in_any_order():
    random = np.random.default_rng(0)
    motion = stack([stack([drive(LINE, 10 + 30 * n, random.uniform(2, 18), STEPS) for n in range(4)]) for _ in range(5)])
    checker = SceneChecker(scenario(ROAD, motion[0]), LIMITS)
    violation, first = checker.check_samples(motion)
    for k in range(5):
        alone = checker.check_samples(motion[k : k + 1])
        assert (alone[0][0] == violation[k]).all()
        assert (alone[1][0] == first[k]).all()
    assert (violation[:, ::-1] == checker_of(motion[:, ::-1]).check_samples(motion[:, ::-1])[0]).all()


def checker_of(motion):
    return SceneChecker(scenario(ROAD, motion[0]), LIMITS)


def test_nothing_valid_is_nothing_judged():
    empty = Trajectories.empty(1, 1, STEPS)
    log = stack([drive(LINE, 10, 10, STEPS)])
    found = SceneChecker(scenario(ROAD, log), LIMITS).severities(empty)
    assert (found.worst == NEVER).all()
    assert found.violation.tolist() == [[0]]
    assert found.first_step.tolist() == [[-1]]


def test_where_the_network_ends_the_road_ends_and_where_it_is_cut_it_does_not():
    onward = drive(LINE, 250, 8, STEPS)  # over the end at 300 m, straight on
    assert judge(ROAD, onward) == ([Violation.NONE], [-1])
    flags, first = judge(straight_road(whole=True), onward)
    assert flags == [Violation.OFF_ROAD]
    assert 60 < first[0] < 75  # its front is out after 6 s
    beyond = drive(np.array([[0.0, 0.0], [400.0, 0.0]]), 250, 30, STEPS)  # out of the raster, too
    assert Violation.OFF_ROAD in judge(straight_road(whole=True), beyond)[0][0]
    assert Violation.OFF_ROAD not in judge(ROAD, beyond)[0][0]


def test_who_starts_off_the_road_is_judged_once_it_is_on_it():
    way = np.array([[20.0, -6.0], [40.0, -6.0], [70.0, 0.0], [110.0, 0.0], [140.0, -9.0], [300.0, -9.0]])
    kinked = replace(LIMITS, curvature=9, lateral_acceleration=99, side_slip=9, velocity_step=9)
    flags, first = judge(ROAD, drive(way, 0, 12, STEPS), limits=kinked)
    assert Violation.OFF_ROAD in flags[0]
    assert 90 < 20 + 1.2 * first[0] < 160  # the way out, not the way in
    away = np.array([[20.0, -4.5], [40.0, -4.5], [80.0, -25.0], [300.0, -25.0]])
    assert Violation.OFF_ROAD in judge(ROAD, drive(away, 0, 12, STEPS))[0][0]  # it does not come, it goes
    parked = drive(way, 0, 0, STEPS)
    parked.position[50:] = drive(way[:4], 0, 12, STEPS).position[:51]
    assert Violation.OFF_ROAD not in judge(ROAD, parked)[0][0]


def test_candidates_of_many_samples_are_judged_as_each_sample_alone():
    scene = busy_crossing()
    motion, checker = noisy_samples(scene, 3, 5).motion, SceneChecker(scene, LIMITS)
    others = replace(motion, valid=motion.valid & (np.arange(len(scene.vehicles)) != 1)[:, None])
    sample, planned = np.array([0, 0, 2]), motion[np.array([0, 1, 2]), 1]
    alone = checker.alone(np.full(3, 1), planned)
    apart = [checker.severities_of(1, planned[i : i + 1], others[k], checker.size) for i, k in enumerate(sample.tolist())]
    together = checker.among_samples(1, planned, sample, others, checker.size, alone)
    assert np.array_equal(together.worst, np.concatenate([one.worst for one in apart]))
    assert np.array_equal(together.first, np.concatenate([one.first for one in apart]))
    assert (together.worst[:, RULES.index("overlap")] > NEVER).any()


@pytest.mark.parametrize("far", [1e20, -1e20, 3e38])
def test_a_place_beyond_all_whole_numbers_is_illegal_and_nothing_else(far):
    """A planner that diverges gives such places before it gives ones that are not finite."""
    scene = busy_crossing()
    for first in (50, 0):
        motion = scene.log.copy()
        motion.position[0, first:] = far
        motion.position[0, 0] = scene.log.position[0, 0]
        violation, _ = check_samples(scene, motion[np.newaxis], LIMITS)
        assert Violation(int(violation[0, 0])) & Violation.ACCELERATION
        assert violation[0, 6:].tolist() == [0, 0]
