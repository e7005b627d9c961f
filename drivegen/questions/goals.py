"""What a vision-language model is asked about a vehicle's candidate goals, and the type that its answer must have.

What it is shown and told is a file a version: `goals_2`, and `goals_1` for comparison; `wordings` finds them by their names.
Numbers are drawn anew for every vehicle, so that a liking for low numbers can't pass for knowledge of driving.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from drivegen.core import seeds
from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import Scenario
from drivegen.goals.candidates import Candidates
from drivegen.lm.prompt import Image, Prompt
from drivegen.questions.places import Place

LONGEST_RANKING = 8


@dataclass(frozen=True)
class Wording:
    """How it is asked.

    Attributes:
        version: names the whole wording: answers are recorded under it. instructions: before every question.
        question: has room for {seconds}. wanted: which places are to be ranked first.
        gather: the places that a vehicle's candidates are. show: words and picture of a case, about so many pixels squared.
        stops: whether a place to stand at every line and behind every queue is added to what a selector offers.
    """

    version: str
    instructions: str
    question: str
    wanted: str
    gather: "Callable[[Scenario, int, Candidates], list[Place]]"
    show: "Callable[[Case, int, Wording], tuple[str, Image]]"
    stops: bool = False


class Ranked(BaseModel):
    """One place."""

    model_config = ConfigDict(extra="forbid")
    goal: Annotated[int, Field(ge=0, description="Number of the place.")]
    reason: Annotated[str, Field(max_length=400, description="Why, in at most twenty words.")]


class Ranking(BaseModel):
    """The likeliest places, the likeliest first."""

    model_config = ConfigDict(extra="forbid")
    ranking: Annotated[list[Ranked], Field(min_length=1, max_length=LONGEST_RANKING)]


class VehicleRanking(Ranking):
    """Those of one vehicle of several."""

    vehicle: Annotated[int, Field(ge=0, description="Number of the vehicle.")]


class Rankings(BaseModel):
    """Those of all vehicles that were asked about."""

    model_config = ConfigDict(extra="forbid")
    vehicles: list[VehicleRanking]


@dataclass(frozen=True)
class Case:
    """One vehicle that is asked about.

    Attributes:
        places: those that it may be at, by number.
    """

    scenario: Scenario
    vehicle: int
    candidates: Candidates
    places: tuple[Place, ...]

    @classmethod
    def of(cls, scenario: Scenario, vehicle: int, candidates: Candidates, seed: int, wording: Wording) -> "Case":
        """Numbers drawn by seed, scenario and vehicle."""
        lot = seeds.rng(seed, "goal-numbers", scenario.scenario_id, vehicle)
        places = wording.gather(scenario, vehicle, candidates)
        return cls(scenario, vehicle, candidates, tuple(places[i] for i in lot.permutation(len(places))))

    @property
    def order(self) -> NDArray[np.intp]:
        """(P,) the candidate that stands for each number."""
        return np.array([place.shown for place in self.places], np.intp)


def examples(folder: str) -> tuple[str | Image, ...]:
    """Worked examples to be shown before every question: NAME.png and NAME.txt beside it, by name; none where `folder` is "".

    Raises UnusableInput where the folder is not there, or a picture has no text in UTF-8.
    """
    if folder and not Path(folder).is_dir():
        raise UnusableInput(f"{folder} is no folder of examples: mend the name in params.yaml, or leave it empty")
    parts: list[str | Image] = []
    for picture in sorted(Path(folder).glob("*.png")) if folder else []:
        text = picture.with_suffix(".txt")
        try:
            words = text.read_text(encoding="utf-8")
        except (FileNotFoundError, UnicodeDecodeError):
            raise UnusableInput(f"{picture} is an example without words: put them into {text.name} beside it, in UTF-8") from None
        parts += [f"An example:\n{words}", Image(picture.read_bytes(), "image/png")]
    return tuple(parts)


def about_vehicle(case: Case, places: int, pixels: int, before: tuple[str | Image, ...], wording: Wording) -> Prompt[Ranking]:
    """The question for one vehicle; `before` are examples and knowledge."""

    def check(answer: Ranking) -> None:
        _check(answer, len(case.places), "")

    question = f"Rank the {min(places, len(case.places))} {wording.wanted} places."
    return Prompt(
        wording.version, wording.instructions, (*before, *wording.show(case, pixels, wording), question), Ranking, check
    )


def about_scenario(
    cases: Sequence[Case], places: int, pixels: int, before: tuple[str | Image, ...], wording: Wording
) -> Prompt[Rankings]:
    """One question for several vehicles of a scenario, each with its own picture and table."""
    counts = {case.vehicle: len(case.places) for case in cases}

    def check(answer: Rankings) -> None:
        vehicles = [ranking.vehicle for ranking in answer.vehicles]
        if sorted(vehicles) != sorted(counts):
            raise ValueError(f"give each of the vehicles {', '.join(map(str, counts))} exactly one ranking")
        for ranking in answer.vehicles:
            _check(ranking, counts[ranking.vehicle], f"vehicle {ranking.vehicle}: ")

    parts = [part for case in cases for part in wording.show(case, pixels, wording)]
    question = f"For each of these {len(cases)} vehicles rank the {places} {wording.wanted} places, or all where it has fewer."
    return Prompt(wording.version, wording.instructions, (*before, *parts, question), Rankings, check)


def _check(answer: Ranking, count: int, whose: str) -> None:
    numbers = [ranked.goal for ranked in answer.ranking]
    if max(numbers) >= count:
        raise ValueError(f"{whose}there is no place {max(numbers)}: numbers go from 0 to {count - 1}")
    if len(set(numbers)) < len(numbers):
        raise ValueError(f"{whose}a place is ranked twice")
