"""Bootstrap intervals: coverage, and equality with resampling row by row."""

import numpy as np
import pytest

from drivegen.core.intervals import ROWS, Draws, Interval, bootstrap_means, recording, resamplings, stacked, usual_length


def bootstrap_mean(values: np.ndarray, draws: int, random: np.random.Generator) -> Interval:
    [interval] = bootstrap_means(values[:, None], [str(n) for n in range(len(values))], draws, random)
    return interval


def test_the_interval_holds_the_true_mean_about_as_often_as_it_says():
    random = np.random.default_rng(0)
    held = 0
    for _ in range(200):
        interval = bootstrap_mean(random.normal(3.0, 1.0, 60), 300, random)
        held += interval.low <= 3.0 <= interval.high
    assert 178 <= held <= 198


def test_intervals_of_ten_recordings_hold_the_mean_in_about_nine_cases_of_ten():
    random = np.random.default_rng(0)
    found = [bootstrap_mean(random.normal(size=10), 300, random) for _ in range(300)]
    assert 0.86 <= np.mean([one.low <= 0 <= one.high for one in found]) <= 0.93


def test_multinomial_counts_equal_resampling_row_by_row():
    values = np.random.default_rng(1).gamma(2.0, size=80)
    fast = bootstrap_mean(values, 4000, np.random.default_rng(2))
    random = np.random.default_rng(3)
    slow = np.quantile([random.choice(values, 80).mean() for _ in range(4000)], [0.025, 0.975])
    np.testing.assert_allclose([fast.low, fast.high], slow, rtol=0.03)
    assert fast.value == values.mean()


def test_rows_without_a_value_do_not_count():
    table = np.array([[1.0, np.nan], [3.0, 5.0], [2.0, np.nan]])
    both = bootstrap_means(table, ["a", "b", "c"], 500, np.random.default_rng(0))
    assert [interval.value for interval in both] == [2.0, 5.0]
    assert np.isnan([both[1].low, both[1].high]).all()  # one recording has it


def test_rows_of_one_recording_come_and_go_together():
    times = resamplings(["b", "a", "b", "c"], 200, np.random.default_rng(0))
    assert times.shape == (200, 4)
    np.testing.assert_array_equal(times[:, 0], times[:, 2])
    np.testing.assert_array_equal(times[:, [0, 1, 3]].sum(axis=1), 3)


def test_sums_of_parts_are_those_of_all_rows_resampled_at_once():
    values = np.random.default_rng(0).normal(size=(2 * ROWS + 5, 3, 2))
    of = [str(n // 7) for n in range(len(values))]
    parts = list(stacked(iter(values)))
    assert [len(part) for part in parts] == [ROWS, ROWS, 5]
    sums = Draws.of(of, 20, np.random.default_rng(1)).sums(parts)
    assert sums == pytest.approx(np.tensordot(resamplings(of, 20, np.random.default_rng(1)), values, 1), rel=1e-9, abs=1e-6)
    few = values[:90]
    one, other = (Draws.of(of[:90], 20, np.random.default_rng(1)).sums(parts) for parts in (stacked(few), [few]))
    assert one.tobytes() == other.tobytes()


def test_twenty_alike_scenes_of_a_recording_say_no_more_than_one():
    values = np.random.default_rng(0).normal(size=10).repeat(20)[:, None]
    of = [str(n // 20) for n in range(200)]
    [together] = bootstrap_means(values, of, 2000, np.random.default_rng(1))
    [once] = bootstrap_means(values[::20], of[::20], 2000, np.random.default_rng(1))
    assert (together.low, together.high) == pytest.approx((once.low, once.high))


def test_recordings_that_show_the_same_cars_are_one() -> None:
    same = ("USA_US101-6_1_T-1-000", "USA_US101-28_1_T-1-003", "USA_US101-9_1_T-1-001")
    assert len({recording(name) for name in same}) == 1
    assert recording("USA_US101-3_1_T-1-000") == "USA_US101-3_1_T-1"
    for made in ("-s00", "-s117", "-new"):
        assert recording(f"USA_US101-3_1_T-1-000{made}") == "USA_US101-3_1_T-1"
        assert recording(f"ring-0-3-00120-car7{made}") == recording("ring-0-3-00120-car7") == "ring-0-3"


def test_one_recording_says_nothing_about_others():
    [found] = bootstrap_means(np.array([[1.0], [3.0]]), ["a", "a"], 100, np.random.default_rng(0))
    assert found.value == 2.0
    assert np.isnan([found.low, found.high]).all()


def test_the_usual_length_is_what_most_scenes_have_and_of_several_the_largest():
    assert usual_length(np.array([101.0, 101, 50, 101])) == 101
    assert usual_length(np.array([50, 110, 50, 110, 80])) == 110


def test_nothing_to_average_is_not_a_number():
    empty = bootstrap_mean(np.zeros(0), 10, np.random.default_rng(0))
    unknown = bootstrap_mean(np.full(3, np.nan), 10, np.random.default_rng(0))
    assert np.isnan([empty.value, empty.low, unknown.value, unknown.high]).all()


@pytest.mark.parametrize(
    ("scenario_id", "found"),
    [
        ("USA_Lanker-2_10_T-1-003", "USA_Lanker-2_10_T-1"),
        ("3b2994cb-5f82-4835-9212-0cac8fb3d164-2", "3b2994cb-5f82-4835-9212-0cac8fb3d164"),
        ("00a0ec58-1fb9-4a2b-bfd7-f4e5da7a9eff", "00a0ec58-1fb9-4a2b-bfd7-f4e5da7a9eff"),
        ("cross-000-01-00330-38", "cross-000-01"),
        ("double_ring-000-12-00000-7", "double_ring-000-12"),
        ("map-7-10000", "map"),
        ("cross-000-00-00110-35-new-s03", "cross-000-00"),
        ("cross-000-00-00110-35-s03-new", "cross-000-00"),
        ("drive-01", "drive"),
        ("drive_01", "drive_01"),
    ],
)
def test_a_recording_is_found_in_the_ids_that_every_data_set_writes(scenario_id, found):
    assert recording(scenario_id) == found


def test_scenes_placed_on_one_map_are_of_one_recording() -> None:
    assert {recording(name) for name in ("cross-7-0003", "cross-8-0011-s02", "cross-7-0004-new")} == {"cross"}
    assert recording("four_way-2-7-0003") == "four_way-2"
