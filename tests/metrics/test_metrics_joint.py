"""Joint figures see what shuffling takes away: who goes first, and who would have been run over."""

import numpy as np
import pytest

from drivegen.metrics.joint import conflict_orders, scene_joint, shuffled, summary
from drivegen.metrics.road_edge import RoadEdges
from drivegen.scenario import Trajectories
from tests.scenes import crossing, drive, joined, scenario, stack

NO_ROAD = RoadEdges(np.zeros((4, 4), np.float32), np.zeros(2, np.float32), 1.0)
STEPS, SAMPLES = 81, 12


def meeting(first: float, second: float) -> Trajectories:
    """Two cars that cross at right angles in the middle of a crossing, each from its own start [m] at 10 m/s."""
    roads = crossing()
    return stack([drive(joined(roads, 0, 8, 4), first, 10, STEPS), drive(joined(roads, 2, 15, 7), second, 10, STEPS)])


def polite(count: int = SAMPLES) -> Trajectories:
    """Samples in which now the one, now the other car is let through: never both at once."""
    parts = [meeting(40, 10) if k % 2 else meeting(10, 40) for k in range(count)]
    return Trajectories(*(np.stack([getattr(p, n) for p in parts]) for n in ("position", "heading", "velocity", "valid")))


def test_the_order_at_a_crossing_is_the_difference_of_arrivals() -> None:
    motion = meeting(40, 10)[np.newaxis]
    late = conflict_orders(motion, motion.valid[0])[0]
    assert late[0, 1] == pytest.approx(3.0, abs=0.5)  # 30 m at 10 m/s; within SAME_PLACE of one another a bit less
    assert late[1, 0] == -late[0, 1]
    assert np.isnan(late[0, 0])
    hidden = motion.valid[0] & (np.arange(STEPS) < 3)
    assert np.isnan(conflict_orders(motion, hidden)).all()


def test_vehicles_that_follow_each_other_have_no_order_at_a_conflict() -> None:
    roads = crossing()
    motion = stack([drive(joined(roads, 0, 8, 4), start, 8, STEPS) for start in (5, 25)])[np.newaxis]
    assert np.isnan(conflict_orders(motion, motion.valid[0])).all()


def test_shuffling_keeps_every_vehicle_s_trajectories_and_breaks_their_company() -> None:
    samples = polite()
    mixed = shuffled(samples, np.random.default_rng(0))
    for n in range(2):
        for name in ("position", "heading", "velocity"):
            mine, theirs = (np.sort(getattr(s, name)[:, n].reshape(SAMPLES, -1), axis=0) for s in (samples, mixed))
            np.testing.assert_array_equal(mine, theirs)
    assert not np.array_equal(samples.position[:, 0] - samples.position[:, 1], mixed.position[:, 0] - mixed.position[:, 1])


def test_a_joint_method_beats_its_own_shuffle_in_collisions_and_post_encroachment_times() -> None:
    log = meeting(40, 10)
    scene = scenario(crossing(), log)
    samples = polite()
    together = summary([scene_joint(scene, samples, log, NO_ROAD)])
    apart = summary([scene_joint(scene, shuffled(samples, np.random.default_rng(s)), log, NO_ROAD) for s in range(8)])
    assert together["collision_per_vehicle"] == 0 < apart["collision_per_vehicle"]
    assert together["collision_per_scene"] == 0 < apart["collision_per_scene"]
    assert together["order_agreement"] == 0.5  # half of the samples let the other one through
    assert together["ordered_pairs"] == SAMPLES
    assert apart["ordered_pairs"] < 8 * SAMPLES  # some meet at once: no order
    assert together["post_encroachment_distance"] < apart["post_encroachment_distance"]


def test_of_logs_that_are_as_polite_as_the_samples_the_joint_energy_score_prefers_the_unshuffled() -> None:
    samples, both = polite(), (meeting(40, 10), meeting(10, 40))

    def energy(found: Trajectories) -> float:
        return float(np.mean([scene_joint(scenario(crossing(), log), found, log, NO_ROAD).energy for log in both]))

    assert energy(samples) < min(energy(shuffled(samples, np.random.default_rng(s))) for s in range(8))


def test_the_log_as_its_own_sample_is_perfect() -> None:
    log = meeting(40, 10)
    found = summary([scene_joint(scenario(crossing(), log), log[np.newaxis][np.zeros(3, int)], log, NO_ROAD)])
    assert found["order_agreement"] == 1
    assert found["energy_joint"] == found["energy_joint_final"] == found["post_encroachment_distance"] == 0
    assert found["close_call"] == found["log_close_call"]
