"""The published table of error against diversity marks the settings that no other one beats."""

from dataclasses import replace

import numpy as np

from drivegen.core.intervals import Interval
from drivegen.core.methods import read_methods
from drivegen.report.published.front import front
from drivegen.report.published.results import DataSet, Results, Run

ABOUT = read_methods()


def results(error: float, diversity: float) -> Results:
    values = {metric: np.full((1, 2), error) for metric in ("min_sade", "min_sfde", "mean_sade", "mean_sfde")}
    return Results(("a", "b"), values, {"diversity": [Interval(diversity, np.nan, np.nan)]}, "learned")


def test_rows_on_the_front_are_bold_and_the_log_is_no_row():
    at = {0.5: results(2.0, 0.8), 0.7: results(2.5, 0.95), 1.0: results(3.0, 1.1)}
    pooled = {
        method: {
            **{metric: Interval(error, error, error) for metric in ("min_sade", "mean_sade")},
            "diversity": Interval(diversity, diversity, diversity),
        }
        for method, (error, diversity) in {"bits": (1.8, 0.6), "constant_velocity": (5.0, 0.9), "log": (0.0, 1.0)}.items()
    }
    data = DataSet("x", "some scenes", "", (Run(7, 7),), ABOUT, {method: results(1, 1) for method in pooled}, by_scene=False)
    table = front(data, at, pooled, 0.6)
    bold = {row.cells[0].text for row in table.rows if row.cells[0].best}
    assert bold == {"DriveGen, temperature 0.5", "DriveGen, temperature 0.7", "BITS"}
    assert "Log (recorded futures)" not in {row.cells[0].text for row in table.rows}


def test_the_temperature_in_use_is_named_and_those_that_are_beaten_stand_below_the_table():
    at = {0.5: results(2.0, 0.9), 1.5: results(4.0, 0.8)}
    pooled = {"drivegen": {"mean_sade": Interval(1.9, 1, 2), "diversity": Interval(0.95, 0.9, 1)}}
    data = DataSet("x", "some scenes", "", (Run(7, 7),), ABOUT, {"drivegen": results(1.9, 0.95)}, by_scene=False)
    table = front(data, at, pooled, 0.4)
    assert "DriveGen, temperature 0.4 (in use)" in {row.cells[0].text for row in table.rows}
    assert table.notes[-1].endswith("DriveGen at temperature 0.5; temperature 1.5.")
    assert table.picture.startswith(b"<?xml")
    assert "![Error against diversity: some scenes](front-x.svg)" in table.markdown()
    assert "temperature in use" in front(data, at, pooled, None).markdown()


def test_a_point_of_the_curve_is_of_the_first_training_seed():
    """So is its diversity; the mean of two seeds would be of no model that anybody has."""
    two = replace(results(2.0, 0.9), values={"mean_sade": np.array([[2.0, 2.0], [8.0, 8.0]])})
    data = DataSet("x", "some scenes", "", (Run(7, 7), Run(8, 7)), ABOUT, {"drivegen": two}, by_scene=False)
    table = front(data, {0.5: two}, {}, 0.4)
    assert "2.00" in [cell.text for row in table.rows for cell in row.cells]


def test_a_row_that_was_not_measured_is_not_said_to_be_beaten():
    pooled = {"drivegen": {"mean_sade": Interval(1.9, 1, 2)}}
    data = DataSet("x", "some scenes", "", (Run(7, 7),), ABOUT, {"drivegen": results(1.9, 0.95)}, by_scene=False)
    notes = front(data, {0.5: results(2.0, 0.9), 1.0: results(3.0, 0.8)}, pooled, 0.4).notes
    assert notes[-1].endswith("DriveGen at temperature 1.")
