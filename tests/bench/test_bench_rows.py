"""Benchmark rows say whether they pass, compare in the right direction, and work on sound scenes."""

import json
import time

import numpy as np
import pytest

from drivegen import bench
from drivegen.bench import Row, _row, _scene, generation
from drivegen.core.errors import UnusableInput


@pytest.mark.parametrize(
    ("value", "smaller_is_better", "passed", "ratio"), [(2.0, True, True, 2.0), (5.0, True, False, 0.8), (2.0, False, False, 0.5)]
)
def test_a_row_passes_and_compares_in_its_own_direction(value, smaller_is_better, passed, ratio):
    row = Row("x", value, "ms", 3.0, smaller_is_better, 4.0, "the old way")
    assert row.passed == passed
    assert row.ratio == ratio
    assert row.as_json()["pass"] == passed


def test_a_row_without_a_reference_has_no_ratio():
    assert Row("x", 1.0, "ms", 3.0, True).ratio is None
    assert json.loads(json.dumps(Row("x", 1.0, "ms", 3.0, True).as_json()))["reference"] is None


def test_a_row_without_a_target_cannot_miss_it():
    assert Row("x", 1e9, "ms", None, True).passed


def test_the_clock_counts_work_and_not_waiting():
    numbers = np.arange(200_000, dtype=np.float64)
    assert _row.best_cpu_seconds(lambda: np.sin(numbers).sum(), turns=2) > 0


def test_every_part_is_found_and_an_unknown_one_is_named():
    assert {"checker", "lanes", "planners", "raster", "reading", "simulation"} <= set(bench.parts())
    with pytest.raises(UnusableInput, match="no benchmark is called 'nothing': choose one of checker"):
        list(bench.measure("nothing"))


def test_benchmark_scenes_are_sound_and_always_the_same():
    scene = _scene.scene(3)
    scene.validate()
    assert len(scene.vehicles) == 16
    np.testing.assert_array_equal(scene.vehicles.position, _scene.scene(3).vehicles.position)
    samples = _scene.samples(scene)
    assert samples.motion.valid.shape == (10, 16, _scene.STEPS)


def test_a_measured_part_gives_rows():
    (row,) = bench.measure("lanes")
    assert row.value > 0
    assert row.unit == "ms"


def test_a_clock_takes_inner_steps_off_outer_ones():
    clock = generation._Clock()

    def spin(seconds: float) -> None:
        end = time.process_time() + seconds
        while time.process_time() < end:
            pass

    inner = clock.time("inner", lambda: spin(0.03))
    clock.time("outer", lambda: (inner(), spin(0.01)))()
    assert 0.03 <= clock.spent["inner"] < 0.2
    assert 0.01 <= clock.spent["outer"] < clock.spent["inner"]


def test_a_part_says_what_it_needs_and_is_left_out(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert any(sentence.startswith("generation: not measured, it needs data/models") for sentence in bench.unmeasured())
