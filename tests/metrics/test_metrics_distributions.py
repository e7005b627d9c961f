"""Distances of distributions: against scipy and plain loops, zero for the log, and intervals over scenes."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import wasserstein_distance

from drivegen.core.scenario import Trajectories
from drivegen.core.seeds import rng
from drivegen.metrics.distributions import (
    BINS,
    MANOEUVRES,
    RANGES,
    SceneCounts,
    distances,
    jensen_shannon,
    scene_counts,
    wasserstein,
)
from drivegen.metrics.encroachment import post_encroachment
from drivegen.metrics.features import scene_features
from tests.scenes import busy_crossing, noisy_samples

SCENE = busy_crossing(81)
SEEDS = st.integers(0, 2**32 - 1)


def counted(samples, scene=SCENE) -> SceneCounts:
    return scene_counts(scene_features(scene, samples, scene.log, None)[0])


@given(SEEDS)
@settings(max_examples=20, deadline=None)
def test_wasserstein_is_scipy_s_to_the_width_of_a_bin(seed):
    random = np.random.default_rng(seed)
    one, other = random.normal(4, 1.5, 300), random.normal(random.uniform(2, 7), 2, 500)
    counts = np.stack([np.histogram(np.clip(v, 0, 12), BINS, (0, 12))[0] for v in (one, other)]).astype(float)
    wanted = wasserstein_distance(np.clip(one, 0, 12), np.clip(other, 0, 12))
    assert wasserstein(counts, 0.0, 12.0) == pytest.approx(wanted, abs=12 / BINS)


def test_wasserstein_by_hand_and_nothing_to_compare():
    counts = np.zeros((2, BINS))
    counts[0, 10], counts[1, 30] = 5, 2
    assert wasserstein(counts, 0.0, float(BINS)) == pytest.approx(20)
    counts[1] = 0
    assert np.isnan(wasserstein(counts, 0.0, float(BINS)))


def test_jensen_shannon_by_hand():
    assert jensen_shannon(np.array([[3.0, 0], [0, 9.0]])) == pytest.approx(1)
    assert jensen_shannon(np.array([[1.0, 3], [2, 6]])) == pytest.approx(0, abs=1e-12)
    p, q = np.array([0.5, 0.5]), np.array([0.9, 0.1])
    m = (p + q) / 2
    wanted = (p @ np.log2(p / m) + q @ np.log2(q / m)) / 2
    assert jensen_shannon(np.array([4 * p, 7 * q])) == pytest.approx(wanted)


def test_the_log_has_no_distance_from_itself():
    scenes = [counted(SCENE.log[np.newaxis][np.zeros(3, np.intp)])] * 4
    for name, interval in distances(scenes, list("abcd"), 20, rng(0, "test")).items():
        assert interval.value == pytest.approx(0, abs=1e-9), name
        assert interval.high == pytest.approx(0, abs=1e-9)


def test_samples_weigh_as_much_as_their_log_however_many_they_are():
    two, four = counted(noisy_samples(SCENE, 2).motion), counted(noisy_samples(SCENE, 4).motion)
    vehicles = len(SCENE.vehicles)
    for counts in (two, four):
        np.testing.assert_allclose(counts.manoeuvres.sum(axis=1), vehicles)
        np.testing.assert_allclose(counts.numbers[0].sum(axis=1), vehicles * (SCENE.steps - 2))


def test_faster_traffic_is_as_far_in_speed_as_it_is_faster():
    log = SCENE.log
    fast = replace(log, position=log.position[:, :1] + 1.5 * (log.position - log.position[:, :1]))
    scenes = [counted(fast[np.newaxis])]
    found = distances(scenes, ["a"], 10, rng(0, "test"))
    speeds = log.speed[:, 1:-1]
    assert found["speed"].value == pytest.approx(0.5 * speeds.mean(), abs=0.25)
    assert found["manoeuvres"].value < 0.2


def headways_by_loops(scene) -> list[float]:
    """Time to the nearest car ahead of those of the log that follow one straight ahead in their lane."""
    features, _ = scene_features(scene, scene.log[np.newaxis], scene.log, None)
    found = []
    for n in range(len(scene.vehicles)):
        for t in range(1, scene.steps - 1):
            speed = np.hypot(*(scene.log.position[n, t + 1] - scene.log.position[n, t - 1])) / 0.2
            gap = features.around.gap[1, n, t]
            if speed > 1 and np.isfinite(gap) and gap / speed < 10:
                found.append(gap / speed)
    return found


def test_headways_are_those_of_loops():
    counts = counted(SCENE.log[np.newaxis]).numbers[list(RANGES).index("headway")]
    slow = headways_by_loops(SCENE)
    assert len(slow) > 50
    assert counts[0].sum() == pytest.approx(len(slow), abs=2)
    wanted = np.histogram(slow, BINS, RANGES["headway"])[0]
    assert np.abs(np.cumsum(counts[0]) - np.cumsum(wanted)).max() <= 3


def test_manoeuvres_are_counted_by_name():
    found = counted(SCENE.log[np.newaxis]).manoeuvres
    by_name = dict(zip(MANOEUVRES, found[0], strict=True))
    assert by_name["stop"] >= 1
    assert by_name["straight"] >= 3
    np.testing.assert_array_equal(found[0], found[1])


def test_intervals_hold_their_values():
    scenes = [counted(noisy_samples(SCENE, 3, seed=i).motion) for i in range(5)]
    found = distances(scenes, list("abcde"), 50, rng(0, "test"))
    there = [interval for interval in found.values() if not np.isnan(interval.value)]
    assert len(there) > len(found) / 2
    for interval in there:
        assert interval.low <= interval.value <= interval.high


def test_encounters_are_pairs_of_the_log_and_on_average_of_a_sample():
    log = SCENE.log
    features = scene_features(SCENE, log[np.newaxis], log, None)[0]
    pairs = len(post_encroachment(log[np.newaxis], features.known[1])[0])
    apart = replace(log, position=log.position + 1000 * np.arange(len(log.valid), dtype=np.float32)[:, None, None])
    names = ("position", "heading", "velocity", "valid")
    samples = Trajectories(*(np.stack([getattr(one, name) for one in (log, apart)]) for name in names))
    assert pairs > 0
    np.testing.assert_allclose(counted(samples).encounters, [pairs, pairs / 2])


def test_distances_are_drawn_by_recording():
    still, fast = counted(SCENE.log[np.newaxis]), counted(noisy_samples(SCENE, 1, seed=3).motion)
    pair, both = (distances([still, fast] * n, ["a", "b"] * n, 300, rng(0, "test"))["jerk"] for n in (1, 8))
    assert (both.low, both.high) == pytest.approx((pair.low, pair.high))
