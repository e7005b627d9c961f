"""`drivegen estimate`: what language models would cost, before a run."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path

import pyarrow.parquet as pq
from rich.console import Console

from drivegen.asked import language_model
from drivegen.cli._lm import MaxUsd, Words, model, role
from drivegen.goals.candidates import Settings as CandidateSettings
from drivegen.goals.candidates import candidates
from drivegen.lanes.graph import LaneGraph
from drivegen.lm.backends.base import Request
from drivegen.lm.model import LanguageModel
from drivegen.lm.prices import Estimate, estimate
from drivegen.lm.settings import RoleSettings
from drivegen.maps.writers.language_model import prompt
from drivegen.scenario import Scenario
from drivegen.selectors._vlm_question import LIKELIEST, Case, about_scenario, about_vehicle, examples
from drivegen.selectors.vlm import LAYOUTS
from drivegen.selectors.vlm import Settings as AskingSettings
from drivegen.settings import build, read_section
from drivegen.store.scenarios import read_shard, shards

_MAP_TOKENS, _TRAFFIC_TOKENS, _RANKING_TOKENS = 500, 250, 120
"""Of an answer of ordinary size: a map, the traffic of a description, the ranking of one vehicle's goals."""

_SCENES = 3
"""Scenes whose questions about goals are really made; the others are taken to be like them."""

_TEST = Path("data/scenarios/test")

_NOBODY = "no language model is configured for {}: nobody is asked, nothing is spent (try --lm)"


def command(lm: Words = None, max_usd: MaxUsd = None) -> None:
    """Print calls, tokens and dollars of each role, for the descriptions and test scenes of this project; nobody is asked."""
    console = Console(soft_wrap=True, highlight=False, markup=False)
    for name, told in (("maps", _maps), ("goals", _goals), ("corner_cases", _corner_cases)):
        settings = role(name, lm, max_usd)
        if not settings.model:
            console.print(_NOBODY.format(name))
            continue
        for line in told(settings, model(name, lm, max_usd)):
            console.print(line)


def _maps(settings: RoleSettings, asking: LanguageModel) -> list[str]:
    texts = list(read_section("maps.prompts").values())
    roads = estimate(settings, [asking.request(prompt(text)) for text in texts], _MAP_TOKENS)
    batch = estimate(settings, [asking.request(prompt(text)) for text in texts], _MAP_TOKENS, batch=True)
    one = asking.request(language_model.prompt(texts[0] if texts else ""))
    traffic = estimate(settings, [one], _TRAFFIC_TOKENS)
    lines = _lines("maps", asking, settings, roads, batch)
    return [*lines, f"traffic     of one description: dollars {_dollars(traffic.usd)} (drivegen generate --text --lm)"]


def _goals(settings: RoleSettings, asking: LanguageModel) -> list[str]:
    if not _TEST.exists():
        return [f"goals       no {_TEST} here: `make run` makes the scenes that would be asked about"]
    asked = build(AskingSettings, read_section("goals.vlm"), "params.yaml: goals.vlm")
    found = shards(_TEST)
    total = sum(pq.read_metadata(shard).num_rows for shard in found)  # a row is a scenario
    scenes = list(islice((scenario for shard in found for scenario in read_shard(shard)), _SCENES))
    lines = []
    for layout in LAYOUTS:
        requests, answer = _questions(scenes, replace(asked, layout=layout), asking)
        share = (total / len(scenes)) if scenes else 0.0
        plain, batch = (_times(estimate(settings, requests, answer, batch=one), share) for one in (False, True))
        lines += _lines(f"goals, {layout}", asking, settings, plain, batch)
    return lines


def _questions(scenes: Sequence[Scenario], asked: AskingSettings, asking: LanguageModel) -> tuple[list[Request], int]:
    """The questions about the goals of some scenes, and tokens of an answer to one of them."""
    offered = build(CandidateSettings, read_section("goals.candidates"), "params.yaml: goals.candidates")
    before, requests, vehicles = examples(asked.examples), [], 0
    for scenario in scenes:
        graph = LaneGraph.of(scenario.map)
        found = [candidates(graph, scenario, n, offered) for n in range(len(scenario.vehicles))]
        cases = [Case.of(scenario, n, c, 0) for n, c in enumerate(found) if len(c) > 1]
        cases = cases[: max(round(asked.ask_when_unsure * len(cases)), 1)]
        vehicles += len(cases)
        if asked.layout == "per_scenario":
            requests.append(asking.request(about_scenario(cases, asked.ranked, asked.pixels, before, LIKELIEST)))
        else:
            requests += [asking.request(about_vehicle(case, asked.ranked, asked.pixels, before, LIKELIEST)) for case in cases]
    return requests, _RANKING_TOKENS * vehicles // max(len(requests), 1)


def _corner_cases(settings: RoleSettings, asking: LanguageModel) -> list[str]:  # noqa: ARG001  as the others
    return ["corner_cases  nothing in this pipeline asks it: no calls, 0 dollars"]


def _times(one: Estimate, share: float) -> Estimate:
    """An estimate of so many times as many calls."""
    dollars = (None if usd is None else usd * share for usd in (one.usd, one.most_usd))
    return Estimate(round(one.calls * share), round(one.input_tokens * share), round(one.output_tokens * share), *dollars)


def _lines(what: str, asking: LanguageModel, settings: RoleSettings, found: Estimate, batch: Estimate) -> list[str]:
    over = f"a run stops at {settings.max_usd:.4f}" + (
        f" or {settings.max_calls} calls" if found.calls > settings.max_calls else ""
    )
    return [
        f"model       {asking.description}, for {what}",
        f"calls       {found.calls}",
        f"tokens      about {found.input_tokens} in, {found.output_tokens} out",
        f"dollars     {_dollars(found.usd)}, in batches {_dollars(batch.usd)}; at most {_dollars(found.most_usd)}; {over}",
    ]


def _dollars(usd: float | None) -> str:
    return "unknown" if usd is None else f"{usd:.4f}"
