"""How well a planner drives to the true goal: what is left to it once the goal is right."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drivegen.core import seeds
from drivegen.core.scenario import DT, Scenario, Trajectories
from drivegen.planners.base import Examples, PlanRequests
from drivegen.planners.shared.motion import GRID, Residuals, decode
from drivegen.planners.shared.paths import Frames

SMOOTHED = 5
"""Speeds are averaged over so many steps before acceleration and jerk are taken: logged ones are noisy."""

MISSED = 2.0
"""A track is missed if no sample ends nearer to its goal than this [m]."""

PROBED = 2
"""Trajectories for each track while training is watched."""

Sample = Callable[[Sequence[Scenario], PlanRequests], Trajectories]
"""A planner's `sample`."""

Judge = Callable[[Sequence[Scenario], PlanRequests, Trajectories], dict[str, NDArray[np.bool_]]]
"""Verdicts (B,) by name on requests' motion (B, T), such as "off_road"; the stage brings the legal checker."""


def drawn_tracks(examples: Examples, most: int, scenes: int | None, seed: int) -> NDArray[np.intp]:
    """At most `most` moving tracks, drawn by `seed`, of at most `scenes` scenarios; parked ones are no achievement."""
    moving = np.flatnonzero(~examples.requests.parked)
    if scenes is not None:
        scenes_scored = seeds.rng(seed, "score", "scenes").permutation(np.unique(examples.requests.scenario[moving]))[:scenes]
        moving = moving[np.isin(examples.requests.scenario[moving], scenes_scored)]
    return np.sort(seeds.rng(seed, "score").permutation(moving)[:most])


def score(
    sample: Sample, examples: Examples, tracks: NDArray[np.intp], samples: int, seed: int, judge: Judge
) -> dict[str, float]:
    """Figures of `samples` trajectories for each of the tracks `tracks`, with anchors on the same tracks beside them.

    `ade_best` and `ade_mean` [m] are the best and the mean of a track's samples over its seen steps, `goal_error` [m] is
    the mean distance to the goal at its step, `miss_rate` the share of tracks with no sample within MISSED of it.
    `acceleration` [m/s2] and `jerk` [m/s3] are root mean squares along the track, `.._distance` the Wasserstein-1 distances
    of their distributions to the log's. Verdicts are shares of trajectories, up to the goal. Names with `log.` and `base.` before
    them are the log's own figures and those of the exact base without any residual, which needs no training; those with
    `hidden.` are the planner's errors when it is told of no route and of nothing on it.
    """
    if len(tracks) == 0:
        return {"scored_tracks": 0}
    rows = np.repeat(tracks, samples)
    own = [seeds.derive(seed, "score", int(row), k) for row in tracks for k in range(samples)]
    requests = replace(examples.requests[rows], seed=np.array(own, np.int64))
    log, of_tracks = examples.motion[tracks], examples.requests[tracks]
    figures: dict[str, float] = {"scored_tracks": len(tracks), "scored_scenes": len(np.unique(of_tracks.scenario))}
    figures["without_route"] = float((of_tracks.route < 0).mean())
    planned = {
        "": (requests, sample(examples.scenarios, requests)),
        "base.": (of_tracks, _base(of_tracks, log.steps)),
        "log.": (of_tracks, log),
    }
    for prefix, (wanted, motion) in planned.items():
        mine = _smoothness(motion, log) | ({} if motion is log else _errors(wanted, motion, log))
        judged = replace(motion, valid=motion.valid & (np.arange(motion.steps) <= wanted.goal_step[:, None]))
        mine |= {name: float(broken.mean()) for name, broken in judge(examples.scenarios, wanted, judged).items()}
        figures |= {prefix + name: value for name, value in mine.items()}
    unrouted = _errors(requests, sample(examples.scenarios, without_routes(requests)), log)
    figures |= {f"hidden.{name}": unrouted[name] for name in ("ade_best", "ade_mean")}
    return {key: value if isinstance(value, int) else round(float(value), 6) for key, value in figures.items()}


