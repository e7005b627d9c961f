"""What adversaries find of what is there to be found: every goal of every vehicle is driven, so it is known who can fail where.

A scenario is *open* if the driver has a counted collision in it as it is, or once one goal is exchanged that the arena allows.
Who exchanges goals one at a time, among the same motions, finds nothing beyond these; who varies goals, too, may.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries.base import Adversary
from drivegen.adversaries.shared.arena import Arena, Runs
from drivegen.adversaries.shared.candidates import Candidates
from drivegen.adversaries.shared.findings import handed_over
from drivegen.adversaries.shared.goals import exchanged_goals
from drivegen.corner_cases.trials import Variants

EVERY, VARIED = "every_goal", "drivegen_cs"
"""What is there to be found, as a method; and the adversary that searches in several variants, `drivegen_cs.<variant>`."""

CHUNK = 8192
"""Goals that are driven together: motion of a hundred thousand takes gigabytes."""


@dataclass(frozen=True)
class Search:
    """What an adversary found in C scenarios.

    Attributes:
        first: (C,) the run in which the driver first had a counted collision, inf where it never had.
        avoidable: (C,) the same of one that could have been avoided.
    """

    first: NDArray[np.float64]
    avoidable: NDArray[np.float64]

    @classmethod
    def of(cls, runs: Runs) -> "Search":
        """Judge failures in each scenario until one could have been avoided."""
        first = np.full(len(runs.arena.ground.choices), np.inf)
        failed = np.flatnonzero(runs.outcome.counted)
        np.minimum.at(first, runs.scenario[failed], runs.query[failed])
        handed, avoidable = handed_over(runs)
        return cls(first, np.where(avoidable, runs.query[handed], np.inf))


@dataclass(frozen=True)
class Recall:
    """Of C scenarios.

    Attributes:
        scenarios: (C,) ids. open: (C,) see the module. searches: by method.
    """

    scenarios: list[str]
    open: NDArray[np.bool_]
    searches: Mapping[str, Search]

    @classmethod
    def of(cls, arena: Arena, adversaries: Mapping[str, Adversary], draws: int) -> "Recall":
        """Drive all goals, `draws` motions towards each, and let every adversary search in an arena of its own."""
        names = [choice.scenario.scenario_id for choice in arena.ground.choices]
        is_open, searches = open_scenarios(arena, draws), {}
        for name, adversary in adversaries.items():
            own = arena.again(arena.trials.driver)
            adversary.attack(own)
            searches[name] = Search.of(own.runs())
        return cls(names, is_open, searches)

    @classmethod
    def joined(cls, parts: "Sequence[Recall]") -> "Recall":
        """Scenarios of all parts, in order; at least one part, the same methods in all."""
        of_methods = {name: [part.searches[name] for part in parts] for name in parts[0].searches}
        return cls(
            [name for part in parts for name in part.scenarios],
            np.concatenate([part.open for part in parts]),
            {
                name: Search(np.concatenate([one.first for one in own]), np.concatenate([one.avoidable for one in own]))
                for name, own in of_methods.items()
            },
        )


def open_scenarios(arena: Arena, draws: int) -> NDArray[np.bool_]:
    """(C,) which scenarios are open. These runs are not the arena's: they take nothing of its budget."""
    scenes = np.arange(len(arena.ground.of))
    fails = arena.trials.run(Variants.unchanged(scenes, arena.trials.steps)).counted.copy()
    pool = exchanged_goals(arena, draws, scenes)
    for low in range(0, len(pool), CHUNK):
        for row in _failing(arena, pool, np.arange(low, min(low + CHUNK, len(pool)))).tolist():
            scene = int(pool.scene[row])
            fails[scene] = fails[scene] or arena.fits(scene, pool.vehicle[row : row + 1], pool.motion[row : row + 1])
    return np.bincount(arena.ground.of, fails, len(arena.ground.choices)) > 0


def _failing(arena: Arena, pool: Candidates, rows: NDArray[np.int64]) -> NDArray[np.int64]:
    outcome = arena.trials.run(Variants.one_each(pool.scene[rows], pool.vehicle[rows], pool.motion[rows]))
    return rows[outcome.counted]
