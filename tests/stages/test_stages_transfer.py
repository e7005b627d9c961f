"""The stage `transfer` on hand-made cases, and its published table."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import orjson
import pytest

from drivegen.core.errors import UnusableInput
from drivegen.core.samples import Samples
from drivegen.core.scenario import Trajectories
from drivegen.report.published.transfer import transfer_table
from drivegen.store.files import write_json
from drivegen.store.samples import read_samples, write_samples
from drivegen.store.scenarios import write_shard
from stages import publish_corner, transfer
from stages._door import read_params, read_section
from tests.drivers.taught import PARAMS
from tests.scenes import drive, stack
from tests.stages.crossing_cases import ACROSS, LINE, SHARD, scene, write_cases


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """Three scenes, in two of which IDM's case is that somebody drives across."""
    write_cases(root := tmp_path_factory.mktemp("transfer"))
    return root


def run(made: Path, out: Path) -> list[dict[str, object]]:
    attacks = {"random": "random.legal.10", "cat": "cat.legal.10"}
    small = {"attacks": attacks, "drivers": {"idm": read_section("transfer.drivers.idm", PARAMS)}, "draws": 20}
    params = replace(read_params("transfer", transfer.Params, PARAMS), **small)
    transfer.main(params, made / "test", made / "round", made / "attack", out / "transfer.json")
    return orjson.loads((out / "transfer.json").read_bytes())


def test_who_was_searched_against_fails_in_its_cases_and_not_without_the_attack(made, tmp_path):
    about = {"method": "random", "found_for": "idm", "driver": "idm", "n": 2}
    failed, untouched = run(made, tmp_path)
    assert failed == {**about, "metric": "counted", "value": 1.0, "low": 1.0, "high": 1.0}
    assert untouched == {**about, "metric": "untouched", "value": 0.0, "low": 0.0, "high": 0.0}


def test_of_several_scenes_the_one_that_was_attacked_is_driven_without_the_attack(made, tmp_path):
    hit = stack([drive(LINE, 10, 9, 61), drive(ACROSS, 0, 10.2, 61)])  # another future, in which IDM fails as it is
    both = [Trajectories.joined([hit[np.newaxis], scene(n).log[np.newaxis]]) for n in range(3)]
    futures = [Samples.without_goals(f"run{n}-0", "drivegen", motion) for n, motion in enumerate(both)]
    write_samples(tmp_path / "round" / SHARD, futures)
    for part in ("test", "attack"):
        (tmp_path / part).symlink_to(made / part)
    assert [row["value"] for row in run(tmp_path, tmp_path)] == [1.0, 0.0]


def test_a_case_in_which_nobody_was_exchanged_is_no_attack(made, tmp_path):
    cases = read_samples(made / "attack/idm/random.legal.10/samples.parquet")
    futures = [Samples.without_goals(case.scenario_id, "drivegen", case.motion) for case in cases]
    futures += [Samples.without_goals("run2-0", "drivegen", scene(2).log[np.newaxis])]
    write_samples(tmp_path / "round" / SHARD, futures)
    for part in ("test", "attack"):
        (tmp_path / part).symlink_to(made / part)
    assert run(tmp_path, tmp_path) == []


def test_cases_of_other_scenarios_are_refused(made, tmp_path):
    write_shard(tmp_path / "test" / SHARD, [scene(0)])
    write_samples(tmp_path / "round" / SHARD, [Samples.without_goals("run0-0", "drivegen", scene(0).log[np.newaxis])])
    params = replace(read_params("transfer", transfer.Params, PARAMS), attacks={"random": "random.legal.10"})
    with pytest.raises(UnusableInput, match="cases are of scenario run1-0, which is not among the scenarios"):
        transfer.main(params, tmp_path / "test", tmp_path / "round", made / "attack", tmp_path / "out.json")


def test_cases_in_logs_are_refused(made, tmp_path):
    params = replace(read_params("transfer", transfer.Params, PARAMS), attacks={"dataset": "dataset.legal.1"})
    with pytest.raises(UnusableInput, match=r"^dataset\.legal\.1 attacks logs, which are compared with no generated traffic"):
        transfer.main(params, made / "test", made / "round", made / "attack", tmp_path / "out.json")


def test_the_table_has_a_line_for_whom_it_was_found_and_a_column_for_who_drives(made, tmp_path):
    place = tmp_path / "runs/7"
    rows = run(made, tmp_path)
    write_json(place / publish_corner.TRANSFERRED, [{**row, "driver": name} for name in ("idm", "gail") for row in rows])
    write_json(place / "reports/metrics/attack/idm.json", {})
    publish_corner.main(publish_corner.Params(7, [7], {}, 20), tmp_path / "runs", tmp_path / "out")
    text = (tmp_path / "out/transfer.md").read_text()
    assert "|  | found for | cases | driven by idm | driven by gail |" in text
    assert "| random goals | idm | 2 | 1.00 (without 0.00) | 1.00 (without 0.00) |" in text
    published = orjson.loads((tmp_path / "out/transfer.json").read_bytes())
    assert {row["seeds"] for row in published} == {1}
    assert {row["data"] for row in published} == {"sumo_corpus"}


def test_a_figure_of_one_recording_has_no_interval(made, tmp_path):
    row = {"method": "random", "found_for": "idm", "driver": "idm", "value": 1.0, "low": None, "high": None, "n": 1, "seeds": 1}
    text = transfer_table([{**row, "metric": "counted"}, {**row, "metric": "untouched", "value": 0.0}]).markdown()
    assert "| random goals | idm | 1 | 1.00 (without 0.00) |" in text
