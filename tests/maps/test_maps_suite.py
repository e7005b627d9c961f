"""The suite's trials on cases whose outcome is known, the counts, and the command that prints them."""

import json
import sys

import pytest
from typer.testing import CliRunner

from drivegen import cli
from drivegen.core.errors import UnusableInput
from drivegen.layouts.crossings import Crossing, Roundabout
from drivegen.layouts.spec import MapSpec
from drivegen.maps.examine import WrittenNetwork
from drivegen.maps.suite.cases import OWN, Case, outside_cases, own_cases
from drivegen.maps.suite.expect import EXPECTATIONS
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

    def write(self, text, seed):
        if text not in self._answers:
            raise UnusableInput("I can draw nothing like it\ntry: crossing")
        return Understanding(self._answers[text], "a script")


def test_trials_tell_what_became_of_each_description():
    roads = {"crossing": CROSSING, "wrong": ROUNDABOUT, "refused by netconvert": BROKEN, "impossible": CROSSING}
    texts = ("crossing", "wrong", "refused by netconvert", "unknown")
    cases = [Case(OWN, "plain", text, {"arms": 4, "signals_min": 1}) for text in texts]
    cases += [Case(OWN, "refuse", "impossible", None), Case(OWN, "refuse", "poem", None)]
    trials = tried(cases, Scripted(roads), 7)
    assert [trial.right for trial in trials] == [True, False, False, False, False, True]
    assert [trial.right_after_offer for trial in trials] == [True, False, False, True, False, True]
    assert [trial.is_wrong for trial in trials] == [False, True, True, False, True, False]
    assert trials[1].wrong == ("arms: asked 4, got []", "signals_min: asked 1, got 0")
    assert "nowhere" in " ".join(trials[2].wrong)
    assert counted(trials[:4]) == {"lines": 4, "right": 1, "right_after_offer": 2, "declined": 1, "wrong": 2, "repaired": 0}
    told = published("a script", trials)
    assert [case["text"] for case in told["failed"]][:1] == ["wrong"]
    assert set(told["groups"]) == {"own, plain", "own, refuse"}
    assert "seconds" not in json.dumps(told)


def test_what_is_expected_of_traffic_is_judged_by_who_reads_traffic():
    case = Case(OWN, "plain", "crossing", {"arms": 4}, {"cars": 2})
    [trial] = tried([case], Scripted({"crossing": CROSSING}), 7, lambda text, traffic: [f"{text}: {traffic}"])
    assert trial.wrong == ("crossing: {'cars': 2}",)


def test_a_network_that_ends_the_process_does_not_take_the_others_along(tmp_path):
    from drivegen.layouts.compile import compile_map

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
    [trial] = tried([case], Scripted({"crossing": CROSSING}), 7)
    assert trial.wrong == ('{"arms": 4}',)
    (tmp_path / "check_map.py").write_text(f"import sys; assert sys.executable == {sys.executable!r}")
    assert tried([case], Scripted({"crossing": CROSSING}), 7)[0].right
    (tmp_path / "map_prompts.jsonl").write_text("{")
    with pytest.raises(UnusableInput, match=r"map_prompts\.jsonl is not JSON"):
        outside_cases(tmp_path)
    with pytest.raises(UnusableInput, match="must hold"):
        outside_cases(tmp_path / "nowhere")


def test_the_suites_hold_what_they_promise():
    cases = own_cases()
    assert len({case.text for case in cases}) == len(cases)
    assert {case.group for case in cases} == {"plain", "long", "refuse"}
    assert {name for case in cases for name in case.expect or {}} <= EXPECTATIONS


def test_the_command_prints_counts_by_group_and_says_what_nobody_has_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("DRIVEGEN_REAL_DATA", raising=False)
    words = ["bench", "maps", "--every", "25", "--json", "table.json"]
    told = CliRunner(env={"COLUMNS": "220"}).invoke(cli.build(words), words, catch_exceptions=False)
    assert told.exit_code == 0
    assert "written by: phrase table" in told.output
    assert "right after offer" in told.output
    assert "not measured: name a model with --lm" in told.output
    table = json.loads((tmp_path / "table.json").read_text())
    assert table["writers"][1] == {"written_by": "language model", "measured": False}
    assert min(table["writers"][0]["cpu_seconds"].values()) > 0
    assert sum(group["lines"] for group in table["writers"][0]["groups"].values()) == table["descriptions"]


def test_bench_alone_measures_speed_as_before(monkeypatch):
    from drivegen.cli import bench

    monkeypatch.setattr(bench, "measure", lambda only: iter(()))
    told = CliRunner().invoke(cli.build(["bench"]), ["bench", "--only", "lanes"], catch_exceptions=False)
    assert told.exit_code == 0
    assert "target" in told.output
