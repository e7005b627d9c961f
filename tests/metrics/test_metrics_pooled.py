"""Pooling over scenes and seeds, by hand cases and against plain loops."""

import numpy as np
import pytest

from drivegen.core.intervals import Interval
from drivegen.metrics.pooled import Resampling, envelope, pooled_mean, rank_correlation


def resampling(seeds: int, groups: list[str], draws: int = 400) -> Resampling:
    return Resampling.of([(seed, 0) for seed in range(seeds)], groups, draws, np.random.default_rng(5))


def test_the_mean_is_over_all_cells_that_are_known():
    values = np.array([[1.0, 2.0, np.nan], [3.0, 4.0, 5.0]])
    assert pooled_mean(values, resampling(2, ["a", "b", "c"])).value == pytest.approx(3.0)


def test_nothing_known_is_nan():
    assert np.isnan(pooled_mean(np.full((2, 2), np.nan), resampling(2, ["a", "b"])).value)


def test_scenes_of_one_recording_count_as_one_when_intervals_are_drawn():
    rng = np.random.default_rng(0)
    values = np.repeat(rng.normal(size=10), 20)[None]  # ten recordings of twenty scenes that are all alike
    alone = pooled_mean(values, resampling(1, [str(i) for i in range(200)]))
    together = pooled_mean(values, resampling(1, [str(i // 20) for i in range(200)]))
    assert together.high - together.low > 3 * (alone.high - alone.low)


def test_what_differs_between_seeds_widens_the_interval():
    same, different = np.zeros((3, 50)), np.repeat(np.array([[-1.0], [0.0], [1.0]]), 50, axis=1)
    groups = [str(i) for i in range(50)]
    assert pooled_mean(same, resampling(3, groups)).high == 0
    assert pooled_mean(different, resampling(3, groups)).high > 0.5


def test_what_differs_between_sampling_seeds_widens_the_interval_too_and_pairs_are_crossed():
    runs = [(trained, drawn) for trained in (7, 8, 9) for drawn in (7, 17, 27)]
    by_sampling = np.repeat([[drawn / 10] for _, drawn in runs], 50, axis=1)
    found = Resampling.of(runs, [str(i) for i in range(50)], 400, np.random.default_rng(5))
    interval = pooled_mean(by_sampling, found)
    assert (interval.value, interval.low, interval.high) == pytest.approx((1.7, 0.7, 2.7), abs=0.4)
    grid = found.runs.reshape(-1, 3, 3)
    np.testing.assert_allclose(grid * grid.sum((1, 2), keepdims=True), grid.sum(2, keepdims=True) * grid.sum(1, keepdims=True))


def test_draws_agree_with_resampling_by_plain_loops():
    rng = np.random.default_rng(3)
    values, groups = rng.normal(size=(2, 6)), ["a", "a", "b", "c", "c", "c"]
    values[0, 1] = np.nan
    drawn = resampling(2, groups, draws=50)
    means = []
    for d in range(50):
        cells = [values[s, n] for s in range(2) for n in range(6) for _ in range(int(drawn.runs[d, s] * drawn.scenes[d, n]))]
        known = [cell for cell in cells if np.isfinite(cell)]
        means += [np.mean(known)] if known else []
    found = pooled_mean(values, drawn)
    assert (found.low, found.high) == pytest.approx(tuple(np.quantile(means, [0.025, 0.975])))


def test_one_recording_has_a_mean_and_no_interval():
    found = pooled_mean(np.array([[1.0, 2.0], [3.0, 6.0]]), resampling(2, ["a", "a"]))
    assert found.value == 3.0
    assert np.isnan([found.low, found.high]).all()


def test_a_measure_of_one_recording_among_several_has_no_interval():
    """Seeds alone would give one, and tables would call it an interval over recordings."""
    values = np.array([[1.0, 2.0, np.nan, np.nan], [3.0, 6.0, np.nan, np.nan]])
    found = pooled_mean(values, resampling(2, ["a", "a", "b", "c"]))
    assert found.value == 3.0
    assert np.isnan([found.low, found.high]).all()


def test_an_envelope_holds_every_seed():
    found = envelope([Interval(1.0, 0.5, 1.2), Interval(3.0, 2.0, 4.0), Interval(np.nan, np.nan, np.nan)])
    assert (found.value, found.low, found.high) == (2.0, 0.5, 4.0)


@pytest.mark.parametrize("place", [0, 1, 2])
def test_an_envelope_has_no_ends_where_one_seed_has_none(place: int):
    seeds = [Interval(1.0, 0.5, 1.2), Interval(3.0, 2.0, 4.0)]
    seeds.insert(place, Interval(5.0, np.nan, np.nan))
    found = envelope(seeds)
    assert found.value == 3.0
    assert np.isnan([found.low, found.high]).all()


@pytest.mark.parametrize(
    ("one", "other", "rho"), [([1, 2, 3], [10, 20, 30], 1.0), ([1, 2, 3], [3, 2, 1], -1.0), ([1, 2], [1, 2], np.nan)]
)
def test_rank_correlation_of_hand_cases(one, other, rho):
    assert rank_correlation(np.array(one, float), np.array(other, float)) == pytest.approx(rho, nan_ok=True)


def test_rank_correlation_shares_ranks_among_ties():
    # ranks (1.5, 1.5, 3, 4) and (1, 2, 3, 4): rho = 0.9487
    assert rank_correlation(np.array([5.0, 5, 6, 7]), np.array([1.0, 2, 3, 4])) == pytest.approx(0.9487, abs=1e-4)
