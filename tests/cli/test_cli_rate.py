"""`drivegen rate`, from the words of the command line to the file."""

import json
import sys

import pytest

from drivegen import cli
from drivegen.av2.export import export_scenario
from drivegen.cli import rate
from tests.models import two_lanes
from tests.projects import make_project

BLIND = "from drivegen.world.observation import Action\ndef act(seen): return Action(0 * seen.speed + 2.0)\n"


@pytest.fixture
def project(models, tmp_path):
    folder = make_project(tmp_path, models)
    for speed in (6.0, 9.0):
        scene = two_lanes(speed, f"queue{speed:.0f}")
        export_scenario(scene, scene.log, folder / "scenes", scene.scenario_id)
    (folder / "blind.py").write_text(BLIND)
    return folder


def call(project, monkeypatch, *words):
    monkeypatch.chdir(project)
    monkeypatch.setattr(sys, "argv", ["drivegen", "rate", "--scenarios", "scenes", *words])
    with pytest.raises(SystemExit) as left:
        cli.main()
    return left.value.code or 0


def test_a_driver_that_is_blind_fails_more_often_than_one_that_sees(project, monkeypatch, capsys):
    found = {}
    for driver in ("blind.py", "idm"):
        words = ("--driver", driver, "--runs", "60", "--draws", "64", "--out", "rate.json")
        assert call(project, monkeypatch, *words) == 0
        found[driver] = json.loads((project / "rate.json").read_text())
        said = capsys.readouterr().out
        assert "counted collisions a scene (95 %: " in said
        assert "others come as near as" in said
    blind, idm = found["blind.py"], found["idm"]
    assert blind["scenes"] + len(blind["left_out"]) == 2
    assert sum(blind["strata"]["runs"]) <= 60 + len(blind["strata"]["share"])
    assert blind["low"] <= blind["value"] <= blind["high"]
    assert blind["value"] > idm["value"]


def test_what_cannot_be_done_is_one_sentence_and_writes_nothing(project, monkeypatch, capsys):
    for words, why in (
        (("--driver", "nobody"), "no drivers plugin is called"),
        (("--driver", "idm", "--draws", "9000"), "--draws 9000 are more than are tried: at most 8192"),
    ):
        assert call(project, monkeypatch, *words, "--out", "rate.json") == 2
        said = capsys.readouterr().err
        assert why in said
        assert said.count("\n") == 1
        assert not (project / "rate.json").exists()


def test_an_output_that_cannot_be_is_refused_before_anything_is_driven(project, monkeypatch, capsys):
    monkeypatch.setattr(rate, "read_traffic", None)
    (project / "there").mkdir()
    for out, why in (("there", "there is there and no plain file"), ("blind.py/out", "blind.py is there and no folder")):
        assert call(project, monkeypatch, "--driver", "idm", "--out", out) == 2
        assert why in capsys.readouterr().err


def test_what_was_found_is_told_before_it_is_written(project, monkeypatch, capsys):
    monkeypatch.setattr(rate, "write_json", None)
    with pytest.raises(TypeError):
        call(project, monkeypatch, "--driver", "idm", "--runs", "10", "--draws", "8", "--out", "rate.json")
    assert "counted collisions a scene" in capsys.readouterr().out
