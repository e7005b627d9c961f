"""`drivegen view` of what `drivegen corner` wrote: a folder a kind, with a recording beside the scenario."""

import shlex
import sys
from pathlib import Path

import pytest

from drivegen import cli
from drivegen.av2.export import export_scenario
from drivegen.cli import view
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import write_shard
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


def test_scenarios_of_shards_are_listed_by_what_views_them(kinds, monkeypatch, capsys):
    road = scenes.straight_road()
    log = scenes.stack([scenes.drive(road.centreline[0], 20.0, 8.0, 101)])
    scene = scenes.scenario(road, log, "town:7")
    for place in ("data/shipped", "data/beset"):
        write_shard(kinds.parent / place / "shard-00000.parquet", [scene])
    write_samples(kinds.parent / "data/my futures/shard-00000.parquet", [scenes.noisy_samples(scene, 2)])
    for folder, words in {"data/shipped": "town:7", "data/my futures": "town:7-s00 --futures 'data/my futures'"}.items():
        assert call(monkeypatch, folder) == 2
        assert capsys.readouterr().err.endswith(f"{folder} holds 1 scenario, view one of them:\n  drivegen view {words}\n")
        assert call(monkeypatch, *shlex.split(words), "--out", "made.rrd") == 0
        capsys.readouterr()
    (kinds.parent / "data/my futures").rename(kinds.parent / "samples")
    (kinds.parent / "driven").mkdir()  # as in a round of corner cases
    assert call(monkeypatch, ".") == 2
    assert capsys.readouterr().err.endswith("\n  drivegen view town:7-s00 --futures samples\n")
    assert call(monkeypatch, "data/beset") == 2
    assert "data/beset holds shards: `drivegen export` makes folders of them" in capsys.readouterr().err
    assert call(monkeypatch, "data") == 2
    assert "data holds neither a scenario nor a sensor log nor a recording: give" in capsys.readouterr().err


def test_a_recording_is_not_written_again(kinds, monkeypatch, capsys):
    assert call(monkeypatch, "out/cut-in/recording.rrd", "--out", "other.rrd") == 2
    assert "is a recording already" in capsys.readouterr().err


def test_what_is_no_scenario_here_may_be_one_in_the_project_s_folder(kinds, monkeypatch, capsys):
    assert call(monkeypatch, "town:7") == 2
    assert "give a scenario's folder or, in the project's, its id" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("empty.rrd",), "empty.rrd is no recording, or was cut off: give a scenario's folder"),
        (("text.rrd",), "text.rrd is no recording"),
        (("nowhere.rrd",), "nowhere.rrd is not there: give a recording that is"),
        (("data/shipped/shard-00000.parquet",), "shard-00000.parquet is a file and no recording (.rrd): give one or a folder"),
        (("town:7", "--futures", "wrong"), "wrong is no folder: --futures names that of the futures"),
        (("town:7-s00",), "town:7-s00 is a future, and data/generated/drivegen is not there: name the folder"),
        (("town:7-s05", "--futures", "made"), "made has no number 05 of town:7, `drivegen view made` lists what it has"),
        (("village:1-s00",), "village:1-s00 is no folder, and no scenario in data/shipped"),
    ],
)
def test_what_is_not_there_is_said_with_its_place(kinds, monkeypatch, capsys, words, sentence):
    road = scenes.straight_road()
    log = scenes.stack([scenes.drive(road.centreline[0], 20.0, 8.0, 101)])
    scene = scenes.scenario(road, log, "town:7")
    write_shard(kinds.parent / "data/shipped/shard-00000.parquet", [scene])
    write_samples(kinds.parent / "made/shard-00000.parquet", [scenes.noisy_samples(scene, 2)])
    (kinds.parent / "empty.rrd").touch()
    (kinds.parent / "text.rrd").write_text("text")
    assert call(monkeypatch, *words) == 2
    assert sentence in capsys.readouterr().err
    assert not list(kinds.parent.glob("town*.rrd"))
