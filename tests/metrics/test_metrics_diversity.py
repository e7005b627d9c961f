"""Diversity: against the paper's sums in four loops, and what must not change it."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.geometry import rotate
from drivegen.core.scenario import Trajectories
from drivegen.metrics.diversity import own_frames, plain_differences, random_pairs, ratio, squared_differences

SEEDS = st.integers(0, 2**32 - 1)


def scene(random, vehicles=3, steps=5) -> Trajectories:
    valid = random.random((vehicles, steps)) < 0.8
    valid[:, 0] = True
    heading = random.uniform(-3, 3, (vehicles, steps)).astype(np.float32)
    position = random.normal(0, 10, (vehicles, steps, 2)).astype(np.float32)
    return Trajectories(position, heading, np.zeros_like(position), valid)


def by_the_paper(one: Trajectories, other: Trajectories, power: int) -> float:
    """D(S1, S2) as it is printed, with four nested loops."""
    total = 0.0
    for i in range(len(one.valid)):
        for j in range(len(other.valid)):
            for t in range(min(one.steps, other.steps)):
                if one.valid[i, t] and other.valid[j, t]:
                    total += np.linalg.norm(own(one, i, t) - own(other, j, t)) ** power
    return total


def own(motion, i, t):
    """Position at step t as vehicle i sees it from its first pose."""
    offset = (motion.position[i, t] - motion.position[i, 0]).astype(np.float64)
    cos, sin = np.cos(float(motion.heading[i, 0])), np.sin(float(motion.heading[i, 0]))
    return np.array([cos * offset[0] + sin * offset[1], -sin * offset[0] + cos * offset[1]])


@given(SEEDS)
@settings(max_examples=15, deadline=None)
def test_both_norms_equal_the_paper_s_sums(seed):
    random = np.random.default_rng(seed)
    scenes = [scene(random, int(random.integers(1, 4)), int(random.integers(2, 6))) for _ in range(3)]
    pairs = np.array([[0, 1], [1, 2], [2, 0]])
    frames = own_frames(scenes)
    for differences, power in ((squared_differences, 2), (plain_differences, 1)):
        wanted = [by_the_paper(scenes[a], scenes[b], power) for a, b in pairs]
        np.testing.assert_allclose(differences(frames, pairs), wanted, rtol=2e-5, atol=1e-3)


@given(SEEDS, st.floats(-3, 3))
@settings(max_examples=15, deadline=None)
def test_where_and_how_a_scene_lies_does_not_matter(seed, angle):
    random = np.random.default_rng(seed)
    scenes = [scene(random) for _ in range(2)]
    first = scenes[0]
    turned = rotate(first.position.astype(np.float64), np.float64(angle)) + 30
    moved = Trajectories(turned.astype(np.float32), first.heading + np.float32(angle), first.velocity, first.valid)
    pairs = np.array([[0, 1]])
    for differences in (squared_differences, plain_differences):
        before, after = (differences(own_frames([one, scenes[1]]), pairs) for one in (first, moved))
        np.testing.assert_allclose(after, before, rtol=1e-3)


def test_scenes_of_one_standing_vehicle_differ_by_nothing():
    still = Trajectories(
        np.full((1, 4, 2), 7, np.float32), np.ones((1, 4), np.float32), np.zeros((1, 4, 2)), np.ones((1, 4), bool)
    )
    frames = own_frames([still, still])
    assert squared_differences(frames, np.array([[0, 1]])).tolist() == [0.0]
    assert plain_differences(frames, np.array([[0, 1]])).tolist() == [0.0]


def test_every_split_pairs_every_scene_once():
    pairs = random_pairs(7, 5, np.random.default_rng(0)).reshape(5, 3, 2)
    for split in pairs:
        assert len(np.unique(split)) == 6
    assert not np.array_equal(pairs[0], pairs[1])


def test_one_scene_has_no_pairs_and_no_ratio():
    pairs = random_pairs(1, 5, np.random.default_rng(0))
    assert pairs.shape == (0, 2)
    assert np.isnan(ratio(np.zeros(0), np.zeros(0), pairs, ["a"], 10, np.random.default_rng(0)).value)


def test_the_real_set_against_itself_is_one_and_the_interval_holds_the_ratio():
    random = np.random.default_rng(1)
    pairs = random_pairs(30, 10, random)
    real = random.uniform(5, 10, len(pairs))
    names = [f"scene {n}" for n in range(30)]
    same = ratio(real, real, pairs, names, 200, random)
    assert same.value == 1.0
    np.testing.assert_allclose([same.low, same.high], 1.0)
    half = ratio(real * random.uniform(0.4, 0.6, len(pairs)), real, pairs, names, 200, random)
    assert half.low < half.value < half.high < 0.6


def test_pairs_of_scenes_are_drawn_by_recording():
    pairs = np.array([[0, 1], [2, 3]])
    found = ratio(np.array([1.0, 3.0]), np.ones(2), pairs, ["a", "a", "b", "b"], 200, np.random.default_rng(0))
    assert (found.value, found.low, found.high) == (2.0, 1.0, 3.0)  # a alone, b alone
