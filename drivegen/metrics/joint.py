"""Joint consistency: do the vehicles of a sample belong together, or are they N futures side by side?

The yardstick is the same samples *shuffled*: each vehicle keeps its K trajectories but deals them out to the samples anew, by
itself. Every marginal stays as it is, and whatever vehicles have to do with one another is gone. Where a method's samples are
no nearer to the log than their shuffles, its joint structure is worth nothing. Compared are

* collisions: share of vehicles whose box touches another one;
* the order at conflict points: of the pairs that cross or join each other's way in the log and in the sample, the share that
  comes in the log's order;
* energy scores of the scene (`proper`), which are strictly proper for joint futures: lower is better;
* distances of headways and post-encroachment times to the log's (`distributions`), and the share of close calls.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.metrics.displacement import scored_steps
from drivegen.metrics.distributions import RANGES, SceneCounts, scene_counts, wasserstein
from drivegen.metrics.encroachment import CROSSING, LONGEST, SAME_PLACE
from drivegen.metrics.features import scene_features
from drivegen.metrics.proper import energy_scores
from drivegen.metrics.road_edge import RoadEdges
from drivegen.metrics.surroundings import touching
from drivegen.scenario import DT, Scenario, Trajectories

SAME_TIME = 0.3
"""Visits of a conflict point that are nearer in time than this have no order [s]."""


@dataclass(frozen=True)
class SceneJoint:
    """One scene's K samples, as they are or shuffled.

    Attributes:
        touching: (K, N) bool, the box touches another one.
        agree, conflicts: number of (sample, pair) whose order at a conflict point is the log's, and of all that have one.
        energy_final, energy: energy scores of all vehicles at once [m].
        counts: histograms beside the log's.
    """

    touching: NDArray[np.bool_]
    agree: int
    conflicts: int
    energy_final: float
    energy: float
    counts: SceneCounts


def shuffled(samples: Trajectories, rng: np.random.Generator) -> Trajectories:
    """Samples (K, N, T) with each vehicle's K trajectories in an order of its own."""
    count, vehicles = samples.valid.shape[:2]
    order = rng.permuted(np.tile(np.arange(count)[:, None], (1, vehicles)), axis=0)
    return samples[order, np.arange(vehicles)]


def scene_joint(scenario: Scenario, samples: Trajectories, log: Trajectories, edges: RoadEdges) -> SceneJoint:
    """Measure samples (K, N, T) against the log (N, T); `edges` as for `scene_features`."""
    features, boxes = scene_features(scenario, samples, log, edges)
    count = len(scenario.vehicles)
    hit = touching(boxes, count, np.ones(1))[0, :-1]
    energy = energy_scores(samples, log)
    known = scored_steps(log)
    truth = conflict_orders(log[np.newaxis], known)
    agree, conflicts = _agreement(conflict_orders(samples, known), truth[0])
    return SceneJoint(hit, agree, conflicts, energy.energy_joint_final, energy.energy_joint, scene_counts(features))


def conflict_orders(motion: Trajectories, known: NDArray[np.bool_]) -> NDArray[np.float64]:
    """(K, N, N) [s]: by how much vehicle b is later than a where their ways cross or join; NaN where they don't.

    The place is that of least time between both visits, as for post-encroachment times: centres nearer than SAME_PLACE,
    headings that differ by more than CROSSING. `motion` is (K, N, T); steps that `known` (N, T) leaves out are not looked at.
    """
    cos, sin = np.cos(motion.heading), np.sin(motion.heading)
    position, mask = np.ascontiguousarray(motion.position), np.ascontiguousarray(known)
    return np.asarray(_orders(position, cos, sin, mask, round(LONGEST / DT)) * DT)


def _agreement(found: NDArray[np.float64], truth: NDArray[np.float64]) -> tuple[int, int]:
    """Number of (sample, pair) in the order of the log's `truth` (N, N), and of all that both give an order to."""
    pairs = np.triu_indices(len(truth), 1)
    mine, theirs = found[:, pairs[0], pairs[1]], truth[pairs]
    ordered = (np.abs(mine) >= SAME_TIME) & (np.abs(theirs) >= SAME_TIME)
    return int((ordered & (np.sign(mine) == np.sign(theirs))).sum()), int(ordered.sum())


@njit(cache=True)
def _orders(position, cos, sin, known, longest):  # type: ignore[no-untyped-def]
    samples, vehicles, steps = cos.shape
    out = np.full((samples, vehicles, vehicles), np.nan)
    widest = np.cos(CROSSING)
    for k in range(samples):
        for a in range(vehicles):
            for b in range(a + 1, vehicles):
                least, found = longest + 1, 0
                for s in range(steps):
                    if not known[a, s]:
                        continue
                    for t in range(max(0, s - least + 1), min(steps, s + least)):
                        dx = position[k, a, s, 0] - position[k, b, t, 0]
                        dy = position[k, a, s, 1] - position[k, b, t, 1]
                        if not known[b, t] or dx * dx + dy * dy >= SAME_PLACE**2 or abs(s - t) >= least:
                            continue
                        if cos[k, a, s] * cos[k, b, t] + sin[k, a, s] * sin[k, b, t] < widest:
                            least, found = abs(s - t), t - s
                if least <= longest:
                    out[k, a, b], out[k, b, a] = found, -found
    return out


def summary(scenes: Sequence[SceneJoint]) -> dict[str, float]:
    """All figures over a set of scenes; NaN where nothing was there to be measured."""
    conflicts = sum(scene.conflicts for scene in scenes)
    found = {
        "collision_per_vehicle": float(np.mean([scene.touching.mean() for scene in scenes])),
        "collision_per_scene": float(np.mean([scene.touching.any(axis=1).mean() for scene in scenes])),
        "order_agreement": sum(scene.agree for scene in scenes) / conflicts if conflicts else float("nan"),
        "ordered_pairs": float(conflicts),
        "energy_joint_final": float(np.mean([scene.energy_final for scene in scenes])),
        "energy_joint": float(np.mean([scene.energy for scene in scenes])),
        "close_call": float(np.nanmean([scene.counts.close_call[1] for scene in scenes])),
        "log_close_call": float(np.nanmean([scene.counts.close_call[0] for scene in scenes])),
    }
    for number, name in enumerate(RANGES):
        if name in ("headway", "time_to_collision", "post_encroachment"):
            counts = np.sum([scene.counts.numbers[number] for scene in scenes], axis=0)
            found[f"{name}_distance"] = float(wasserstein(counts, *RANGES[name]))
    return found
