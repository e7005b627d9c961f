"""A vision-language model ranks each vehicle's goals (paper, section III-B); the learned selector stands in where it doesn't.

It is shown what a person would be: a picture from above with numbered places, a table of them, a few words. Its ranking becomes
odds by a declared mixture (`questions.account.odds`). Nothing that it says is trusted: an answer with unknown or doubled numbers
is asked for again, and then the learned selector's odds count; both are told in the account.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import Scenario
from drivegen.goals.candidates import Candidates
from drivegen.lm.model import LanguageModel
from drivegen.lm.prompt import Prompt, fenced
from drivegen.questions.account import Account
from drivegen.questions.asking import LAYOUTS as LAYOUTS
from drivegen.questions.asking import Asking, Scene
from drivegen.questions.asking import Settings as Settings
from drivegen.questions.goals import examples
from drivegen.questions.places import with_stops
from drivegen.questions.wordings import likeliest
from drivegen.roads.graph import LaneGraph
from drivegen.selectors.base import FirstFrameSelector
from drivegen.selectors.learned import Plugin as Learned

Offered = tuple[LaneGraph, Scenario, Sequence[Candidates]]
"""A scenario with what its vehicles are offered."""


def asker(model: LanguageModel, settings: Settings, seed: int) -> Asking:
    """Who asks for the likeliest goals, examples and knowledge before every question. Raises UnusableInput for no wording."""
    told = (fenced("knowledge", settings.knowledge),) if settings.knowledge else ()
    return Asking(model, settings, seed, (*examples(settings.examples), *told), likeliest(model.prompt_version))


class Plugin(FirstFrameSelector):
    """The selector; `load` alone gives one that has nobody to ask, `asking` one with a model."""

    described = "learned selector in place of a vision-language model (none was given)"

    def __init__(self, usual: Learned, asking: Asking | None = None) -> None:
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
        """With a model to ask. Raises MissingTool where the learned selector was not trained, UnusableInput for no wording."""
        return cls(Learned.load(folder), asker(model, settings, seed))

    def offer(self, graph: LaneGraph, scenario: Scenario, candidates: Sequence[Candidates]) -> list[Candidates]:  # noqa: ARG002 protocol
        """The given ones; where a model is asked, with a place to stand at every line and behind every queue."""
        if self._asking is None or not self._asking.wording.stops:
            return list(candidates)
        return [with_stops(scenario, n, c) for n, c in enumerate(candidates)]

    def rank(self, graph: LaneGraph, scenario: Scenario, candidates: Sequence[Candidates]) -> list[NDArray[np.float32]]:
        """The model's odds where it was asked and gave an answer, the learned selector's elsewhere.

        Raises MissingTool where the recorded answer to a question is missing and nobody may be asked, OverBudget.
        """
        usual = self._usual.rank(graph, scenario, candidates)
        if self._asking is None:
            self.account.vehicles += len(usual)
            self.account.fallback["no-model"] += len(usual)
            return usual
        return self._asking.odds(Scene(scenario, candidates, usual), self.account)

    def questions(self, offered: Sequence[Offered]) -> tuple[list[Prompt[Any]], int]:
        """What the model would be asked at first, and tokens of an answer; nothing where there is none."""
        return self._asking.questions(self._scenes(offered)) if self._asking else ([], 0)

    @property
    def in_batches(self) -> bool:
        """Whether questions that are known together are to be asked together, by `ahead`."""
        return self._asking is not None and self._asking.model.in_batches

    def ahead(self, offered: Sequence[Offered]) -> None:
        """Before `rank`: ask about all of them in one batch, if lm.goals is set to that."""
        if self._asking is not None and self.in_batches:
            self._asking.ahead(self._scenes(offered))

    def _scenes(self, offered: Sequence[Offered]) -> list[Scene]:
        """As `rank` will ask about them: `offer` adds nothing to what it has added to."""
        scenes = [(graph, scenario, self.offer(graph, scenario, found)) for graph, scenario, found in offered]
        return [Scene(scenario, found, self._usual.rank(graph, scenario, found)) for graph, scenario, found in scenes]
