"""Rows of published figures: columns of an interval, and groups in the order of the rows."""

import numpy as np

from drivegen.core.intervals import Interval
from drivegen.report.published.figures import as_columns, grouped

ROWS = [
    {"driver": "idm", "method": "cat", "metric": "counted", "value": 1.0},
    {"driver": "gail", "method": "cat", "metric": "counted", "value": 2.0},
    {"driver": "idm", "method": "cat", "metric": "kinds", "value": 3.0},
]


def test_what_is_not_finite_is_none():
    assert as_columns(Interval(1.0, np.nan, np.inf)) == {"value": 1.0, "low": None, "high": None}
    assert as_columns(Interval(1.0, 0.5, 2.0), ("a", "b", "c")) == {"a": 1.0, "b": 0.5, "c": 2.0}


def test_groups_come_as_their_first_rows_and_one_column_is_a_key_by_itself():
    several = grouped(ROWS, ("driver", "method"), ("metric",))
    assert list(several) == [("idm", "cat"), ("gail", "cat")]
    assert {metric: line["value"] for metric, line in several["idm", "cat"].items()} == {"counted": 1.0, "kinds": 3.0}
    assert list(grouped(ROWS, ("metric",), ("driver", "method"))["counted"]) == [("idm", "cat"), ("gail", "cat")]
