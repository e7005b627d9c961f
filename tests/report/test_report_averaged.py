"""What published figures are of: scenes of one length, over recordings; who is marked; orders with and without anchors."""

from dataclasses import replace

import numpy as np

from drivegen.core.intervals import Interval
from drivegen.core.methods import read_methods
from drivegen.core.seeds import rng
from drivegen.report.averaged import scenes_and_recordings, taken_over, vehicles_over
from drivegen.report.columns import mark
from drivegen.report.published.quality import tables, transfer
from drivegen.report.published.results import DataSet, Results, Run, pool, rows, split

ABOUT = read_methods()
SCENES = ("USA_Lanker-2_10_T-1-000", "USA_Lanker-2_10_T-1-001", "USA_US101-12_1_T-1-000", "USA_US101-12_1_T-1-001")
CAUTION = ", which are few: they hold less than 95 %, about 50 %"
FLOOR = {"min_sade": 2.0, "mean_sade": 2.0}


def results(error: float, steps: tuple[float, ...] = (101, 101, 101, 50)) -> Results:
    """One seed; the scenes' errors are `error` times 1, 2, 3 and 100."""
    values = dict.fromkeys(("min_sade", "min_sfde", "mean_sade", "mean_sfde"), error * np.array([[1.0, 2, 3, 100]]))
    return Results(SCENES, {**values, "steps": np.array([steps])}, {}, "none")


def data_set(**changes: object) -> DataSet:
    averaged, left_out = split({"drivegen": results(1.0), "idm": results(2.0)})
    data = DataSet("x", "some scenes", "", (Run(7, 7),), ABOUT, averaged, by_scene=False, left_out=left_out)
    return replace(data, **changes)


BEHIND = ", not better than constant velocity in the mean"


def test_scenes_of_another_length_are_left_out_of_means_and_shown_one_by_one():
    data = data_set()
    pooled = pool(data, 50, rng(7, "pool"))
    assert pooled["drivegen"]["mean_sade"].value == 2.0
    assert {row["n"] for row in rows(data, pooled)} == {3}
    assert "steps" not in {row["metric"] for row in rows(data, pooled)}
    *means, scenes = tables(data, pooled, 50, rng(7, "paired"))
    assert [[cell.text for cell in row.cells] for row in scenes.rows] == [
        ["USA_US101-12_1_T-1-001 (4.9 s)", "100.00 / 100.00", "200.00 / 200.00"]
    ]
    said = f"Means are over 3 scenes of 10 s, intervals (95 %) over their 2 recordings{CAUTION}."
    assert {table.notes[0] for table in means} == {f"{said} Scenes of another length are not averaged with them: 1 of 4.9 s."}
    few = tables(replace(data, by_scene=True), pooled, 50, rng(7, "paired"))[-1]
    assert len(few.rows) == 4


def test_scenes_of_one_length_are_all_averaged_and_nothing_is_left_out():
    averaged, left_out = split({"drivegen": results(1.0, (81, 81, 81, 81))})
    assert (averaged["drivegen"].scenarios, left_out) == (SCENES, {})
    data = data_set(methods=averaged, left_out=left_out)
    assert data.over == f"Means are over 4 scenes of 8 s, intervals (95 %) over their 2 recordings{CAUTION}."
    assert tables(data, pool(data, 50, rng(7, "pool")), 50, rng(7, "paired"))[-1].name == "boxes-x"


def test_notes_say_what_they_know():
    assert scenes_and_recordings(3, 1, None, {}) == "Means are over 3 scenes, all of one recording, which gives no intervals."
    assert taken_over(
        {"log": {}, "idm": {"scenarios": 5, "recordings": 2, "steps": 111, "left_out.51": 2, "left_out.81": 1}}
    ) == (
        f"Means are over 5 scenes of 11 s, intervals (95 %) over their 2 recordings{CAUTION}. "
        "Scenes of another length are not averaged with them: 2 of 5 s and 1 of 8 s.",
    )
    assert vehicles_over({"recordings": 20.0, "left_out": 3.0}) == (
        "Intervals (95 %) are over 20 recordings. Vehicles of scenes of another length are not averaged with these: 3.",
    )
    assert taken_over({}) == vehicles_over({"vehicles": 3.0}) == ()


def test_who_beats_constant_velocity_by_the_best_of_ten_alone_has_a_mark_of_its_own():
    assert mark("bits", ABOUT["bits"], {"min_sade": 2.0, "mean_sade": 3.0}, FLOOR) == ", under-trained"
    assert mark("bits", ABOUT["bits"], {"min_sade": 1.9, "mean_sade": 2.0}, FLOOR) == BEHIND
    assert mark("bits", ABOUT["bits"], {"min_sade": 1.9, "mean_sade": 1.9}, FLOOR) == ""
    assert mark("drivegen", ABOUT["drivegen"], {"min_sade": 2.5, "mean_sade": 2.5}, FLOOR) == BEHIND
    assert (
        mark("constant_velocity", ABOUT["constant_velocity"], FLOOR, FLOOR)
        == mark("random_agent", ABOUT["random_agent"], {"mean_sade": 9.0}, FLOOR)
        == ""
    )
    assert mark("bits", ABOUT["bits"], {"min_sade": 2.0}, {}) == mark("bits", ABOUT["bits"], {}, FLOOR) == ""


def test_orders_are_compared_with_and_without_anchors():
    one = {"drivegen": 1.0, "bits": 2.0, "idm": 3.0, "drivegen_without_goals": 8.0, "random_agent": 9.0, "log": 0.0}
    other = {**one, "drivegen": 3.0, "idm": 1.0}
    pooled = [{m: {"min_sade": Interval(v, np.nan, np.nan)} for m, v in values.items()} for values in (one, other)]
    [found] = [row for row in transfer(data_set(), pooled[0], data_set(), pooled[1]).rows if row.cells[0].text == "min-sADE"]
    assert [cell.text for cell in found.cells[1:]] == ["0.60", "5", "-1.00", "3"]  # 1 - 6 * 8 / (5 * 24); turned round
