"""`drivegen view` of what `drivegen corner` wrote: a folder a kind, with a recording beside the scenario."""

import sys
from pathlib import Path

import pytest

from drivegen import cli
from drivegen.av2.export import export_scenario
from drivegen.cli import view
from tests import scenes


@pytest.fixture
def kinds(tmp_path, monkeypatch) -> Path:
    road = scenes.straight_road()
    log = scenes.stack([scenes.drive(road.centreline[0], 20.0, 8.0, 101)])
    for kind in ("cut-in", "standing"):
        export_scenario(scenes.scenario(road, log), log, tmp_path / "out" / kind, kind)
        (tmp_path / "out" / kind / "recording.rrd").write_bytes(b"RRF2")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(view, "_has_screen", lambda: False)
    return tmp_path / "out"


def call(monkeypatch, *words) -> int:
    monkeypatch.setattr(sys, "argv", ["drivegen", "view", *words])
    with pytest.raises(SystemExit) as left:
        cli.main()
    return left.value.code or 0


def test_the_recording_beside_a_kind_s_scenario_is_shown(kinds, monkeypatch, capsys):
    assert call(monkeypatch, "out/cut-in") == 0
    assert capsys.readouterr().out.startswith("out/cut-in/recording.rrd: look at it with")
    assert call(monkeypatch, "out/cut-in", "--out", "plain.rrd") == 0  # one of the scenario itself
    assert (kinds.parent / "plain.rrd").stat().st_size > 1000


def test_kinds_are_listed_and_the_only_one_is_taken(kinds, monkeypatch, capsys):
    assert call(monkeypatch, "out") == 2
    said = capsys.readouterr().err
    assert "\n  drivegen view out/cut-in\n  drivegen view out/standing\n" in said
    (kinds / "standing").rename(kinds.parent / "standing")
    assert call(monkeypatch, "out") == 0
    assert capsys.readouterr().out.startswith("out/cut-in/recording.rrd: look at it with")


def test_what_is_no_scenario_here_may_be_one_in_the_project_s_folder(kinds, monkeypatch, capsys):
    assert call(monkeypatch, "town:7") == 2
    assert "give a scenario's folder or, in the project's, its id" in capsys.readouterr().err
