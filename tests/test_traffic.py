"""What becomes of samples: rows, folders, and those that are no scenario."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from drivegen import traffic as make
from drivegen.asked.account import Item
from drivegen.av2.folder import read_folder
from drivegen.checker.limits import Limits
from drivegen.core.errors import UnusableInput
from drivegen.core.settings import build, read_section
from drivegen.generators.base import Settings
from drivegen.goals.packing import pack
from drivegen.rollout.models import Equipment
from drivegen.selectors.random import Plugin as Uniform
from drivegen.traffic import Start, Traffic, row, write_sample
from tests.projects import PARAMS
from tests.scenes import busy_crossing, noisy_samples


def traffic(*, logged: bool, dropped: list[tuple[int, int]]) -> Traffic:
    """Three samples of the crossing; sample 0 has a collision of vehicles 0 and 1 where it is scored against a log."""
    scene = busy_crossing(30)
    samples = noisy_samples(scene, 3)
    if not logged:
        samples.violation[:] = 0
    for k, n in dropped:
        samples.dropped[k, n] = True
        samples.motion.valid[k, n] = False
    samples.goal[:] = 0
    choices = make.choose([scene], Uniform(), generation().candidates, 1.0)[0]
    goals = pack(scene, "random", choices.candidates, choices.used)
    return Traffic(Start(scene if logged else replace(scene, log=None), {"overlap": 2}), samples, goals, "uniform")


def generation() -> Settings:
    return build(Settings, read_section("rollout.generation", PARAMS), "generation")


def test_against_a_log_nobody_is_left_out_and_the_illegal_are_counted():
    first, second, _ = (row(traffic(logged=True, dropped=[]), k) for k in range(3))
    assert (first["illegal"], first["colliding"], first["violations"]) == (2, 2, {"collision": 2})
    assert (second["illegal"], second["colliding"], second["violations"]) == (0, 0, {})
    assert first["id"] == "crossing-0-s00"
    assert 0 < first["sade"] < first["sfde"]


def test_new_traffic_is_written_without_those_dropped(tmp_path):
    made = traffic(logged=False, dropped=[(1, 3), (1, 4)])
    told = row(made, 1)
    assert (told["vehicles"], told["dropped"], told["not_placed"], told["rejected"]) == (8, 2, {"overlap": 2}, None)
    assert (told["sade"], told["sfde"]) == (None, None)
    write_sample(made, 1, tmp_path)
    assert sorted(read_folder(tmp_path / told["id"], "made").track_id) == [f"track-{i}" for i in (0, 1, 2, 5, 6, 7)]


def test_a_future_that_leaves_vehicles_out_has_not_the_number_that_was_asked_for(monkeypatch):
    made = traffic(logged=False, dropped=[(1, 3)])
    asked = SimpleNamespace(only=lambda present: present)

    def told(present):
        return [Item("number", "7 vehicles beside the target", len(present) == 8)]

    made = replace(made, start=replace(made.start, asked=asked, told=told))
    monkeypatch.setattr(make, "manoeuvres", lambda *_: [])
    assert [[item["got"] for item in row(made, k)["asked"]] for k in (0, 1)] == [[True], [False]]


def test_a_sample_that_dropped_its_target_is_counted_and_not_written(tmp_path):
    made = traffic(logged=False, dropped=[(2, 0)])
    assert (row(made, 2)["id"], row(made, 2)["rejected"]) == (None, "no-legal-target")
    write_sample(made, 2, tmp_path)
    assert not list(tmp_path.iterdir())


def test_where_no_sample_has_a_legal_target_it_is_said(monkeypatch):
    none = traffic(logged=False, dropped=[(k, 0) for k in range(3)])
    monkeypatch.setattr(make, "roll_out", lambda *_: [none.samples])
    limits = build(Limits, read_section("calibrate.floors", PARAMS), "floors")
    with pytest.raises(UnusableInput, match="try another seed") as error:
        make.make(none.start, Equipment(None, Uniform(), limits), generation(), 3, 7)
    assert error.value.reason == "no-legal-target"


def test_what_the_log_lost_on_the_way_in_is_counted():
    scene = busy_crossing(30)
    noted = replace(scene, notes={"dropped_overlapping": "2", "target": "AV"})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(make, "select", lambda *_: noted)
        assert make.from_log(None, None).left_out == {"overlapping": 2}
