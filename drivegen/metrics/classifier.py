"""Can a classifier tell generated tracks from logged ones? AUC per method: 0.5 if it can't, 1 if it always can.

Gradient-boosted trees see features of single tracks, one generated for each logged one (the same vehicle of the same scene,
from a sample drawn by seed); vehicles that stand still in both are left out, and those that leave one at once. It is trained
on other scenes than it is asked about: five folds of recordings (fewer where there are fewer), drawn by seed, because scenes
of one recording show the same logged vehicles. What it finds may be small (a wrong jerk tells as surely as a wrong turn), so
an AUC says that there is a difference, not how much it matters.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.intervals import Interval, counts, percentiles
from drivegen.metrics.features import Features

FOLDS = 5
MOST = 4096
"""Scenes whose tracks it learns from and is asked about; of more as many, evenly spread."""

STILL = 2.0
"""A track that gets no farther than this stands still [m]."""

LONGEST_TIME = 10.0
"""Times to collision and headways are capped here [s]."""

Floats = NDArray[np.float64]

TRACK_FEATURES = (
    "mean_speed", "least_speed", "highest_speed", "spread_of_speed", "share_standing",
    "mean_abs_acceleration", "hardest_braking", "hardest_acceleration", "mean_abs_jerk", "hardest_jerk", "smoothness",
    "mean_abs_turning", "sharpest_turning", "mean_abs_angular_acceleration", "hardest_lateral", "turned",
    "travelled", "straightness", "nearest_box", "mean_nearest_box", "least_time_to_collision", "least_headway",
    "farthest_outside", "mean_outside",
)  # fmt: skip


@dataclass(frozen=True)
class TrackPairs:
    """Features of P logged tracks and of the generated tracks of the same vehicles, each (P, len(TRACK_FEATURES))."""

    logged: Floats
    generated: Floats


def track_pairs(features: Features, sample: int) -> TrackPairs:
    """Tracks of one scene; `features` are K samples and, last, the log; `sample` is the one that is shown."""
    both = features[[sample, -1]]
    generated, logged = _tracks(both)
    moved = np.maximum(generated[:, _TRAVELLED], logged[:, _TRAVELLED]) > STILL
    told = moved & both.known[3].any(axis=-1).all(axis=0)
    return TrackPairs(logged[told], generated[told])


_TRAVELLED = TRACK_FEATURES.index("travelled")


def _tracks(features: Features) -> Floats:
    """(K, N, F) features of every track."""
    moves, around, (known, speeds, accelerations, jerks) = features.kinematics, features.around, features.known
    acceleration, jerk = np.where(accelerations, moves.acceleration, 0), np.abs(moves.jerk)
    power = np.maximum((acceleration**2).sum(axis=-1), 1e-6)
    step = np.diff(features.motion.position, axis=-2)
    both = features.motion.valid[..., 1:] & features.motion.valid[..., :-1]
    travelled = np.where(both, np.hypot(step[..., 0], step[..., 1]), 0).sum(axis=-1)
    way = np.hypot(*np.moveaxis(np.where(both[..., None], step, 0).sum(axis=-2), -1, 0))
    mean_speed = _mean(moves.speed, speeds)
    headway = np.where(moves.speed > 1, around.gap / np.maximum(moves.speed, 1), LONGEST_TIME)
    columns = (
        mean_speed,
        _least(moves.speed, speeds),
        -_least(-moves.speed, speeds),
        np.sqrt(np.maximum(_mean(moves.speed.astype(np.float64) ** 2, speeds) - mean_speed**2, 0)),
        _mean(moves.speed < 0.5, speeds),
        _mean(np.abs(acceleration), accelerations),
        _least(acceleration, accelerations),
        -_least(-acceleration, accelerations),
        _mean(jerk, jerks),
        -_least(-jerk, jerks),
        (acceleration[..., 1:] * acceleration[..., :-1]).sum(axis=-1) / power,
        _mean(np.abs(moves.turning), speeds),
        -_least(-np.abs(moves.turning), speeds),
        _mean(np.abs(moves.angular_acceleration), accelerations),
        -_least(-np.abs(moves.lateral), speeds),
        np.abs(_mean(moves.turning, speeds)),
        travelled,
        way / np.maximum(travelled, 1e-3),
        _least(around.nearest, known),
        _mean(around.nearest, known),
        np.minimum(_least(around.time_to_collision, speeds), LONGEST_TIME),
        np.minimum(_least(headway, speeds), LONGEST_TIME),
        -_least(-features.edge, known),
        _mean(features.edge, known),
    )
    return np.stack([np.asarray(column, np.float64) for column in columns], axis=-1)


def _mean(values: NDArray[np.generic], known: NDArray[np.bool_]) -> Floats:
    return np.asarray(np.where(known, values, 0).sum(axis=-1, dtype=np.float64) / np.maximum(known.sum(axis=-1), 1))


def _least(values: NDArray[np.floating], known: NDArray[np.bool_]) -> NDArray[np.floating]:
    return np.asarray(np.where(known, values, np.inf).min(axis=-1))


def telling_apart(
    scenes: Sequence[TrackPairs], recordings: Sequence[str], seed: int, draws: int, rng: np.random.Generator
) -> Interval:
    """AUC over all scenes, each asked about by a classifier that was trained on other recordings; intervals resample these.

    `recordings` has one name a scene. NaN where there are fewer than two recordings with tracks.
    """
    names, number = np.unique(np.asarray(recordings), return_inverse=True)
    spread = np.linspace(0, len(scenes) - 1, min(len(scenes), MOST)).astype(int)
    chosen = [scenes[row] for row in spread.tolist()]
    recording = np.repeat(number[spread], [len(pairs.logged) for pairs in chosen])
    known = np.unique(recording)
    if len(known) < 2:
        return Interval(np.nan, np.nan, np.nan)
    tracks = np.concatenate([getattr(pairs, side) for side in ("logged", "generated") for pairs in chosen])
    generated = np.repeat([False, True], len(recording))
    recording = np.tile(recording, 2)
    score = _held_out_scores(tracks, generated, recording, folds(rng.permutation(known)), seed)
    ranks = np.unique(np.round(score, 9), return_inverse=True)[1]
    weight = np.zeros((draws, len(names)))
    weight[:, known] = counts(len(known), draws, rng)
    drawn = np.array([_auc(ranks, generated, weights[recording]) for weights in weight])
    return Interval(_auc(ranks, generated, np.ones(len(recording))), *percentiles(drawn[np.isfinite(drawn)]))


def folds(recordings: NDArray[np.intp]) -> list[NDArray[np.intp]]:
    """Parts of the distinct numbers of recordings (R,), in their order: FOLDS of them, R where there are fewer recordings."""
    return np.array_split(recordings, min(FOLDS, len(recordings)))


def _held_out_scores(
    tracks: Floats, generated: NDArray[np.bool_], recording: NDArray[np.intp], parts: list[NDArray[np.intp]], seed: int
) -> Floats:
    """Log odds of being generated, from the classifier of the fold that did not see the track's recording."""
    from sklearn.ensemble import HistGradientBoostingClassifier  # a second to import, which no process of `spread` needs

    score = np.zeros(len(tracks))
    for fold in parts:
        asked = np.isin(recording, fold)
        trees = HistGradientBoostingClassifier(
            max_iter=80, max_leaf_nodes=12, min_samples_leaf=10, l2_regularization=1.0, early_stopping=False, random_state=seed
        )
        trees.fit(tracks[~asked], generated[~asked])
        score[asked] = trees.decision_function(tracks[asked])
    return score


def _auc(ranks: NDArray[np.intp], generated: NDArray[np.bool_], weight: Floats) -> float:
    """Weighted chance that a generated track has a higher rank than a logged one; equal ranks count half."""
    made = np.bincount(ranks, weight * generated)
    real = np.bincount(ranks, weight * ~generated)
    total = made.sum() * real.sum()
    below = np.cumsum(real) - real / 2
    return float(made @ below / total) if total > 0 else np.nan
