"""How good candidates and their ranking are, against logged ends: coverage, likelihood, hits, expected error.

The label of a vehicle is the candidate nearest to its logged end. Only vehicles that are seen (nearly) to the end of the
horizon can be scored, since candidates are meant for its last step.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.goals.candidates import Candidates, Manoeuvre
from drivegen.scenario import Scenario

SEEN = 0.95
"""A track counts if it is seen up to this share of the horizon."""

MOVING = 2.0
"""A vehicle that ends farther than this from where it began [m] moved."""

NEAR = (2.0, 4.0)
"""Coverage is the share of vehicles with a candidate within these distances [m]."""


@dataclass(frozen=True)
class Judged:
    """V vehicles with a scorable end.

    Attributes:
        distance: V arrays (C,) [m] of each candidate from the logged end. probability: V arrays (C,).
        manoeuvre: V arrays (C,). moved: (V,) bool.
    """

    distance: list[NDArray[np.float32]]
    probability: list[NDArray[np.float32]]
    manoeuvre: list[NDArray[np.uint8]]
    moved: NDArray[np.bool_]

    @classmethod
    def joined(cls, parts: "Sequence[Judged]") -> "Judged":
        """All of them."""
        return cls(
            [d for part in parts for d in part.distance],
            [p for part in parts for p in part.probability],
            [m for part in parts for m in part.manoeuvre],
            np.concatenate([np.zeros(0, np.bool_), *(part.moved for part in parts)]),
        )


def scorable(scenario: Scenario) -> NDArray[np.bool_]:
    """(N,) vehicles that are seen at step 0 and long enough for their end to be a label."""
    if scenario.log is None:
        return np.zeros(len(scenario.vehicles), np.bool_)
    seen: NDArray[np.bool_] = scenario.log.valid[:, 0] & (scenario.log.last_valid() >= SEEN * scenario.horizon)
    return seen


def judge(scenario: Scenario, candidates: Sequence[Candidates], probabilities: Sequence[NDArray[np.float32]]) -> Judged:
    """Compare all vehicles' candidates with where the log ended."""
    rows = np.flatnonzero(scorable(scenario)).tolist()
    if scenario.log is None or len(rows) == 0:
        return Judged([], [], [], np.zeros(0, np.bool_))
    end = scenario.log.position[rows, scenario.log.last_valid()[rows]]
    return Judged(
        [np.hypot(*(candidates[n].position - place).T) for n, place in zip(rows, end, strict=True)],
        [probabilities[n] for n in rows],
        [candidates[n].manoeuvre for n in rows],
        np.hypot(*(end - scenario.vehicles.position[rows]).T) > MOVING,
    )


def scores(judged: Judged) -> dict[str, dict[str, float]]:
    """Means over all vehicles and over the moving ones; each group says how many it has."""
    table = np.array([_row(*row) for row in zip(judged.distance, judged.probability, judged.manoeuvre, strict=True)])
    table = table.reshape(-1, len(METRICS))
    groups = {"all": np.ones(len(table), np.bool_), "moving": judged.moved}
    return {
        name: {"vehicles": float(rows.sum())}
        | (dict(zip(METRICS, table[rows].mean(0).tolist(), strict=True)) if rows.any() else {})
        for name, rows in groups.items()
    }


METRICS = (
    "candidates", "coverage_2m", "coverage_4m", "oracle_fde", "nll", "hit_1", "hit_3", "mean_reciprocal_rank", "expected_fde",
    "manoeuvre_accuracy", "entropy",
)  # fmt: skip
"""Columns of `_row`: distances [m], nll and entropy [nat]."""


def _row(distance: NDArray[np.float32], probability: NDArray[np.float32], manoeuvre: NDArray[np.uint8]) -> tuple[float, ...]:
    label = int(np.lexsort((-probability, distance))[0])  # of two at one place the likelier one
    rank = int((probability > probability[label]).sum() + ((probability == probability[label]).sum() - 1) / 2)
    p = np.maximum(probability.astype(np.float64), 1e-9)
    best = np.bincount(manoeuvre, probability, len(Manoeuvre)).argmax()
    return (
        len(distance),
        *(float(distance[label] < near) for near in NEAR),
        float(distance[label]),
        float(-np.log(p[label])),
        float(rank == 0),
        float(rank < 3),
        1 / (rank + 1),
        float((p * distance).sum() / p.sum()),
        float(best == manoeuvre[label]),
        float(-(p * np.log(p)).sum()),
    )
