"""What a driver's failures have in common: P(collision | feature) with denominators, smoothing and intervals.

The paper sends "feature values with the highest collision probability" to the model as a knowledge prompt. Here every
encounter counts, not only the fatal ones, so a feature that is merely frequent does not look dangerous.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegen.corner_cases.encounters import SPEED_EDGES, Behaviour, Direction, Encounters

SHAPE = (len(SPEED_EDGES) + 1, len(Direction), len(Behaviour))
Z95 = 1.959964
"""The normal distribution's central 95 % reach so many standard deviations to either side."""


@dataclass(frozen=True)
class Knowledge:
    """Counts over cells (relative speed, direction, behaviour), pooled over rounds.

    Attributes:
        encounters: SHAPE int64, encounters nearer than the reach that was asked for.
        collisions: SHAPE int64, those that ended in a collision which was not the social vehicle's running up from behind.
        strength: pseudo-encounters by which each cell leans on its marginals.
    """

    encounters: NDArray[np.int64]
    collisions: NDArray[np.int64]
    strength: float

    @classmethod
    def none(cls, strength: float) -> "Knowledge":
        """Nothing known yet."""
        return cls(np.zeros(SHAPE, np.int64), np.zeros(SHAPE, np.int64), strength)

    def with_outcomes(self, met: Encounters, collided: NDArray[np.bool_], reach: float) -> "Knowledge":
        """Add encounters nearer than `reach` [m], those from behind left out; `collided` has their shape."""
        near = met.met & ~met.behind & (met.gap <= reach)
        cells = (met.speed_bin[near], met.direction[near], met.behaviour[near])
        encounters, hit = self.encounters.copy(), self.collisions.copy()
        np.add.at(encounters, cells, 1)
        np.add.at(hit, cells, collided[near].astype(np.int64))
        return Knowledge(encounters, hit, self.strength)

    def __add__(self, other: "Knowledge") -> "Knowledge":
        """Counts of both."""
        return Knowledge(self.encounters + other.encounters, self.collisions + other.collisions, self.strength)

    @property
    def base_rate(self) -> float:
        """P(collision | encounter), smoothed by half a collision in one encounter more (Jeffreys)."""
        return float((self.collisions.sum() + 0.5) / (self.encounters.sum() + 1.0))

    def probability(self) -> NDArray[np.float64]:
        """P(collision | cell), SHAPE: each cell leans on the product of its three marginal odds (naive Bayes prior)."""
        rate = self.base_rate
        odds = np.full(SHAPE, rate / (1 - rate))
        for axis in range(3):
            others = tuple(a for a in range(3) if a != axis)
            encounters, hit = self.encounters.sum(others), self.collisions.sum(others)
            marginal = (hit + self.strength * rate) / (encounters + self.strength)
            shape = [1, 1, 1]
            shape[axis] = -1
            odds = odds * ((marginal / (1 - marginal)) / (rate / (1 - rate))).reshape(shape)
        prior = odds / (1 + odds)
        return np.asarray((self.collisions + self.strength * prior) / (self.encounters + self.strength))

    def rows(self) -> list[dict[str, Any]]:
        """One row per feature value that occurred: counts, probability and its 95 % Wilson interval, riskiest first."""
        features: tuple[tuple[str, list[str]], ...] = (
            ("relative speed [m/s]", speed_names()),
            ("direction", [d.name.lower() for d in Direction]),
            ("behaviour", [b.name.lower() for b in Behaviour]),
        )
        rows: list[dict[str, Any]] = []
        for axis, (feature, values) in enumerate(features):
            others = tuple(a for a in range(3) if a != axis)
            for value, met, hit in zip(values, self.encounters.sum(others), self.collisions.sum(others), strict=True):
                if met:
                    low, high = wilson(int(hit), int(met))
                    rows.append(
                        {
                            "feature": feature,
                            "value": value,
                            "encounters": int(met),
                            "collisions": int(hit),
                            "probability": round(float(hit / met), 6),
                            "low": round(low, 6),
                            "high": round(high, 6),
                        }
                    )
        return sorted(rows, key=lambda row: (-row["probability"], row["feature"], row["value"]))

    def to_json(self) -> dict[str, Any]:
        """Plain lists, for the record."""
        return {"encounters": self.encounters.tolist(), "collisions": self.collisions.tolist(), "strength": self.strength}

    @classmethod
    def from_json(cls, value: dict[str, Any]) -> "Knowledge":
        """The inverse of `to_json`."""
        encounters, hit = np.asarray(value["encounters"], np.int64), np.asarray(value["collisions"], np.int64)
        return cls(encounters.reshape(SHAPE), hit.reshape(SHAPE), float(value["strength"]))


def wilson(hits: int, trials: int) -> tuple[float, float]:
    """95 % Wilson score interval of a proportion; (0, 1) without trials."""
    if trials == 0:
        return 0.0, 1.0
    p, z2 = hits / trials, Z95**2
    centre = (p + z2 / (2 * trials)) / (1 + z2 / trials)
    half = Z95 * np.sqrt(p * (1 - p) / trials + z2 / (4 * trials**2)) / (1 + z2 / trials)
    return max(0.0, float(centre - half)), min(1.0, float(centre + half))


def speed_names() -> list[str]:
    """The relative-speed bins [m/s] in words."""
    edges = [f"{edge:g}" for edge in SPEED_EDGES]
    return [f"below {edges[0]}", *(f"{a} to {b}" for a, b in pairwise(edges)), f"above {edges[-1]}"]
