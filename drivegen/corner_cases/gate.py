"""The release gate: two drivers, or two versions of one, through the same scenes, and whether the new one collides more often.

Counted are collisions that say something of the driver (`DrivingOutcome.counted`) or, of these, the avoidable ones. Scenes must
not have been chosen for what one of the two did in them: cases found against the old one flatter the new one.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.intervals import Interval, bootstrap_means, recording
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.core.seeds import rng
from drivegen.core.settings import Count, Within
from drivegen.core.wording import many
from drivegen.corner_cases.case import Case
from drivegen.corner_cases.failures import NONE, Failures, failures, replayed_case
from drivegen.drivers.base import Driver
from drivegen.metrics.paired import Finding, Paired, chance, odds
from drivegen.simulators.batch import Plugin as Batch
from drivegen.world.outcome import DrivingOutcome, with_off_road

BLOCK = 4096
"""Runs that are in memory with all that is known of them."""

ASTRAY = 0.01
"""Who is off the road for so much more of its time than the other is said to be."""

Futures = Sequence[tuple[Scenario, int, Trajectories]]
"""Scenarios, the number of a future of each (0 of a log), and its motion."""


@dataclass(frozen=True)
class Settings:
    """`alarms`: share of alike drivers that may be called worse; `avoidable`: only such collisions count; bootstrap `draws`."""

    alarms: Annotated[float, Within(0, 0.5, above=True)]
    avoidable: bool
    draws: Count


@dataclass(frozen=True)
class Gate:
    """What R runs say of two drivers.

    Attributes:
        scenarios, samples: of each run, its scenario and the number of its future there.
        collided: (2, R) whether each driver did, the old one's first. paired: what follows.
        off_road: (2,) of all its time the share that each driver has a corner off the road.
        shares: of collisions, of the old driver, of the new one, and the latter less the former, with intervals over recordings.
    """

    settings: Settings
    scenarios: Sequence[str]
    samples: Sequence[int]
    collided: NDArray[np.bool_]
    paired: Paired
    shares: Sequence[Interval]
    off_road: tuple[float, float]

    @property
    def finding(self) -> Finding:
        """Worse, better, or not told apart."""
        return self.paired.finding(self.settings.alarms)

    @property
    def counted(self) -> str:
        """What is counted, in words."""
        return f"{self._kind}s"

    @property
    def _kind(self) -> str:
        return "avoidable collision" if self.settings.avoidable else "counted collision"

    def sentence(self, old: str, new: str) -> str:
        """The verdict on two drivers of these names, and whether the new one leaves the road, where it hits nobody."""
        before, after = self.off_road
        astray = f"; {new} is off the road for {after:.1%} of its time, {old} for {before:.1%}" if after > before + ASTRAY else ""
        return self._verdict(old, new) + astray

    def _verdict(self, old: str, new: str) -> str:
        paired, more = self.paired, self.paired.new - self.paired.old
        where = f"in {many(paired.runs, 'run')} of {many(len(paired.differences), 'recording')}"
        if self.finding == Finding.UNDECIDED:
            collided = many(paired.old, self._kind)
            return f"{self.finding}: {where} {old} has {collided}, {new} {paired.new}; {self._why_not()}"
        sign = 1 if self.finding == Finding.WORSE else -1
        share = f" ({more / paired.old:+.0%})" if paired.old else ""
        alike, likelier = chance(sign * paired.differences), odds(sign * paired.differences)
        said = f" odds {_to_one(likelier)} that it is {self.finding} rather than alike;" if likelier > 1 else ""
        return (
            f"{self.finding}: {where} {new} has {abs(more)} {self.counted} {'more' if sign > 0 else 'fewer'} than {old}{share};"
            f"{said} of alike drivers {alike:.2g} differ so"
        )

    def _why_not(self) -> str:
        paired = self.paired
        if not paired.differences.any():
            return "each recording has as many of both"
        least = paired.noticed(self.settings.alarms)
        if np.isnan(least):
            return f"recordings that differ: {np.count_nonzero(paired.differences)}, too few to tell: give more recordings"
        share = f" ({least / paired.old:.0%})" if paired.old else ""
        worse, better = (_to_one(odds(sign * paired.differences)) for sign in (1, -1))
        said = f"odds {worse} that it is worse rather than alike, {better} that it is better"
        return f"{said}; about {least:.0f} more{share} would be noticed"

    def record(self, old: str, new: str) -> dict[str, Any]:
        """All of it for programs; `differ` are the runs in which one collided and the other did not."""
        paired, differences = self.paired, self.paired.differences
        differ = np.flatnonzero(self.collided[0] != self.collided[1]).tolist()
        return {
            "finding": self.finding,
            "sentence": self.sentence(old, new),
            "counted": self.counted,
            "runs": paired.runs,
            "recordings": len(differences),
            "collisions": {"old": paired.old, "new": paired.new, "only_old": paired.only_old, "only_new": paired.only_new},
            "off_road": dict(zip(("old", "new"), self.off_road, strict=True)),
            "shares": {name: asdict(one) for name, one in zip(("old", "new", "difference"), self.shares, strict=True)},
            "chance_if_alike": {"worse": chance(differences), "better": chance(-differences)},
            "odds_over_alike": {"worse": odds(differences), "better": odds(-differences)},
            "noticed": paired.noticed(self.settings.alarms),
            "settings": asdict(self.settings),
            "differ": [
                {
                    "scenario": self.scenarios[run],
                    "sample": self.samples[run],
                    "collided": "new" if self.collided[1, run] else "old",
                }
                for run in differ
            ],
        }


def gate(old: Driver, new: Driver, futures: Futures, settings: Settings, seed: int) -> Gate:
    """Drive both through all `futures`, neighbours replayed, and compare. Raises UnusableInput where there are none."""
    if not futures:
        raise UnusableInput("there is no scene to drive both through", reason="no-scenarios")
    traffic = [(scenario, motion) for scenario, _, motion in futures]
    blocks = [traffic[first : first + BLOCK] for first in range(0, len(traffic), BLOCK)]
    driven = [_driven((old, new), block, settings.avoidable) for block in blocks]
    collided, off_road, steps = (np.concatenate(parts, axis=1) for parts in zip(*driven, strict=True))
    scenarios = [scenario.scenario_id for scenario, _ in traffic]
    recordings = [recording(name) for name in scenarios]
    values = np.stack([*collided, collided[1].astype(np.int64) - collided[0]], axis=1).astype(np.float64)
    shares = bootstrap_means(values, recordings, settings.draws, rng(seed, "gate", "bootstrap"))
    paired = Paired.of(collided[0], collided[1], recordings)
    before, after = ((off_road * steps).sum(axis=1) / steps.sum(axis=1)).tolist()
    return Gate(settings, scenarios, [k for _, k, _ in futures], collided, paired, shares, (before, after))


def _driven(
    drivers: Sequence[Driver], traffic: Sequence[tuple[Scenario, Trajectories]], avoidable: bool
) -> tuple[NDArray[np.bool_], NDArray[np.float32], NDArray[np.int64]]:
    """(D, R) whether each driver has a collision that counts in each run, its share of the run off the road, its steps there."""
    scenarios = [scenario for scenario, _ in traffic]
    outcomes = Batch().run_each(drivers, scenarios, [motion for _, motion in traffic])
    off_road = np.stack([with_off_road(outcome, scenarios).off_road for outcome in outcomes])
    steps = np.stack([outcome.motion.valid.sum(axis=1) for outcome in outcomes])
    if not avoidable:
        return np.stack([outcome.counted for outcome in outcomes]), off_road, steps
    failed: list[Failures] = []
    for outcome, driver in zip(outcomes, drivers, strict=True):
        known = (outcomes[0], failed[0]) if failed else None

        def case(run: int, outcome: DrivingOutcome = outcome, driver: Driver = driver) -> Case:
            return replayed_case(*traffic[run], outcome, run, driver.name)

        failed.append(failures(outcome, case, known))
    return np.not_equal(np.stack(failed), NONE).astype(np.bool_), off_road, steps


def _to_one(value: float) -> str:
    """Odds as they are said."""
    return f"{value:.3g} to 1" if value >= 1 else f"1 to {1 / value:.3g}"
