"""Displacement errors: by hand, against av2's formulas, against plain loops, and what must not change them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import rotate
from drivegen.core.scenario import Trajectories
from drivegen.metrics.displacement import FIRST_SCORED, scene_errors, standing_at_exit, summarise
from drivegen.metrics.proper import energy_scores

SEEDS = st.integers(0, 2**32 - 1)


def motion(position, valid=None) -> Trajectories:
    position = np.asarray(position, np.float32)
    shape = position.shape[:-1]
    valid = np.ones(shape, np.bool_) if valid is None else np.asarray(valid, np.bool_)
    return Trajectories(position, np.zeros(shape, np.float32), np.zeros_like(position), valid)


def drawn(seed, worlds=4, vehicles=3, steps=7, gaps=True):
    """Samples and log with random gaps in the log; step 1 is always observed so that everybody is scored."""
    random = np.random.default_rng(seed)
    valid = random.random((vehicles, steps)) < (0.7 if gaps else 2)
    valid[:, :2] = True
    return (
        motion(random.normal(0, 20, (worlds, vehicles, steps, 2))),
        motion(random.normal(0, 20, (vehicles, steps, 2)), valid),
    )


def av2_compute_world_ade(forecasted, gt):
    """av2.datasets.motion_forecasting.eval.metrics.compute_world_ade: (M, K, N, 2) x (M, N, 2) -> (K,)."""
    actors = zip(forecasted, gt, strict=True)
    return np.stack([[np.linalg.norm(world - truth, axis=1).mean() for world in worlds] for worlds, truth in actors]).mean(axis=0)


def av2_compute_world_fde(forecasted, gt):
    """av2.datasets.motion_forecasting.eval.metrics.compute_world_fde."""
    actors = zip(forecasted, gt, strict=True)
    return np.stack([np.linalg.norm(worlds[:, -1] - truth[-1], axis=1) for worlds, truth in actors]).mean(axis=0)


def by_loops(samples, log):
    """The definition, step by step in plain Python."""
    sade, sfde = [], []
    for world in range(len(samples.valid)):
        ades, fdes = [], []
        for i in range(len(log.valid)):
            distances = [
                float(np.hypot(*(samples.position[world, i, t].astype(float) - log.position[i, t])))
                for t in range(FIRST_SCORED, log.steps)
                if log.valid[i, t]
            ]
            if distances:
                ades.append(sum(distances) / len(distances))
                fdes.append(distances[-1])
        sade.append(sum(ades) / len(ades))
        sfde.append(sum(fdes) / len(fdes))
    return np.array(sade), np.array(sfde)


def test_two_vehicles_over_three_steps_by_hand():
    log = motion([[[0, 0], [1, 0], [2, 0]], [[0, 0], [0, 1], [0, 2]]])
    sample = motion([[[[0, 0], [1, 3], [2, 4]], [[0, 0], [5, 1], [0, 2]]]])
    sade, sfde = scene_errors(sample, log)
    assert sade.tolist() == [((3 + 4) / 2 + (5 + 0) / 2) / 2]
    assert sfde.tolist() == [(4 + 0) / 2]


def test_a_track_that_ends_early_is_scored_to_its_last_observed_step():
    log = motion([[[0, 0], [1, 0], [99, 99]], [[0, 0], [0, 1], [0, 2]]], [[1, 1, 0], [1, 1, 1]])
    sample = motion([[[[0, 0], [1, 2], [0, 0]], [[0, 0], [0, 1], [0, 3]]]])
    sade, sfde = scene_errors(sample, log)
    assert sade.tolist() == [(2 + (0 + 1) / 2) / 2]
    assert sfde.tolist() == [(2 + 1) / 2]


def test_a_vehicle_seen_in_the_first_frame_only_is_not_scored():
    log = motion([[[0, 0], [1, 0]], [[9, 9], [0, 0]]], [[1, 1], [1, 0]])
    sade, sfde = scene_errors(motion([[[[0, 0], [1, 1]], [[9, 9], [7, 7]]]]), log)
    assert sade.tolist() == sfde.tolist() == [1.0]


@given(SEEDS)
@settings(max_examples=25, deadline=None)
def test_full_tracks_give_what_av2_gives(seed):
    samples, log = drawn(seed, gaps=False)
    future = np.moveaxis(samples.position[:, :, FIRST_SCORED:], 0, 1).astype(np.float64)
    truth = log.position[:, FIRST_SCORED:].astype(np.float64)
    sade, sfde = scene_errors(samples, log)
    np.testing.assert_allclose(sade, av2_compute_world_ade(future, truth), rtol=1e-6)
    np.testing.assert_allclose(sfde, av2_compute_world_fde(future, truth), rtol=1e-6)


@given(SEEDS)
@settings(max_examples=25, deadline=None)
def test_arrays_and_loops_agree_with_gaps(seed):
    samples, log = drawn(seed)
    for fast, slow in zip(scene_errors(samples, log), by_loops(samples, log), strict=True):
        np.testing.assert_allclose(fast, slow, rtol=1e-6)


@given(SEEDS)
@settings(max_examples=25, deadline=None)
def test_the_order_of_vehicles_and_worlds_does_not_matter(seed):
    samples, log = drawn(seed)
    random = np.random.default_rng(seed)
    actors, worlds = random.permutation(len(log.valid)), random.permutation(len(samples.valid))
    sade, sfde = scene_errors(samples, log)
    again, final = scene_errors(samples[worlds][:, actors], log[actors])
    np.testing.assert_allclose(again, sade[worlds], rtol=1e-9)
    np.testing.assert_allclose(final, sfde[worlds], rtol=1e-9)


@given(SEEDS, st.floats(-np.pi, np.pi), st.floats(0.1, 10))
@settings(max_examples=25, deadline=None)
def test_rigid_motion_changes_nothing_and_scaling_scales(seed, angle, scale):
    samples, log = drawn(seed)
    sade, sfde = scene_errors(samples, log)

    def moved(trajectories):
        return motion(rotate(trajectories.position.astype(np.float64), np.float64(angle)) * scale + 5.0, trajectories.valid)

    again, final = scene_errors(moved(samples), moved(log))
    np.testing.assert_allclose(again, scale * sade, rtol=1e-4)
    np.testing.assert_allclose(final, scale * sfde, rtol=1e-4)


def test_garbage_at_steps_that_the_log_did_not_see_changes_nothing():
    samples, log = drawn(3)
    spoilt = samples.position.copy()
    spoilt[:, ~log.valid] = np.nan
    log.position[~log.valid] = np.inf
    np.testing.assert_array_equal(scene_errors(motion(spoilt), log), scene_errors(samples, log))


def test_the_minimum_of_each_error_is_taken_on_its_own():
    summary = summarise(np.array([1.0, 3.0]), np.array([8.0, 4.0]))
    assert (summary.min_sade, summary.min_sfde, summary.mean_sade, summary.mean_sfde) == (1.0, 4.0, 2.0, 6.0)


def test_a_sample_that_leaves_a_vehicle_out_is_refused():
    samples, log = drawn(1)
    samples.valid[2, 0, 1] = False
    with pytest.raises(UnusableInput, match="leaves out"):
        scene_errors(samples, log)


def test_a_log_without_a_second_step_is_refused():
    samples, log = drawn(1)
    log.valid[:, 1:] = False
    with pytest.raises(UnusableInput) as refusal:
        scene_errors(samples, log)
    assert refusal.value.reason == "nothing-to-score"


def test_other_vehicles_than_the_log_are_refused():
    samples, log = drawn(1)
    with pytest.raises(UnusableInput, match="differ in shape"):
        scene_errors(samples[:, :2], log)


@given(SEEDS)
@settings(max_examples=20, deadline=None)
def test_who_leaves_before_the_log_stands_at_its_exit_in_the_errors(seed):
    samples, log = drawn(seed, gaps=False)
    samples.valid[1, 2, 4:] = False
    standing = motion(samples.position.copy())
    standing.position[1, 2, 4:] = samples.position[1, 2, 3]
    for found, wanted in zip(scene_errors(samples, log), scene_errors(standing, log), strict=True):
        np.testing.assert_array_equal(found, wanted)
    found = energy_scores(standing_at_exit(samples, log), log)
    assert found == energy_scores(standing, log)


def test_where_the_log_has_left_nothing_is_scored():
    samples, log = drawn(0, gaps=False)
    log.valid[2, 4:] = False
    before = scene_errors(samples, log)
    samples.valid[:, 2, 5:] = False
    samples.position[:, 2, 5:] = 1e6
    for found, wanted in zip(scene_errors(samples, log), before, strict=True):
        np.testing.assert_array_equal(found, wanted)


@pytest.mark.parametrize("missing", [slice(None), slice(2, 4), slice(0, 2)])
def test_a_vehicle_that_is_left_out_or_comes_and_goes_is_refused(missing):
    samples, log = drawn(0, gaps=False)
    samples.valid[0, 1, missing] = False
    with pytest.raises(UnusableInput, match="leaves out"):
        scene_errors(samples, log)
