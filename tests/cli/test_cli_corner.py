"""`drivegen corner`, from the words of the command line to the files."""

import json
import sys
from dataclasses import replace

import numpy as np
import pytest
import yaml

from drivegen import cli
from drivegen.av2.export import export_scenario
from drivegen.av2.folder import read_folder
from drivegen.cli._project import ground as ground_of
from drivegen.core.safe_xml import parse
from drivegen.core.signals import Signals, SignalState
from tests.projects import make_project
from tests.scenes import busy_crossing, drive, scenario, stack, straight_road

BLIND = "from drivegen.world.observation import Action\ndef act(seen): return Action(0 * seen.speed)\n"


@pytest.fixture
def project(models, tmp_path):
    folder = make_project(tmp_path, models)
    road = straight_road(600)
    line = road.centreline[0].astype(float)
    for name, parked in (("a", 80), ("b", 90)):
        log = stack([drive(line, 20, 12, 101), drive(line, parked, 0, 101)])
        scene = replace(scenario(road, log, name), source="Argoverse 2 Motion Forecasting")
        export_scenario(scene, log, folder / "scenes", name)
    (folder / "blind.py").write_text(BLIND)
    return folder


def call(project, monkeypatch, *words):
    monkeypatch.chdir(project)
    monkeypatch.setattr(sys, "argv", ["drivegen", "corner", *words])
    with pytest.raises(SystemExit) as left:
        cli.main()
    return left.value.code or 0


def test_a_driver_of_a_file_is_tested_and_its_kinds_are_written(project, monkeypatch, capsys):
    words = ("--driver", "blind.py", "--scenarios", "scenes", "--out", "out", "--adversary", "dataset")
    assert call(project, monkeypatch, *words) == 0
    said = capsys.readouterr().out
    assert "standing, in a: Another stands in its way" in said
    assert "2 cases of 1 kind in out" in said
    assert "standing  2      -     2 of 2" in said  # logged traffic has no odds
    assert "Odds, of the attacker's goal by itself (of two attackers the product of both), and" in said
    assert "out/standing: picture.png, recording.rrd, sentence.txt, standing, standing.xodr, standing.xosc" in said
    cases = json.loads((project / "out/cases.json").read_text())
    assert [case["kind"] for case in cases] == ["standing", "standing"]
    assert {case["avoidable"] for case in cases} == {"with warning"}
    written = project / "out/standing"
    assert {file.name for file in written.iterdir()} == {
        "standing", "standing.xosc", "standing.xodr", "picture.png", "recording.rrd", "sentence.txt"
    }  # fmt: skip
    log = read_folder(written / "standing", "again")
    assert {case["tracks"]["partner"] for case in cases} <= set(log.track_id.tolist())
    assert {case["tracks"]["attacker"] for case in cases} == {None}  # in logged traffic
    place = parse((written / "standing.xosc").read_bytes(), "xosc", root="OpenSCENARIO").find(".//ManeuverGroup[@name='Ego']")
    assert len(list(place.iter("Vertex"))) == int(cases[0]["seconds"] * 10 + 1.5)
    assert np.isfinite(log.motion.position[log.motion.valid]).all()


def test_what_cannot_be_run_is_one_sentence_and_leaves_nothing(project, monkeypatch, capsys):
    (project / "broken.py").write_text("def act(seen): return seen.nothing\n")
    for driver, why in (("broken.py", "act(observation) fails"), ("nobody", "no drivers plugin is called")):
        words = ("--driver", driver, "--scenarios", "scenes", "--out", "out", "--adversary", "dataset")
        assert call(project, monkeypatch, *words) == 2
        said = capsys.readouterr().err
        assert why in said
        assert said.count("\n") == 1
        assert not (project / "out").exists()


def test_odds_of_goals_know_nothing_of_what_lights_show_later(project, monkeypatch):
    monkeypatch.chdir(project)
    scene = busy_crossing()
    later = scene.signals.state.copy()
    later[:, 1:] = np.where(later[:, 1:] == SignalState.GREEN, SignalState.RED, SignalState.GREEN)
    other = replace(scene, signals=Signals(scene.signals.lane, later))
    ground = ground_of("log", [scene, other], 1)
    assert ground.choices[1].scenario is other
    for one, two in zip(ground.choices[0].natural, ground.choices[1].natural, strict=True):
        assert np.array_equal(one, two)


WORDS = ("--driver", "blind.py", "--scenarios", "scenes", "--out", "out", "--adversary", "dataset")


def test_a_folder_that_is_not_empty_is_refused_before_anything_is_driven(project, monkeypatch, capsys):
    (project / "blind.py").write_text("def act(seen): return seen.nothing\n")
    (project / "out").mkdir()
    (project / "out/mine.txt").write_text("mine")
    assert call(project, monkeypatch, *WORDS) == 2
    assert "out is not empty" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "value", "why"),
    [
        ("queries", [], "attack.queries is empty"),
        ("queries", [0], "attack.queries[0] must be at least 1"),
        ("samples", "two", "attack.samples must be"),
        ("reaction_steps", None, "attack.reaction_steps must be"),
    ],
)
def test_settings_that_are_wrong_are_named(project, monkeypatch, capsys, name, value, why):
    tree = yaml.safe_load((project / "params.yaml").read_text())
    tree["attack"][name] = value
    (project / "params.yaml").write_text(yaml.safe_dump(tree))
    assert call(project, monkeypatch, *WORDS) == 2
    assert why in capsys.readouterr().err
    assert not (project / "out").exists()
