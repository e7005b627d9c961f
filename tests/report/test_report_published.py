"""Published tables beside the errors: who is best in what, what was trained for how long, what generating costs, goals."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.core.intervals import Interval
from drivegen.core.methods import read_methods
from drivegen.core.seeds import rng
from drivegen.report.published.additions import added
from drivegen.report.published.best import best
from drivegen.report.published.costs import costs
from drivegen.report.published.goals import goals
from drivegen.report.published.index import index
from drivegen.report.published.quality import cell, few, tables, training
from drivegen.report.published.results import DataSet, Results, Run, pool, rows, set_numbers
from drivegen.report.published.training import Trained, models
from drivegen.report.table import Cell, Table
from drivegen.warehouse.runs import Model

ABOUT = read_methods()
SELECTORS = ("random", "prior", "learned", "vlm", "log")
SCENES = tuple(f"rec{n}-000" for n in range(8))


def results(distance: float, **values: float) -> Results:
    """One seed; every scene has the value, and all errors are the one that is given."""
    values |= dict.fromkeys(("min_sfde", "mean_sade", "mean_sfde"), values["min_sade"])
    of_scenes = {name: np.full((1, len(SCENES)), value) for name, value in values.items()}
    return Results(SCENES, of_scenes, {"distance.speed": [Interval(distance, np.nan, np.nan)]}, "none")


def data_set(**changes: object) -> DataSet:
    methods = {
        "drivegen": results(0.5, min_sade=1.0, nll_1s=2.0, realism=0.7, energy_final=1.0, rejected=0.3),
        "bits": results(0.4, min_sade=2.0, nll_1s=1.0, realism=0.7, energy_final=1.5, rejected=0.0),
        "trafficgen": results(0.6, min_sade=3.0, nll_1s=5.0, realism=0.2, energy_final=0.5, rejected=0.0),
        "log": results(0.0, min_sade=0.0, nll_1s=0.0, realism=0.9, energy_final=0.0, rejected=0.0),
    }
    return DataSet(**{
        "name": "x", "title": "some scenes", "trained_on": "", "runs": (Run(7, 7),), "about": ABOUT, "methods": methods,
        "by_scene": False, **changes,
    })  # fmt: skip


def pooled_of(data: DataSet):
    return pool(data, 50, rng(7, "pool"))


def test_losses_stand_beside_wins_and_the_log_does_not_compete():
    data = data_set()
    [table] = best(data, pooled_of(data), 50, rng(7, "best"))
    found = {row.cells[0].text: [cell.text for cell in row.cells[1:]] for row in table.rows}
    assert found["min-sADE [m]"] == ["1.000", "BITS", "2.000", "-1.000", "better"]
    assert found["NLL at 1 s"] == ["2.000", "BITS", "1.000", "+1.000", "worse"]
    assert found["realism: score"][-1] == "level"
    assert found["energy score at the end [m]"][1:] == ["TrafficGen", "0.500", "+0.500", "worse"]
    assert found["distance: speed [m/s]"][-2:] == ["not paired", "behind"]
    assert table.notes[0].startswith("Of 8 measures: behind 1, better 4, level 1, worse 2.")
    assert "(errors: 4, likelihoods: 1)" in table.notes[-1]


def with_scenes(results: Results, metric: str, *values: float) -> Results:
    return replace(results, values={**results.values, metric: np.array([values])})


def test_who_is_better_is_said_by_the_pairs_and_not_by_means_over_other_scenes():
    """DriveGen is worse wherever both have the measure; the other one's mean has bad scenes that DriveGen lacks."""
    data, nan = data_set(), np.nan
    methods = {
        "drivegen": with_scenes(data.methods["drivegen"], "nll_1s", 2, 2, 2, 2, nan, nan, nan, nan),
        "bits": with_scenes(data.methods["bits"], "nll_1s", 1, 1, 1, 1, 9, 9, 9, 9),
    }
    methods["drivegen"] = with_scenes(methods["drivegen"], "realism", *[0.5] * 4, *[nan] * 4)
    methods["bits"] = with_scenes(methods["bits"], "realism", *[0.6] * 4, *[0.1] * 4)
    data = replace(data, methods=methods)
    [table] = best(data, pooled_of(data), 50, rng(7, "best"))
    found = {row.cells[0].text: [cell.text for cell in row.cells[1:]] for row in table.rows}
    assert found["NLL at 1 s"] == ["2.000", "BITS", "5.000", "+1.000", "worse"]
    assert found["realism: score"] == ["0.500", "BITS", "0.350", "-0.100", "worse"]


