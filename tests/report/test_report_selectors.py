"""The table of goal selectors: the same columns for all, what was not run says so, who chose is told."""

from drivegen.core import plugins
from drivegen.goals.scores import METRICS
from drivegen.report.evidence import Evidence
from drivegen.report.sections import models

MOVING = dict.fromkeys((*METRICS, "calibration_error"), 0.5)
BOUNDS = {f"{name}{end}": value for name in MOVING for end, value in ((".low", 0.4), (".high", 0.6))}
ROW = {"described": "learned selector (imitates logs)", "moving": {"vehicles": 40.0, **MOVING, **BOUNDS}, "all": {}}
ASKING = {"vehicles": 50, "fallback": {"timeout": 3}, "label_bias": -0.21, "label_bias_by_chance": 0.04}


def rows(**goals):
    names = tuple(plugins.names("selectors", ("random", "prior", "learned")))
    results = {f"goals/{name}": value for name, value in goals.items()}
    table = models.selector(Evidence(results=results, selectors=names)).tables[0]
    assert all(len(row.cells) == len(table.columns) for row in table.rows)
    return {row.cells[0].text: dict(zip(table.columns, row.cells, strict=True)) for row in table.rows}


def test_every_score_is_a_column_with_its_interval_and_what_was_not_run_says_so():
    found = rows(learned=ROW)
    assert list(found) == ["random", "prior", "learned", "log", "vlm"]
    learned = found["learned"]
    assert learned["chosen by"].text == ROW["described"]
    assert learned["vehicles"].text == "40"
    assert {(learned[c].text, learned[c].note) for c in models.SCORES.values()} == {("0.50", "0.40\u20130.60")}
    assert learned["label bias"].text == "sees no numbers"
    assert {cell.text for name, cell in found["vlm"].items() if name != "selector"} == {"not measured"}


def test_a_model_tells_its_label_bias_and_for_whom_the_fallback_chose():
    asked = rows(vlm={**ROW, "described": "language model little", "asking": ASKING})["vlm"]
    assert asked["chosen by"].text == "language model little; learned selector for 3 of 50 without an answer"
    assert asked["label bias"].text == "-0.21"
    assert "0.04" in asked["label bias"].note
