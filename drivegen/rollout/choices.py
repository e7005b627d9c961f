"""A scenario with the goals that its vehicles may take and their odds: what a selector offers, and what a rollout draws from."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import Scenario
from drivegen.goals.candidates import Candidates, candidates
from drivegen.goals.candidates import Settings as CandidateSettings
from drivegen.goals.manoeuvres import Manoeuvre
from drivegen.goals.packing import unpack
from drivegen.roads.graph import LaneGraph
from drivegen.selectors.base import Selector
from drivegen.store.goals import GoalColumns

Probabilities = list[NDArray[np.float32]]
"""One array (C,) per vehicle of a scenario, over its candidates."""


@dataclass(frozen=True)
class Choices:
    """A scenario with the goals that its vehicles may take.

    Attributes:
        scenario: the scenario, N vehicles.
        candidates: N Candidates.
        natural: N arrays (C,), the selector's own probabilities.
        used: N arrays (C,), those that goals are drawn with.
    """

    scenario: Scenario
    candidates: list[Candidates]
    natural: Probabilities
    used: Probabilities


def choose(scenarios: Sequence[Scenario], selector: Selector, settings: CandidateSettings, temperature: float) -> list[Choices]:
    """Candidates and probabilities of all vehicles of all scenarios; goals are drawn from the tempered ones."""
    choices = []
    for scenario in scenarios:
        graph = LaneGraph.of(scenario.map)
        candidates_of = [candidates(graph, scenario, n, settings) for n in range(len(scenario.vehicles))]
        offered = selector.offer(graph, scenario, candidates_of)
        natural = selector.rank(graph, scenario, offered)
        choices.append(Choices(scenario, offered, natural, tempered(natural, offered, temperature)))
    return choices


def recorded_choices(scenarios: Sequence[Scenario], goals: Sequence[GoalColumns], temperature: float) -> list[Choices]:
    """As `choose`, from what the goals stage recorded for the same scenarios.

    Raises UnusableInput where they are not the same.
    """
    if [s.scenario_id for s in scenarios] != [g.scenario_id for g in goals]:
        raise UnusableInput("the recorded goals belong to other scenarios: run the goals stage again")
    choices = []
    for scenario, columns in zip(scenarios, goals, strict=True):
        offered, natural = unpack(LaneGraph.of(scenario.map), columns)
        choices.append(Choices(scenario, offered, natural, tempered(natural, offered, temperature)))
    return choices


def tempered(probabilities: Probabilities, candidates: Sequence[Candidates], temperature: float) -> Probabilities:
    """`p ** (1 / temperature)`, normalised, of each manoeuvre as a whole and of the candidates within each manoeuvre.

    Below 1 the likely goals gain, above 1 the unlikely ones. Candidate by candidate alone, whoever may stay where it is would
    nearly always do so: staying is one candidate, driving on is spread over many. At 1 they are the same arrays.
    """
    if temperature == 1.0:  # to normalise would change last bits, which a ratio of the two shows
        return probabilities
    both = zip(probabilities, candidates, strict=True)
    return [_tempered(p.astype(np.float64), c.manoeuvre, 1.0 / temperature) for p, c in both]


def _tempered(p: NDArray[np.float64], manoeuvre: NDArray[np.uint8], power: float) -> NDArray[np.float32]:
    """One vehicle's (C,)."""
    mass, within = (np.bincount(manoeuvre, weights, len(Manoeuvre)) for weights in (p, p**power))
    of_manoeuvre = mass**power / np.where(within > 0, within, 1.0)
    odds = p**power * of_manoeuvre[manoeuvre]
    return np.asarray(odds / odds.sum(), np.float32)
