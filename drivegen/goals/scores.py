"""How good candidates and their ranking are, against logged ends: coverage, likelihood, hits, expected error.

The label of a vehicle is the candidate nearest to its logged end. Only vehicles that are seen (nearly) to the end of the
horizon can be scored, since candidates are meant for its last step. What is equally likely is ranked by lot: figures are
expectations over it. Intervals are bootstrapped over recordings, because vehicles of one share its traffic. How far away ends
are depends on the horizon, so only vehicles of the horizon that most scenes have are averaged, as in `metrics.whole`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import comb

import numpy as np
from numpy.typing import NDArray

from drivegen.core import seeds
from drivegen.core.intervals import percentiles, recording, resamplings, usual_length
from drivegen.core.scenario import Scenario
from drivegen.goals.candidates import Candidates
from drivegen.goals.labels import ends
from drivegen.goals.manoeuvres import Manoeuvre

SEEN = 0.95
"""A track counts if it is seen up to this share of the horizon."""

MOVING = 2.0
"""A vehicle that ends farther than this from where it began [m] moved."""

NEAR = (2.0, 4.0)
"""Coverage is the share of vehicles with a candidate within these distances [m]."""

BINS = 10
"""Of the likeliest candidate's probability, for the calibration error."""


@dataclass(frozen=True)
class Judged:
    """V vehicles with a scorable end.

    Attributes:
        distance: V arrays (C,) [m] of each candidate from the logged end. probability: V arrays (C,).
        manoeuvre: V arrays (C,). moved: (V,) bool. steps: (V,) length of the scenario.
        scenario: (V,) str, its id.
        scene_steps: (S,) length of every scenario with a log, also of those without such a vehicle.
    """

    distance: list[NDArray[np.float32]]
    probability: list[NDArray[np.float32]]
    manoeuvre: list[NDArray[np.uint8]]
    moved: NDArray[np.bool_]
    steps: NDArray[np.intp]
    scenario: NDArray[np.str_]
    scene_steps: NDArray[np.intp]

    @classmethod
    def joined(cls, parts: "Sequence[Judged]") -> "Judged":
        """All of them."""
        return cls(
            [d for part in parts for d in part.distance],
            [p for part in parts for p in part.probability],
            [m for part in parts for m in part.manoeuvre],
            np.concatenate([np.zeros(0, np.bool_), *(part.moved for part in parts)]),
            np.concatenate([np.zeros(0, np.intp), *(part.steps for part in parts)]),
            np.concatenate([np.zeros(0, np.str_), *(part.scenario for part in parts)]),
            np.concatenate([np.zeros(0, np.intp), *(part.scene_steps for part in parts)]),
        )


def scorable(scenario: Scenario) -> NDArray[np.bool_]:
    """(N,) vehicles that are seen at step 0 and long enough for their end to be a label."""
    if scenario.log is None:
        return np.zeros(len(scenario.vehicles), np.bool_)
    long_enough: NDArray[np.bool_] = scenario.log.valid[:, 0] & (scenario.log.last_valid() >= SEEN * scenario.horizon)
    return long_enough


def judge(scenario: Scenario, candidates: Sequence[Candidates], probabilities: Sequence[NDArray[np.float32]]) -> Judged:
    """Compare all vehicles' candidates with where they ended, carried on where they were last seen just before."""
    if scenario.log is None:
        return Judged.joined([])
    found = ends(scenario, candidates)
    scored = scorable(scenario)[found.vehicle]
    rows, end = found.vehicle[scored].tolist(), found.position[scored]
    return Judged(
        [np.hypot(*(candidates[n].position - place).T) for n, place in zip(rows, end, strict=True)],
        [probabilities[n] for n in rows],
        [candidates[n].manoeuvre for n in rows],
        np.hypot(*(end - scenario.vehicles.position[rows]).T) > MOVING,
        np.full(len(rows), scenario.steps, np.intp),
        np.full(len(rows), scenario.scenario_id),
        np.array([scenario.steps], np.intp),
    )


def scores(judged: Judged, seed: int = 0, draws: int = 0) -> dict[str, dict[str, float]]:
    """Means over all vehicles and over the moving ones; each group says how many it has, and how many of another horizon.

    With `draws` each figure has its bootstrap interval beside it, "NAME.low" and "NAME.high".
    """
    table, recordings = _table(judged), np.array([recording(scenario) for scenario in judged.scenario], np.str_)
    usual = judged.steps == usual_length(judged.scene_steps) if len(table) else np.zeros(0, np.bool_)
    groups = {"all": np.ones(len(table), np.bool_), "moving": judged.moved}
    by_group = {}
    for name, group in groups.items():
        keep = group & usual
        by_group[name] = {"vehicles": float(keep.sum()), "left_out": float((group & ~usual).sum())}
        if keep.any():
            rng = seeds.rng(seed, "goal-scores", name)
            by_group[name] |= _means(table[keep], recordings[keep], draws, rng)
    return by_group


