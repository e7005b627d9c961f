"""The release gate on hand-made scenes: who is worse, what counts, what is said."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import Trajectories
from drivegen.corner_cases.gate import Gate, Settings, gate
from drivegen.drivers import idm
from drivegen.drivers.mutants.table import Mutant
from drivegen.metrics.paired import Finding, Paired
from drivegen.rollout.shipping import sample_id
from drivegen.simulators.batch import Plugin as Batch
from drivegen.world.observation import Action
from tests.checking import IDM
from tests.scenes import drive, joined, scenario, stack, straight_road

ROAD = straight_road(600)
LINE = ROAD.centreline[0].astype(np.float64)
SETTINGS = Settings(alarms=0.05, avoidable=False, draws=100)
SOUND = idm.Plugin(IDM)
BLIND = Mutant("idm.ignores_standing", SOUND)


def parked(recording: str, sample: int = 0, place: float = 80.0):
    """A target on its way to a parked car, cut from that recording."""
    log = stack([drive(LINE, 20, 12, 101), drive(LINE, place + 2 * sample, 0, 101)])
    scene = scenario(ROAD, log, f"{recording}-{sample}")
    return scene, sample, scene.log


def appears(recording: str):
    """A car stands in the target's way that is there from one second and a half on: nobody can avoid it."""
    scene, _, log = parked(recording, place=47.0)
    valid = log.valid.copy()
    valid[1, :15] = False
    log = Trajectories(log.position, log.heading, log.velocity, valid)
    return replace(scene, log=log), 0, log


def test_who_overlooks_parked_cars_is_worse_and_who_sees_them_again_is_better():
    traffic = [parked(f"run{n}", k) for n in range(6) for k in range(2)]
    worse = gate(SOUND, BLIND, traffic, SETTINGS, 7)
    assert worse.finding == Finding.WORSE
    assert worse.collided.tolist() == [[False] * 12, [True] * 12]
    assert worse.paired.differences.tolist() == [2] * 6
    assert worse.shares[2].value == 1.0
    assert "worse: in 12 runs of 6 recordings new has 12 counted collisions more than old; odds" in worse.sentence("old", "new")
    assert gate(BLIND, SOUND, traffic, SETTINGS, 7).finding == Finding.BETTER


def test_a_driver_is_not_told_from_itself_nor_two_by_one_recording():
    traffic = [parked("run", k) for k in range(20)]
    same = gate(BLIND, BLIND, traffic, SETTINGS, 7)
    assert same.finding == Finding.UNDECIDED
    assert "each recording has as many of both" in same.sentence("a", "b")
    alone = gate(SOUND, BLIND, traffic, SETTINGS, 7)
    assert (alone.finding, alone.paired.only_new) == (Finding.UNDECIDED, 20)
    assert "too few to tell: give more recordings" in alone.sentence("a", "b")


def test_what_nobody_could_avoid_counts_only_where_all_counts():
    traffic = [appears("sudden"), parked("seen")]
    both = gate(SOUND, BLIND, traffic, SETTINGS, 7)
    assert both.collided.tolist() == [[True, False], [True, True]]
    assert "a has 1 counted collision, b 2;" in both.sentence("a", "b")
    seen = gate(SOUND, BLIND, traffic, replace(SETTINGS, avoidable=True), 7)
    assert seen.collided.tolist() == [[False, False], [False, True]]
    assert "a has 0 avoidable collisions, b 1;" in seen.sentence("a", "b")


def test_the_record_names_the_runs_in_which_only_one_collided():
    scene, _, log = parked("run")
    free, _, way = parked("free", place=500.0)
    record = gate(SOUND, BLIND, [(scene, 1, log), (scene, 4, log), (free, 0, way)], SETTINGS, 7).record("a", "b")
    assert record["differ"] == [{"scenario": "run-0", "sample": k, "collided": "new"} for k in (1, 4)]
    assert (record["runs"], record["recordings"], record["finding"]) == (3, 2, "not told apart")
    assert record["collisions"] == {"old": 0, "new": 2, "only_old": 0, "only_new": 2}


def test_what_would_have_been_noticed_is_said_where_nothing_is_found():
    names = [f"run{n}" for n in range(20)]
    collided = np.array([[n % 2 == which for n in range(20)] for which in range(2)])
    result = Gate(SETTINGS, names, [0] * 20, collided, Paired.of(*collided, names), [], (0.0, 0.0))
    assert result.finding == Finding.UNDECIDED
    assert result.paired.noticed(0.05) == pytest.approx(np.sqrt(20) * 2.926, rel=1e-3)
    assert "about 13 more (131%) would be noticed" in result.sentence("a", "b")


class Evades:
    """Drives beside the road, where nobody is."""

    name = "evades"

    def act(self, seen):
        return Action(torch.zeros_like(seen.speed), torch.full_like(seen.speed, 20.0))


def test_who_hits_nobody_because_it_leaves_the_road_is_said_to():
    found = gate(BLIND, Evades(), [parked(f"run{n}", k) for n in range(6) for k in range(2)], SETTINGS, 7)
    assert found.finding == Finding.BETTER
    assert found.off_road[0] == 0
    assert found.off_road[1] > 0.3
    assert f"; evades is off the road for {found.off_road[1]:.1%} of its time, idm for 0.0%" in found.sentence("idm", "evades")
    assert found.record("idm", "evades")["off_road"] == {"old": 0.0, "new": found.off_road[1]}
    assert "off the road" not in gate(BLIND, SOUND, [parked("run")], SETTINGS, 7).sentence("a", "b")


def test_a_short_run_off_the_road_is_a_small_share_of_all_time():
    road = straight_road(600, 1)
    line, beside = joined(road, 0), np.array([[0.0, -3.0], [600.0, -3.0]])
    free = stack([drive(line, 20, 10, 101), drive(line, 400, 10, 101)])
    short = stack([drive(beside, 20, 10, 101), drive(beside, 33, 0, 101)])  # runs into it after a second
    scenes = [(scenario(road, free, "a-0"), 0, free), (scenario(road, short, "b-0"), 0, short)]
    found = gate(BLIND, BLIND, scenes, SETTINGS, 7)
    steps = Batch().run(BLIND, [scene for scene, _, _ in scenes], [free, short]).motion.valid.sum(axis=1)
    assert steps[0] == 101 > 8 * steps[1]
    assert found.off_road[0] == pytest.approx(steps[1] / steps.sum())


def test_without_scenes_there_is_nothing_to_compare():
    with pytest.raises(UnusableInput, match="no scene"):
        gate(SOUND, BLIND, [], SETTINGS, 7)


def test_futures_that_became_scenarios_are_of_their_recording():
    scene, _, log = parked("run")
    shipped = [(replace(scene, scenario_id=sample_id("ring-0-3-00120-car7", k)), 0, log) for k in range(8)]
    found = gate(SOUND, BLIND, shipped, SETTINGS, 7)
    assert (found.paired.differences.tolist(), found.finding) == ([8], Finding.UNDECIDED)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_verdict_that_its_odds_do_not_share_is_said_without_them(sign):
    differences = sign * np.array([20] * 40 + [-20] * 23 + [0])
    collided = np.zeros((2, 1300), bool)
    paired = replace(Paired.of(*collided, [f"r{n}" for n in range(1300)]), differences=differences, new=400 + sign * 340, old=400)
    result = Gate(SETTINGS, [], [], collided, paired, [], (0.0, 0.0))
    assert result.finding == (Finding.WORSE if sign > 0 else Finding.BETTER)
    assert "odds" not in result.sentence("a", "b")
