"""DriveGen with goals by a vision-language model: it follows what goals@vlm recorded, and is a row that reads "not measured"."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from drivegen.core import plugins
from drivegen.core.methods import read_methods
from drivegen.goals.packing import unpack
from drivegen.report.evidence import Evidence
from drivegen.report.sections.quality import name_of
from drivegen.report.table import NOT_MEASURED, number, row
from drivegen.roads.graph import LaneGraph
from drivegen.store.goals import read_goals
from drivegen.store.samples import read_samples
from drivegen.store.scenarios import write_shard
from stages import goals, rollout
from stages._door import read_params
from tests.lm import asking
from tests.lm.chat_server import Says, serving
from tests.scenes import busy_crossing

SHARD = "shard-00000.parquet"


def test_it_drives_to_the_goals_that_the_model_chose(models: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    choosing, rolling = read_params("goals", goals.Params), read_params("rollout", rollout.Params)
    monkeypatch.chdir(tmp_path)
    write_shard(Path("test") / SHARD, [busy_crossing(101, "a")])
    with serving([Says(json.dumps({"ranking": [{"goal": 0, "reason": "free"}]}))]) as server:
        lm = {
            "goals": vars(asking.settings(server.url, max_calls=100, prompt="goals-2")),
            "records": {"mode": "auto", "folder": "store"},
        }
        Path("params.yaml").write_text(yaml.safe_dump({"lm": lm}))
        goals.main(
            replace(choosing, workers=1),
            Path("test"),
            models / "selector",
            Path("goals/vlm"),
            Path("vlm.parquet"),
            Path("vlm.json"),
        )
    rolling = replace(rolling, workers=1, samples=2)
    rollout.main(rolling, Path("test"), models, Path("goals"), Path("generated/drivegen_vlm"), Path("rejected.parquet"))
    [made] = read_samples(Path("generated/drivegen_vlm") / SHARD)
    [recorded] = read_goals(Path("goals/vlm") / SHARD)
    assert made.method == "drivegen_vlm"
    _, probability = unpack(LaneGraph.of(busy_crossing(101, "a").map), recorded)
    for n, own in enumerate(probability):
        followed = made.goal[:, n] >= 0
        np.testing.assert_allclose(made.natural[followed, n], own[made.goal[followed, n]], rtol=1e-5)


def test_without_a_model_it_says_that_nobody_was_asked(models: Path) -> None:
    settings = read_params("rollout", rollout.Params).generation
    made = plugins.load("generators", "drivegen_vlm")(models, settings)
    assert made.backend == "learned selector in place of a vision-language model (none was given)"


def test_it_is_a_row_where_somebody_was_asked_and_none_elsewhere() -> None:
    measured = {"drivegen": {"min_sade": 1.0}}
    assert "drivegen_vlm" not in Evidence(methods=read_methods()).rows(measured)
    asked = Evidence({"goals/vlm": {"described": "a model"}}, methods=read_methods())
    assert asked.rows(measured)["drivegen_vlm"] == {}
    line = row(name_of("drivegen_vlm", measured, asked), number(asked.rows(measured)["drivegen_vlm"].get("min_sade"), 2))
    assert [cell.text for cell in line.cells] == ["DriveGen, goals by a vision-language model", NOT_MEASURED]
