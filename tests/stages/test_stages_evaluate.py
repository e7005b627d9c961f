"""Stages evaluate, collect and report on small shards."""

import csv
import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from drivegen.core.errors import UnusableInput
from drivegen.core.samples import Samples
from drivegen.metrics.scene import Settings
from drivegen.store.costs import COST, write_cost
from drivegen.store.rejected import write_rejected
from drivegen.store.results import RESULT, WHOLE_SCENE
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import write_shard
from drivegen.warehouse.database import query
from stages import collect, evaluate, report
from stages._door import read_params
from tests.scenes import busy_crossing, noisy_samples, rejected_of

ROOT = Path(__file__).parents[2]
MEASURED = Settings(horizons=(1.0, 3.0), bandwidths=(0.5, 1.0, 2.0, 4.0), box_scales=(0.9, 1.0, 1.1))
PER_SAMPLE = ("collision_per_vehicle", "off_road_per_vehicle", "illegal_per_vehicle")
PARAMS = evaluate.Params(seed=7, workers=1, draws=50, splits=4, measured=MEASURED)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Two shards of scenes with two methods' samples, all evaluated."""
    root, down = tmp_path_factory.mktemp("run"), []
    for shard, ids in (("shard-00000.parquet", "abc"), ("shard-00001.parquet", "de")):
        scenes = [busy_crossing(60, f"scene-{letter}") for letter in ids]
        write_shard(root / "test" / shard, scenes)
        noisy = [noisy_samples(scene, 4, seed=i, method="drivegen") for i, scene in enumerate(scenes)]
        write_samples(root / "generated" / "drivegen" / shard, noisy)
        down += [rejected_of(one) for one in noisy]
        logs = [Samples.without_goals(scene.scenario_id, "log", scene.log[np.newaxis]) for scene in scenes]
        write_samples(root / "generated" / "log" / shard, logs)
    write_rejected(root / "rejected" / "drivegen.parquet", down)
    for method in ("drivegen", "log"):
        run(root, method)
    return root


def run(root, method, params=PARAMS, out="quality"):
    places = (f"{out}/{method}.parquet", f"{out}_details/{method}.json", f"{out}/{method}.json")
    evaluate.main(params, root / "test", root / "generated" / method, *(root / "metrics" / place for place in places))
    return details_of(root, method, out)


def details_of(root, method, out="quality"):
    return json.loads((root / "metrics" / f"{out}_details" / f"{method}.json").read_text())


def test_the_log_makes_no_error_and_is_as_diverse_as_itself(made):
    summary = details_of(made, "log")
    assert (summary["min_sade"], summary["mean_sfde"], summary["collision_per_vehicle"]) == (0, 0, 0)
    assert summary["diversity_ratio"] == summary["diversity_ratio_any_sample_plain"] == pytest.approx(1.0)