def test_what_drivegen_has_no_number_of_is_no_row_and_no_row_is_no_table():
    data = data_set()
    methods = {**data.methods, "drivegen": with_scenes(data.methods["drivegen"], "nll_1s", *[np.nan] * 8)}
    data = replace(data, methods=methods)
    [table] = best(data, pooled_of(data), 50, rng(7, "best"))
    assert "NLL at 1 s" not in {row.cells[0].text for row in table.rows}
    assert "nan" not in table.markdown()
    alone = replace(data, methods={"drivegen": methods["drivegen"]})
    assert best(alone, pooled_of(alone), 50, rng(7, "best")) == []


@pytest.mark.parametrize("recordings", [1, 4])
def test_without_an_interval_nobody_is_better_or_worse(recordings: int):
    data = data_set()
    few = tuple(f"rec{n % recordings}-00{n}" for n in range(8))
    data = replace(data, methods={name: replace(found, scenarios=few) for name, found in data.methods.items()})
    [table] = best(data, pooled_of(data), 50, rng(7, "best"))
    assert {row.cells[-1].text for row in table.rows} == {"ahead", "behind", "level"}
    assert "or there is no interval" in table.notes[0]


def test_the_errors_of_who_learnt_from_more_stand_less_those_of_who_learnt_from_less():
    less, more = data_set(), data_set(name="y", methods={"drivegen": results(0.5, min_sade=0.75)})
    table = training(less, more, 50, rng(7, "training"))
    found = {row.cells[0].text: [cell.text for cell in row.cells[1:4]] for row in table.rows}
    assert found == {"DriveGen": ["1.00", "0.75", "-0.25"]}


def test_only_who_plans_with_a_checker_has_a_share_of_rejected():
    data = data_set()
    table = next(t for t in tables(data, pooled_of(data), 50, rng(7, "paired")) if t.name == "boxes-x")
    last = {row.cells[0].text: row.cells[-1].text for row in table.rows}
    assert (last["DriveGen"], last["BITS"]) == ("0.300", "\u2013")


def test_what_only_a_whole_set_has_comes_with_the_shuffles():
    found = set_numbers(
        {"joint.order": 0.9, "joint.order.low": 0.8, "joint.order.high": 1.0, "shuffled.headway": 0.4, "auc": None}
    )
    assert found["joint.order"] == Interval(0.9, 0.8, 1.0)
    assert found["shuffled.headway"].value == 0.4
    assert "auc" not in found


def test_an_interval_that_is_null_is_none():
    """JSON has no NaN: what is of one recording has ends that are null."""
    found = set_numbers({"distance.speed": 0.5, "distance.speed.low": None, "distance.speed.high": None})
    assert found["distance.speed"].value == 0.5
    assert np.isnan([found["distance.speed"].low, found["distance.speed"].high]).all()
    run = {"moving": {"vehicles": 9.0, "nll": 2.0, "nll.low": None, "nll.high": None, "hit_1": None}}
    table = goals("x", "some scenes", SELECTORS, {"learned": [run]})
    [line] = [row for row in table.rows if row.cells[0].text == "learned"]
    assert (line.cells[table.columns.index("NLL [nat]")].text, line.cells[table.columns.index("NLL [nat]")].note) == ("2.00", "")


def test_a_figure_in_which_no_recording_differs_has_no_ends():
    """A share of 0 in all recordings says nothing of how small it is: "0.000 (0.000 to 0.000)" would."""
    assert cell(Interval(0.0, 0.0, 0.0), 3) == Cell("0.000")
    assert cell(Interval(0.5, 0.25, 0.75)) == Cell("0.50", "0.25 to 0.75")
    assert cell(Interval(0.5, np.nan, np.nan)) == Cell("0.50")


