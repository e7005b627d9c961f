from dataclasses import replace

import numpy as np
import pytest

from drivegen.core.scenario import FIRST_SECOND, Actors, Trajectories
from drivegen.simulators.batch import Plugin
from drivegen.world.outcome import AT_FAULT, CollisionKind, with_off_road
from tests.scenes import LANE_WIDTH, across, beside, drive, scenario, stack, straight_road
from tests.world.steady import Steady

ROAD = straight_road(600)
LINE = ROAD.centreline[0].astype(np.float64)
NEXT = ROAD.centreline[1].astype(np.float64)


def meet(other, target=None, driver=None, **changes):
    target = target if target is not None else drive(LINE, 50, 10, 101)
    log = stack([target, other])
    scene = replace(scenario(ROAD, log), **changes)
    outcome = Plugin().run(driver or Steady(), [scene], [log])
    return CollisionKind(outcome.kind[0]), int(outcome.step[0]), outcome


@pytest.mark.parametrize(
    ("kind", "other", "target"),
    [
        (CollisionKind.FRONT, drive(LINE, 80, 0, 101), None),
        (CollisionKind.FRONT, drive(LINE[::-1].copy(), 480, 8, 101), None),  # head-on: the target's front is in it
        (CollisionKind.HIT_FROM_BEHIND, drive(LINE, 20, 16, 101), None),
        (CollisionKind.HIT_STANDING, drive(LINE, 20, 16, 101), drive(LINE, 50, 0, 101)),
        (CollisionKind.FRONT, drive(across(80), 120, 0, 101), None),  # into the side of one that stands across
        (CollisionKind.HIT_IN_SIDE, drive(across(80), 88, 10, 101), None),  # it comes with its front into ours
        (CollisionKind.FRONT, drive(beside(LINE, 1.5), 80, 0, 101), drive(LINE, 50, 30, 101)),  # fast, hardly overlapping
        (CollisionKind.HIT_FROM_BEHIND, drive(beside(LINE, -1.5), 20, 39, 101), None),
        (CollisionKind.AT_SPAWN, drive(LINE, 53, 10, 101), None),
        (CollisionKind.NONE, drive(NEXT, 50, 10, 101), None),
        (CollisionKind.NONE, drive(LINE, 60, 10, 101), None),
    ],
)
def test_who_hit_whom(kind, other, target):
    assert meet(other, target)[0] == kind


def hidden(track, first, last):
    """The track as one sees it that is hidden from step `first` to the one before `last`."""
    step = np.arange(track.steps)
    return replace(track, valid=track.valid & ~((step >= first) & (step < last)))


@pytest.mark.parametrize(("first", "last"), [(0, 29), (10, 29)])  # it begins there, or goes on after a gap
def test_who_appears_inside_the_target_is_nobodys_collision(first, last):
    seen, again, outcome = meet(hidden(drive(LINE, 80, 0, 101), first, last))
    assert (seen, again) == (CollisionKind.AT_SPAWN, 29)
    assert outcome.artefact[0]
    assert not outcome.counted[0]
    assert meet(hidden(drive(LINE, 80, 0, 101), 0, 20))[0] == CollisionKind.FRONT  # there for a while before they meet


def test_side_swipes_are_the_drivers_fault():
    kind, _, _ = meet(drive(NEXT, 50, 10, 101), driver=Steady(offset=LANE_WIDTH))
    assert kind == CollisionKind.SIDE
    assert kind in AT_FAULT


def test_crashes_in_the_first_second_are_told_apart():
    kind, step, outcome = meet(drive(LINE, 58, 0, 101))
    assert (kind, step) == (CollisionKind.FRONT, 4)  # 3.4 m at 10 m/s
    assert outcome.in_first_second[0]
    assert not meet(drive(LINE, 80, 0, 101))[2].in_first_second[0]
    steps = np.array([0, FIRST_SECOND, FIRST_SECOND + 1, -1], np.int16)
    kinds = np.array([CollisionKind.AT_SPAWN, CollisionKind.FRONT, CollisionKind.FRONT, CollisionKind.NONE], np.uint8)
    told = replace(outcome, kind=kinds, step=steps).in_first_second
    assert told.tolist() == [True, True, False, False]
    kinds[2] = CollisionKind.HIT_FROM_BEHIND
    assert replace(outcome, kind=kinds, step=steps).artefact.tolist() == [True, True, True, False]


def test_the_first_collision_counts_and_ends_the_run():
    log = stack([drive(LINE, 50, 10, 101), drive(LINE, 110, 0, 101), drive(LINE, 70, 0, 101)])
    outcome = Plugin().run(Steady(), [scenario(ROAD, log)], [log])
    assert outcome.partner[0] == 2
    assert outcome.motion.valid[0].sum() == outcome.step[0] + 1 == 17  # 15.4 m at 10 m/s is 16 steps


def test_people_are_partners_after_the_vehicles():
    walker = Trajectories.empty(1, 101)
    walker.position[:], walker.valid[:] = [80.0, 0.0], True
    people = Actors(np.array(["p"]), np.array([5], np.uint8), np.float32([[0.6, 0.6, 1.8]]), walker)
    kind, _, outcome = meet(drive(LINE, 300, 10, 101), context=people)
    assert kind == CollisionKind.FRONT
    assert outcome.partner[0] == 2


def test_offsets_are_approached_along_the_path_and_at_a_bounded_slope():
    log = stack([drive(LINE, 50, 10, 101)])
    motion = Plugin().run(Steady(offset=3.0), [scenario(ROAD, log)], [log]).motion
    side = motion.position[0, :, 1]
    assert side[-1] == pytest.approx(3.0)
    assert (np.diff(side) / np.diff(motion.position[0, :, 0])).max() == pytest.approx(0.3, abs=1e-3)
    assert motion.position[0, -1, 0] == pytest.approx(150, abs=0.5)
    assert np.hypot(*np.diff(motion.position[0], axis=0).T) == pytest.approx(1.0, abs=1e-3)  # at 10 m/s, whichever way it goes


@pytest.mark.parametrize(("speed", "kind"), [(0.05, CollisionKind.HIT_STANDING), (0.2, CollisionKind.HIT_FROM_BEHIND)])
def test_who_creeps_no_faster_than_noise_stands(speed, kind):
    assert meet(drive(LINE, 20, 16, 101), drive(LINE, 50, speed, 101))[0] == kind


def test_targets_never_drive_backwards():
    log = stack([drive(LINE, 50, 3, 101)])
    motion = Plugin().run(Steady(acceleration=-2.0), [scenario(ROAD, log)], [log]).motion
    assert (np.diff(motion.position[0, :, 0]) >= 0).all()
    assert motion.speed[0, -1] == 0


def test_time_off_the_road_is_a_share_of_the_steps():
    log = stack([drive(beside(LINE, -6.0), 50, 10, 101)])
    scene = scenario(ROAD, log)
    off = Plugin().run(Steady(), [scene], [log])
    assert np.isnan(off.off_road[0])
    assert with_off_road(off, [scene]).off_road[0] > 0.5
    on = stack([drive(LINE, 50, 10, 101)])
    assert with_off_road(Plugin().run(Steady(), [scene], [on]), [scene]).off_road[0] == 0