def test_the_summary_is_flat_and_its_means_are_those_of_the_rows(made):
    summary = details_of(made, "drivegen")
    assert all(value is None or isinstance(value, int | float) for value in summary.values())
    rows = pq.read_table(made / "metrics/quality/drivegen.parquet").to_pylist()
    for name in ("min_sade", "min_sfde", "mean_sade", "mean_sfde", "collision_per_scene", "violation.collision"):
        values = [row["value"] for row in rows if row["metric"] == name and row["sample"] == WHOLE_SCENE]
        assert len(values) == 5
        assert summary[name] == pytest.approx(np.mean(values))
        assert summary[f"{name}.low"] <= summary[name] <= summary[f"{name}.high"]
    assert summary["scenarios"] == summary["label.road.signalised_junction"] == 5
    assert summary["agent_steps"] == 5 * 8 * 59
    assert summary["diversity_pairs"] == 4 * (5 // 2)
    assert 0 < summary["min_sade"] < summary["mean_sade"]


def test_every_sample_has_rows_of_which_the_scenes_are_means(made):
    rows = pq.read_table(made / "metrics/quality/drivegen.parquet").to_pylist()
    found = {(row["metric"], row["sample"]): row["value"] for row in rows if row["scenario"] == "scene-d"}
    for each, whole in (("sade", "mean_sade"), ("sfde", "mean_sfde"), *((name, name) for name in PER_SAMPLE)):
        values = [found[each, k] for k in range(4)]
        assert np.mean(values) == pytest.approx(found[whole, WHOLE_SCENE])
    assert min(found["sade", k] for k in range(4)) == found["min_sade", WHOLE_SCENE]
    assert ("sade", 4) not in found


def test_scenes_of_another_length_are_measured_and_not_averaged(made, tmp_path):
    scenes = [busy_crossing(60, "a-000"), busy_crossing(60, "a-001"), busy_crossing(60, "b-000"), busy_crossing(30, "c-000")]
    write_shard(tmp_path / "test" / "shard-00000.parquet", scenes)
    write_samples(tmp_path / "generated/x/shard-00000.parquet", [noisy_samples(s, 4, seed=i) for i, s in enumerate(scenes)])
    found = run(tmp_path, "x")
    rows = pq.read_table(tmp_path / "metrics/quality/x.parquet").to_pylist()
    error = {row["scenario"]: row["value"] for row in rows if row["metric"] == "mean_sade"}
    assert len(error) == 4
    assert found["mean_sade"] == pytest.approx(np.mean([error[scene] for scene in ("a-000", "a-001", "b-000")]))
    assert (found["scenarios"], found["recordings"], found["steps"], found["left_out.30"]) == (3, 2, 60, 1)
    one, other = np.mean([error["a-000"], error["a-001"]]), error["b-000"]
    assert [found["mean_sade.low"], found["mean_sade.high"]] == pytest.approx(sorted([one, other]))  # draws of one recording
    assert found["diversity_pairs"] == 4 * (3 // 2)


def test_dvc_shows_few_numbers(made):
    shown = json.loads((made / "metrics/quality/drivegen.json").read_text())
    details = details_of(made, "drivegen")
    assert len("reports/metrics/quality/drivegen_without_goals.json") + sum(len(name) + 4 for name in shown) <= 120
    assert all(details[name] == value for name, value in shown.items())


def test_rows_name_run_method_and_seed(made):
    table = pq.read_table(made / "metrics/quality/drivegen.parquet")
    assert table.schema.remove_metadata() == RESULT
    first = table.to_pylist()[0]
    assert re.fullmatch(r"[0-9a-f]{12}", first["run"])
    assert (first["stage"], first["method"], first["seed"]) == ("evaluate", "drivegen", 7)


def test_two_processes_give_the_same_bytes_as_one(made):
    again = run(made, "drivegen", replace(PARAMS, workers=2), "again")
    assert again["scenarios"] == 5
    for end in ("parquet", "json"):
        first, second = (made / "metrics" / folder / f"drivegen.{end}" for folder in ("quality", "again"))
        assert first.read_bytes() == second.read_bytes()
        second.unlink()


def test_samples_of_other_scenes_are_refused(made, tmp_path):
    write_shard(tmp_path / "test" / "shard-00000.parquet", [busy_crossing(20, "another")])
    outs = [tmp_path / name for name in ("x.parquet", "details.json", "x.json")]
    with pytest.raises(UnusableInput, match="lacks scenario another"):
        evaluate.main(PARAMS, tmp_path / "test", made / "generated/drivegen", *outs)
    assert [place.name for place in tmp_path.iterdir()] == ["test"]


def test_all_results_and_costs_are_collected(made, tmp_path):
    write_cost(tmp_path / "costs", "evaluate", "drivegen", {"cpu_seconds": 5.0, "scenarios": 5})
    collected(made, tmp_path)
    quality = query(tmp_path / "drivegen.duckdb", "from scenario_quality order by method").to_pylist()
    summary = details_of(made, "drivegen")
    assert [row["method"] for row in quality] == ["drivegen", "log"]
    assert quality[0]["min_sade"] == pytest.approx(summary["min_sade"])
    assert query(tmp_path / "drivegen.duckdb", "from costs").schema.names == COST.names


def test_a_copy_of_a_round_of_corner_cases_is_no_round(made, tmp_path):
    project = shutil.copytree(made, tmp_path / "project")
    for folder in ("2", "10", "2-backup"):
        shutil.copytree(made / "generated" / "drivegen", project / "corner" / folder / "samples")
    found = query(collected(project, tmp_path), "select item from samples where stage = 'corner'").to_pylist()
    assert list(dict.fromkeys(row["item"] for row in found)) == ["2", "10"]


def collected(made, tmp_path):
    """Run the stage on what there is; costs and calls are those of `tmp_path`."""
    params = read_params("collect", collect.Params, ROOT / "params.yaml")
    folders = (made / name for name in ("scenarios", "new", "shipped", "generated", "corner"))
    collect.main(
        params,
        made / "metrics",
        tmp_path / "pieces",
        tmp_path / "costs",
        tmp_path / "calls",
        ROOT / "params.yaml",
        *folders,
        tmp_path / "costs.md",
        tmp_path / "drivegen.duckdb",
    )
    return tmp_path / "drivegen.duckdb"


def costs_of(made, tmp_path, *costs):
    """The table of costs where so much was measured here."""
    for stage, item, found in costs:
        write_cost(tmp_path / "costs", stage, item, found)
    collected(made, tmp_path)
    return (tmp_path / "costs.md").read_text()


def test_costs_of_methods_count_the_choice_of_goals_and_of_training_the_gpu_if_there_was_one(made, tmp_path):
    text = costs_of(
        made,
        tmp_path,
        ("rollout", "drivegen", {"cpu_seconds": 1.0, "peak_megabytes": 900.0}),
        ("rollout_baseline", "log", {"cpu_seconds": 0.4, "peak_megabytes": 700.0}),
        ("goals", "learned", {"cpu_seconds": 0.5}),
        ("train_generator", "bits", {"cpu_seconds": 120.0}),
        ("train_generator", "smart", {"cpu_seconds": 9.0, "training_gpu_seconds": 30.0}),
    )
    assert "| drivegen | 300 | 100 | 900 | 5 |" in text
    assert "| log | 80 | 0 | 700 | 5 |" in text
    assert "| train_generator | smart | 9 | 30 |" in text
    assert "| train_generator | bits | 120 | none |" in text


def test_what_was_restored_from_the_cache_is_no_number_and_no_gap(made, tmp_path):
    metrics = shutil.copytree(made / "metrics", tmp_path / "made" / "metrics")
    for name in ("train_selector.json", "train_planner/route_fm.json"):
        (metrics / name).parent.mkdir(exist_ok=True)
        (metrics / name).write_text("{}")
    text = costs_of(metrics.parent, tmp_path, ("rollout_baseline", "log", {"cpu_seconds": 0.4, "peak_megabytes": 700.0}))
    gone = "not measured here: restored from cache"
    assert f"| drivegen | {gone} | {gone} | {gone} | 5 |" in text
    assert "| log | 80 | 0 | 700 | 5 |" in text
    assert f"| train_selector |  | {gone} | {gone} |" in text
    assert f"| train_planner | route_fm | {gone} | {gone} |" in text


def report_of(made, out):
    places = [
        made / folder for folder in ("metrics", "plots", "test", "generated", "rejected", "goals", "corner", "maps", "costs")
    ]
    report.main(replace(read_params("report", report.Params), scenes=2, maps=4), *places, out / "index.html", out / "tables")
    return (out / "index.html").read_text()


def test_the_report_shows_what_was_measured(made, tmp_path):
    (made / "plots").mkdir(exist_ok=True)
    with (made / "plots/train_selector.csv").open("w", newline="") as file:
        csv.writer(file).writerows([["step", "train", "validation"], [1, 2.0, 2.5], [2, 1.0, ""]])
    page = report_of(made, tmp_path / "one")
    summary = details_of(made, "drivegen")
    assert f"{summary['min_sade']:.2f}" in page
    assert "hand-made scenes" in page
    assert page.count("data:image/png") == 4  # each scene large, and by every method
    assert page.count("32 turned down: 32 speed") == 4  # in the caption of each
    assert "Training: selector" in page
    assert (tmp_path / "one/tables/quality.md").read_text().startswith("### Table I")
    assert report_of(made, tmp_path / "two") == page


def test_the_report_survives_that_nothing_has_run(tmp_path):
    page = report_of(tmp_path, tmp_path)
    assert "the stage evaluate has not run" in page


def test_a_broken_json_is_named(tmp_path):
    (tmp_path / "metrics").mkdir()
    (tmp_path / "metrics" / "ingest.json").write_text('{"accepted": ')
    with pytest.raises(UnusableInput, match=r"ingest\.json is not JSON"):
        report_of(tmp_path, tmp_path)
