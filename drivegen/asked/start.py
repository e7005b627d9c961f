"""The first frame of what was asked for: some placements are drawn, and the first is taken that has all that was wished."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drivegen.asked.goals import Duty, Ordered, ordered
from drivegen.asked.wishes import Cast, Fill, cast
from drivegen.core import seeds
from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import Scenario
from drivegen.core.settings import Count
from drivegen.generators.base import Settings as GeneratorSettings
from drivegen.placement.scenes import Initialiser
from drivegen.roads.graph import LaneGraph
from drivegen.rollout.choices import Choices, choose
from drivegen.selectors.base import Selector
from drivegen.words.request import TrafficRequest

UNLIKELY = 0.05
"""A start is good enough where the selector itself gives the goals of every manoeuvre at least this probability."""


@dataclass(frozen=True)
class Settings:
    """How what is asked for is looked for.

    Attributes:
        densities: by their words, see `Fill`.
        placements: drawn for one in which everybody stands as wished.
        starts: of those, looked at for one in which every manoeuvre has a likely goal.
    """

    densities: dict[str, Fill]
    placements: Count
    starts: Count


@dataclass(frozen=True)
class AskedStart:
    """A first frame and its goals.

    Attributes:
        scenario: who stands where. cast: who was asked for. number: (N,) which of the cast each vehicle is.
        rejected: how many were not placed, by reason. duties: manoeuvres of vehicles that were placed.
        free: choices as nobody asked for anything. ordered: choices under the duties.
    """

    scenario: Scenario
    cast: Cast
    number: NDArray[np.intp]
    rejected: Mapping[str, int]
    duties: tuple[Duty, ...]
    free: Choices
    ordered: Ordered

    def vehicle(self, number: int) -> int | None:
        """The scenario's vehicle that is the asked vehicle `number`; None if it found no place."""
        places = np.flatnonzero(self.number == number)
        return int(places[0]) if len(places) else None

    def only(self, present: NDArray[np.intp]) -> "AskedStart":
        """The first frame of the vehicles `present` alone, as it is written where a future leaves others out; no duties."""
        scenario = replace(self.scenario, vehicles=self.scenario.vehicles[present])
        free = replace(self.free, scenario=scenario, candidates=[self.free.candidates[n] for n in present.tolist()])
        return replace(self, scenario=scenario, number=self.number[present], duties=(), free=free)


def start(
    initialiser: Initialiser,
    name: str,
    request: TrafficRequest,
    settings: Settings,
    vehicles: int,
    selector: Selector,
    generation: GeneratorSettings,
    seed: int,
) -> AskedStart:
    """The best start of those drawn: most wishes placed first, then most manoeuvres with a goal, then the
    likeliest goals. Same seed, same start.

    `vehicles` in all where the request does not say how many. Raises UnusableInput, reason `no-place`, where the map has no
    room for the target, and for kinds that the asset table lacks.
    """
    best: AskedStart | None = None
    looked_at = 0
    for placed in _placements(initialiser, name, request, settings, vehicles, seed):
        if best is not None and any(_missing(placed)) and _missing(placed) >= _missing(best):
            continue
        looked_at += 1
        start = _with_goals(placed, selector, generation)
        if best is None or _lacks(start) < _lacks(best):
            best = start
        if not any(_lacks(best)) or looked_at >= settings.starts:
            break
    assert best is not None
    return best


@dataclass(frozen=True)
class _Placed:
    scenario: Scenario
    cast: Cast
    number: NDArray[np.intp]
    rejected: Mapping[str, int]


def _placements(
    initialiser: Initialiser, name: str, request: TrafficRequest, settings: Settings, vehicles: int, seed: int
) -> Iterator[_Placed]:
    """Those in which there is room for the target, which differs from turn to turn. Raises UnusableInput where there never is."""
    room = False
    for turn in range(settings.placements):
        random = seeds.rng(seed, "asked", name, turn)
        try:
            asked = cast(request, settings.densities, vehicles, random, left_hand=initialiser.left_hand)
            if asked.radius is None and len(asked) > vehicles:  # more than usual need more road
                asked = replace(asked, radius=initialiser.radius * len(asked) / vehicles)
            placed = _placed(initialiser, name, asked, random)
        except UnusableInput as error:
            if error.reason != "no-place" or (turn + 1 == settings.placements and not room):
                raise
            continue
        room = True
        yield placed


def _placed(initialiser: Initialiser, name: str, asked: Cast, random: np.random.Generator) -> _Placed:
    rows = [
        initialiser.drawn_rows(1, random)[0] if kind.vehicle_kind is None else initialiser.row_of(kind.vehicle_kind, random)
        for kind in asked.kinds
    ]
    scenario, placement = initialiser.begin(name, rows, random, asked.wishes, asked.radius)
    return _Placed(scenario, asked, placement.number, placement.rejected)


def _with_goals(placed: _Placed, selector: Selector, generation: GeneratorSettings) -> AskedStart:
    scenario = placed.scenario
    at = {int(number): vehicle for vehicle, number in enumerate(placed.number)}
    duties = tuple(Duty(at[order.number], order.manoeuvre, order.within) for order in placed.cast.orders if order.number in at)
    free = choose([scenario], selector, generation.candidates, generation.temperature)[0]
    bound = ordered(LaneGraph.of(scenario.map), free, selector, duties)
    return AskedStart(scenario, placed.cast, placed.number, placed.rejected, duties, free, bound)


def _missing(start: "_Placed | AskedStart") -> tuple[int, int]:
    """How many found no place: of those with a wish, and of all."""
    there = set(start.number.tolist())
    wished = sum(wish.stands and number not in there for number, wish in enumerate(start.cast.wishes))
    return wished, len(start.cast) - len(there)


def _lacks(start: AskedStart) -> tuple[float, ...]:
    """What is missing, the gravest first: wished vehicles, manoeuvres without a goal, vehicles, likelihood of the goals."""
    wished, missing = _missing(start)
    unlikely = sum(np.log(UNLIKELY / max(mass, 1e-6)) for mass in start.ordered.natural if mass < UNLIKELY)
    return wished, len(start.cast.orders) - sum(start.ordered.feasible), missing, float(unlikely)
