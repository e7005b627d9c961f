"""Testers of mutated drivers: traffic as it is, and adversaries that search against each of them; sound drivers drive the same.

An adversary searches against the driver that is tested, as somebody would who does not know whether it is faulty; what the sound
one does in the scenes so found is seen by nobody before all is over. All runs of a search are kept, those that only look, too;
none is chosen afterwards: so a search favours neither of two drivers that differ by chance alone.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

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
    """The runs that an adversary makes of each mutant, and those of its sound driver through the same scenes.

    What does not depend on who drives is made once for all of them.
    """
    first: Arena | None = None
    for name, mutant in mutants.items():
        arena = Arena(mutant, ground, bounds, seed) if first is None else first.again(mutant)
        first = first or arena
        adversary.attack(arena)
        runs = arena.runs()
        other = replace(runs, outcome=arena.trials.by(mutant.sound).run(runs.variants))
        sound = failures(other.outcome, lambda run, other=other: other.case(run, "sound", ""))  # type: ignore[misc]
        failed = failures(runs.outcome, lambda run, runs=runs: runs.case(run, "mutant", ""), (other.outcome, sound))  # type: ignore[misc]
        order = np.lexsort((runs.query, runs.scenario))
        ids = np.array([choice.scenario.scenario_id for choice in ground.choices])[runs.scenario[order]]
        yield name, Pairs(ids, np.zeros(len(order), np.int64), failed[order], sound[order])