def test_additions_in_one_recording_have_a_difference_without_ends():
    one = tuple(f"rec-00{n}" for n in range(8))
    plain, safer = (replace(results(0.5, min_sade=error), scenarios=one) for error in (2.0, 2.5))
    shares = np.array([[0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8]])
    plain, safer = (
        replace(each, values={**each.values, "collision_per_vehicle": shares * of, "illegal_per_vehicle": shares * of})
        for each, of in ((plain, 1.0), (safer, 0.5))
    )
    data = data_set(methods={"bits": plain}, added={"bits/none": plain, "bits/checker": safer})
    [table] = added(data, pooled_of(data), 50, rng(7, "added"))
    assert "nan" not in table.markdown()
    assert table.rows[-1].cells[5] == Cell("0.225", "-0.225")


def test_few_scenes_are_said_to_be_few_under_every_table():
    data = data_set(by_scene=True)
    found = few(data, tables(data, pooled_of(data), 50, rng(7, "paired")))
    assert {table.notes[-1].startswith("So few scenes") for table in found} == {True}
    assert few(data_set(), found) == found


def curve(*losses: float) -> dict[str, list[float]]:
    return {"step": [100.0 * (n + 1) for n in range(len(losses))], "validation": list(losses)}


def trained(
    name: str, parameters: int, seconds: float, seed: int = 7, plateau: bool | None = True, temperature: float | None = None
) -> Trained:
    took = {"cpu_seconds": seconds, "training_cpu_seconds": seconds - 10} if seconds else {}
    return Trained("toys", seed, Model(name, parameters, curve(9.0, 4.0, 3.5, 3.5), took, plateau, temperature))


def test_models_stand_with_size_time_and_whether_each_seed_is_at_its_plateau():
    found = [trained(name, 100, 60.0) for name in ("train_planner/route_fm", "train_selector/train_selector")]
    found += [trained("train_generator/bits", 7, 100.0, 7, True, 0.5), trained("train_generator/bits", 7, 120.0, 8, False, 0.7)]
    [table] = models(found, ABOUT)
    rows = {row.cells[0].text: [cell.text for cell in row.cells[1:]] for row in table.rows}
    assert rows["BITS"] == ["7", "400", "100, 120", "90, 110", "yes, no", "0.5, 0.7"]
    assert rows["DriveGen, together"][:3] == ["200", "\u2013", "120"]
    assert list(rows)[:3] == ["DriveGen: planner", "DriveGen: goal selector", "DriveGen, together"]
    assert any(
        "whole stages took 100 to 120 CPU-seconds for a rival that learns traffic, and 120 for" in note for note in table.notes
    )
    assert table.picture.startswith(b"<?xml")
    [table] = models([replace(one, lists=30.0) if one.seed == 7 else one for one in found], ABOUT)
    assert any("models together, after 30 once for the goal lists, which all seeds share." in note for note in table.notes)


def test_what_nobody_timed_says_so_and_gives_no_budget():
    [table] = models([trained("train_generator/bits", 7, 0.0)], ABOUT)
    assert table.rows[0].cells[3].text == "not measured here: restored from cache"
    assert not any("Budget" in note for note in table.notes)


def test_a_thousand_scenarios_cost_what_both_of_drivegens_stages_took():
    run = {
        "rollout/drivegen": {"cpu_seconds": 0.8, "peak_megabytes": 900.0},
        "goals/learned": {"cpu_seconds": 0.4, "peak_megabytes": 1000.0},
        "rollout_rival/bits": {"cpu_seconds": 1.6, "peak_megabytes": 500.0},
    }
    dearer = {**run, "rollout_rival/bits": {"cpu_seconds": 3.2, "peak_megabytes": 500.0}}
    rows = {row.cells[0].text: [cell.text for cell in row.cells[1:]] for row in costs(data_set(), [run, dearer], 10).rows}
    assert rows["DriveGen"] == ["150 (150 to 150)", "50 (50 to 50)", "1\u202f000 (1\u202f000 to 1\u202f000)"]
    assert rows["BITS"] == ["300 (200 to 400)", "\u2013", "500 (500 to 500)"]
    assert rows["TrafficGen"][0] == "not measured here: restored from cache"


def test_scenes_that_are_not_averaged_cost_all_the_same_and_what_ran_once_has_no_range():
    run = {"rollout_rival/bits": {"cpu_seconds": 1.6, "peak_megabytes": 500.0}}
    others = {"bits": replace(results(0.4, min_sade=1.0), scenarios=("a-000", "b-000"))}
    table = costs(data_set(left_out=others), [run, {}], 6)
    [line] = [row for row in table.rows if row.cells[0].text == "BITS"]
    assert line.cells[1].text == "160"  # of 8 and 2
    assert table.notes[0].startswith(
        "6 samples of each of 10 scenarios, mean and range over the runs in which the stage ran, of 2;"
    )


