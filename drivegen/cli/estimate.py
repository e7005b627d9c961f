"""`drivegen estimate`: what language models would cost, before a run."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from drivegen.asked import language_model
from drivegen.cli._console import plain
from drivegen.cli._lm import MaxUsd, Words, model, role
from drivegen.core.errors import MissingTool
from drivegen.core.scenario import Scenario
from drivegen.core.settings import build, read_section
from drivegen.corner_cases.asking import asking as asking_about_dangers
from drivegen.corner_cases.collisions import PIXELS
from drivegen.corner_cases.knowledge import SHAPE, Knowledge
from drivegen.goals.candidates import Settings as CandidateSettings
from drivegen.goals.candidates import candidates
from drivegen.lm.model import LanguageModel
from drivegen.lm.prices import MAP_TOKENS, TRAFFIC_TOKENS, estimate, in_dollars
from drivegen.lm.prompt import Image, Prompt
from drivegen.lm.settings import RoleSettings
from drivegen.maps.writers.base import ROUNDS
from drivegen.maps.writers.language_model import prompt
from drivegen.questions.asking import Scene
from drivegen.questions.goals import Wording, examples
from drivegen.questions.places import with_stops
from drivegen.render.png import png
from drivegen.roads.graph import LaneGraph
from drivegen.selectors.vlm import LAYOUTS, asker
from drivegen.selectors.vlm import Settings as AskingSettings
from drivegen.store.scenarios import count, read_shard, shards

_SCENES = 3
"""Scenes whose questions about goals are really made; the others are taken to be like them."""

_TEST = Path("data/scenarios/test")

_KNOWN = Knowledge(np.ones(SHAPE, np.int64), np.zeros(SHAPE, np.int64), 1.0)
"""As long as what a round knows can be: every feature was met."""

_BLANK = png(np.zeros((PIXELS, PIXELS, 3), np.uint8))
"""In place of a picture of a collision, which has its size."""

_NOBODY = "no language model is configured for {}: nobody is asked, nothing is spent (try --lm)"


def command(lm: Words = None, max_usd: MaxUsd = None) -> None:
    """Print calls, tokens and dollars of each role, for the descriptions and test scenes of this project; nobody is asked.

    Exits with 1 where the scenes of a role are not made yet.
    """
    console, unknown = plain(), []
    for name, lines_of in (("maps", _maps), ("goals", _goals), ("corner_cases", _corner_cases)):
        settings = role(name, lm, max_usd)
        if not settings.model:
            console.print(_NOBODY.format(name))
            continue
        if lines_of is not _maps and not shards(_TEST):
            unknown.append(name)
            continue
        for line in lines_of(settings, model(name, lm, max_usd)):
            console.print(line)
    if unknown:
        raise MissingTool(f"{' and '.join(unknown)} not estimated: no scenes in {_TEST} to be asked about, `make run` makes them")


def _maps(settings: RoleSettings, asking: LanguageModel) -> list[str]:
    texts = list(read_section("maps.prompts").values())
    lines = _lines("maps", asking, settings, [prompt(text) for text in texts], MAP_TOKENS, repairs=ROUNDS)
    one = asking.request(language_model.prompt(texts[0] if texts else ""))
    traffic = estimate(settings, [one], TRAFFIC_TOKENS)
    return [*lines, f"traffic     of one description: dollars {in_dollars(traffic.usd)} (drivegen generate --text --lm)"]


def _goals(settings: RoleSettings, asking: LanguageModel) -> list[str]:
    usual = build(AskingSettings, read_section("goals.vlm"), "params.yaml: goals.vlm")
    asks = {layout: asker(asking, replace(usual, layout=layout), 0) for layout in LAYOUTS}
    scenes, times = _first_scenes(asks[usual.layout].wording)
    return [
        line
        for layout, one in asks.items()
        for line in _lines(f"goals, {layout}", asking, settings, *one.questions(scenes), times)
    ]


def _corner_cases(settings: RoleSettings, asking: LanguageModel) -> list[str]:
    corner, rounds = read_section("corner"), read_section("run")["rounds"]
    how = build(AskingSettings, corner["vlm"], "params.yaml: corner.vlm")
    shown = (*(Image(_BLANK, "image/png") for _ in range(corner["pictures"])), *examples(how.examples))
    asks = asking_about_dangers(asking, how, 0, _KNOWN, shown, corner["pressure"]["reaction_time"])
    scenes, times = _first_scenes(asks.wording)
    used = "" if corner["goals"] == "vlm" else f"; not asked as params.yaml is (corner.goals: {corner['goals']})"
    times *= sum(one["round"] > 0 for one in rounds)
    return _lines(f"corner_cases{used}", asking, settings, *asks.questions(scenes), times)


def _first_scenes(wording: Wording) -> tuple[list[Scene], float]:
    """What would be asked about a few test scenes, and how many times as many there are."""
    offered = build(CandidateSettings, read_section("goals.candidates"), "params.yaml: goals.candidates")
    files = shards(_TEST)
    scenes = [_scene(one, offered, wording) for one in islice((one for shard in files for one in read_shard(shard)), _SCENES)]
    return scenes, sum(map(count, files)) / max(len(scenes), 1)


def _scene(scenario: Scenario, offered: CandidateSettings, wording: Wording) -> Scene:
    """With equal odds, for none need be trained yet: others are asked about than by trained ones, but as many."""
    graph = LaneGraph.of(scenario.map)
    found = [candidates(graph, scenario, n, offered) for n in range(len(scenario.vehicles))]
    if wording.stops:
        found = [with_stops(scenario, n, c) for n, c in enumerate(found)]
    return Scene(scenario, found, [np.full(len(c), 1 / len(c), np.float32) for c in found])


def _lines(
    what: str,
    asking: LanguageModel,
    settings: RoleSettings,
    prompts: Sequence[Prompt[Any]],
    answer: int,
    times: float = 1.0,
    repairs: int = 0,
) -> list[str]:
    requests = [asking.request(one) for one in prompts]
    plain, batch = (estimate(settings, requests, answer, batch=one, repairs=repairs).times(times) for one in (False, True))
    over = f"a run stops at {settings.max_usd:.4f}" + (
        f" or {settings.max_calls} calls" if plain.calls > settings.max_calls else ""
    )
    return [
        f"model       {asking.description}, for {what}",
        f"calls       {plain.calls}",
        f"tokens      about {plain.input_tokens} in, {plain.output_tokens} out",
        f"dollars     {in_dollars(plain.usd)}, in batches {in_dollars(batch.usd)}; at most {in_dollars(plain.most_usd)}; {over}",
    ]
