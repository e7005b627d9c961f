"""The door `publish` on runs written by hand: what is pooled, what is said of what is missing, same bytes."""

import shutil
from pathlib import Path

import numpy as np
import orjson
import pytest

from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.report.published.results import pairs
from drivegen.store.files import write_json
from drivegen.store.results import Run, result_rows, write_results
from stages import publish
from stages._door import read_params
from stages.publish import About, Params

SCENES = ["USA_Lanker-2_10_T-1-000", "USA_Lanker-2_10_T-1-001", "USA_US101-12_1_T-1-000"]


def about(title: str, **changes: object) -> About:
    return About(**{"title": title, "folder": "", "params": {}, "folders": {}, "front": True, "by_scene": False, **changes})


def params(**changes: object) -> Params:
    data = {"here": about("Here"), "there": about("There", by_scene=True), "absent": about("Absent")}
    values = {
        "seed": 7, "draws": 50, "seeds": (7, 8), "sampling_seeds": (7,), "temperatures": (0.5,), "params": {}, "data": data,
        "transfer": (("here", "there"),), "training": (("here", "there"),),
        "own": ("drivegen",), "rivals": ("bits",), "baselines": (), "selectors": ("random",),
    }  # fmt: skip
    return Params(**{**values, **changes})


def run(place: Path, errors: dict[str, list[float]], scenes: list[str] = SCENES) -> None:
    """One evaluated run: `errors` by method are min-sADE of each scene; the rest follows from it."""
    metrics = place / "reports/metrics"
    for method, error in errors.items():
        values = {
            name: np.array(error) * factor
            for name, factor in zip(("min_sade", "min_sfde", "mean_sade", "mean_sfde"), (1, 2, 3, 4), strict=True)
        }
        values |= dict.fromkeys(("agent_steps", "vehicles", "bandwidth.nll_1s", "manoeuvre.left"), np.array(error))
        rows = result_rows(Run("x", "evaluate", method, "", 7, ""), scenes, values)
        write_results(metrics / f"quality/{method}.parquet", [rows])
        details = {"diversity_ratio": 0.9, "diversity_ratio.low": 0.8, "diversity_ratio.high": 1.0, "distance.speed": 0.5}
        write_json(metrics / f"quality_details/{method}.json", details)
    write_json(metrics / "ingest.json", {"trained_on": "toys", "note": ""})


@pytest.fixture
def runs(tmp_path: Path) -> Path:
    for seed, shift in ((7, 0.0), (8, 1.0)):
        for name in ("here", "there"):
            run(
                tmp_path / "runs" / name / f"{seed}-7",
                {"drivegen": [1 + shift, 2, 3], "bits": [9.0, 9, 9], "constant_velocity": [5.0, 5, 5]},
            )
    run(tmp_path / "runs/here/t0.5", {"drivegen": [1.0, 1, 1]})
    return tmp_path / "runs"


def test_every_figure_is_a_row_with_its_interval_and_who_chose(runs, tmp_path):
    publish.main(params(), runs, tmp_path / "out")
    rows = orjson.loads((tmp_path / "out/scenario_quality.json").read_bytes())
    assert all(
        set(row)
        == {
            "data",
            "method",
            "metric",
            "value",
            "low",
            "high",
            "n",
            "seeds",
            "sampling_seeds",
            "plateau",
            "additions",
            "selector",
        }
        for row in rows
    )
    found = {(row["data"], row["method"], row["metric"]): row for row in rows}
    mine = found["here", "drivegen", "min_sade"]
    assert mine["value"] == pytest.approx(6.5 / 3)
    assert mine["low"] < mine["value"] < mine["high"]
    assert (mine["sampling_seeds"], mine["plateau"], mine["additions"]) == (1, None, ["exclusion", "checker", "tempo"])
    assert (mine["n"], mine["seeds"], mine["selector"]) == (3, 2, "learned selector (imitates logs)")
    assert found["here", "drivegen", "diversity"]["low"] == 0.8
    assert {metric for _, _, metric in found} == {"min_sade", "min_sfde", "mean_sade", "mean_sfde", "diversity", "distance.speed"}


def test_who_chose_goals_is_told_as_the_stage_goals_wrote_it(runs, tmp_path):
    for seed in (7, 8):
        run(runs / "here" / f"{seed}-7", {"drivegen_vlm": [1.0, 1, 1]})
        goals = {"described": "language model somebody", "moving": {"vehicles": 3, "nll": 2.0}}
        write_json(runs / "here" / f"{seed}-7/reports/metrics/goals/vlm.json", goals)
    publish.main(params(), runs, tmp_path / "out")
    rows = orjson.loads((tmp_path / "out/scenario_quality.json").read_bytes())
    assert {row["selector"] for row in rows if row["method"] == "drivegen_vlm"} == {"language model somebody"}
    text = (tmp_path / "out/paired-drivegen_vlm-here.md").read_text()
    assert "| DriveGen | -1.17" in text  # 1 - 13/6


def test_scenes_of_one_recording_are_drawn_together(runs, tmp_path):
    for seed in (7, 8):
        run(runs / "here" / f"{seed}-7", {"drivegen": [1.0, 1.0, 4.0]})
    publish.main(params(), runs, tmp_path / "out")
    rows = orjson.loads((tmp_path / "out/scenario_quality.json").read_bytes())
    [mine] = [row for row in rows if (row["data"], row["method"], row["metric"]) == ("here", "drivegen", "min_sade")]
    assert (mine["low"], mine["value"], mine["high"]) == (1.0, 2.0, 4.0)  # two recordings: both draws of one come in 50