def without_routes(requests: PlanRequests) -> PlanRequests:
    """The same requests where no route fits: its line, its leader and its signals are unknown."""
    never, zero = np.full(len(requests), np.inf, np.float32), np.zeros(len(requests), np.float32)
    return replace(
        requests, route=np.full(len(requests), -1, np.int32), goal_s=zero, goal_d=zero, leader_gap=never, leader_speed=zero,
        stop_s=never,
    )  # fmt: skip


def probe(sample: Sample, examples: Examples, tracks: NDArray[np.intp], seed: int) -> float:
    """Mean ADE [m] over the tracks `tracks`, PROBED trajectories each, always with the same noise."""
    if len(tracks) == 0:
        return float("nan")
    own = [seeds.derive(seed, "probe", int(row), k) for row in tracks for k in range(PROBED)]
    requests = replace(examples.requests[np.repeat(tracks, PROBED)], seed=np.array(own, np.int64))
    return _errors(requests, sample(examples.scenarios, requests), examples.motion[tracks])["ade_mean"]


def _base(requests: PlanRequests, steps: int) -> Trajectories:
    """Motion (B, steps) that meets both ends exactly and has no residual: a smooth speed along the path."""
    none = np.zeros((len(requests), GRID), np.float32)
    return decode(Frames.of(requests), requests, Residuals(none, none, none), steps)


def _errors(requests: PlanRequests, motion: Trajectories, log: Trajectories) -> dict[str, float]:
    """Errors of motion (B, T) against logs (D, T) of which each has B / D rows; unseen steps don't count."""
    steps, times = motion.steps, len(requests) // len(log.valid)
    truth = log.until(steps)[np.repeat(np.arange(len(log.valid)), times)]
    scored = truth.valid & motion.valid & (np.arange(steps) <= requests.goal_step[:, None])
    scored[:, 0] = False  # the first frame is given
    away = np.hypot(*np.moveaxis(motion.position - truth.position, -1, 0)) * scored
    ade = (away.sum(axis=1) / np.maximum(scored.sum(axis=1), 1)).reshape(-1, times)
    at_goal = motion.position[np.arange(len(requests)), requests.goal_step] - requests.goal_position
    error = np.hypot(*at_goal.T)
    return {
        "ade_best": float(ade.min(axis=1).mean()),
        "ade_mean": float(ade.mean()),
        "goal_error": float(error.mean()),
        "miss_rate": float((error.reshape(-1, times).min(axis=1) > MISSED).mean()),
    }


def _smoothness(motion: Trajectories, log: Trajectories) -> dict[str, float]:
    """Root mean squares of acceleration and jerk along the track, and how far they lie from the log's."""
    figures = {}
    for name, order in (("acceleration", 1), ("jerk", 2)):
        mine, theirs = _changes(motion, order), _changes(log, order)
        figures[name] = float(np.sqrt((mine**2).mean())) if len(mine) else float("nan")
        figures[f"{name}_distance"] = _wasserstein(mine, theirs)
    return figures


def _changes(motion: Trajectories, order: int) -> NDArray[np.float64]:
    """Differences in time of the smoothed speeds, all fully seen ones in a row."""
    window = np.ones(SMOOTHED) / SMOOTHED
    speed = np.stack([np.convolve(row, window, "valid") for row in motion.speed])
    whole = np.stack([np.convolve(row, window, "valid") for row in motion.valid]) > 1 - 1e-6
    change = np.diff(speed, n=order, axis=1) / DT**order
    count = whole.shape[1] - order
    in_a_row = np.logical_and.reduce([whole[:, k : k + count] for k in range(order + 1)])
    return np.asarray(change[in_a_row])


def _wasserstein(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Wasserstein-1 distance of two sets of numbers, from a thousand quantiles of each."""
    if len(a) == 0 or len(b) == 0:
        return float("nan")
    level = (np.arange(1000) + 0.5) / 1000
    return float(np.abs(np.quantile(a, level) - np.quantile(b, level)).mean())
