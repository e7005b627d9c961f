"""Every kind of corner case by a handmade one, and what one kind holds."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.core.scenario import Actors
from drivegen.corner_cases.avoidance import Avoidance
from drivegen.corner_cases.encounters import Behaviour
from drivegen.corner_cases.judgement import Judgement
from drivegen.corner_cases.kinds import Kind, groups, kind_of, meeting
from tests.corner_cases.handmade import LINE, NEXT, collision
from tests.corner_cases.test_corner_cases_avoidance import shifting
from tests.scenes import crossing, drive, joined, stack

CROSSING = crossing()
STRAIGHT, LEFT = joined(CROSSING, 0, 8, 4), joined(CROSSING, 0, 9, 5)
ONCOMING, TURNING = joined(CROSSING, 2, 14, 6), joined(CROSSING, 2, 15, 7)
FROM_RIGHT, FROM_LEFT = joined(CROSSING, 1, 11, 5), joined(CROSSING, 3, 17, 7)
JOINING = joined(CROSSING, 1, 13, 4)
BACK = LINE[::-1].copy()
FIELDS = ("position", "heading", "velocity", "valid")

SCENES = {
    Kind.CUT_IN: (drive(LINE, 20, 14, 101), shifting(NEXT, 50, 8, 2.0, 2.0)),
    Kind.OWN_SHIFT: (shifting(NEXT, 20, 14, 2.0, 2.0), drive(LINE, 48, 8, 101)),
    Kind.REAR: (drive(LINE, 20, 14, 101), drive(LINE, 50, 8, 101)),
    Kind.STANDING: (drive(LINE, 20, 14, 101), drive(LINE, 90, 0, 101)),
    Kind.ONCOMING: (drive(LINE, 20, 14, 101), drive(BACK, 450, 8, 101)),
    Kind.ONCOMING_TURN: (drive(STRAIGHT, 40, 10, 101), drive(TURNING, 38, 10, 101)),
    Kind.OWN_TURN: (drive(LEFT, 38, 10, 101), drive(ONCOMING, 40, 10, 101)),
    Kind.CROSSING_LEFT: (drive(STRAIGHT, 40, 10, 101), drive(FROM_LEFT, 40, 10, 101)),
    Kind.CROSSING_RIGHT: (drive(STRAIGHT, 40, 10, 101), drive(FROM_RIGHT, 41, 10, 101)),
    Kind.MERGE: (drive(STRAIGHT, 30, 12, 101), drive(JOINING, 68, 5, 101)),
}


@pytest.mark.parametrize("kind", SCENES)
def test_each_kind_is_named(kind):
    roads = {"roads": CROSSING} if kind in list(SCENES)[5:] else {}
    assert kind_of(collision(stack(list(SCENES[kind])), **roads)) == kind


def test_who_comes_over_slowly_cuts_in_and_who_stays_beside_does_not():
    pair = (drive(LINE, 20, 12, 101), shifting(NEXT, 20, 12, 2.0, 10.0))
    assert kind_of(collision(stack(list(pair)))) == Kind.CUT_IN
    assert kind_of(collision(stack(list(pair[::-1])))) == Kind.OWN_SHIFT


def test_who_swings_over_slowly_from_beside_cuts_in_though_it_turns_as_much_as_who_comes_from_another_road():
    swing = np.array([[0, NEXT[0, 1]], [60, NEXT[0, 1]], [68, LINE[0, 1]], [200, LINE[0, 1]]])
    assert kind_of(collision(stack([drive(LINE, 20, 14, 101), drive(swing, 58, 2, 101)]))) == Kind.CUT_IN


def arc(radius: float, turn: float) -> np.ndarray:
    """A way (P, 2) [m] of a point every degree: a bend to the left by `turn` degrees about the origin."""
    angle = np.radians(np.arange(turn + 1))
    return radius * np.stack([np.cos(angle), np.sin(angle)], -1)


def test_who_has_only_begun_its_turn_when_it_is_hit_turns_all_the_same():
    before, bend = np.array([[200.0, LINE[0, 1] + 2.6]]), arc(20, 90)[:, ::-1] * [-1, 1] + [110, LINE[0, 1] + 2.6 - 20]
    case = collision(stack([drive(LINE, 20, 14, 101), drive(np.concatenate([before, bend]), 45, 8, 101)]))
    met = meeting(case)
    assert met.opposed
    assert (met.did, met.own) == (Behaviour.STRAIGHT, Behaviour.STRAIGHT)
    assert kind_of(case) == Kind.ONCOMING_TURN


def test_who_comes_towards_it_round_a_bend_and_follows_it_is_oncoming():
    case = collision(stack([drive(arc(130, 90), 5, 12, 101), drive(arc(131, 90)[::-1], 90, 8, 101)]))
    way = case.other[0]
    assert meeting(case).opposed
    assert abs(way.heading[case.step + 30] - way.heading[case.step - 30]) > np.radians(20)
    assert kind_of(case) == Kind.ONCOMING


def test_who_is_run_into_on_a_bend_ahead_is_run_into_from_behind_though_it_turns():
    case = collision(stack([drive(LEFT, 47.0, 12, 101), drive(LEFT, 80, 2.6, 101)]), roads=CROSSING)
    met = meeting(case)
    assert (met.did, met.own) == (Behaviour.TURNING_LEFT, Behaviour.STRAIGHT)
    assert kind_of(case) == Kind.REAR


def test_a_person_is_a_kind_of_its_own():
    case = collision(stack(list(SCENES[Kind.STANDING])))
    walker = Actors(np.array(["p"]), np.array([5], np.uint8), np.float32([[0.6, 0.6, 1.8]]), case.traffic[1:])
    assert kind_of(replace(case, scenario=replace(case.scenario, context=walker), partner=2)) == Kind.PERSON


def test_duplicates_are_one_case_the_likeliest_and_the_largest_kind_comes_first():
    rear, stands = (collision(stack(list(SCENES[kind])), scenario_id=kind) for kind in (Kind.REAR, Kind.STANDING))
    twice = [replace(rear, odds=odds) for odds in (0.1, 0.3)]
    elsewhere = replace(stands, scenario=replace(stands.scenario, scenario_id="elsewhere"))
    found = groups([*twice, stands, elsewhere])
    assert [(group.kind, group.cases, group.duplicates) for group in found] == [
        (Kind.STANDING, (2, 3), 0),
        (Kind.REAR, (1,), 1),
    ]


def test_a_pair_that_meets_in_two_ways_is_one_case():
    rear, stands = (collision(stack(list(SCENES[kind]))) for kind in (Kind.REAR, Kind.STANDING))
    found = groups([replace(rear, odds=0.1), replace(stands, odds=0.3)])
    assert [(group.kind, group.cases, group.duplicates) for group in found] == [(Kind.STANDING, (1,), 1)]


def test_the_sentence_says_what_happens_and_how_much_time_there_was():
    case = collision(stack(list(SCENES[Kind.STANDING])))
    in_time, too_late = Avoidance(3.0, 1.2, 1.4), Avoidance(0.4, 0.6, float("nan"))
    said = Judgement(case, Kind.STANDING, in_time, in_time, {}).sentence
    assert said == (
        "Another stands in its way; after 4.7 s blind runs into it with its front (14 against 0 m/s). "
        "It can be seen coming 3.0 s before and avoided until 1.2 s before: 1.8 s to react."
    )
    assert "no longer" in Judgement(case, Kind.STANDING, too_late, too_late, {}).sentence


@pytest.mark.parametrize("kind", SCENES)
def test_a_gap_in_the_track_of_the_other_says_nothing_of_what_it_did(kind):
    roads = {"roads": CROSSING} if kind in list(SCENES)[5:] else {}
    case = collision(stack(list(SCENES[kind])), **roads)
    seen, scrambled = (replace(case.traffic, **{name: getattr(case.traffic, name).copy() for name in FIELDS}) for _ in range(2))
    for motion in (seen, scrambled):
        motion.valid[1, case.step - 31 : case.step - 8] = False
    scrambled.position[1, ~scrambled.valid[1]] = 0.0
    scrambled.heading[1, ~scrambled.valid[1]] = 3.0
    scrambled.velocity[1, ~scrambled.valid[1]] = 0.0
    assert meeting(replace(case, traffic=scrambled)) == meeting(replace(case, traffic=seen))
    assert kind_of(replace(case, traffic=scrambled)) == kind_of(replace(case, traffic=seen))
