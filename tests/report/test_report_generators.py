"""The section on generators to compare with."""

from drivegen.core.methods import read_methods
from drivegen.report.evidence import Curve, Evidence
from drivegen.report.sections.generators import section

LCTGEN = {
    "generator": "lctgen", "parameters": 321960, "train_examples": 600, "steps": 500, "validation_loss": 3.5,
    "validation_min_sade": 5.0, "validation_min_sfde": 12.0, "validation_mean_sade": 6.0, "validation_mean_sfde": 13.0,
    "lctgen_log_code.validation_min_sade": 3.0, "lctgen_log_code.validation_mean_sade": 4.0, "sampling_temperature": 0.7,
}  # fmt: skip
STEPS = [100.0, 200.0, 300.0, 400.0]


def made(losses: list[float], plateau: bool | None = True):
    return section(
        Evidence(
            methods=read_methods(),
            results={"train_generator/lctgen": LCTGEN | {"plateau": plateau}},
            curves=(Curve("train_generator/lctgen", {"step": STEPS, "train": losses, "validation": losses}),),
            costs={"train_generator/lctgen": {"training_cpu_seconds": 71.25}},
        )
    )


def test_parameters_errors_and_the_bound_stand_in_the_table():
    table, times = made([9.0, 4.0, 3.5, 3.5]).tables
    method, bound = ([cell.text for cell in row.cells] for row in table.rows)
    assert method[0] == "LCTGen"
    assert "5.00" in method
    assert "yes" in method
    assert method[table.columns.index("temperature")] == "0.7"
    assert "a bound" in bound[0]
    assert "3.00" in bound
    assert len(method) == len(bound) == len(table.columns)
    assert not times.repeatable
    assert times.rows[0].cells[1].text == "71.2"


def test_what_was_trained_elsewhere_says_so():
    [_, times] = section(Evidence(results={"train_generator/lctgen": LCTGEN}, methods=read_methods())).tables
    assert [cell.text for cell in times.rows[0].cells] == ["LCTGen", "not measured here: restored from cache"]


def test_what_still_gained_is_said_to_and_what_is_too_short_says_nothing():
    for plateau, word in ((False, "no"), (None, "\u2013")):
        table = made([9.0, 8.0, 7.0, 6.0], plateau).tables[0]
        assert table.rows[0].cells[table.columns.index("plateau")].text == word


def test_nothing_trained_says_so():
    assert "train_generator" in section(Evidence()).missing


def test_there_is_one_figure_for_each_curve():
    assert [figure.title for figure in made([9.0, 8.0, 7.0, 6.0]).figures] == ["Training: LCTGen"]
