"""Put questions about goals to a language model and make odds of its answers; what it leaves unanswered keeps the usual odds.

Two callers: the selector `vlm` asks for the likeliest goals, corner cases for the most dangerous ones. They differ in wording, in
what stands before a question, and in what is usual.
"""

from collections.abc import Iterable, Sequence, Set
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegen.core import seeds
from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import Scenario
from drivegen.goals.candidates import Candidates
from drivegen.goals.outlook import Outlooks
from drivegen.lm.model import LanguageModel
from drivegen.lm.prices import RANKING_TOKENS
from drivegen.lm.prompt import Image, NoAnswer, Prompt
from drivegen.questions.account import Account, odds, worth_asking
from drivegen.questions.goals import LONGEST_RANKING, Case, Wording, about_scenario, about_vehicle

LAYOUTS = ("per_vehicle", "per_scenario")

MOST_PIXELS = 4096
"""No model reads more, and a picture grows with the square."""

Numbers = list[int]
Probabilities = Sequence[NDArray[np.float32]]


@dataclass(frozen=True)
class Settings:
    """How the model is asked, and what its answers count.

    Attributes:
        layout: "per_vehicle", a call for each (the paper's), or "per_scenario", one call with all pictures.
        pixels: side of a picture. ranked: places that it is to rank. at_once: calls at the same time.
        decay: odds of a place over those of the one ranked before it. trust: share of the odds that the ranking gets.
        ask_when_unsure: share of vehicles with a choice that it is asked about: those where the usual odds are least certain or
            whose goals matter most to others. knowledge: words that are put before every question. examples: a folder of worked
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
        if not 1 <= self.ranked <= LONGEST_RANKING or self.at_once < 1 or not 256 <= self.pixels <= MOST_PIXELS:
            raise UnusableInput(
                f"goals.vlm: ranked is 1 to {LONGEST_RANKING}, at_once at least 1, pixels are 256 to {MOST_PIXELS}"
            )
        if not (0 < self.decay <= 1 and 0 <= self.trust <= 1 and 0 <= self.ask_when_unsure <= 1):
            raise UnusableInput("goals.vlm: decay, trust and ask_when_unsure are shares of 1")


@dataclass(frozen=True)
class Scene:
    """One scenario to be asked about: its vehicles' candidates and their usual odds, N each."""

    scenario: Scenario
    candidates: Sequence[Candidates]
    usual: Probabilities


@dataclass(frozen=True)
class Asking:
    """Somebody to ask, and how.

    Attributes:
        before: parts that stand before every question: examples, knowledge. wording: what is asked of the places.
        spared: vehicles that it is never asked about.
    """

    model: LanguageModel
    settings: Settings
    seed: int
    before: tuple[str | Image, ...]
    wording: Wording
    spared: Set[int] = frozenset()

    def ahead(self, scenes: Sequence[Scene]) -> None:
        """Ask about all of them in one batch, if the role is set to that, so that `odds` finds the answers there."""
        self.model.ask_ahead(self.questions(scenes)[0])

    def questions(self, scenes: Sequence[Scene]) -> tuple[list[Prompt[Any]], int]:
        """What is asked about scenes at first, and tokens of an ordinary answer: of a ranking for each vehicle in a question."""
        cases = [self._cases(scene) for scene in scenes]
        prompts = [prompt for of_scene in cases for prompt in self._prompts(of_scene)]
        return prompts, RANKING_TOKENS * sum(map(len, cases)) // max(len(prompts), 1)

    def odds(self, scene: Scene, account: Account) -> list[NDArray[np.float32]]:
        """The model's odds where it was asked and gave an answer, the usual ones elsewhere; `account` is told.

        Raises MissingTool where the recorded answer to a question is missing and nobody may be asked, OverBudget.
        """
        odds_of = list(scene.usual)
        cases = self._cases(scene)
        account.vehicles += len(odds_of) - len(self.spared)
        account.unasked += len(odds_of) - len(self.spared) - len(cases)
        for case, numbers in zip(cases, self._answers(cases), strict=True):
            if isinstance(numbers, NoAnswer):
                account.fallback[numbers.reason] += 1
                continue
            account.note(numbers[0], len(case.places))
            own = [case.places[number].members for number in numbers]
            odds_of[case.vehicle] = odds(own, odds_of[case.vehicle], self.settings.decay, self.settings.trust)
        return odds_of

    def _cases(self, scene: Scene) -> list[Case]:
        """Vehicles that the model is asked about."""
        offered, share = scene.candidates, self.settings.ask_when_unsure
        able = [n for n, c in enumerate(offered) if len(c) > 1 and n not in self.spared]
        every = [Case.of(scene.scenario, n, offered[n], self.seed, self.wording) for n in able]
        cases = [case for case in every if len(case.places) > 1]
        if share == 1:
            return cases
        everybody = np.full(len(offered), scene.scenario.steps)
        lot = float(seeds.rng(self.seed, "ask-when-unsure", scene.scenario.scenario_id).random())
        exclusive = Outlooks.of(scene.scenario, offered, everybody).exclusions()
        chosen = worth_asking(scene.usual, exclusive, [case.vehicle for case in cases], share, lot)
        return [case for case in cases if case.vehicle in chosen]

    def _prompts(self, cases: Sequence[Case]) -> list[Prompt[Any]]:
        """A question for each case, or one for all."""
        how = (self.settings.ranked, self.settings.pixels, self.before, self.wording)
        if self.settings.layout == "per_scenario":
            return [about_scenario(cases, *how)] if cases else []
        return [about_vehicle(case, *how) for case in cases]

    def _answers(self, cases: Sequence[Case]) -> list[Numbers | NoAnswer]:
        """Numbers in order of rank for each case, or why there are none."""
        replies = list(self._asked(self._prompts(cases)))
        if self.settings.layout == "per_vehicle":
            return [reply if isinstance(reply, NoAnswer) else _numbers(reply) for reply in replies]
        if not cases or isinstance(replies[0], NoAnswer):
            return [replies[0] for _ in cases]
        numbers = {ranking.vehicle: _numbers(ranking) for ranking in replies[0].vehicles}
        return [numbers[case.vehicle] for case in cases]

    def _asked(self, prompts: Sequence[Prompt[Any]]) -> Iterable[Any]:
        """An answer or a NoAnswer for each prompt."""
        with ThreadPoolExecutor(self.settings.at_once) as pool:
            replies = [pool.submit(self.model.ask, prompt) for prompt in prompts]
        for reply in replies:
            try:
                yield reply.result()
            except NoAnswer as failure:
                yield failure


def _numbers(ranking: Any) -> Numbers:
    return [ranked.goal for ranked in ranking.ranking]
