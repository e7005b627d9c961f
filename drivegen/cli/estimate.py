"""`drivegen estimate`: what language models would cost, before a run."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np

from drivegen.asked import language_model
from drivegen.cli._console import plain
from drivegen.cli._lm import MaxUsd, Words, model, role
from drivegen.core.scenario import TARGET, Scenario
from drivegen.core.settings import build, read_section
from drivegen.corner_cases.asking import WORDING as CORNER
from drivegen.corner_cases.asking import in_words
from drivegen.corner_cases.collisions import PIXELS
from drivegen.corner_cases.knowledge import SHAPE, Knowledge
from drivegen.goals.candidates import Settings as CandidateSettings
from drivegen.goals.candidates import candidates
from drivegen.lm.backends.base import Request
from drivegen.lm.model import LanguageModel
from drivegen.lm.prices import MAP_TOKENS, RANKING_TOKENS, TRAFFIC_TOKENS, Estimate, estimate, in_dollars
from drivegen.lm.prompt import Image
from drivegen.lm.settings import RoleSettings
from drivegen.maps.writers.language_model import prompt
from drivegen.questions.goals import Case, Wording, about_scenario, about_vehicle, examples
from drivegen.questions.places import with_stops
from drivegen.questions.wordings import likeliest
from drivegen.render.png import png
from drivegen.roads.graph import LaneGraph
from drivegen.selectors.vlm import LAYOUTS
from drivegen.selectors.vlm import Settings as AskingSettings
from drivegen.store.scenarios import count, read_shard, shards

_SCENES = 3
"""Scenes whose questions about goals are really made; the others are taken to be like them."""

_TEST = Path("data/scenarios/test")

_KNOWN = in_words(Knowledge(np.ones(SHAPE, np.int64), np.zeros(SHAPE, np.int64), 1.0))
"""As long as what a round knows can be: every feature was met."""

_BLANK = png(np.zeros((PIXELS, PIXELS, 3), np.uint8))
"""In place of a picture of a collision, which has its size."""

_NOBODY = "no language model is configured for {}: nobody is asked, nothing is spent (try --lm)"


def command(lm: Words = None, max_usd: MaxUsd = None) -> None:
    """Print calls, tokens and dollars of each role, for the descriptions and test scenes of this project; nobody is asked."""
    console = plain()
    for name, lines_of in (("maps", _maps), ("goals", _goals), ("corner_cases", _corner_cases)):
        settings = role(name, lm, max_usd)
        if not settings.model:
            console.print(_NOBODY.format(name))
            continue
        for line in lines_of(settings, model(name, lm, max_usd)):
            console.print(line)


def _maps(settings: RoleSettings, asking: LanguageModel) -> list[str]:
    texts = list(read_section("maps.prompts").values())
    roads = estimate(settings, [asking.request(prompt(text)) for text in texts], MAP_TOKENS)
    batch = estimate(settings, [asking.request(prompt(text)) for text in texts], MAP_TOKENS, batch=True)
    one = asking.request(language_model.prompt(texts[0] if texts else ""))
    traffic = estimate(settings, [one], TRAFFIC_TOKENS)
    lines = _lines("maps", asking, settings, roads, batch)
    return [*lines, f"traffic     of one description: dollars {in_dollars(traffic.usd)} (drivegen generate --text --lm)"]


def _goals(settings: RoleSettings, asking: LanguageModel) -> list[str]:
    if not shards(_TEST):
        return [f"goals       no scenes in {_TEST}: `make run` makes the scenes that would be asked about"]
    usual = build(AskingSettings, read_section("goals.vlm"), "params.yaml: goals.vlm")
    scenes, total = _first_scenes()
    share = (total / len(scenes)) if scenes else 0.0
    lines = []
    for layout in LAYOUTS:
        how = replace(usual, layout=layout)
        requests, answer = _questions(scenes, how, asking, likeliest(settings.prompt), examples(usual.examples), first=0)
        plain, batch = (estimate(settings, requests, answer, batch=one).times(share) for one in (False, True))
        lines += _lines(f"goals, {layout}", asking, settings, plain, batch)
    return lines


def _questions(
    scenes: Sequence[Scenario],
    how: AskingSettings,
    asking: LanguageModel,
    wording: Wording,
    before: tuple[str | Image, ...],
    first: int,
) -> tuple[list[Request], int]:
    """The questions about the goals of some scenes' vehicles from the `first` on, and tokens of an answer to one of them."""
    offered = build(CandidateSettings, read_section("goals.candidates"), "params.yaml: goals.candidates")
    requests, vehicles = [], 0
    for scenario in scenes:
        graph = LaneGraph.of(scenario.map)
        offers = [(n, candidates(graph, scenario, n, offered)) for n in range(first, len(scenario.vehicles))]
        if wording.stops:
            offers = [(n, with_stops(scenario, n, c)) for n, c in offers]
        every = [Case.of(scenario, n, c, 0, wording) for n, c in offers]
        cases = [case for case in every if len(case.places) > 1]
        cases = cases[: max(round(how.ask_when_unsure * len(cases)), 1)]
        if not cases:
            continue
        vehicles += len(cases)
        if how.layout == "per_scenario":
            requests.append(asking.request(about_scenario(cases, how.ranked, how.pixels, before, wording)))
        else:
            requests += [asking.request(about_vehicle(case, how.ranked, how.pixels, before, wording)) for case in cases]
    return requests, RANKING_TOKENS * vehicles // max(len(requests), 1)


def _corner_cases(settings: RoleSettings, asking: LanguageModel) -> list[str]:
    if not shards(_TEST):
        return [f"corner_cases  no scenes in {_TEST}: `make run` makes the scenes that would be asked about"]
    corner, rounds = read_section("corner"), read_section("run")["rounds"]
    how = build(AskingSettings, corner["vlm"], "params.yaml: corner.vlm")
    wording = replace(CORNER, instructions=CORNER.instructions + "\n" + _KNOWN)
    shown = tuple(Image(_BLANK, "image/png") for _ in range(corner["pictures"]))
    scenes, total = _first_scenes()
    requests, answer = _questions(scenes, how, asking, wording, shown, first=TARGET + 1)
    times = total / max(len(scenes), 1) * sum(one["round"] > 0 for one in rounds)
    plain, batch = (estimate(settings, requests, answer, batch=one).times(times) for one in (False, True))
    used = "" if corner["goals"] == "vlm" else f"; not asked as params.yaml is (corner.goals: {corner['goals']})"
    return _lines(f"corner_cases{used}", asking, settings, plain, batch)


def _first_scenes() -> tuple[list[Scenario], int]:
    """A few test scenes, and how many there are."""
    files = shards(_TEST)
    total = sum(count(shard) for shard in files)
    return list(islice((scenario for shard in files for scenario in read_shard(shard)), _SCENES)), total


def _lines(what: str, asking: LanguageModel, settings: RoleSettings, plain: Estimate, batch: Estimate) -> list[str]:
    over = f"a run stops at {settings.max_usd:.4f}" + (
        f" or {settings.max_calls} calls" if plain.calls > settings.max_calls else ""
    )
    return [
        f"model       {asking.description}, for {what}",
        f"calls       {plain.calls}",
        f"tokens      about {plain.input_tokens} in, {plain.output_tokens} out",
        f"dollars     {in_dollars(plain.usd)}, in batches {in_dollars(batch.usd)}; at most {in_dollars(plain.most_usd)}; {over}",
    ]
