"""The planners' table: groups of the same tracks with their anchors, what is under-trained is marked, times stay in the page."""

from dataclasses import replace

import pytest

from drivegen.report.evidence import Curve, Evidence
from drivegen.report.sections import planners

SCORES = {"scored_tracks": 600, "scored_scenes": 118, "steps": 800, "epochs": 30.0, "ade_best": 0.25, "base.ade_best": 0.9}
FEW = {**SCORES, "scored_tracks": 150, "scored_scenes": 16, "steps": 900, "epochs": 4.2, "base.ade_best": 0.8}
EVIDENCE = Evidence(
    planners=("route_fm", "poly_fm", "paper"),
    results={"train_planner/paper": FEW, "train_planner/poly_fm": SCORES, "train_planner/route_fm": SCORES | {"log.jerk": 0.5}},
    curves=(Curve("train_planner/poly_fm", {"step": [0.0, 400.0], "train": [2.0, 1.0], "ade": [float("nan"), 2.0]}),),
    costs={"train_planner/poly_fm": {"training_cpu_seconds": 40.0, "planning_cpu_seconds": 2.0, "planned": 6000.0}},
)  # fmt: skip


def test_planners_of_the_same_tracks_stand_together_before_their_anchors() -> None:
    table = planners.section(EVIDENCE).tables[0]
    names = [row.cells[0].text for row in table.rows]
    marked = "paper (under-trained: 900 steps, 4.2 of 90 epochs)"
    assert names == [marked, "no residual", "log", "poly_fm", "route_fm", "no residual", "log"]
    assert [row.cells[2].text for row in table.rows] == ["0.250", "0.800", "–", "0.250", "0.250", "0.900", "–"]
    assert table.rows[0].cells[-1].text == "150 of 16"
    assert table.repeatable


def test_times_are_rates_where_they_were_measured_and_do_not_go_to_the_files() -> None:
    table = planners.section(EVIDENCE).tables[1]
    rows = {row.cells[0].text: [cell.text for cell in row.cells[1:]] for row in table.rows}
    assert rows["poly_fm"][0] == "40"
    assert rows["poly_fm"][2].replace("\u202f", "") == "3000"
    assert rows["poly_fm"][1] == rows["poly_fm"][3] == "none"  # no GPU
    assert rows["route_fm"] == ["not measured here: restored from cache"] * 4
    assert not table.repeatable


def test_a_planner_that_was_not_trained_has_a_row_that_says_so() -> None:
    results = {"train_planner/route_fm": SCORES, "train_planner/other": SCORES}
    table = planners.section(replace(EVIDENCE, results=results)).tables[0]
    rows = {row.cells[0].text: {cell.text for cell in row.cells[1:]} for row in table.rows}
    assert rows["paper"] == rows["poly_fm"] == {"not measured"}
    assert "other" in rows
    assert {len(row.cells) for row in table.rows} == {len(table.columns)}


@pytest.mark.parametrize("costs", [EVIDENCE.costs, {}])
def test_errors_are_drawn_over_cost_and_over_steps_without_it(costs: dict[str, dict[str, float]]) -> None:
    figures = planners.section(replace(EVIDENCE, costs=costs)).figures
    assert [figure.title for figure in figures] == ["ADE over training cost", "Training: planner poly fm"]
    assert figures[0].data.startswith(b"<?xml")


def test_without_results_the_section_says_so() -> None:
    section = planners.section(Evidence())
    assert "train_planner" in section.missing
    assert not section.tables
