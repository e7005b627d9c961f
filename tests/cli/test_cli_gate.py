"""`drivegen gate`, from the words of the command line to the exit code and the record."""

import json
import shutil
import sys
from dataclasses import replace

import numpy as np
import pytest

from drivegen import cli
from drivegen.core.samples import Samples
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import write_shard
from tests.projects import copy_params
from tests.scenes import drive, scenario, stack, straight_road

BLIND = "from drivegen.world.observation import Action\ndef act(seen): return Action(0 * seen.speed)\n"
LINE = straight_road(600).centreline[0].astype(np.float64)


def parked(place: float):
    return stack([drive(LINE, 20, 12, 101), drive(LINE, place, 0, 101)])


@pytest.fixture
def project(tmp_path, monkeypatch):
    """Six recordings with a parked car each, a future of each without; a driver that sees nobody, and one that fails."""
    copy_params(tmp_path)
    scenes = [scenario(straight_road(600), parked(80.0 + n), f"run{n}-0") for n in range(6)]
    write_shard(tmp_path / "scenes/shard-00000.parquet", scenes)
    free = [Samples.without_goals(s.scenario_id, "drivegen", stack([s.log, parked(500.0)])) for s in scenes]
    write_samples(tmp_path / "futures/shard-00000.parquet", free)
    (tmp_path / "blind.py").write_text(BLIND)
    (tmp_path / "broken.py").write_text("def act(seen): return seen.nothing\n")
    (tmp_path / "hasty.yaml").write_text("idm: {headway: 1.4}\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def call(monkeypatch, *words):
    monkeypatch.setattr(sys, "argv", ["drivegen", "gate", *words])
    with pytest.raises(SystemExit) as left:
        cli.main()
    return left.value.code or 0


def test_a_worse_driver_has_an_exit_code_of_its_own_and_a_record(project, monkeypatch, capsys):
    assert call(monkeypatch, "idm", "blind.py", "--scenarios", "scenes", "--out", "out") == 3
    said = capsys.readouterr().out
    assert "worse: in 6 runs of 6 recordings blind.py has 6 counted collisions more than idm; odds" in said
    assert "100.00%" in said
    assert "(100.00% to" not in said  # no recording differs: resampling says nothing
    record = json.loads((project / "out/gate.json").read_text())
    assert (record["finding"], record["old"], record["new"], record["folder"]) == ("worse", "idm", "blind.py", "scenes")
    assert len(record["differ"]) == 6
    assert record["chance_if_alike"]["worse"] == pytest.approx(1 / 64)


def test_a_better_driver_passes_and_futures_are_driven(project, monkeypatch, capsys):
    words = ("blind.py", "idm", "--scenarios", "futures", "--of", "scenes")
    assert call(monkeypatch, *words, "--strict", "--avoidable") == 0
    assert (
        "better: in 12 runs of 6 recordings idm has 6 avoidable collisions fewer than blind.py (-100%)" in capsys.readouterr().out
    )
    assert call(monkeypatch, *words, "--most", "3") == 0
    assert "not told apart: in 6 runs of 3 recordings" in capsys.readouterr().out


def test_what_is_not_told_apart_passes_unless_one_is_strict(project, monkeypatch, capsys):
    words = ("idm", "hasty.yaml", "--scenarios", "scenes")
    assert call(monkeypatch, *words) == 0
    assert "each recording has as many of both" in capsys.readouterr().out
    assert call(monkeypatch, *words, "--strict") == 4


def test_one_recording_is_too_few_for_an_interval(project, monkeypatch, capsys):
    assert call(monkeypatch, "idm", "blind.py", "--scenarios", "scenes", "--most", "1") == 0
    said = capsys.readouterr().out
    assert "too few recordings for an interval" in said
    assert "nan" not in said
    assert "in 1 run of 1 recording idm has 0 counted collisions, blind.py 1; recordings that differ: 1, too few to tell" in said
    long = "a-folder-of-drivers-with-a-long-name/a-driver-that-sees-nobody-and-has-a-long-name.py"
    (project / long).parent.mkdir()
    shutil.copy("blind.py", long)
    assert call(monkeypatch, "idm", long, "--scenarios", "scenes", "--most", "1") == 0
    assert f"new: {long}  1" in capsys.readouterr().out
    assert call(monkeypatch, "blind.py", "blind.py", "--scenarios", "scenes", "--most", "1") == 0
    assert "has 1 counted collision, blind.py 1" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("new", "scenarios", "why"),
    [
        ("broken.py", "scenes", "act(observation) fails"),
        ("nobody", "scenes", "no drivers plugin is called"),
        ("lost.py", "scenes", "lost.py is no Python file"),
        ("lost.yaml", "scenes", "lost.yaml is no file: give one with a driver's name and settings"),
        ("lost.yml", "scenes", "lost.yml is no file: give one with a driver's name and settings"),
        ("idm", "data/scenarios/test", "data/scenarios/test is no folder: run `make run` first"),
        ("./idm", "scenes", "'./idm' is no driver: give a Python file (.py), a YAML file"),
        ("drivers", "scenes", "'drivers' is no driver: give a Python file (.py), a YAML file"),
        ("", "scenes", "'' is no driver: give a Python file (.py), a YAML file"),
        ("unknown.yaml", "scenes", "unknown.yaml: no drivers plugin is called 'foo'"),
        ("mutant.yaml", "scenes", "mutant.yaml: there is no mutated driver 'idm.foo'"),
        (
            "untaught.yaml",
            "scenes",
            "untaught.yaml: lost holds no trained driver: run `make run` first, or name the folder of its",
        ),
        ("two.yaml", "scenes", "two.yaml must be a driver's name"),
        ("wrong.yaml", "scenes", "wrong.yaml: idm: unknown name 'head'"),
        ("text.yaml", "scenes", "text.yaml: idm.headway must be float"),
        ("huge.yaml", "scenes", "huge.yaml: idm.headway must be between 0 and 1000, not 1e+300"),
        ("tiny.yaml", "scenes", "tiny.yaml: idm.acceleration must be between 0.001 and 1000, not 1e-300"),
        ("idm", "nowhere", "nowhere is no folder"),
        ("idm", "empty", "(neither shard-*.parquet nor scenario_*.parquet is there): give one with shards"),
        ("idm", "stands", "(1 no-motion (scene-0)): give one with shards"),
        ("idm", "round", "round is a round of corner cases"),
        ("idm", "attack", "attack is a round of corner cases or an attack"),
        ("idm", "round/samples", "round/samples is a round of corner cases"),
        ("idm", "futures", "name their folder"),
    ],
)
def test_what_cannot_be_compared_is_one_sentence_and_leaves_nothing(project, monkeypatch, capsys, new, scenarios, why):
    (project / "empty").mkdir()
    write_shard(project / "stands/shard-00000.parquet", [replace(scenario(straight_road(), parked(80.0)), log=None)])
    for part in ("samples", "driven"):
        shutil.copytree(project / "futures", project / "round" / part)
    write_samples(project / "attack/samples.parquet", [])
    (project / "drivers").mkdir()
    (project / "unknown.yaml").write_text("foo: {}\n")
    (project / "mutant.yaml").write_text("idm.foo: {}\n")
    (project / "untaught.yaml").write_text("gail: {weights: lost}\n")
    (project / "two.yaml").write_text("idm: {}\ngail: {}\n")
    (project / "wrong.yaml").write_text("idm: {head: 1.0}\n")
    (project / "text.yaml").write_text("idm: {headway: soon}\n")
    (project / "huge.yaml").write_text("idm: {headway: 1.0e+300}\n")
    (project / "tiny.yaml").write_text("idm: {acceleration: 1.0e-300}\n")
    assert call(monkeypatch, "idm", new, "--scenarios", scenarios, "--out", "out") == 2
    said = capsys.readouterr().err
    assert why in said
    assert said.count("\n") == 1
    assert not (project / "out").exists()