def scene_scores(judged: Judged) -> tuple[list[str], dict[str, NDArray[np.float64]]]:
    """The scenarios (S,) that have such vehicles, and means over all of them in each, (S,) by name of METRICS."""
    scenarios, number = np.unique(judged.scenario, return_inverse=True)
    sums = np.zeros((len(scenarios), len(METRICS)))
    np.add.at(sums, number, _table(judged)[:, : len(METRICS)])
    means = sums / np.bincount(number, minlength=len(scenarios))[:, None]
    return scenarios.tolist(), dict(zip(METRICS, means.T, strict=True))


def _table(judged: Judged) -> NDArray[np.float64]:
    """A `_row` for each vehicle."""
    rows = [_row(*row) for row in zip(judged.distance, judged.probability, judged.manoeuvre, strict=True)]
    return np.array(rows).reshape(-1, len(METRICS) + 2)


METRICS = (
    "candidates", "coverage_2m", "coverage_4m", "oracle_fde", "nll", "hit_1", "hit_3", "hit_1_within_4m", "hit_3_within_4m",
    "mean_reciprocal_rank", "expected_fde", "manoeuvre_accuracy", "entropy",
)  # fmt: skip
"""Columns of `_row` that are averaged: distances [m], nll and entropy [nat].

hit_k: the candidate nearest to the logged end is among the k likeliest. hit_k_within_4m: one of the k likeliest lies within
4 m of it, which does not depend on how finely candidates are spaced.
"""


def _means(table: NDArray[np.float64], of: NDArray[np.str_], draws: int, rng: np.random.Generator) -> dict[str, float]:
    """Means over vehicles and the calibration error, with intervals where the recordings `of` (V,) are drawn `draws` times."""
    recordings, number = np.unique(of, return_inverse=True)
    names, count = (*METRICS, "calibration_error"), len(recordings)
    confidence, hit = table[:, -2], table[:, -1]
    bins = np.minimum((confidence * BINS).astype(int), BINS - 1)
    sums = np.zeros((count, len(METRICS) + 1))
    np.add.at(sums, number, np.column_stack([np.ones(len(table)), table[:, : len(METRICS)]]))
    gaps = np.zeros((count, BINS))
    np.add.at(gaps, (number, bins), confidence - hit)

    def statistics(times: NDArray[np.float64]) -> NDArray[np.float64]:
        """(D, M) of recordings taken `times` (D, R) each."""
        total = times @ sums
        error = np.abs(times @ gaps).sum(1)
        return np.column_stack([total[:, 1:], error]) / np.maximum(total[:, :1], 1.0)

    values = dict(zip(names, statistics(np.ones((1, count)))[0].tolist(), strict=True)) | {"recordings": float(count)}
    if draws:
        resampled = statistics(resamplings(recordings.tolist(), draws, rng))
        for k, name in enumerate(names):
            values[f"{name}.low"], values[f"{name}.high"] = percentiles(resampled[:, k])
    return values


def _row(distance: NDArray[np.float32], probability: NDArray[np.float32], manoeuvre: NDArray[np.uint8]) -> tuple[float, ...]:
    """METRICS of one vehicle, then the likeliest candidate's probability and whether it is the label."""
    label = int(np.lexsort((-probability, distance))[0])  # of two at one place the likelier one
    above, equal = int((probability > probability[label]).sum()), int((probability == probability[label]).sum())
    p = np.maximum(probability.astype(np.float64), 1e-9)
    best = np.bincount(manoeuvre, probability, len(Manoeuvre)).argmax()
    first = min(max((1 - above) / equal, 0.0), 1.0)
    return (
        len(distance),
        *(float(distance[label] < near) for near in NEAR),
        float(distance[label]),
        float(-np.log(p[label])),
        first,
        min(max((3 - above) / equal, 0.0), 1.0),
        _near_among(distance, probability, 1),
        _near_among(distance, probability, 3),
        float(np.mean(1 / np.arange(above + 1, above + equal + 1))),
        float((p * distance).sum() / p.sum()),
        float(best == manoeuvre[label]),
        float(-(p * np.log(p)).sum()),
        float(p.max()),
        first,
    )


def _near_among(distance: NDArray[np.float32], probability: NDArray[np.float32], most: int) -> float:
    """How likely one of the `most` likeliest candidates lies within NEAR[-1], equal ones taken by lot."""
    near = distance < NEAR[-1]
    if len(distance) <= most:
        return float(near.any())
    last = np.sort(probability)[-most]
    above, tied = probability > last, probability == last
    if (near & above).any():
        return 1.0
    open_places, count, good = most - int(above.sum()), int(tied.sum()), int((near & tied).sum())
    return 1.0 - comb(count - good, open_places) / comb(count, open_places)
