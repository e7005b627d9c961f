"""The WOSAC-style score: against Waymo's estimator in plain numpy, its anchors, its weights, and what must not change it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.scenario import Trajectories
from drivegen.generators.constant_velocity import constant_velocity
from drivegen.metrics.features import scene_features
from drivegen.metrics.realism import HISTOGRAMS, INDICATORS, WEIGHTS, _log_likelihood, bernoulli_likelihood, realism
from drivegen.metrics.road_edge import RoadEdges
from drivegen.roads.drivable import CELL, road_field
from tests.scenes import busy_crossing, noisy_samples

SEEDS = st.integers(0, 2**32 - 1)
SCENE = busy_crossing(81)


def edges_of(scene) -> RoadEdges:
    field = road_field(scene.map)
    return RoadEdges(field.outside, field.origin, CELL, field.beyond_rim)


EDGES = edges_of(SCENE)


def score(samples, log=None, scene=SCENE):
    log = scene.log if log is None else log
    return realism(scene_features(scene, samples, log, EDGES)[0])


def histogram_estimate(log_values, sim_values, low, high, bins, pseudocount):
    """waymo_open_dataset's estimators.histogram_estimate for one object: log likelihood of each logged value."""
    edges = np.linspace(low, high, bins + 1)
    counts = np.histogram(np.clip(sim_values, low, high), edges)[0] + pseudocount
    number = np.clip(np.digitize(np.clip(log_values, low, high), edges) - 1, 0, bins - 1)
    return np.log(counts / counts.sum())[number]


@given(SEEDS)
@settings(max_examples=20, deadline=None)
def test_likelihoods_are_those_of_waymo_s_estimator(seed):
    random = np.random.default_rng(seed)
    values = random.normal(3, 6, (5, 3, 11)).astype(np.float32)  # four samples and the log
    logged = random.random((3, 11)) < 0.8
    known = logged & (np.arange(11) < random.integers(1, 20, (5, 3, 1)))  # some leave the map early
    known[-1] = logged
    slow = sum(
        histogram_estimate(values[-1, n][logged[n]], values[:-1, n][known[:-1, n]], -2.0, 10.0, 12, 0.1).sum() for n in range(3)
    )
    assert _log_likelihood(values, known, -2.0, 10.0, 12, 0.1) == pytest.approx(slow, rel=1e-5)


def test_an_indicator_by_hand():
    happens = np.array([[True, False], [False, False], [True, False]])  # two samples, the log
    wanted = np.sqrt((1.001 / 2.002) * (2.001 / 2.002))
    assert bernoulli_likelihood(happens) == pytest.approx(wanted)


def test_weights_are_the_challenge_s_without_lights():
    assert sum(WEIGHTS.values()) == pytest.approx(1.0)
    assert set(WEIGHTS) == set(HISTOGRAMS) | set(INDICATORS)
    assert WEIGHTS["collision"] == pytest.approx(0.25 / 0.95)
    assert WEIGHTS["time_to_collision"] == pytest.approx(0.1 / 0.95)


def repeated(motion: Trajectories, times=4) -> Trajectories:
    return motion[np.newaxis][np.zeros(times, np.intp)]


def random_walk(scene, times=4) -> Trajectories:
    random = np.random.default_rng(0)
    step = random.normal(0, 1, (times, len(scene.vehicles), scene.steps, 2)).cumsum(axis=2)
    log = repeated(scene.log, times)
    return replace(log, position=(scene.vehicles.position[:, None] + step).astype(np.float32))


def test_the_anchors_stand_in_their_order_and_the_log_below_one():
    log = score(repeated(SCENE.log))
    noisy = score(noisy_samples(SCENE, 4).motion)
    straight = score(repeated(constant_velocity(SCENE)))
    walk = score(random_walk(SCENE))
    assert 1 > log["score"] > noisy["score"] > straight["score"] > walk["score"] > 0
    assert log["collision"] == pytest.approx(1, abs=0.01)
    assert all(0 <= value <= 1 for name, value in walk.items())


def test_the_score_is_the_weighted_sum():
    found = score(noisy_samples(SCENE, 4).motion)
    assert found["score"] == pytest.approx(sum(WEIGHTS[name] * found[name] for name in WEIGHTS))


def test_many_copies_say_what_few_do_but_for_the_pseudocounts():
    few, many = score(repeated(SCENE.log, 10)), score(repeated(SCENE.log, 32))
    assert few["score"] == pytest.approx(many["score"], abs=0.005)


@given(SEEDS)
@settings(max_examples=8, deadline=None)
def test_order_of_vehicles_and_samples_does_not_matter(seed):
    random = np.random.default_rng(seed)
    samples = noisy_samples(SCENE, 3).motion
    actors, worlds = random.permutation(len(SCENE.vehicles)), random.permutation(3)
    scene = replace(SCENE, vehicles=SCENE.vehicles[actors], log=SCENE.log[actors])
    again = score(samples[worlds][:, actors], scene=scene)
    assert again["score"] == pytest.approx(score(samples)["score"], abs=1e-6)


def test_garbage_at_steps_that_the_log_did_not_see_changes_nothing():
    samples, log = noisy_samples(SCENE, 3).motion, replace(SCENE.log, valid=SCENE.log.valid.copy())
    log.valid[2, 20:50] = False
    log.valid[5, 1:] = False
    spoilt = replace(samples, position=np.where(log.valid[..., None], samples.position, np.float32(1e6)))
    assert score(spoilt, log) == score(samples, log)


def test_a_log_too_short_for_accelerations_has_no_score():
    log = replace(SCENE.log, valid=SCENE.log.valid.copy())
    log.valid[:, 3:] = False
    found = score(repeated(SCENE.log), log)
    assert np.isnan(found["linear_acceleration"])
    assert np.isnan(found["score"])
    assert found["linear_speed"] > 0
