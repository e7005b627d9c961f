"""Plots: labels that would lie over one another."""

import pytest

from drivegen.report.plots import SERIES, apart, coloured, curves, front, lines, panels, shares, steps, two_kinds

LINE = 0.4


def test_labels_that_are_apart_stay_where_they_are():
    places = [(1.0, 2.0), (1.0, 3.0), (0.0, 2.1)]
    assert apart(places, near=0.5, line=LINE) == [2.0, 3.0, 2.1]


def test_labels_that_would_touch_are_raised_line_by_line_in_the_order_of_their_points():
    raised = apart([(1.0, 2.1), (1.1, 2.0), (0.9, 2.2)], near=0.5, line=LINE)
    assert raised == pytest.approx([2.4, 2.0, 2.8])


def test_no_two_near_labels_come_within_a_line_of_one_another():
    places = [(0.1 * (i % 3), (i * 37 % 11) / 10) for i in range(11)]
    raised = apart(places, near=0.15, line=LINE)
    for i, (x, _) in enumerate(places):
        for j in range(i):
            assert abs(places[j][0] - x) >= 0.15 or abs(raised[i] - raised[j]) >= LINE - 1e-9


def test_no_method_is_missing_from_the_front_however_many_there_are():
    points = {f"method {n}": (1.0, float(n)) for n in range(len(SERIES) + 1)}
    picture = front([("0.5", 0.9, 2.0)], points).decode()
    assert all(f"<!-- {name} -->" in picture for name in points)


MANY = [f"series {n}" for n in range(len(SERIES) + 2)]
LINE_OF = {name: ([0.0, 1.0], [1.0, 2.0]) for name in MANY}


@pytest.mark.parametrize(
    "picture",
    [
        curves({"step": [0.0, 1.0], **{name: [1.0, 2.0] for name in MANY}}, "step"),
        lines(LINE_OF, "x", "y"),
        panels({"group": LINE_OF}, "x", "y"),
        shares({name: [1.0, 2.0] for name in MANY}, "x"),
        two_kinds(dict(list(LINE_OF.items())[:2]), dict(list(LINE_OF.items())[2:]), "x", "y"),
        steps({name: {"0": (1.0, 0.5, 2.0), "4": (0.5, 0.2, 1.0)} for name in MANY}, "x", "y"),
    ],
    ids=["curves", "lines", "panels", "shares", "two kinds", "steps"],
)
def test_no_line_is_missing_where_there_are_more_than_colours(picture: bytes):
    assert [name for name in MANY if f"<!-- {name} -->" not in picture.decode()] == []


def test_colours_come_again_in_their_order():
    assert [colour for _, colour in coloured(range(5), ("a", "b"))] == ["a", "b", "a", "b", "a"]


def test_a_line_has_one_colour_in_all_panels_and_a_name_in_the_first_that_has_it():
    line = ([0.0, 1.0], [1.0, 2.0])
    picture = panels({"one": {"seed 8": line}, "two": {"seed 7": line, "seed 8": line}}, "x", "y").decode()
    drawn = [part for part in picture.split("<path ") if "stroke-width: 1.2" in part]
    shown = [next(colour for colour in SERIES if colour in part) for part in drawn]
    assert shown == [SERIES[0], SERIES[0], SERIES[1], SERIES[0], SERIES[1]]  # a line and its legend, two lines and one legend
    assert [picture.count(f"<!-- seed {seed} -->") for seed in (7, 8)] == [1, 1]
