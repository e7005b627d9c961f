"""The answers in lm_store are to the questions that are asked today; needs the real recordings that they are about."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.first_frame import first_frame
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


def scene() -> Scene:
    """The one of Peachtree."""
    data, settings = commonroad.Plugin(REAL), build(Selection, section("ingest.selection"), "ingest.selection")
    settings = replace(settings, horizon=section("ingest.horizons")["commonroad"])
    names = [name for name in data.scenes("test") if name.startswith("USA_Peach")]
    for name in names:
        try:
            shown = first_frame(select(data.read("test", name), settings))
        except UnusableInput:
            continue
        graph, how = LaneGraph.of(shown.map), build(Settings, section("goals.candidates"), "goals.candidates")
        found = [candidates(graph, shown, n, how) for n in range(len(shown.vehicles))]
        offered = [with_stops(shown, n, places) for n, places in enumerate(found)]
        return Scene(shown, offered, [np.full(len(places), 1 / len(places), np.float32) for places in offered])
    raise AssertionError("no scene of Peachtree can be used")


def test_recorded_answers_are_to_todays_questions():
    account, one = Account(), scene()
    odds = asking().odds(one, account)
    assert account.fallback == {}
    assert account.table()["asked"] == len(asking().questions(one)) > 0
    assert all(max(own) > 2 / len(own) for own in odds if len(own) > 8)


def test_what_is_not_recorded_is_said():
    elsewhere = replace(asking(), seed=section("run")["seed"] + 1)
    with pytest.raises(MissingTool, match="holds no answer"):
        elsewhere.odds(scene(), Account())
