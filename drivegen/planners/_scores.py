"""How well a planner drives to the true goal: what is left to it once the goal is right."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drivegen import seeds
from drivegen.planners.base import Examples, Planner
from drivegen.scenario import DT, Trajectories

SMOOTHED = 5
"""Speeds are averaged over so many steps before acceleration and jerk are taken: logged ones are noisy."""


def score(planner: Planner, examples: Examples, most: int, samples: int, seed: int) -> dict[str, float | int]:
    """Errors [m], accelerations [m/s2] and jerks [m/s3] over at most `most` tracks, `samples` trajectories for each.

    The tracks are drawn by `seed`; parked ones are left out, because staying is no achievement. `ade_best` and
    `ade_mean` are the best and the mean of a track's samples over its seen steps, `goal_error` is the mean distance to
    the goal at its step, `acceleration` and `jerk` are root mean squares along the track, with the log's beside them.
    """
    moving = np.flatnonzero(~examples.requests.parked)
    if len(moving) == 0:
        return {"scored_tracks": 0}
    drawn = np.sort(seeds.rng(seed, "score").permutation(moving)[:most])
    rows = np.repeat(drawn, samples)
    own = [seeds.derive(seed, "score", int(row), k) for row in drawn for k in range(samples)]
    requests = replace(examples.requests[rows], seed=np.array(own, np.int64))
    motion, log = planner.sample(examples.scenarios, requests), examples.motion[rows]
    steps = motion.steps
    scored = log.until(steps).valid & motion.valid & (np.arange(steps) <= requests.goal_step[:, None])
    scored[:, 0] = False  # the first frame is given
    away = np.hypot(*np.moveaxis(motion.position - log.until(steps).position, -1, 0)) * scored
    ade = (away.sum(axis=1) / np.maximum(scored.sum(axis=1), 1)).reshape(-1, samples)
    at_goal = motion.position[np.arange(len(rows)), requests.goal_step] - requests.goal_position
    found = {"scored_tracks": len(drawn), "ade_best": ade.min(axis=1).mean(), "ade_mean": ade.mean()}
    found |= {"goal_error": np.hypot(*at_goal.T).mean(), "without_route": (examples.requests.route[drawn] < 0).mean()}
    found |= _smoothness("", motion) | _smoothness("log_", examples.motion[drawn])
    return {key: value if isinstance(value, int) else round(float(value), 6) for key, value in found.items()}


def _smoothness(prefix: str, motion: Trajectories) -> dict[str, float]:
    """Root mean squares of acceleration and jerk along the track, from the smoothed speeds of fully seen stretches."""
    window = np.ones(SMOOTHED) / SMOOTHED
    speed = np.stack([np.convolve(row, window, "valid") for row in motion.speed])
    seen = np.stack([np.convolve(row, window, "valid") for row in motion.valid]) > 1 - 1e-6
    found = {}
    for name, order in (("acceleration", 1), ("jerk", 2)):
        change = np.diff(speed, n=order, axis=1) / DT**order
        known = _all_seen(seen, order)
        found[prefix + name] = float(np.sqrt((change[known] ** 2).mean())) if known.any() else float("nan")
    return found


def _all_seen(seen: NDArray[np.bool_], order: int) -> NDArray[np.bool_]:
    count = seen.shape[1] - order
    return np.asarray(np.logical_and.reduce([seen[:, k : k + count] for k in range(order + 1)]))
