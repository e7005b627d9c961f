"""The classifier: it can't tell the log from itself, can tell noise, and its AUC is that of plain loops."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.seeds import rng
from drivegen.metrics.classifier import TRACK_FEATURES, TrackPairs, _auc, folds, telling_apart, track_pairs
from drivegen.metrics.features import scene_features
from drivegen.metrics.road_edge import RoadEdges
from drivegen.roads.drivable import CELL, road_field
from tests.scenes import busy_crossing, noisy_samples

SCENE = busy_crossing(81)
FIELD = road_field(SCENE.map)
EDGES = RoadEdges(FIELD.outside, FIELD.origin, CELL, FIELD.beyond_rim)


def pairs_of(motion) -> TrackPairs:
    return track_pairs(scene_features(SCENE, motion, SCENE.log, EDGES)[0], 0)


def told(scenes, seed=7):
    return telling_apart(scenes, [str(n) for n in range(len(scenes))], seed, 50, rng(seed, "test"))


def test_a_copy_of_the_log_cannot_be_told_apart():
    found = told([pairs_of(noisy_samples(SCENE, 1, seed=i).motion) for i in range(6)])
    assert found.value > 0.5
    same = told([pairs_of(SCENE.log[np.newaxis])] * 6)
    assert (same.value, same.low, same.high) == (0.5, 0.5, 0.5)


def test_tracks_of_one_source_stay_near_a_half():
    random = np.random.default_rng(0)
    scenes = [TrackPairs(random.normal(size=(12, 24)), random.normal(size=(12, 24))) for _ in range(30)]
    found = told(scenes)
    assert 0.4 < found.value < 0.6
    assert found.low < 0.5 < found.high


def test_jerky_tracks_are_told_from_scenes_never_seen():
    random = np.random.default_rng(0)

    def shaken():
        shake = random.normal(0, 0.05, SCENE.log.position.shape).astype(np.float32)
        return replace(SCENE.log, position=SCENE.log.position + shake)[np.newaxis]

    found = told([pairs_of(shaken()) for _ in range(6)])
    assert found.value > 0.95
    assert found.low <= found.value <= found.high


def test_folds_are_of_recordings_and_as_many_as_there_are_of_few():
    assert [len(fold) for fold in folds(np.arange(12))] == [3, 3, 2, 2, 2]
    assert [fold.tolist() for fold in folds(np.array([7, 2, 5]))] == [[7], [2], [5]]


def test_no_recording_is_learnt_from_and_asked_about():
    # Which side of its mark is the generated one differs by recording; only the recording's other scene gives it away.
    random = np.random.default_rng(0)

    def scene(mark):
        both = random.normal(0, 0.01, (2, 12, 24))
        both[:, :, 0] += 2 * mark
        both[mark % 2, :, 0] += 1
        return TrackPairs(*both)

    scenes = [scene(mark) for mark in random.permutation(20) for _ in range(2)]
    apart = telling_apart(scenes, [str(n // 2) for n in range(40)], 7, 50, rng(7, "test"))
    leaking = told(scenes)
    assert leaking.value > 0.9
    assert apart.value < 0.6


def test_one_recording_cannot_be_asked_about():
    scenes = [TrackPairs(np.zeros((3, 24)), np.ones((3, 24)))] * 4
    assert np.isnan(telling_apart(scenes, ["a"] * 4, 7, 50, rng(7, "test")).value)


def test_the_same_seed_gives_the_same_answer():
    scenes = [pairs_of(noisy_samples(SCENE, 1, seed=i).motion) for i in range(5)]
    assert told(scenes) == told(scenes)


def test_who_stands_still_in_both_is_left_out():
    found = pairs_of(SCENE.log[np.newaxis])
    ways = np.array([np.hypot(*np.diff(p, axis=0).T).sum() for p in SCENE.log.position])
    np.testing.assert_array_equal(found.logged, found.generated)
    travelled = found.logged[:, TRACK_FEATURES.index("travelled")]
    np.testing.assert_allclose(travelled, ways[ways > 2], rtol=1e-5)


def test_fewer_than_two_scenes_have_no_answer():
    assert np.isnan(told([pairs_of(SCENE.log[np.newaxis])]).value)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_the_auc_is_that_of_loops(seed):
    random = np.random.default_rng(seed)
    ranks, generated, weight = random.integers(0, 6, 30), random.random(30) < 0.5, random.integers(0, 3, 30).astype(float)
    won = total = 0.0
    for i in np.flatnonzero(generated):
        for j in np.flatnonzero(~generated):
            won += weight[i] * weight[j] * ((ranks[i] > ranks[j]) + 0.5 * (ranks[i] == ranks[j]))
            total += weight[i] * weight[j]
    assert _auc(ranks, generated, weight) == (pytest.approx(won / total) if total else pytest.approx(np.nan, nan_ok=True))
