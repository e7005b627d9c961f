"""What an adversary's runs came to, scenario by scenario, and the cases among them."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries.shared.arena import Runs
from drivegen.core.intervals import recording
from drivegen.core.samples import Samples
from drivegen.core.scenario import Trajectories
from drivegen.core.seeds import rng
from drivegen.corner_cases.avoidance import Avoidable, judge
from drivegen.corner_cases.case import Case
from drivegen.corner_cases.kinds import kind_of
from drivegen.corner_cases.survival import Reacting, holds
from drivegen.drivers.base import Driver
from drivegen.metrics.driving import driving_summary
from drivegen.simulators.shared.drives import kind_shares, run_metrics
from drivegen.world.reactive import Reaction

_NOTHING, _COLLIDED, _UNAVOIDABLE, _AVOIDABLE = range(4)
"""What a run is worth: no collision, one that does not count, one that does, one that does and could have been avoided."""


@dataclass(frozen=True)
class Findings:
    """Of C scenarios, by the one run that is handed over of each (`handed_over`).

    Attributes:
        scenarios: (C,) ids. metrics: (C,) arrays by name; NaN where a scenario has none.
        motion: (C, T) of the driven targets. cases: those handed-over runs that count. kinds: of each case.
    """

    scenarios: list[str]
    metrics: dict[str, NDArray[np.float64]]
    motion: Trajectories
    cases: list[Case]
    kinds: list[str]

    @classmethod
    def of(cls, runs: Runs, driver: Driver, method: str, law: Reaction) -> "Findings":
        """Judge the runs of `driver` that `method` has made; neighbours that react do so by `law`.

        `cases` counts all counted runs, not only those that are handed over; `first` is the query that first counted.
        `avoidable` is a share of scenarios; the last six are of cases alone. Raises AssertionError for a scenario without a run.
        """
        (best, avoidable), outcome = handed_over(runs), runs.outcome
        assert (best >= 0).all(), "an adversary left out a scenario"  # its -1 would be another's run
        good, scenario = outcome.counted, runs.scenario
        chosen = np.flatnonzero(good[best])
        cases = [runs.case(int(best[c]), driver.name, method) for c in chosen.tolist()]
        every = {
            name: np.asarray(value[best], np.float64) for name, value in (run_metrics(outcome) | kind_shares(outcome)).items()
        }
        first = np.full(len(best), np.inf)
        np.minimum.at(first, scenario[good], runs.query[good])

        def of_cases(values: Sequence[float]) -> NDArray[np.float64]:
            whole = np.full(len(best), np.nan)
            whole[chosen] = values
            return whole

        own = {
            "counted": good[best].astype(np.float64),
            "cases": np.bincount(scenario, good, len(best)),
            "queries": np.bincount(scenario, minlength=len(best)).astype(np.float64),
            "first": np.where(np.isinf(first), np.nan, first),
            "avoidable": avoidable.astype(np.float64),
            "legal_share": of_cases([case.legal for case in cases]),
            "survives_reaction": of_cases(holds(cases, driver, Reacting.ALL, law).tolist()),
            "odds": of_cases([case.odds for case in cases]),
            "attacker": of_cases([case.attacker for case in cases]),
            "impact.step": of_cases([case.step for case in cases]),
            "impact.partner": of_cases([case.partner for case in cases]),
        }
        names = [choice.scenario.scenario_id for choice in runs.arena.ground.choices]
        return cls(names, every | own, outcome.motion[best], cases, [str(kind_of(case)) for case in cases])

    @classmethod
    def joined(cls, parts: "Sequence[Findings]") -> "Findings":
        """Scenarios of all parts, in order."""
        return cls(
            [name for part in parts for name in part.scenarios],
            {name: np.concatenate([part.metrics[name] for part in parts]) for name in parts[0].metrics},
            Trajectories.joined([part.motion for part in parts]),
            [case for part in parts for case in part.cases],
            [kind for part in parts for kind in part.kinds],
        )

    @property
    def samples(self) -> list[Samples]:
        """The traffic of the cases, one sample each."""
        return [_sample(case, case.traffic, case.violation, case.odds) for case in self.cases]

    @property
    def driven(self) -> list[Samples]:
        """The targets of the cases, alone, as they were driven."""
        return [_sample(case, case.driven[np.newaxis], 0, np.nan) for case in self.cases]

    def summary(self, draws: int, seed: int) -> dict[str, Any]:
        """Means with intervals over recordings (`driving_summary`), how many kinds there are, and how often each."""
        random = rng(seed, "attack", "bootstrap")
        recordings = [recording(name) for name in self.scenarios]
        numbers = driving_summary(self.metrics, recordings, self.motion, np.arange(len(recordings)), draws, random)
        kinds = Counter(sorted(self.kinds))
        return {**numbers, "kinds": len(kinds), "of_kind": dict(kinds)}


def handed_over(runs: Runs) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """(C,) the run that is handed over of each scenario, -1 where it has none, and (C,) whether it ends in an avoidable case.

    The first that counts and could have been avoided, else the first that counts, else the first with any collision, else the
    last. Runs are judged until that is known.
    """
    outcome = runs.outcome
    worth = np.where(outcome.counted, _AVOIDABLE, np.where(outcome.collided, _COLLIDED, _NOTHING))
    judged = np.zeros(len(worth), np.bool_)
    while True:
        best = runs.best(worth)
        asked = best[best >= 0]
        asked = asked[outcome.counted[asked] & ~judged[asked]]
        if not len(asked):
            return best, (best >= 0) & (worth[best] == _AVOIDABLE)
        judged[asked] = True
        verdicts = judge([runs.case(run, "", "") for run in asked.tolist()])
        worth[asked] = [_UNAVOIDABLE if each.verdict == Avoidable.NO else _AVOIDABLE for each in verdicts]


def _sample(case: Case, motion: Trajectories, violation: int, odds: float) -> Samples:
    whole = Samples.without_goals(case.scenario_id, case.method, motion[np.newaxis])
    if violation:
        whole.violation[0, case.attacker] = violation
    if case.attacker < motion.valid.shape[0]:
        whole.natural[0, case.attacker] = whole.used[0, case.attacker] = odds
    return whole
