"""A vision-language model ranks each vehicle's goals (paper, section III-B); the learned selector stands in where it doesn't.

It is shown what a person would be: a picture from above with numbered places, a table of them, a few words. Its ranking becomes
odds by a declared mixture (`_vlm_account.odds`). Nothing that it says is trusted: an answer with unknown or doubled numbers is
asked for again, and then the learned selector's odds count; both are told in the account.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from drivegen import seeds
from drivegen.errors import UnusableInput
from drivegen.goals.candidates import Candidates
from drivegen.goals.outlook import Outlooks
from drivegen.lanes.graph import LaneGraph
from drivegen.lm.model import LanguageModel
from drivegen.lm.prompt import Image, NoAnswer, fenced
from drivegen.scenario import Scenario
from drivegen.selectors._vlm_account import Account, odds, worth_asking
from drivegen.selectors._vlm_question import LONGEST_RANKING, Case, about_scenario, about_vehicle, examples
from drivegen.selectors.base import FirstFrameSelector
from drivegen.selectors.learned import Plugin as Learned

LAYOUTS = ("per_vehicle", "per_scenario")

Numbers = list[int]


@dataclass(frozen=True)
class Settings:
    """How the model is asked, and what its answers count.

    Attributes:
        layout: "per_vehicle", a call for each (the paper's), or "per_scenario", one call with all pictures.
        pixels: side of a picture. ranked: places that it is to rank. at_once: calls at the same time.
        decay: odds of a place over those of the one ranked before it. trust: share of the odds that the ranking gets.
        ask_when_unsure: share of vehicles that it is asked about: those where the learned selector is least certain or whose
            goals matter most to others. knowledge: words that are put before every question. examples: a folder of worked
            examples (NAME.png, NAME.txt) that are shown before it; "" for none.
    """

    layout: str
    pixels: int
    ranked: int
    at_once: int
    decay: float
    trust: float
    ask_when_unsure: float
    knowledge: str
    examples: str

    def __post_init__(self) -> None:
        if self.layout not in LAYOUTS:
            raise UnusableInput(f"goals.vlm: layout is one of {', '.join(LAYOUTS)}, not {self.layout!r}")
        if not 1 <= self.ranked <= LONGEST_RANKING or self.at_once < 1 or self.pixels < 256:
            raise UnusableInput(f"goals.vlm: ranked is 1 to {LONGEST_RANKING}, at_once at least 1, pixels at least 256")
        if not (0 < self.decay <= 1 and 0 <= self.trust <= 1 and 0 <= self.ask_when_unsure <= 1):
            raise UnusableInput("goals.vlm: decay, trust and ask_when_unsure are shares of 1")


@dataclass(frozen=True)
class _Asking:
    model: LanguageModel
    settings: Settings
    seed: int
    before: tuple[str | Image, ...]


class Plugin(FirstFrameSelector):
    """The selector; `load` alone gives one that has nobody to ask, `asking` one with a model."""

    described = "learned selector in place of a vision-language model (none was given)"

    def __init__(self, usual: Learned, asking: _Asking | None = None) -> None:
        self.account = Account()
        self._usual, self._asking = usual, asking
        if asking is not None:
            share = asking.settings.ask_when_unsure
            whom = "" if share == 1 else f", asked about {share:.0%} of vehicles, else learned selector"
            self.described = f"{asking.model.description}{whom}"

    @classmethod
    def load(cls, folder: Path) -> Self:
        """The learned selector alone. Raises MissingTool where it was not trained."""
        return cls(Learned.load(folder))

    @classmethod
    def asking(cls, folder: Path, model: LanguageModel, settings: Settings, seed: int) -> Self:
        """With a model to ask. Raises MissingTool where the learned selector was not trained."""
        told = (fenced("knowledge", settings.knowledge),) if settings.knowledge else ()
        return cls(Learned.load(folder), _Asking(model, settings, seed, (*examples(settings.examples), *told)))

    def rank(self, graph: LaneGraph, scenario: Scenario, candidates: Sequence[Candidates]) -> list[NDArray[np.float32]]:
        """The model's odds where it was asked and gave an answer, the learned selector's elsewhere.

        Raises MissingTool where the recorded answer to a question is missing and nobody may be asked, OverBudget.
        """
        usual = self._usual.rank(graph, scenario, candidates)
        self.account.vehicles += len(usual)
        if self._asking is None:
            self.account.fallback["no-model"] += len(usual)
            return usual
        chosen = self._chosen(scenario, candidates, usual)
        self.account.unasked += len(usual) - len(chosen)
        cases = [Case.of(scenario, n, candidates[n], self._asking.seed) for n in chosen.tolist()]
        settings = self._asking.settings
        for case, numbers in zip(cases, self._answers(cases, self._asking), strict=True):
            if isinstance(numbers, NoAnswer):
                self.account.fallback[numbers.reason] += 1
                continue
            self.account.note(numbers[0], len(case.order))
            usual[case.vehicle] = odds(case.order[numbers].tolist(), usual[case.vehicle], settings.decay, settings.trust)
        return usual

    def _chosen(
        self, scenario: Scenario, candidates: Sequence[Candidates], usual: Sequence[NDArray[np.float32]]
    ) -> NDArray[np.intp]:
        """Vehicles that the model is asked about."""
        assert self._asking is not None
        share = self._asking.settings.ask_when_unsure
        if share == 1:
            return np.array([n for n, c in enumerate(candidates) if len(c) > 1], np.intp)
        everybody = np.full(len(candidates), scenario.steps)
        lot = float(seeds.rng(self._asking.seed, "ask-when-unsure", scenario.scenario_id).random())
        return worth_asking(usual, Outlooks.of(scenario, candidates, everybody).exclusions(), share, lot)

    @staticmethod
    def _answers(cases: Sequence[Case], asking: _Asking) -> list[Numbers | NoAnswer]:
        """Numbers in order of rank for each case, or why there are none."""
        settings = asking.settings
        if settings.layout == "per_scenario":
            return _together(cases, asking)
        prompts = [about_vehicle(case, settings.ranked, settings.pixels, asking.before) for case in cases]
        with ThreadPoolExecutor(settings.at_once) as pool:
            replies = [pool.submit(asking.model.ask, prompt) for prompt in prompts]
        answers: list[Numbers | NoAnswer] = []
        for reply in replies:
            try:
                answers.append([ranked.goal for ranked in reply.result().ranking])
            except NoAnswer as failure:
                answers.append(failure)
        return answers


def _together(cases: Sequence[Case], asking: _Asking) -> list[Numbers | NoAnswer]:
    """All cases in one question."""
    if not cases:
        return []
    try:
        answer = asking.model.ask(about_scenario(cases, asking.settings.ranked, asking.settings.pixels, asking.before))
    except NoAnswer as failure:
        return [failure] * len(cases)
    told = {ranking.vehicle: [ranked.goal for ranked in ranking.ranking] for ranking in answer.vehicles}
    return [told[case.vehicle] for case in cases]
