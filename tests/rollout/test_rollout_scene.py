"""The rollout: what is kept is legal together, budgets hold, records agree with what was drawn."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from drivegen.checker.scene import check_samples
from drivegen.core.errors import UnusableInput
from drivegen.core.samples import NO_GOAL, Samples, Violation
from drivegen.core.scenario import DT, TARGET
from drivegen.goals.candidates import candidates
from drivegen.goals.joint import draw_together
from drivegen.goals.manoeuvres import Manoeuvre
from drivegen.goals.packing import pack
from drivegen.roads.graph import LaneGraph
from drivegen.rollout.batch import BRAKING, goal_requests, roll_out
from drivegen.rollout.choices import Choices, choose, recorded_choices, tempered
from drivegen.rollout.models import Equipment
from drivegen.rollout.scene import Rollout, RolloutSettings, steps_to_avoid_target
from drivegen.rollout.towards import Spread, plan_all_goals, plan_near_goals
from tests.checking import LIMITS
from tests.models import candidate_settings, two_lanes
from tests.scenes import busy_crossing, drive, joined, scenario, stack, straight_road

SETTINGS = RolloutSettings(attempts=3, rounds=4, evictions=1, drop_illegal=False, target_steps=None, exclusion=True, tempo=0.8)
SAMPLES = 4


@pytest.fixture(scope="module")
def equipment(models) -> Equipment:
    return Equipment.open(models, "route_fm", "random")


@pytest.fixture(scope="module")
def choices(equipment) -> list[Choices]:
    """Goals at random on busy roads: many exclude each other, and not every vehicle finds a way."""
    scenes = [busy_crossing(), two_lanes(9.0)]
    return choose(scenes, equipment.selector, candidate_settings(), 1.0)


def rolled(equipment, choices, **changes) -> list[Samples]:
    settings = replace(SETTINGS, **changes)
    return roll_out(choices, equipment.planner, equipment.limits, settings, SAMPLES, 7, "drivegen")


def test_what_is_kept_is_legal_together_and_what_is_not_is_left_out(equipment, choices):
    made = rolled(equipment, choices, drop_illegal=True)
    for choice, samples in zip(choices, made, strict=True):
        np.testing.assert_array_equal(samples.motion.valid.all(-1), ~samples.dropped)
        np.testing.assert_array_equal(samples.motion.valid.any(-1), ~samples.dropped)
        violation, _ = check_samples(choice.scenario, samples.motion, equipment.limits)
        assert not violation[~samples.dropped].any()
        assert not samples.violation.any()


def test_verdicts_are_those_of_all_vehicles_together_and_nobody_is_dropped(equipment, choices):
    for choice, samples in zip(choices, rolled(equipment, choices), strict=True):
        violation, first = check_samples(choice.scenario, samples.motion, equipment.limits)
        np.testing.assert_array_equal(samples.violation, violation)
        np.testing.assert_array_equal(samples.first_violation, first)
        assert not samples.dropped.any()
        assert samples.motion.valid.all()


def illegal(samples: list[Samples]) -> float:
    return float(np.concatenate([(s.violation != 0).ravel() for s in samples]).mean())


def test_more_rounds_leave_less_that_is_illegal(equipment, choices):
    first, last = (illegal(rolled(equipment, choices, rounds=rounds)) for rounds in (1, 6))
    assert first > 0
    assert last < 0.5 * first


@pytest.mark.parametrize(("attempts", "rounds", "evictions"), [(1, 1, 0), (3, 4, 1), (2, 3, 0)])
def test_attempts_stay_within_the_budget(equipment, choices, attempts, rounds, evictions):
    made = rolled(equipment, choices, attempts=attempts, rounds=rounds, evictions=evictions)
    counts = np.concatenate([s.attempts.ravel() for s in made])
    assert counts.min() >= 1
    assert counts.max() <= 1 + attempts * (rounds - 1)


def test_who_is_evicted_is_planned_again_a_bounded_number_of_times(equipment, choices, monkeypatch):
    made = []
    monkeypatch.setattr("drivegen.rollout.batch.Rollout", lambda *given: made.append(Rollout(*given)) or made[-1])
    rolled(equipment, choices, evictions=1, rounds=6)
    evictions = np.concatenate([rollout.evictions.ravel() for rollout in made])
    assert evictions.max() <= 1


def test_the_record_holds_the_probabilities_of_the_goals_that_were_followed(equipment, choices):
    leaning = [replace(c, used=tempered(c.natural, c.candidates, 0.5)) for c in choices]
    for choice, samples in zip(leaning, rolled(equipment, leaning), strict=True):
        for n in range(len(choice.scenario.vehicles)):
            np.testing.assert_array_equal(samples.natural[:, n], choice.natural[n][samples.goal[:, n]])
            np.testing.assert_array_equal(samples.used[:, n], choice.used[n][samples.goal[:, n]])


def test_first_goals_follow_the_odds_they_are_drawn_with(equipment, choices):
    """A goal that is certain is followed, even where it stays illegal."""
    certain = [replace(c, used=[np.eye(1, len(p), dtype=np.float32)[0] for p in c.used]) for c in choices]
    for samples in rolled(equipment, certain):
        assert not samples.goal.any()


@pytest.mark.parametrize("tempo", [0.0, 0.8])
def test_without_a_tempo_first_goals_are_drawn_with_the_own_odds_to_the_bit(equipment, choices, monkeypatch, tempo):
    given = []
    monkeypatch.setattr(
        "drivegen.rollout.draws.draw_together", lambda odds, *rest: given.append(odds) or draw_together(odds, *rest)
    )
    rolled(equipment, choices, tempo=tempo, rounds=1)
    own = [np.concatenate(choice.used) for choice in choices]
    assert [np.array_equal(np.broadcast_to(p, odds.shape), odds) for p, odds in zip(own, given, strict=True)] == [tempo == 0] * 2


def test_motion_ends_at_the_goal(equipment, choices):
    for choice, samples in zip(choices, rolled(equipment, choices), strict=True):
        for n, found in enumerate(choice.candidates):
            away = np.hypot(*(samples.motion.position[:, n, -1] - found.position[samples.goal[:, n]]).T)
            assert away.max() < 0.01


def test_who_is_to_stay_while_it_rolls_brakes_first(equipment):
    roads = straight_road(whole=True)
    rolling = scenario(roads, stack([drive(joined(roads, 0), 20, speed, 101) for speed in (1.8, 0.0)]))
    (choice,) = choose([rolling], equipment.selector, candidate_settings(), 1.0)
    rows = [(0, n, int(np.flatnonzero(c.manoeuvre == Manoeuvre.STAY)[0]), 0) for n, c in enumerate(choice.candidates)]
    requests = goal_requests([choice], [np.array(rows)], lambda _: 7)
    speed = equipment.planner.sample([rolling], requests).speed
    assert speed[0, 0] == pytest.approx(1.8, abs=1e-3)
    assert np.diff(speed[0]).min() > -1.5 * BRAKING * DT - 1e-3
    assert (speed[0, 12:] == 0).all()
    assert requests.goal_s.tolist() == pytest.approx([1.8**2 / (2 * BRAKING), 0.0], abs=1e-3)
    assert (speed[1] == 0).all()


def test_of_what_is_illegal_the_least_is_kept_whenever_it_came():
    road = straight_road()
    line = road.centreline[0].astype(np.float64)
    late, early = drive(line, 10, 10, 101, 1.2), drive(line, 10, 20, 101)  # too fast from some step on, or from the first
    aside = np.float32([[0, -3]]) * (np.arange(101) > 90)[:, None]
    worse = replace(late, position=late.position + aside)  # too fast, and off the road
    scene = scenario(road, stack([drive(line, 10, 10, 101)]))
    found = candidates(LaneGraph.of(road), scene, 0, candidate_settings())
    odds = [np.full(len(found), 1 / len(found), np.float32)]
    rollout = Rollout(Choices(scene, [found], odds, odds), LIMITS, SETTINGS, 1, 7)
    for tried, kept in (([worse], 0), ([early], 1), ([early, late], 2), ([worse, early], 2)):
        goals = [next(i for i, motion in enumerate((worse, early, late)) if motion is one) for one in tried]
        rollout.commit(np.array([(0, 0, goal, 0) for goal in goals]), stack(tried))
        assert rollout.goal.tolist() == [[kept]]
    np.testing.assert_array_equal(rollout.result("drivegen").motion.position[0, 0], late.position)


def test_a_target_whose_motion_is_known_beforehand_follows_no_goal_of_any_probability():
    road = straight_road()
    line = road.centreline[0].astype(np.float64)
    log = stack([drive(line, 10, 10, 101), drive(line, 60, 10, 101)])
    scene = scenario(road, log)
    found = [candidates(LaneGraph.of(road), scene, n, candidate_settings()) for n in range(2)]
    odds = [np.full(len(c), 1 / len(c), np.float32) for c in found]
    rollout = Rollout(Choices(scene, found, odds, odds), LIMITS, SETTINGS, 1, 7, log[[0]])
    rollout.commit(np.array([(0, 1, 3, 0)]), log[[1]])
    samples = rollout.result("drivegen")
    assert samples.goal.tolist() == [[NO_GOAL, 3]]
    for values, given in ((samples.natural, odds), (samples.used, odds)):
        assert np.isnan(values[0, TARGET])
        assert values[0, 1] == given[1][3]


def test_the_target_is_nobodys_partner_in_corner_cases(equipment, choices):
    for samples in rolled(equipment, choices, target_steps=20):
        assert not (samples.violation[:, TARGET] & Violation.COLLISION).any()


def test_who_comes_from_behind_avoids_the_target_always_the_others_until_its_driver_can_react():
    road = straight_road()
    line = road.centreline[0].astype(np.float64)
    cars = [drive(line, 100, 8, 101), drive(line, 50, 8, 101), drive(line, 150, 8, 101), drive(line[::-1], 250, 8, 101)]
    scene = scenario(road, stack(cars))  # the target, behind it, ahead of it, and behind it the other way
    assert scene.vehicles.position[3, 0] < scene.vehicles.position[0, 0]
    assert steps_to_avoid_target(scene, 20).tolist() == [101, 101, 20, 20]
    assert steps_to_avoid_target(scene, None).tolist() == [101] * 4


@pytest.mark.parametrize(("target_steps", "sent_away"), [(None, [1, 1, 0]), (20, [0, 1, 0])])
def test_nobody_is_sent_away_whom_a_vehicle_need_not_avoid(target_steps, sent_away):
    """An oncoming car runs into one that stands, and later into the target, which it avoids for two seconds only."""
    road = straight_road()
    line = road.centreline[0].astype(np.float64)
    cars = stack([drive(line, 100, 8, 101), drive(line, 150, 0, 101), drive(line[::-1], 125, 5, 101)])
    scene = scenario(road, cars)
    found = [candidates(LaneGraph.of(road), scene, n, candidate_settings()) for n in range(3)]
    odds = [np.full(len(c), 1 / len(c), np.float32) for c in found]
    rollout = Rollout(Choices(scene, found, odds, odds), LIMITS, replace(SETTINGS, target_steps=target_steps), 1, 7)
    for n in range(2):
        rollout._settle(0, n, 0, cars[n])
    assert rollout._evict(0, 2, cars[2])
    assert rollout.evictions[0].tolist() == sent_away


def test_for_no_scenarios_nothing_is_planned(equipment):
    assert roll_out([], equipment.planner, LIMITS, SETTINGS, 1, 7, "drivegen") == []
    assert plan_all_goals([], equipment.planner, 7) == []
    assert plan_near_goals([], [], Spread(1.0, 0.1, 1.0), equipment.planner, 7) == []


def test_recorded_goals_of_other_scenarios_are_refused(choices):
    columns = pack(replace(choices[0].scenario, scenario_id="another"), "random", choices[0].candidates, choices[0].natural)
    with pytest.raises(UnusableInput, match="other scenarios"):
        recorded_choices([choices[0].scenario], [columns], 1.0)


def test_temperature_sharpens_and_flattens():
    natural, kept = [np.float32([0.6, 0.3, 0.1])], [SimpleNamespace(manoeuvre=np.zeros(3, np.uint8))]
    assert tempered(natural, kept, 1.0)[0] is natural[0]  # to the last bit: a ratio of the two is 1
    np.testing.assert_allclose(tempered(natural, kept, 0.5)[0], np.float32([0.36, 0.09, 0.01]) / 0.46, rtol=1e-6)
    assert tempered(natural, kept, 5.0)[0][2] > 0.2


def test_odds_hold_at_the_least_temperature_that_settings_allow():
    many = SimpleNamespace(manoeuvre=np.resize(np.arange(len(Manoeuvre), dtype=np.uint8), 400))
    odds = tempered([np.full(400, 1 / 400, np.float32)], [many], 0.01)[0]
    np.testing.assert_allclose(odds, 1 / 400, rtol=1e-3)


def test_a_manoeuvre_does_not_lose_by_being_spread_over_more_candidates():
    """Half of the vehicles stay, half drive on to one of five places; so it remains at any temperature."""
    natural = [np.float32([0.5, 0.2, 0.1, 0.1, 0.05, 0.05])]
    ways = [SimpleNamespace(manoeuvre=np.array([Manoeuvre.STAY, *[Manoeuvre.KEEP] * 5], np.uint8))]
    for temperature in (0.2, 0.45, 1.0, 3.0):
        odds = tempered(natural, ways, temperature)[0]
        np.testing.assert_allclose(odds[0], 0.5, rtol=1e-6)
        np.testing.assert_allclose(odds[2] / odds[1], 0.5 ** (1 / temperature), rtol=1e-5)
    np.testing.assert_allclose(tempered([np.float32([0.8, 0.1, 0.1, 0, 0, 0])], ways, 0.5)[0][0], 0.64 / 0.68, rtol=1e-6)


def test_who_drives_out_by_an_exit_is_gone_and_legal_and_in_nobody_s_way(equipment):
    roads = straight_road(130, 1, whole=True)
    line = roads.centreline[0].astype(np.float64)
    scene = scenario(roads, stack([drive(line, start, 12, 101) for start in (60, 90, 25)]))
    samples = rolled(equipment, choose([scene], equipment.selector, candidate_settings(), 1.0))[0]
    assert samples.left_map.any()
    np.testing.assert_array_equal(samples.left_map, ~samples.motion.valid[..., -1])
    assert samples.motion.valid[..., 0].all()
    seen = np.cumprod(samples.motion.valid, axis=-1, dtype=bool)
    np.testing.assert_array_equal(seen, samples.motion.valid)  # gone for good
    fronts = samples.motion.position[..., 0] + 2.3
    assert fronts[samples.motion.valid].max() < 130.5
    assert not (samples.violation[samples.left_map] & Violation.OFF_ROAD).any()
