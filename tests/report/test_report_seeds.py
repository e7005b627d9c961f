"""Rows of several seeds become one."""

import pytest

from drivegen.report.published.seeds import estimate_of, over_seeds


def test_ends_are_those_of_all_seeds_that_have_a_value_or_none():
    whole = {"value": pytest.approx(0.6), "low": pytest.approx(0.5), "high": pytest.approx(0.7), "seeds": 2}
    assert estimate_of([[0.5, 0.4, 0.6], [0.7, 0.6, 0.8], [None, None, None]]) == whole
    without = estimate_of([[0.5, 0.4, 0.6], [1.0, None, None], [float("nan"), None, None]])
    assert without == {"value": 0.75, "low": None, "high": None, "seeds": 2}
    assert estimate_of([[None, None, None]]) == {"value": None, "low": None, "high": None, "seeds": 0}


def test_a_row_that_the_first_seed_lacks_is_there():
    ends = {"value": 0.5, "low": 0.4, "high": 0.6}
    one, other = {"method": "cat", **ends, "n": 3}, {"method": "random", **ends, "n": 4}
    rows = list(over_seeds("corpus", [[one], [{**one, "value": 0.7, "n": 9}, other]]))
    assert [(row["method"], row["n"], row["seeds"]) for row in rows] == [("cat", 3, 2), ("random", 4, 1)]
    assert rows[0]["value"] == pytest.approx(0.6)
    assert list(over_seeds("corpus", [[other]])) == [{"data": "corpus", **other, "seeds": 1}]
