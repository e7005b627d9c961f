"""The stage `recall` on hand-made scenes, and its published table."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import orjson
import pytest

from drivegen.store.files import write_json
from stages import publish_corner, recall
from stages._door import read_params, read_section
from tests.drivers.taught import PARAMS
from tests.stages.queues import write_queues

QUERIES = [1, 4]
GOALS_ALONE = "drivegen_cs.no_variations"


@pytest.fixture(scope="module")
def made(tmp_path_factory, models: Path) -> Path:
    """See `queues`."""
    write_queues(root := tmp_path_factory.mktemp("recall"), models)
    return root


def run(made: Path, out: Path, **changes: object) -> list[dict[str, object]]:
    sound = read_section("recall.drivers.idm", PARAMS)
    weak = {**sound, "emergency_braking": 1.0}  # whoever stops before it is run into
    few = {"workers": 1, "scenes": 3, "motions": 1, "queries": QUERIES, "draws": 20}
    small = {
        **few,
        "drivers": {"idm": weak},
        "variants": {"no_variations": read_section("recall.variants.no_variations", PARAMS)},
    }
    params = replace(read_params("recall", recall.Params, PARAMS), **{**small, **changes})
    recall.main(params, made / "test", made / "models", made / "goals", made / "round", out / publish_corner.FOUND)
    return orjson.loads((out / publish_corner.FOUND).read_bytes())


@pytest.fixture(scope="module")
def rows(made, tmp_path_factory) -> list[dict[str, object]]:
    """Of a driver that can hardly brake."""
    return run(made, tmp_path_factory.mktemp("rows"))


def values(rows: list[dict[str, object]], metric: str) -> dict[object, object]:
    return {(row["method"], row["queries"]): row["value"] for row in rows if row["metric"] == metric}


def test_recall_is_a_share_of_what_is_there_and_more_runs_find_no_less(rows):
    counted, found = values(rows, "counted"), values(rows, "recall")
    assert {row["n"] for row in rows if row["metric"] != "recall"} == {3}
    there = counted.pop((recall.EVERY, None))
    assert there > 0
    assert set(found) == {(method, q) for method in ("drivegen_cs", GOALS_ALONE, "cat", "random") for q in QUERIES}
    for key, share in found.items():
        assert counted[key] >= share * there - 1e-9
        assert values(rows, "avoidable")[key] <= counted[key]
    for method in ("random", GOALS_ALONE):  # who varies no goal finds nothing beyond them
        assert counted[method, 4] == pytest.approx(found[method, 4] * there)
    for method in ("drivegen_cs", "cat", "random"):
        assert found[method, 1] <= found[method, 4]


def test_where_nothing_can_be_found_there_is_no_recall(made, tmp_path):
    rows = run(made, tmp_path, drivers={"idm": read_section("recall.drivers.idm", PARAMS)}, reaction_steps=200, queries=[1])
    assert values(rows, "counted") == dict.fromkeys(
        [(recall.EVERY, None), *((m, 1) for m in ("drivegen_cs", GOALS_ALONE, "cat", "random"))], 0.0
    )
    assert {row["n"] for row in rows if row["metric"] == "recall"} == {0}
    assert set(values(rows, "recall").values()) == {None}


def test_the_table_has_a_line_for_each_adversary_and_number_of_runs(rows, tmp_path):
    place = tmp_path / "runs/7"
    write_json(place / publish_corner.FOUND, rows)
    write_json(place / "reports/metrics/attack/idm.json", {})
    publish_corner.main(publish_corner.Params(7, [7], {}, 20), tmp_path / "runs", tmp_path / "out")
    text = (tmp_path / "out/recall.md").read_text()
    lines = [line for line in text.splitlines() if line.startswith("| idm |")]
    assert len(lines) == 1 + 3 * len(QUERIES)
    assert lines[0].startswith("| idm | every goal driven | all |")
    assert any(line.startswith("| idm | DriveGen-CS | 4 |") for line in lines)
    ablated = (tmp_path / "out/ablation.md").read_text()
    assert [line.split(" | ")[1] for line in ablated.splitlines() if line.startswith("| idm |")] == [
        "whole",
        "goals as they are, without variations",
    ]
    published = orjson.loads((tmp_path / "out/recall.json").read_bytes())
    assert {row["seeds"] for row in published} == {1}
    assert [row["value"] for row in published] == [
        row["value"] for row in rows if row["value"] is None or np.isfinite(row["value"])
    ]
