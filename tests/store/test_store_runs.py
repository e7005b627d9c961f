"""What a run left in its workspace is read back: scores, curves, times, sizes, parameters, code."""

from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import save_file

from drivegen.core.errors import UnusableInput
from drivegen.store.costs import write_cost
from drivegen.store.files import write_json
from drivegen.store.results import Run, result_rows, write_results
from drivegen.warehouse.runs import COSTS, METRICS, read_codes, read_curve, read_models, read_param, read_scores


def part(file: Path, scenes: list[str], **values: list[float]) -> Path:
    rows = result_rows(Run("x", "evaluate", "drivegen", "", 7, ""), scenes, {k: np.array(v) for k, v in values.items()})
    write_results(file, [rows])
    return file


def test_scores_of_several_runs_stand_side_by_side_and_gaps_are_no_numbers(tmp_path: Path) -> None:
    parts = [part(tmp_path / "a.parquet", ["s1", "s0"], error=[1.0, 0.0], other=[5.0, 6.0])]
    parts.append(part(tmp_path / "b.parquet", ["s0", "s1"], error=[2.0, 3.0]))
    scenarios, values = read_scores(parts)
    assert scenarios == ("s0", "s1")
    np.testing.assert_array_equal(values["error"], [[0.0, 1.0], [2.0, 3.0]])
    np.testing.assert_array_equal(values["other"], [[6.0, 5.0], [np.nan, np.nan]])


def test_scores_are_of_scenes_not_of_single_samples(tmp_path: Path) -> None:
    run, numbers = Run("x", "evaluate", "drivegen", "", 7, ""), np.array([1.0, 3.0])
    each = result_rows(run, ["s0", "s0"], {"error": numbers, "sade": numbers}, np.array([0, 1]))
    write_results(tmp_path / "a.parquet", [result_rows(run, ["s0"], {"error": np.array([2.0])}), each])
    scenarios, values = read_scores([tmp_path / "a.parquet"])
    assert (scenarios, set(values)) == (("s0",), {"error"})
    np.testing.assert_array_equal(values["error"], [[2.0]])


def test_scores_of_other_scenes_are_refused(tmp_path: Path) -> None:
    parts = [part(tmp_path / "a.parquet", ["s0"], error=[1.0]), part(tmp_path / "b.parquet", ["s1"], error=[1.0])]
    with pytest.raises(UnusableInput, match=r"b\.parquet: other scenes than in .*a\.parquet"):
        read_scores(parts)


def test_every_model_comes_with_its_size_and_its_time_where_it_was_trained_here(tmp_path: Path) -> None:
    for name in ("train_generator/bits", "train_planner/route_fm", "train_selector"):
        file = tmp_path / "reports/plots" / f"{name}.csv"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("step,train,validation\n10,2.0,\n20,1.0,0.5\n")
    for folder, shape in (("generators/bits", (2, 3)), ("selector", (4,))):
        (tmp_path / "data/models" / folder).mkdir(parents=True)
        save_file({"weight": np.zeros(shape), "bias": np.zeros(1)}, tmp_path / "data/models" / folder / "weights.safetensors")
    write_cost(tmp_path / COSTS, "train_generator", "bits", {"cpu_seconds": 3.0})
    write_cost(tmp_path / COSTS, "train_selector", "train_selector", {"cpu_seconds": 4.0})
    write_json(tmp_path / METRICS / "train_generator/bits.json", {"plateau": True, "sampling_temperature": 0.5})
    found = {model.name: model for model in read_models(tmp_path)}
    assert (found["train_generator/bits"].plateau, found["train_generator/bits"].temperature) == (True, 0.5)
    assert found["train_planner/route_fm"].temperature is None
    assert set(found) == {"train_generator/bits", "train_planner/route_fm", "train_selector/train_selector"}
    assert found["train_generator/bits"].parameters == 7
    assert found["train_selector/train_selector"].parameters == 5
    assert found["train_planner/route_fm"].parameters is None
    assert found["train_planner/route_fm"].took == {}
    assert found["train_selector/train_selector"].took["cpu_seconds"] == 4.0
    assert found["train_generator/bits"].curve["step"] == [10.0, 20.0]


def test_a_gap_in_a_curve_is_no_number(tmp_path: Path) -> None:
    (tmp_path / "curve.csv").write_text("step,validation\n10,\n20,0.5\n")
    np.testing.assert_array_equal(read_curve(tmp_path / "curve.csv")["validation"], [np.nan, 0.5])


def test_a_runs_own_parameters_are_read_by_name(tmp_path: Path) -> None:
    assert read_param(tmp_path, "rollout.temperature") is None
    (tmp_path / "params.yaml").write_text("rollout: {temperature: 0.4}\n")
    assert read_param(tmp_path, "rollout.temperature") == 0.4
    assert read_param(tmp_path, "rollout.tempo.share") is None


def test_runs_are_gathered_by_the_code_that_made_them(tmp_path: Path) -> None:
    for name, commit in (("a", "12ab"), ("c", "12ab")):
        write_json(tmp_path / name / ".drivegen/code.json", {"commit": commit, "changed": False})
    found = read_codes({name: tmp_path / name for name in ("a", "b", "c")})
    assert found == [
        {"commit": "12ab", "changed": False, "runs": ["a", "c"]},
        {"commit": None, "changed": None, "runs": ["b"]},
    ]
