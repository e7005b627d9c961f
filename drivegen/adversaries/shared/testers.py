"""Testers of mutated drivers: traffic as it is, which the sound drivers drive through, too, and adversaries that search.

An adversary searches against the mutant, and as long against the sound driver, from the same scenes and by the same seed: which
of the two fails more often under attack? Scenes found against one of them and then driven by the other would not tell: they are
the first one's, and any two drivers that differ at all would each look worse in its own. All runs of a search count, those that
only look, too, and none is chosen by how it ended; where one of the two has more of them in a scenario, its last ones are left
out.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries.base import Adversary
from drivegen.adversaries.shared.arena import Arena, Bounds, Ground
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.corner_cases.failures import Failures, failures, replayed_case
from drivegen.drivers.base import Driver
from drivegen.drivers.mutants.table import Mutant
from drivegen.metrics.mutation_score import Pairs
from drivegen.simulators.batch import Plugin as Batch
from drivegen.world.outcome import DrivingOutcome


def by_traffic(
    mutants: Mapping[str, Mutant], scenarios: Sequence[Scenario], traffic: Sequence[Trajectories], turn: Sequence[int]
) -> dict[str, Pairs]:
    """R runs of each mutant and of its sound driver through traffic (N, T), replayed as it is; `turn` (R,) as in `Pairs`."""
    ids = np.array([scenario.scenario_id for scenario in scenarios])
    sound = {id(mutant.sound): mutant.sound for mutant in mutants.values()}
    ran = Batch().run_each([*sound.values(), *mutants.values()], scenarios, traffic)

    def judged(driver: Driver, outcome: DrivingOutcome, known: tuple[DrivingOutcome, Failures] | None = None) -> Failures:
        return failures(outcome, lambda run: replayed_case(scenarios[run], traffic[run], outcome, run, driver.name), known)

    failed = {key: (out, judged(sound[key], out)) for key, out in zip(sound, ran[: len(sound)], strict=True)}
    found: dict[str, Pairs] = {}
    for (name, mutant), outcome in zip(mutants.items(), ran[len(sound) :], strict=True):
        known = failed[id(mutant.sound)]
        found[name] = Pairs(ids, np.array(turn, np.int64), judged(mutant, outcome, known), known[1])
    return found


def by_search(
    mutants: Mapping[str, Mutant], adversary: Adversary, ground: Ground, bounds: Bounds, seed: int
) -> Iterator[tuple[str, Pairs]]:
    """The runs that an adversary makes of each mutant, beside as many that it makes of its sound driver in the same scenario.

    What does not depend on who drives is made once for all of them.
    """
    one, *others = {id(mutant.sound): mutant.sound for mutant in mutants.values()}.values()
    arena = Arena(one, ground, bounds, seed)
    sound = {id(one): _attacked(adversary, arena)}  # after it the arena has what the others share
    sound |= {id(driver): _attacked(adversary, arena.again(driver)) for driver in others}
    for name, mutant in mutants.items():
        yield name, _beside(_attacked(adversary, arena.again(mutant)), sound[id(mutant.sound)])


def _attacked(adversary: Adversary, arena: Arena) -> list[tuple[str, NDArray[np.object_]]]:
    """Of each scenario that was driven in: its id, and by what kind of failure each run ended, in the order of the search."""
    adversary.attack(arena)
    runs = arena.runs()
    failed = failures(runs.outcome, lambda run: runs.case(run, "", ""))
    order = np.lexsort((runs.query, runs.scenario))
    scenario, first = np.unique(runs.scenario[order], return_index=True)
    ids = [arena.ground.choices[number].scenario.scenario_id for number in scenario.tolist()]
    return list(zip(ids, np.split(failed[order], first[1:]), strict=True))


def _beside(mutant: list[tuple[str, NDArray[np.object_]]], sound: list[tuple[str, NDArray[np.object_]]]) -> Pairs:
    """Run by run in each scenario; what only one of the two had of a scenario's runs is left out."""
    other = dict(sound)
    both = [(name, *_as_many(failed, other[name])) for name, failed in mutant if name in other]
    ids = np.repeat([name for name, _, _ in both], [len(failed) for _, failed, _ in both])
    own, its = (np.concatenate([each[side] for each in both]) for side in (1, 2))
    return Pairs(ids, np.zeros(len(ids), np.int64), own, its)


def _as_many(one: NDArray[np.object_], other: NDArray[np.object_]) -> tuple[NDArray[np.object_], NDArray[np.object_]]:
    count = min(len(one), len(other))
    return one[:count], other[:count]
