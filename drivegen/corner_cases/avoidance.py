"""Whether a corner case could have been avoided, until when, and how much time there was between its first cue and that moment.

Two careful drivers are asked, each from every moment up to LONGEST before the collision, the target driven until then as it was:
* `evasive`: brakes by up to 6 m/s2, at once, and moves aside by up to 3.5 m, at 3 m/s2, if the road is wide enough;
* `braking`: UN R157's careful and competent human driver: 0.774 g, reached after 0.6 s, straight on. It perceives a risk 0.4 s
  after the first cue and begins to brake 0.75 s later.

The moment is sought every half second and in the first step of all, then every tenth between the last half second that is early
enough and the one after it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
import torch
from numpy.typing import NDArray

from drivegen.core.scenario import DT
from drivegen.corner_cases.case import Case
from drivegen.corner_cases.cue import cues
from drivegen.corner_cases.reenactment import Evasion, Reenactment
from drivegen.world.reactive import Reaction

EVASIVE = tuple(Evasion(braking, 0.0, offset) for braking in (6.0, 3.0, 0.0) for offset in (0.0, 1.0, -1.0, 2.0, -2.0, 3.5, -3.5))
BRAKING = Evasion(0.774 * 9.81, 0.6)

RESPONSE = 12
"""[steps] From the cue until UN R157's driver brakes: 0.4 s to perceive the risk and 0.75 s to react, rounded up."""

COARSE, LONGEST = 5, 50
"""[steps] Moments are looked at every COARSE, up to LONGEST before the collision."""

CHUNK = 32
"""Cases that are judged together."""


class Avoidable(StrEnum):
    """By the time between the first cue and the last moment: none; less than a careful human driver takes to react; more."""

    NO = "unavoidable"
    SUDDEN = "sudden"
    WARNED = "with warning"


@dataclass(frozen=True)
class Avoidance:
    """How a case could have been avoided.

    Attributes:
        cue: [s] before the collision that it could first be seen coming.
        latest: [s] before the collision of the last moment at which the evasive driver avoids it, NaN if it never does.
        latest_braking: the same of UN R157's driver.
    """

    cue: float
    latest: float
    latest_braking: float

    @property
    def budget(self) -> float:
        """[s] From the first cue to the last moment to act; negative if that lies before it, NaN if never."""
        return self.cue - min(self.latest, self.latest_braking, key=lambda x: (np.isnan(x), x))

    @property
    def verdict(self) -> Avoidable:
        """Its class."""
        if not self.budget >= 0:
            return Avoidable.NO
        return Avoidable.WARNED if round(self.budget / DT) >= RESPONSE else Avoidable.SUDDEN


def judge(cases: Sequence[Case], reaction: Reaction | None = None) -> list[Avoidance]:
    """How each of `cases` could have been avoided; everybody but the attacker reacts by `reaction`, or all are replayed."""
    torch.set_num_threads(1)  # tensors are small, and sums depend on the thread count
    parts = [cases[first : first + CHUNK] for first in range(0, len(cases), CHUNK)]
    return [one for part in parts for one in _judge(Reenactment.of(part), reaction)]


def _judge(cases: Reenactment, reaction: Reaction | None) -> Iterator[Avoidance]:
    cue = cues(cases)
    evasive = latest(cases, EVASIVE, reaction)
    braking = latest(cases, (BRAKING,), reaction)
    for c, contact in enumerate(cases.contact.tolist()):
        yield Avoidance((contact - int(cue[c])) * DT, _seconds(evasive[c]), _seconds(braking[c]))


def latest(cases: Reenactment, evasions: Sequence[Evasion], reaction: Reaction | None) -> NDArray[np.int64]:
    """(C,) the fewest steps before the collision at which some evasion still avoids each case, 0 where none does."""
    before = np.minimum(np.arange(COARSE, LONGEST + 1, COARSE), cases.contact[:, None])  # the first step is asked, too
    before[:, 1:][before[:, 1:] == before[:, :-1]] = 0
    coarse = _first(cases, before, evasions, reaction)
    between = np.maximum(coarse[:, None] - np.arange(COARSE - 1, 0, -1), 0)  # 0 where nothing is to be refined
    fine = _first(cases, between, evasions, reaction)
    return np.where(fine > 0, fine, coarse)


def _first(
    cases: Reenactment, before: NDArray[np.int64], evasions: Sequence[Evasion], reaction: Reaction | None
) -> NDArray[np.int64]:
    """(C,) the first of `before` (C, K) [steps, rising, 0 for none] ahead of contact at which an evasion avoids it, else 0."""
    case, k = np.nonzero((before > 0) & (before <= cases.contact[:, None]))
    steps = np.repeat(cases.contact[case] - before[case, k], len(evasions))
    good = cases.avoids(np.repeat(case, len(evasions)), steps, list(evasions) * len(case), reaction)
    helps = np.zeros(before.shape, np.bool_)
    helps[case, k] = good.reshape(len(case), len(evasions)).any(1)
    return np.where(helps.any(1), before[np.arange(len(before)), helps.argmax(1)], 0)


def _seconds(steps: np.integer) -> float:
    return float(steps * DT) if steps else float("nan")
