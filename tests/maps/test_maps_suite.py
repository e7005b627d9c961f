"""The suite's trials on cases whose outcome is known, the counts, and the command that prints them."""

import json
import sys

import pytest
from typer.testing import CliRunner

from drivegen import cli
from drivegen.errors import UnusableInput
from drivegen.maps.examine import WrittenNetwork
from drivegen.maps.spec import MapSpec
from drivegen.maps.spec_crossings import Crossing, Roundabout
from drivegen.maps.suite.cases import HELD_OUT, OWN, Case, first_try, outside_cases, own_cases
from drivegen.maps.suite.table import counted, published
from drivegen.maps.suite.trials import tried
from drivegen.maps.writers.base import Understanding
from drivegen.sumo.loading import load_all
from drivegen.sumo.plain import Edge, Node, PlainNetwork

ARMS = [{"angle": a} for a in (0, 90, 180, 270)]
CROSSING = MapSpec(road=Crossing.model_validate({"arms": ARMS, "control": "signals"}))
ROUNDABOUT = MapSpec(road=Roundabout.model_validate({"arms": ARMS}))
BROKEN = WrittenNetwork(PlainNetwork([Node("a", 0, 0), Node("b", 100, 0)], [Edge("ab", "a", "nowhere", 1, 10)]))


class Scripted:
    """A writer that knows what to answer."""

    description = "a script"

    def __init__(self, answers):
        self._answers = answers

    def write(self, text, seed, vehicle_words=frozenset()):
        if text not in self._answers:
            raise UnusableInput("I can draw nothing like it")
        spec, writer, repairs = self._answers[text]
        return Understanding(spec, (), (), (), writer, repairs)


def test_trials_tell_how_far_each_description_came():
    writer = Scripted(
        {
            "crossing": (CROSSING, "a script", 2),
            "wrong": (ROUNDABOUT, "a script", 0),
            "refused by netconvert": (BROKEN, "a script", 0),
            "somebody else": (CROSSING, "another", 0),
            "impossible": (CROSSING, "a script", 0),
        }
    )
    expect = {"arms": [4], "signals_min": 1}
    roads = [
        Case(OWN, "road", text, expect) for text in ("crossing", "wrong", "refused by netconvert", "somebody else", "unknown")
    ]
    none = [Case(OWN, "none", "impossible", None), Case(OWN, "none", "poem", None, refused="I can draw")]
    trials = tried([*roads, *none], writer, 7)
    assert [trial.right for trial in trials] == [True, False, False, False, False, False, True]
    assert [trial.loads for trial in trials] == [True, True, False, True, False, True, False]
    assert trials[1].wrong == ("arms: asked [4], got []", "signals_min: asked 1, got 0")
    assert trials[2].valid_xml
    assert "nowhere" in " ".join(trials[2].wrong)
    assert trials[3].stood_in == "another"
    assert not trials[3].understood
    found = counted(trials)
    steps = ("roads", "understood", "valid_xml", "accepted", "loads", "as_asked", "repaired_after_2", "declined", "stood_in_for")
    assert [found[name] for name in steps] == [5, 3, 4, 3, 3, 1, 1, 1, 1]
    assert (found["to_refuse"], found["refused"], found["right"]) == (2, 1, 2)
    told = published("a script", trials)
    assert [case["text"] for case in told["failed"]][:1] == ["wrong"]
    assert "seconds" not in json.dumps(told)


def test_a_network_that_ends_the_process_does_not_take_the_others_along(tmp_path):
    from drivegen.maps.compile import compile_map

    good = compile_map(CROSSING)
    assert load_all([good, b"<net", good.replace(b'type="traffic_light"', b'type="nonsense"'), good]) == [
        True,
        False,
        False,
        True,
    ]
    assert load_all([]) == []


def test_an_outside_folder_brings_its_own_judge(tmp_path):
    (tmp_path / "map_prompts.jsonl").write_text('{"id": "a", "prompt": "crossing", "expect": {"arms": 4}}\n')
    (tmp_path / "check_map.py").write_text("import sys; print(sys.argv[2]); sys.exit('arms' in sys.argv[2])")
    [case] = outside_cases(tmp_path)
    [trial] = tried([case], Scripted({"crossing": (CROSSING, "a script", 0)}), 7)
    assert trial.wrong == ('{"arms": 4}',)
    (tmp_path / "check_map.py").write_text(f"import sys; assert sys.executable == {sys.executable!r}")
    assert tried([case], Scripted({"crossing": (CROSSING, "a script", 0)}), 7)[0].right
    (tmp_path / "map_prompts.jsonl").write_text("{")
    with pytest.raises(UnusableInput, match="no file of descriptions"):
        outside_cases(tmp_path)
    with pytest.raises(UnusableInput, match="must hold"):
        outside_cases(tmp_path / "nowhere")


def test_the_suites_hold_what_they_promise():
    cases = own_cases()
    assert len({case.text for case in cases}) == len(cases)
    assert sum(case.suite == OWN for case in cases) >= 60
    assert sum(case.kind in ("impossible", "hostile") for case in cases) >= 25
    assert {"date", "revision", "as_asked"} <= set(first_try()[0])
    held_out = {case.suite: case for case in cases if case.suite != OWN}
    assert set(held_out) == {f"{HELD_OUT} {part}" for part in "ABCDEFGHIJKLMNOPQSUV"}
    assert sum(case.suite in held_out for case in cases) >= 60


def test_the_command_prints_a_table_per_kind_and_says_what_nobody_has_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("DRIVEGEN_REAL_DATA", raising=False)
    words = ["bench", "maps", "--every", "25", "--json", "table.json"]
    told = CliRunner(env={"COLUMNS": "220"}).invoke(cli.build(words), words, catch_exceptions=False)
    assert told.exit_code == 0
    assert "written by: offline rules" in told.output
    assert "not measured: name a model with --lm" in told.output
    table = json.loads((tmp_path / "table.json").read_text())
    assert table["writers"][1] == {"written_by": "language model", "measured": False}
    assert min(table["writers"][0]["cpu_seconds"].values()) > 0
    assert sum(suite["roads"] + suite["to_refuse"] for suite in table["writers"][0]["suites"].values()) == table["descriptions"]


def test_bench_alone_measures_speed_as_before(monkeypatch):
    from drivegen.cli import bench

    monkeypatch.setattr(bench, "measure", lambda only: iter(()))
    told = CliRunner().invoke(cli.build(["bench"]), ["bench", "--only", "lanes"], catch_exceptions=False)
    assert told.exit_code == 0
    assert "target" in told.output
