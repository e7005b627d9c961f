"""Whether the newer of two drivers collides more often than the older one in the same scenes: exact, over recordings, with odds.

Runs of one recording show the same road and vehicles, so they are one piece of evidence: the runs in which the newer driver
alone collided less those in which the older one alone did, its difference. Were the drivers alike, each recording's difference
would have either sign with the same chance. That fixes the distribution of the sum, given how large the differences are (Fisher's
randomisation test), so a false alarm is no more frequent than was asked, with few recordings and collisions, too.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from statistics import NormalDist
from typing import Self

import numpy as np
from numpy.typing import NDArray

_TILTS = np.array([1 / 32, 1 / 16, 1 / 8, 1 / 4, 1 / 2, 1.0])
"""What a worse driver is thought to be, equally likely: half the log odds that a difference of one run is its own."""

_MOST = 700.0
"""Log odds beyond which, either way, a float ends."""

_POWER = 0.9
"""In so many of such sets of runs what is `noticed` would be."""


class Finding(StrEnum):
    """What is said of the newer driver."""

    WORSE = "worse"
    BETTER = "better"
    UNDECIDED = "not told apart"


@dataclass(frozen=True)
class Paired:
    """Two drivers in the same R runs.

    Attributes:
        old, new: in how many each collided; only_old, only_new: in how many it alone did.
        differences: (G,) int64 of each recording, by name.
    """

    runs: int
    old: int
    new: int
    only_old: int
    only_new: int
    differences: NDArray[np.int64]

    @classmethod
    def of(cls, old: NDArray[np.bool_], new: NDArray[np.bool_], recordings: Sequence[str]) -> Self:
        """From whether each driver collided in each run (R,), and the recording of each."""
        names, number = np.unique(np.asarray(recordings), return_inverse=True)
        change = new.astype(np.int64) - old.astype(np.int64)
        differences = np.bincount(number, change, minlength=len(names)).astype(np.int64)
        only_old, only_new = old & ~new, new & ~old
        return cls(len(old), int(old.sum()), int(new.sum()), int(only_old.sum()), int(only_new.sum()), differences)

    def finding(self, alarms: float) -> Finding:
        """Worse, better or neither; alike drivers are called worse in a share `alarms` of all cases at most, and better, too."""
        if chance(self.differences) <= alarms:
            return Finding.WORSE
        return Finding.BETTER if chance(-self.differences) <= alarms else Finding.UNDECIDED

    def noticed(self, alarms: float) -> float:
        """Collisions more that would be noticed in nine of ten such sets of runs, by the normal approximation.

        It takes recordings to differ as much as they do. NaN where so few differ that nothing could be noticed.
        """
        if 0.5 ** np.count_nonzero(self.differences) > alarms:
            return float("nan")
        spread = float(np.sqrt((self.differences.astype(np.float64) ** 2).sum()))
        return spread * (NormalDist().inv_cdf(1 - alarms) + NormalDist().inv_cdf(_POWER))


def chance(differences: NDArray[np.int64]) -> float:
    """How likely alike drivers have a sum of differences (G,) as large as this one, or larger: exact.

    The number of sums is that of all discordant runs and not of all signs, so they are counted size by size.
    """
    sizes = np.abs(differences[differences != 0])
    mass = np.ones(1)  # of the sum of those differences that are positive
    for size in np.sort(sizes).tolist():
        mass = 0.5 * (np.pad(mass, (0, size)) + np.pad(mass, (size, 0)))
    return min(float(mass[int(differences[differences > 0].sum()) :].sum()), 1.0)


def odds(differences: NDArray[np.int64]) -> float:
    """How much likelier the signs of these differences (G,) are for a worse driver than for an alike one: a Bayes factor.

    A worse driver has sign + with log odds 2 k |d| for some k of `_TILTS`, fixed beforehand. So it is a martingale of alike
    drivers as recordings are added: they reach odds of x in one of x cases at most, whenever one stops (Ville's inequality).
    """
    tilted = np.outer(_TILTS, differences[differences != 0].astype(np.float64))
    likelihoods = (tilted - np.logaddexp(tilted, -tilted) + np.log(2.0)).sum(axis=1)
    return float(np.exp(np.clip(np.logaddexp.reduce(likelihoods) - np.log(len(_TILTS)), -_MOST, _MOST)))
