"""Tables: numbers as they are read, Markdown, and tables from any JSON."""

import pytest

from drivegen.report.sections._generic import tables
from drivegen.report.table import NOT_MEASURED, Cell, Table, decimals, estimate, measured, number, row


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.5, "0.50"),
        (0.0, "0.00"),
        (0.00123, "0.0012"),
        (192000, "192\u202f000"),
        (192000.0, "192\u202f000"),
        (True, "yes"),
        ("words", "words"),
        (None, NOT_MEASURED),
        (float("nan"), NOT_MEASURED),
    ],
)
def test_numbers_as_they_are_read(value, text):
    assert number(value) == text


def test_a_measured_number_carries_its_interval():
    assert measured({"x": 1.0, "x.low": 0.5, "x.high": 1.25}, "x") == Cell("1.00", "0.50\u20131.25")
    assert measured({"x": 1}, "x") == Cell("1.00")
    assert measured({}, "x") == Cell(NOT_MEASURED)


def test_ends_of_a_small_number_are_as_exact_as_the_number():
    assert measured({"x": 0.0042, "x.low": 0.0011, "x.high": 0.0048}, "x") == Cell("0.0042", "0.0011\u20130.0048")


def test_an_interval_that_begins_below_zero_has_no_two_dashes():
    assert measured({"x": 0.5, "x.low": -0.25, "x.high": 1.0}, "x").note == "-0.25 to 1.00"


def test_markdown_has_a_header_aligned_rows_and_notes():
    table = Table("t", "Title", ("", "a|b"), (row("x", Cell("1", "0\u20132", best=True)),), ("A note.",))
    assert table.markdown().splitlines() == [
        "### Title",
        "",
        "|  | a\\|b |",
        "| --- | ---: |",
        "| x | **1** (0\u20132) |",
        "",
        "A note.",
    ]


def test_scalars_become_one_table_and_mappings_of_mappings_a_matrix():
    found = tables(
        "s", "Stage", {"steps": 3, "by_kind": {"car": {"n": 1, "n.low": 0}, "bus": {"size": 12.5}}, "counts": {"a": 1}}
    )
    assert [(table.name, table.title) for table in found] == [
        ("s", "Stage"),
        ("s-by-kind", "Stage: by kind"),
        ("s-counts", "Stage: counts"),
    ]
    assert found[1].columns == ("", "n", "size")
    assert [cell.text for cell in found[1].rows[1].cells] == ["bus", "\u2013", "12.500"]


def test_lists_of_mappings_become_a_matrix_too():
    (found,) = tables("s", "Stage", [{"name": "a", "ok": True}, {"name": "b", "ok": False}])
    assert [[cell.text for cell in line.cells] for line in found.rows] == [["a", "yes"], ["b", "no"]]


def test_lists_of_words_are_one_cell():
    (found,) = tables("s", "Stage", {"rows": [{"ignored": ["red", "blue"], "n": 1}, {"ignored": [], "n": 2}]})
    assert [[cell.text for cell in line.cells] for line in found.rows] == [["1", "red, blue", "1"], ["2", "", "2"]]


def test_nothing_gives_no_table():
    assert tables("s", "Stage", None) == tables("s", "Stage", {}) == ()


def test_deeper_nesting_becomes_tables_of_its_own():
    counts = {"splits": {"train": {"corpus": {"accepted": 600}}, "test": {"corpus": {"accepted": 120, "truncated": 1}}}}
    found = tables("data", "Scenarios", {"trained_on": "the corpus", **counts})
    assert [table.name for table in found] == ["data", "data-splits-train", "data-splits-test"]
    assert found[2].columns == ("", "accepted", "truncated")
    assert [cell.text for cell in found[2].rows[0].cells] == ["corpus", "120", "1"]


@pytest.mark.parametrize(
    ("value", "sign", "text"),
    [
        (0.0123, "", "0.012"),
        (0.00012, "", "0.00012"),
        (-0.00012, "+", "-0.00012"),
        (-0.0007, "", "-0.001"),
        (-3e-17, "", "0.000"),
        (-0.0, "+", "+0.000"),
    ],
)
def test_a_number_on_one_side_of_zero_is_not_rounded_to_it(value, sign, text):
    assert decimals(value, 3, sign) == text


def test_an_interval_beside_zero_is_not_shown_as_one_that_holds_it():
    assert estimate({"value": 0.218, "low": 0.00021, "high": 0.402}) == Cell("0.218", "0.00021 to 0.402")
    assert measured({"x": 0.25, "x.low": 0.0004, "x.high": 0.5}, "x") == Cell("0.25", "0.0004\u20130.50")
