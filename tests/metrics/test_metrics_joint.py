"""Joint figures see what shuffling takes away: who goes first, and who would have been run over."""

import numpy as np
import pytest

from drivegen.core.scenario import Trajectories
from drivegen.metrics.features import scene_features
from drivegen.metrics.joint import SceneJoint, joint_figures, orders, scene_joint, shuffled
from tests.scenes import crossing, drive, joined, scenario, stack

STEPS, SAMPLES = 81, 12


def meeting(first: float, second: float, speeds: tuple[float, float] = (10, 10)) -> Trajectories:
    """Two cars that cross at right angles in the middle of a crossing, each from its own start [m] at its own speed [m/s]."""
    roads = crossing()
    ways = joined(roads, 0, 8, 4), joined(roads, 2, 15, 7)
    return stack([drive(way, start, v, STEPS) for way, start, v in zip(ways, (first, second), speeds, strict=True)])


def polite(count: int = SAMPLES) -> Trajectories:
    """Samples in which now the one, now the other car is let through: never both at once."""
    return stack([meeting(40, 10) if k % 2 else meeting(10, 40) for k in range(count)])


def measured(samples: Trajectories, log: Trajectories, seed: int = 0) -> SceneJoint:
    scene = scenario(crossing(), log)
    return scene_joint(scene, log, *scene_features(scene, samples, log, None), np.random.default_rng(seed))


def test_the_order_at_a_crossing_is_the_log_s_or_the_other_one() -> None:
    log = meeting(40, 10)
    assert orders(log[np.newaxis], log) == (1, 1)
    assert orders(stack([meeting(10, 40)]), log) == (0, 1)
    assert orders(polite(), log) == (SAMPLES // 2, SAMPLES)


def test_one_who_still_waits_when_the_other_comes_is_the_later_one() -> None:
    waits = meeting(40, 10, (10, 1))
    assert orders(stack([meeting(40, 10)]), waits) == (1, 1)
    assert orders(stack([meeting(40, 10, (7, 14))]), waits) == (0, 1)


def test_the_log_does_not_tell_the_order_where_nobody_comes_or_one_goes_elsewhere_or_is_lost() -> None:
    crossed = stack([meeting(40, 10)])
    assert orders(crossed, meeting(10, 10, (1, 1))) == (0, 0)
    roads = crossing()
    away = stack([drive(joined(roads, 0, 8, 4), 40, 10, STEPS), drive(joined(roads, 2, 14, 6), 40, 10, STEPS)])
    assert orders(crossed, away) == (0, 0)
    lost = meeting(40, 10, (10, 1))
    lost.valid[1, 2:] = False
    assert orders(crossed, lost) == (0, 0)


def test_vehicles_that_follow_each_other_have_no_order() -> None:
    roads = crossing()
    log = stack([drive(joined(roads, 0, 8, 4), start, 8, STEPS) for start in (5, 25)])
    assert orders(log[np.newaxis], log) == (0, 0)


def test_shuffling_keeps_every_vehicle_s_trajectories_and_breaks_their_company() -> None:
    samples = polite()
    mixed = shuffled(samples, np.random.default_rng(0))
    for n in range(2):
        for name in ("position", "heading", "velocity"):
            mine, theirs = (np.sort(getattr(s, name)[:, n].reshape(SAMPLES, -1), axis=0) for s in (samples, mixed))
            np.testing.assert_array_equal(mine, theirs)
    assert not np.array_equal(samples.position[:, 0] - samples.position[:, 1], mixed.position[:, 0] - mixed.position[:, 1])


def test_polite_samples_touch_only_when_shuffled() -> None:
    scene = measured(polite(), meeting(40, 10))
    assert scene.metrics["joint.collision"] == 0 < scene.metrics["shuffled.collision"]
    assert scene.orders[0].tolist() == [SAMPLES // 2, SAMPLES]
    assert scene.orders[1, 1] < SAMPLES  # some meet at once: no order


def test_of_logs_that_are_as_polite_as_the_samples_the_joint_energy_score_prefers_the_unshuffled() -> None:
    logs = meeting(40, 10), meeting(10, 40)
    gains = [measured(polite(), log, seed).metrics["joint.energy_gain"] for seed in range(8) for log in logs]
    assert np.mean(gains) > 0


def test_a_set_s_order_is_the_share_over_all_its_pairs_with_an_interval_over_scenes() -> None:
    log = meeting(40, 10)
    right, both = measured(stack([log] * 3), log), measured(polite(), log)
    found = joint_figures([right, both], ["a", "b"], 200, np.random.default_rng(0))["joint.order"]
    assert found.value == pytest.approx((3 + SAMPLES // 2) / (3 + SAMPLES))
    assert (found.low, found.high) == (0.5, 1.0)


def test_what_no_scene_has_is_not_a_number() -> None:
    log = meeting(10, 10, (1, 1))
    found = joint_figures([measured(log[np.newaxis][[0, 0]], log)], ["a"], 20, np.random.default_rng(0))
    assert np.isnan(found["joint.order"].value)
    assert np.isnan(found["shuffled.post_encroachment"].value)