def test_tables_mark_the_under_trained_and_what_nobody_measured(runs, tmp_path):
    publish.main(params(), runs, tmp_path / "out")
    text = (tmp_path / "out/quality-here.md").read_text()
    assert "BITS, under-trained" in text
    assert "| TrafficGen | not measured |" in text
    assert "paper, on Argoverse 2" in text
    assert "-2.83" in (tmp_path / "out/paired-here.md").read_text()  # 13/6 - 5
    assert "temperature 0.5" in (tmp_path / "out/front-here.md").read_text()
    assert (tmp_path / "out/scenes-there.md").exists()
    assert "1.00" in (tmp_path / "out/transfer-here-there.md").read_text()
    missing = orjson.loads((tmp_path / "out/provenance.json").read_bytes())["runs_missing"]
    assert missing == ["absent/7-7", "absent/8-7", "there/t0.5", "absent/t0.5"]
    assert "INCOMPLETE: from 5 of 9 runs; not there: absent/7-7" in (tmp_path / "out/README.md").read_text()


def test_runs_that_nobody_asks_for_any_more_are_not_counted(runs, tmp_path):
    for name in ("here/9", "there/t0.5"):
        run(runs / name, {"drivegen": [1.0, 1, 1]})
    asked = params(data={"here": about("Here"), "there": about("There", front=False)})
    (tmp_path / "out").mkdir()
    (tmp_path / "out/provenance-drivers.json").write_text("{}")  # another part was published there
    publish.main(asked, runs, tmp_path / "out")
    text = (tmp_path / "out/README.md").read_text()
    assert "From all 5 runs that flows/tables.yaml asks for" in text
    assert "* [Drivers](drivers.md)" in text
    made = orjson.loads((tmp_path / "out/provenance.json").read_bytes())
    assert set(made["runs"]) == {"here/7-7", "here/8-7", "here/t0.5", "there/7-7", "there/8-7"}
    assert not (tmp_path / "out/front-there.md").exists()


def test_trained_on_less_and_on_more_is_compared_over_the_seeds_that_both_have(runs, tmp_path):
    shutil.rmtree(runs / "there/8-7")
    publish.main(params(), runs, tmp_path / "out")
    text = (tmp_path / "out/training-there.md").read_text()
    assert "| DriveGen | 2.00 " in text
    assert "| 0.00 |" in text  # no ends: no recording differs


def test_where_no_seed_or_no_scene_is_in_common_the_table_says_so(runs, tmp_path):
    shutil.rmtree(runs / "here/8-7")
    shutil.rmtree(runs / "there/7-7")
    publish.main(params(), runs, tmp_path / "out")
    text = (tmp_path / "out/training-there.md").read_text()
    assert "Nothing to compare: Here with 7-7 and There with 8-7 have no run in common; `make tables`" in text
    assert "DriveGen" not in text
    run(runs / "there/7-7", {"drivegen": [1.0, 2.0]}, ["USA_US101-9_1_T-1-000", "USA_US101-9_1_T-1-001"])
    shutil.rmtree(runs / "there/8-7")
    publish.main(params(), runs, tmp_path / "out")
    assert "Nothing to compare: Here and There have no scene in common." in (tmp_path / "out/training-there.md").read_text()


def test_the_same_runs_give_the_same_bytes(runs, tmp_path):
    for name in ("one", "two"):
        publish.main(params(), runs, tmp_path / name)
    for file in (tmp_path / "one").iterdir():
        assert file.read_bytes() == (tmp_path / "two" / file.name).read_bytes()


def test_seeds_with_other_scenes_are_refused(runs, tmp_path):
    run(runs / "here/8-7", {"drivegen": [1.0, 2.0]}, SCENES[:2])
    with pytest.raises(UnusableInput, match="other scenes"):
        publish.main(params(), runs, tmp_path / "out")


def test_a_run_that_was_stopped_before_all_methods_were_evaluated_is_named(runs, tmp_path):
    stopped = runs / "here/8-7/reports/metrics/quality/bits.parquet"
    stopped.unlink()
    with pytest.raises(UnusableInput, match=r"here/8-7/.*/bits\.parquet is not there.* run `make tables`, or move this run"):
        publish.main(params(), runs, tmp_path / "out")
    shutil.move(runs / "here/8-7", tmp_path / "elsewhere")
    publish.main(params(), runs, tmp_path / "out")
    assert "not there: here/8-7" in (tmp_path / "out/README.md").read_text()


def test_the_section_of_params_yaml_is_what_the_door_takes(monkeypatch):
    monkeypatch.chdir(Path(publish.__file__).parents[1])
    asked = read_params("tables.quality", Params)
    assert set(asked.runs) >= {
        f"{name}/{pair.folder}" for name in asked.data for pair in pairs(asked.seeds, asked.sampling_seeds)
    }


def test_no_runs_are_said_to_be_missing(tmp_path):
    with pytest.raises(MissingTool, match="make tables"):
        publish.main(params(), tmp_path / "nothing", tmp_path / "out")
