"""Stage likeness: a table of seven distances where there is real data, a sentence where there is none."""

from dataclasses import replace
from pathlib import Path

import orjson
import pytest

from drivegen.datasets.sumo_corpus import write_part
from drivegen.metrics.likeness import NAMES
from drivegen.report import Evidence
from drivegen.report.sections.data import likeness as section
from stages.likeness import Params, Real, main
from tests.scenes import busy_crossing

SCENES = ["train/a", "train/b"]
PARAMS = Params(seed=7, scenes=5, draws=3, root="", real={"people": Real("sumo_corpus", "people", tuple((s,) for s in SCENES))})


@pytest.fixture
def corpus(tmp_path: Path) -> Path:
    for folder in ("corpus", "people"):
        write_part(tmp_path / folder / "train", "x-000", [busy_crossing(110, "a"), busy_crossing(110, "b")])
    return tmp_path / "corpus"


def test_traffic_is_not_apart_from_itself_and_each_source_has_a_column(corpus: Path, tmp_path: Path) -> None:
    main(replace(PARAMS, root=str(tmp_path)), corpus, tmp_path / "table.json")
    found = orjson.loads((tmp_path / "table.json").read_bytes())
    assert found["scenes"] == 2
    assert set(found["distance"]) == {"all", "people"}
    assert [found["distance"]["people"][name] for name in ("speed", "acceleration", "standing")] == [0, 0, 0]
    (table,) = section(Evidence(results={"likeness": found})).tables
    assert len(table.rows) == len(NAMES)
    assert len(table.columns) == 4


def test_distances_are_told_in_units_of_how_far_halves_of_real_driving_are_apart() -> None:
    found = {"scenes": 2, "unit": dict.fromkeys(NAMES, 0.5), "distance": {"all": dict.fromkeys(NAMES, 2.0)}}
    (table,) = section(Evidence(results={"likeness": found})).tables
    assert {tuple(cell.text for cell in row.cells[1:]) for row in table.rows} == {("0.500", "4.00")}


def test_without_real_data_the_table_says_so(corpus: Path, tmp_path: Path) -> None:
    main(PARAMS, corpus, tmp_path / "table.json")
    found = orjson.loads((tmp_path / "table.json").read_bytes())
    assert found == {"without": ["people"]}
    assert "recordings of people" in section(Evidence(results={"likeness": found})).missing
