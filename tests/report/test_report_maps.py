"""The section of maps: rows by writer and group, what nobody ran, diversity beside real maps."""

from drivegen.maps.diversity import summary
from drivegen.maps.suite.cases import OWN, REFUSE, Case
from drivegen.maps.suite.table import not_measured, published
from drivegen.maps.suite.trials import Trial
from drivegen.report.evidence import Evidence
from drivegen.report.sections.maps import suites

ROAD, NONE = Case(OWN, "plain", "a crossing", {}), Case(OWN, REFUSE, "poem", None)
TRIALS = [Trial(ROAD, drawn=True, loads=True), Trial(ROAD, refused="no", offer="a", offer_wrong=()), Trial(NONE, refused="no")]
TRIALS += [Trial(ROAD, drawn=True, loads=True, wrong=("arms",))]
SUITE = {"writers": {"offline": published("rules", TRIALS), "language_model": not_measured("language model")}}
WINDOW = {"lanes": 2.0, "arms": 4.0, "curvature": 1.0, "length": 0.5, "connectivity": 1.2}


def test_rows_by_writer_and_group_and_a_model_that_nobody_ran():
    told = suites(Evidence({"map_suite": SUITE}))
    assert [table.name for table in told.tables] == ["map-suite"]
    assert told.missing == ""
    texts = [[cell.text for cell in row.cells] for row in told.tables[0].rows]
    assert texts[0] == ["rules", "own, plain", "3", "1", "2", "1", "1"]
    assert texts[1] == ["rules", "own, refuse", "1", "1", "1", "0", "0"]
    assert texts[2][0] == "language model"
    assert set(texts[2][2:]) == {"not measured"}


def test_diversity_beside_a_source_that_is_not_there():
    found = {"radius": 150.0, "sources": {"maps from words": {"maps": 1.0, **summary([WINDOW, WINDOW])}, "Argoverse 2": None}}
    [table] = suites(Evidence({"map_diversity": found})).tables
    assert [row.cells[0].text for row in table.rows] == ["maps from words", "Argoverse 2"]
    assert [cell.text for cell in table.rows[0].cells[:5]] == ["maps from words", "1", "2", "2.00", "0.00"]
    assert {cell.text for cell in table.rows[1].cells[1:]} == {"not measured"}
    assert all(len(row.cells) == len(table.columns) for row in table.rows)
