"""`drivegen export`: numbers that cannot be counted to."""

import sys

import pytest

from drivegen import cli


def test_more_than_can_be_counted_is_refused(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["drivegen", "export", "x", "--out", "o", "--most", "99999999999999999999999"])
    with pytest.raises(SystemExit) as left:
        cli.main()
    assert left.value.code == 2
    assert "'--most'" in capsys.readouterr().err
