"""The section of maps: rows by writer and suite, by kind, what nobody ran, the first try, diversity beside real maps."""

from drivegen.maps.diversity import summary
from drivegen.maps.suite.cases import HELD_OUT, OWN, Case
from drivegen.maps.suite.table import not_measured, published
from drivegen.maps.suite.trials import Trial
from drivegen.report.evidence import Evidence
from drivegen.report.sections.maps import section

ROAD, NONE = Case(OWN, "crossing", "a crossing", {}), Case(HELD_OUT, "hostile", "poem", None)
TRIALS = [Trial(ROAD, True, "", True, True, True, True, repairs=2), Trial(ROAD, True), Trial(NONE, refused="no")]
FIRST = {
    "date": "2026-01-02",
    "revision": "abc",
    "part": "A",
    "roads": 9,
    "as_asked": 7,
    "declined": 1,
    "to_refuse": 3,
    "refused": 2,
}
SUITE = {
    "first_try": [FIRST],
    "writers": {"offline": published("rules", TRIALS), "language_model": not_measured("language model")},
}
WINDOW = {"lanes": 2.0, "arms": 4.0, "curvature": 1.0, "length": 0.5, "connectivity": 1.2}


def test_rows_by_writer_and_suite_and_a_model_that_nobody_ran():
    told = section(Evidence({"map_suite": SUITE}))
    assert [table.name for table in told.tables] == ["map-suite", "map-suite-rules"]
    assert told.missing == ""
    texts = [[cell.text for cell in row.cells] for row in told.tables[0].rows]
    assert texts[0] == ["rules", "own", "2", "2", "1", "1", "1", "1", "0", "1", "0", "0", "0", "0", "0.500"]
    assert texts[1][:3] == ["rules", "held out", "0"]
    assert texts[1][-3:] == ["1", "1", "1.000"]
    assert texts[2][0] == "language model"
    assert set(texts[2][2:]) == {"not measured"}
    assert "7 of 9 roads as asked, 1 declined; 2 of 3 rightly refused" in told.tables[0].notes[0]
    assert [row.cells[0].text for row in told.tables[1].rows] == ["crossing", "hostile"]


def test_diversity_beside_a_source_that_is_not_there():
    found = {"radius": 150.0, "sources": {"maps from words": {"maps": 1.0, **summary([WINDOW, WINDOW])}, "Argoverse 2": None}}
    [table] = section(Evidence({"map_diversity": found})).tables
    assert [row.cells[0].text for row in table.rows] == ["maps from words", "Argoverse 2"]
    assert [cell.text for cell in table.rows[0].cells[:5]] == ["maps from words", "1", "2", "2.00", "0.00"]
    assert {cell.text for cell in table.rows[1].cells[1:]} == {"not measured"}
    assert all(len(row.cells) == len(table.columns) for row in table.rows)