def test_goals_of_all_seeds_are_one_row_and_selectors_that_did_not_run_are_named():
    seeds = [
        {"described": "learned one", "moving": {"vehicles": 9.0, "nll": nll, "nll.low": nll - 1, "nll.high": nll + 1}}
        for nll in (2.0, 4.0)
    ]
    table = goals("x", "some scenes", SELECTORS, {"learned": seeds})
    rows = {row.cells[0].text: row.cells for row in table.rows}
    column = table.columns.index("NLL [nat]")
    assert (rows["learned"][column].text, rows["learned"][column].note) == ("3.00", "1.00 to 5.00")
    assert rows["vlm"][1].text == "not measured"
    assert "worse than choosing at random" not in table.notes[-1]


def test_where_no_vehicle_moves_goals_are_not_measured():
    still = [{"moving": {"vehicles": 0.0, "left_out": 0.0}}]
    table = goals("x", "some scenes", SELECTORS, {"learned": still, "random": still})
    assert {cell.text for cell in table.rows[0].cells[3:]} == {"not measured"}
    assert "worse than choosing at random" not in table.notes[-1]


def test_a_selector_that_is_worse_than_chance_is_said_to_be():
    found = {name: [{"moving": {"vehicles": 9.0, "nll": nll}}] for name, nll in (("learned", 4.0), ("random", 3.5), ("log", 0.1))}
    notes = goals("x", "some scenes", SELECTORS, found).notes
    assert notes[-1] == "In NLL the selector learned is worse than choosing at random: 4.00 against 3.50 nat."
    assert sum("worse than choosing at random" in note for note in notes) == 1


@pytest.mark.parametrize(
    ("missing", "said"), [([], "From all 1 runs"), (["x/8"], "INCOMPLETE: from 1 of 2 runs; not there: x/8.")]
)
def test_the_table_of_contents_goes_by_data_set(missing: list[str], said: str):
    data = data_set()
    found = [*tables(data, pooled_of(data), 50, rng(7, "paired")), *models([trained("train_generator/bits", 7, 1.0)], ABOUT)]
    paired = Table("paired-drivegen_vlm-x", "DriveGen by a model less the others, paired: some scenes", (), ())
    codes = [{"commit": "1a2b", "changed": False, "runs": []}, {"commit": "3c4d", "changed": True, "runs": []}]
    text = index([*found, paired], {"x": "some scenes"}, {"runs": {"x/7": "1"}, "runs_missing": missing, "code": codes})
    assert said in text
    assert "Of code 1a2b, 3c4d and uncommitted changes. A run is" in text
    assert text.index("paired-drivegen_vlm-x.md") < text.index("## Across data sets")
    assert (
        text.index("## some scenes")
        < text.index("(quality-x.md)")
        < text.index("## Across data sets")
        < text.index("models-toys")
    )


def test_what_an_addition_is_worth_stands_beside_what_it_changes():
    plain, safer = (
        results(0.5, min_sade=error, collision_per_vehicle=share, illegal_per_vehicle=share)
        for error, share in ((2.0, 0.4), (2.5, 0.1))
    )
    data = data_set(added={"bits/none": plain, "bits/checker": safer})
    pooled = pooled_of(data)
    [table] = added(data, pooled, 50, rng(7, "added"))
    lines = {row.cells[0].text: row.cells for row in table.rows}
    assert list(lines) == [
        "DriveGen, its own exclusion + checker + tempo",
        "BITS, as it is",
        "BITS, + checker",
        "Log (recorded futures)",
    ]
    assert (lines["BITS, + checker"][5].text, lines["BITS, + checker"][5].note) == ("0.100", "-0.300")
    told = {(row["method"], tuple(row["additions"]), row["metric"]): row["value"] for row in rows(data, pooled)}
    assert (told["bits", (), "min_sade"], told["bits", ("checker",), "min_sade"]) == (2.0, 2.5)
    assert added(data_set(), pooled, 50, rng(7, "added")) == []
