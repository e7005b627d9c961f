"""Answers in lm_store are to the questions that are asked today; needs the real recordings that they are about."""

import os
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.first_frame import first_frame
from drivegen.core.scenario import Scenario
from drivegen.core.settings import build, read_section
from drivegen.datasets import commonroad
from drivegen.goals.candidates import Settings, candidates
from drivegen.ingest.selection import Settings as Selection
from drivegen.ingest.selection import select
from drivegen.lm.model import LanguageModel
from drivegen.lm.records import Mode, Records
from drivegen.lm.settings import RoleSettings
from drivegen.questions.account import Account
from drivegen.questions.asking import Asking, Scene
from drivegen.questions.asking import Settings as AskingSettings
from drivegen.questions.places import with_stops
from drivegen.questions.wordings import likeliest
from drivegen.roads.graph import LaneGraph
from tests.models import ROOT

REAL = Path(os.environ.get("DRIVEGEN_REAL_DATA", ROOT.parent / "shared" / "data")) / "commonroad"

pytestmark = pytest.mark.skipif(not REAL.is_dir(), reason=f"no real recordings in {REAL}")


def section(name: str) -> dict[str, object]:
    return read_section(name, ROOT / "params.yaml")


def asking() -> Asking:
    """As the runs of the published tables on NGSIM ask."""
    asked = yaml.safe_load((ROOT / "flows/tables.yaml").read_text())["quality"]["data"]["ngsim"]["params"]
    named = {"backend": asked["lm.goals.backend"], "model": asked["lm.goals.model"]}
    role = build(RoleSettings, {**section("lm.goals"), **named}, "lm.goals")
    model = LanguageModel("goals", role, Records(ROOT / "lm_store", Mode.REPLAY))
    how = build(AskingSettings, section("goals")["vlm"], "goals.vlm")
    return Asking(model, how, section("run")["seed"], (), likeliest(role.prompt))


@pytest.fixture(scope="module")
def scenes() -> list[Scene]:
    """The first usable scene of every second recording of Lankershim and Peachtree."""
    data, settings = commonroad.Plugin(REAL), build(Selection, section("ingest.selection"), "ingest.selection")
    settings = replace(settings, horizon=section("ingest.horizons")["commonroad"])
    names = [(name, split) for split in ("train", "val", "test") for name in data.scenes(split)]
    judged = [(name, split) for name, split in names if name.startswith(("USA_Lanker", "USA_Peach"))]
    asked = set(list(dict.fromkeys(name.split(":")[0] for name, _ in judged))[::2])
    found: dict[str, Scene] = {}
    for name, split in judged:
        if (recorded := name.split(":")[0]) in asked - found.keys():
            with suppress(UnusableInput):
                found[recorded] = offered(first_frame(select(data.read(split, name), settings)))
    return list(found.values())


def offered(shown: Scenario) -> Scene:
    """What is asked about a first frame; whose odds are usual is in no question."""
    graph, how = LaneGraph.of(shown.map), build(Settings, section("goals.candidates"), "goals.candidates")
    places = [with_stops(shown, n, candidates(graph, shown, n, how)) for n in range(len(shown.vehicles))]
    return Scene(shown, places, [np.full(len(some), 1 / len(some), np.float32) for some in places])


def test_recorded_answers_are_to_todays_questions(scenes):
    """An eighth: all would take two minutes. On some processors pictures differ in a byte (lm_store/README.md)."""
    account, odds, missing = Account(), list[np.ndarray](), 0
    for scene in scenes:
        everybody = set(range(len(scene.usual)))
        for vehicle in everybody:
            try:
                odds.append(replace(asking(), spared=frozenset(everybody - {vehicle})).odds(scene, account)[vehicle])
            except MissingTool:
                missing += 1
    assert len(scenes) == 6
    assert account.fallback == {}
    assert len(odds) > 70
    assert missing < 0.2 * len(odds)
    assert all(max(own) > 2 / len(own) for own in odds if len(own) > 8)


def test_what_is_not_recorded_is_said(scenes):
    elsewhere = replace(asking(), seed=section("run")["seed"] + 1)
    with pytest.raises(MissingTool, match="holds no answer"):
        elsewhere.odds(scenes[0], Account())
