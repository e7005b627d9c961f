"""Proper scores: what a method expects best by saying what it believes, unlike the best of K samples.

Energy score (Gneiting and Raftery 2007): ES = E d(X, y) - E d(X, X') / 2 for a sample X, another X' and the log y, both
expectations estimated from K samples (the second over pairs of different samples). Lower is better; a method that is
certain has its plain error. Distances d are Euclidean norms, so the score is strictly proper. The estimate is without bias
if samples are drawn independently; samples that are spread on purpose (stratified, or without repetition) have larger
distances d(X, X') than independent ones, and a lower score than what they are drawn from deserves:

* of one vehicle: at its last scored step (`final`), and root mean square over its scored steps (`trajectory`) [m];
* of the scene: root mean square of these over its vehicles (`joint_final`, `joint`) [m]: who moves with whom counts.

Negative log likelihood of the log under the samples, at fixed horizons, in nats per vehicle, of positions in metres: the
samples are turned into a density by a Gaussian kernel. Its bandwidth is one number per method and horizon, from a declared grid:
for each scenario the one that is likeliest for all scenarios of other recordings. `joint` is that of all vehicles' positions
at once.
"""

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import DT, Trajectories
from drivegen.metrics.displacement import scene_errors, scored_steps, standing_at_exit, summarise

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class EnergyScores:
    """The four energy scores of one scene [m]."""

    energy_final: float
    energy_trajectory: float
    energy_joint_final: float
    energy_joint: float


def energy_scores(samples: Trajectories, log: Trajectories) -> EnergyScores:
    """Scores of samples (K, N, T) against the log (N, T), over the vehicles and steps that displacement errors score."""
    scored = scored_steps(log)
    vehicles = scored.any(axis=1)
    scored = scored[vehicles]
    places, truth = samples.position[:, vehicles], log.position[vehicles]
    first, second = np.triu_indices(len(places), 1)
    along, final = _squares(places, truth[None], scored)
    along_apart, final_apart = _squares(places[first], places[second], scored)
    return EnergyScores(
        _energy(final, final_apart),
        _energy(along, along_apart),
        _energy(final.mean(axis=1), final_apart.mean(axis=1)),
        _energy(along.mean(axis=1), along_apart.mean(axis=1)),
    )


def mean_errors(scenes: Iterable[tuple[Trajectories, Trajectories]]) -> dict[str, float]:
    """Errors of `displacement.QualitySummary` and `energy_joint` by name [m], means over scenes.

    Of samples (K, N, T) and log (N, T) of each. Scenes with nothing to score are left out; {} if none is left.
    """
    found = []
    for samples, log in scenes:
        try:
            errors = asdict(summarise(*scene_errors(samples, log)))
        except UnusableInput as error:
            if error.reason != "nothing-to-score":
                raise
        else:
            found.append({**errors, "energy_joint": energy_scores(standing_at_exit(samples, log), log).energy_joint})
    return {name: float(np.mean([one[name] for one in found])) for name in found[0]} if found else {}


def spread(samples: Trajectories, log: Trajectories) -> float:
    """How far two of K samples (K, N, T) are apart [m]: mean over pairs, scored vehicles and their scored steps; 0 for K = 1."""
    scored = scored_steps(log)
    vehicles = scored.any(axis=1)
    first, second = np.triu_indices(len(samples.position), 1)
    if not len(first):
        return 0.0
    gap = samples.position[first][:, vehicles] - samples.position[second][:, vehicles]
    distance = np.where(scored[vehicles], np.hypot(gap[..., 0], gap[..., 1]), 0)
    return float((distance.sum(axis=-1, dtype=np.float64) / scored[vehicles].sum(axis=1)).mean())


def _squares(a: NDArray[np.float32], b: NDArray[np.float32], scored: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Squared distances of paths (P, N, T, 2): mean over scored steps, and at the last one, each (P, N) [m2]."""
    gap = a - b
    squared = np.where(scored, gap[..., 0] ** 2 + gap[..., 1] ** 2, 0)
    last = scored.shape[1] - 1 - np.argmax(scored[:, ::-1], axis=1)
    final = squared[:, np.arange(len(last)), last]
    return squared.sum(axis=-1, dtype=np.float64) / scored.sum(axis=1), final.astype(np.float64)


def _energy(to_log: Floats, apart: Floats) -> float:
    """From squared distances to the log (K, ...) and between different samples (K (K - 1) / 2, ...); one sample is certain."""
    spread = np.sqrt(apart).mean() if len(apart) else 0.0
    return float(np.sqrt(to_log).mean() - spread / 2)


def log_densities(samples: Trajectories, log: Trajectories, horizons: Floats, bandwidths: Floats) -> Floats:
    """(2, H, B) mean over vehicles of the log density of the log's position, by horizon [s] and bandwidth [m].

    The first is of each vehicle alone, the second of all vehicles at once divided by their number. NaN at horizons that no
    vehicle's log reaches; vehicles that were not observed there are left out.
    """
    out = np.full((2, len(horizons), len(bandwidths)), np.nan)
    scored = scored_steps(log)
    for h, step in enumerate(np.rint(horizons / DT).astype(int)):
        seen = scored[:, step] if step < log.steps else np.zeros(len(scored), np.bool_)
        if seen.any():
            gap = samples.position[:, seen, step].astype(np.float64) - log.position[seen, step]
            squared = (gap**2).sum(axis=-1)
            alone = np.stack([_log_mean_exp(-squared / (2 * b**2)).mean() for b in bandwidths])
            together = np.stack([_log_mean_exp(-squared.sum(axis=1) / (2 * b**2)) / seen.sum() for b in bandwidths])
            out[:, h] = np.stack([alone, together]) - np.log(2 * np.pi * bandwidths**2)
    return out


def _log_mean_exp(values: Floats) -> Floats:
    """log of the mean of exp over the first axis."""
    most = values.max(axis=0)
    return np.asarray(most + np.log(np.exp(values - most).mean(axis=0)))


def likeliest_for_others(densities: Floats, recordings: Sequence[str]) -> tuple[Floats, NDArray[np.intp]]:
    """Each scenario's log density (S,) at the bandwidth that is likeliest for all of other recordings, and the number (S,) of it.

    From log densities (S, B) and one name a scenario. Scenarios without any (NaN), and those of a recording that is alone, get
    NaN and -1.
    """
    known = np.isfinite(densities.sum(axis=1))
    filled = np.where(known[:, None], densities, 0.0)
    number = np.unique(np.asarray(recordings), return_inverse=True)[1]
    own = np.zeros((len(filled), filled.shape[1]))
    np.add.at(own, number, filled)
    chosen = np.argmax(filled.sum(axis=0) - own[number], axis=1)
    usable = known & (known.sum() > np.bincount(number, known)[number])
    value = np.where(usable, densities[np.arange(len(densities)), chosen], np.nan)
    return value, np.where(usable, chosen, -1)
