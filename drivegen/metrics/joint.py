"""Joint consistency: do the vehicles of a sample belong together, or are they N futures side by side?

The yardstick is the same samples *shuffled*: each vehicle keeps its K trajectories but deals them out to the samples anew, by
itself. Every marginal stays as it is, and whatever vehicles have to do with one another is gone. Where a method's samples are
no nearer to the log than their shuffles, its joint structure is worth nothing. Compared are

* collisions: share of vehicles whose box touches another one, without the checker's tolerances;
* order: of the pairs that cross or join each other's way in a sample, the share that comes there in the log's order;
* energy scores of the scene (`proper`), which are strictly proper for joint futures: lower is better;
* distances of headways, times to collision and post-encroachment times to the log's (`distributions`).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.boxes import bounds
from drivegen.core.intervals import Draws, Interval, percentiles
from drivegen.core.scenario import DT, Scenario, Trajectories
from drivegen.metrics.displacement import scored_steps
from drivegen.metrics.distributions import SceneCounts, distances, scene_counts
from drivegen.metrics.each import Each
from drivegen.metrics.encroachment import LONGEST, SAME_PLACE, nearest_visits, paces
from drivegen.metrics.features import Features, scene_features
from drivegen.metrics.proper import energy_scores
from drivegen.metrics.surroundings import Boxes, touching

SAME_TIME = 0.3
"""Visits of a conflict point that are nearer in time than this have no order [s]."""

DISTANCES = ("headway", "time_to_collision", "post_encroachment")
"""Distributions of `distributions.RANGES` in which one vehicle has to do with another."""


@dataclass(frozen=True)
class SceneJoint:
    """One scene's samples beside the same shuffled.

    Attributes:
        metrics: figures of the scene by name; `shuffled.x` beside `x` or `joint.x`.
        orders: (2, 2) int64 right orders and all that the log tells, of the samples and (second row) of the shuffled ones.
        shuffled: the shuffled samples' histograms beside the log's.
    """

    metrics: dict[str, float]
    orders: NDArray[np.int64]
    shuffled: SceneCounts


def shuffled(samples: Trajectories, rng: np.random.Generator) -> Trajectories:
    """Samples (K, N, T) with each vehicle's K trajectories in an order of its own."""
    count, vehicles = samples.valid.shape[:2]
    order = rng.permuted(np.tile(np.arange(count)[:, None], (1, vehicles)), axis=0)
    return samples[order, np.arange(vehicles)]


def scene_joint(scenario: Scenario, log: Trajectories, features: Features, boxes: Boxes, rng: np.random.Generator) -> SceneJoint:
    """Measure K samples against the log (N, T); `features` and `boxes` are theirs and, last, the log's."""
    together = features.motion[:-1]
    dealt = shuffled(together, rng)
    apart, apart_boxes = scene_features(scenario, dealt, log, None)
    count = len(log.valid)
    counts, energy = scene_counts(apart), [energy_scores(motion, log).energy_joint for motion in (together, dealt)]
    metrics = {
        "joint.collision": _collisions(boxes, count),
        "shuffled.collision": _collisions(apart_boxes, count),
        "shuffled.close_call": float(counts.close_call[1]),
        "shuffled.encounters": float(counts.encounters[1]),
        "shuffled.energy_joint": energy[1],
        "joint.energy_gain": energy[1] - energy[0],
    }
    return SceneJoint(metrics, np.array([orders(motion, log) for motion in (together, dealt)]), counts)


def joint_figures(
    scenes: Sequence[SceneJoint], recordings: Sequence[str], draws: int, rng: np.random.Generator
) -> dict[str, Interval]:
    """What only a set of scenes has: shares of right orders, distances when shuffled; intervals resample recordings."""
    counted = np.stack([scene.orders for scene in scenes])
    drawn = Draws.of(recordings, draws, rng).sums([counted.astype(np.float64)])
    found = {}
    for kind, name in enumerate(("joint.order", "shuffled.order")):
        found[name] = Interval(float(_share(counted.sum(axis=0)[kind])), *percentiles(_known(_share(drawn[:, kind]))))
    apart = distances(Each(len(scenes), lambda number: scenes[number].shuffled), recordings, draws, rng)
    return found | {f"shuffled.{name}": apart[name] for name in DISTANCES}


def orders(samples: Trajectories, log: Trajectories) -> tuple[int, int]:
    """Of samples (K, N, T): pairs in the log's (N, T) order where their ways cross or join, and all whose order it tells.

    The place is that of least time between both visits, as for post-encroachment times. The log tells the order there if both
    come (within SAME_PLACE), or if one comes while the other one, where its log ends, is still on its way there.
    """
    known = np.ascontiguousarray(scored_steps(log))
    seen = np.ascontiguousarray(samples.valid & known)
    cos, sin = np.cos(samples.heading), np.sin(samples.heading)
    position, truth = np.ascontiguousarray(samples.position), np.ascontiguousarray(log.position)
    right, told = _orders(position, cos, sin, seen, truth, known, round(LONGEST / DT), round(SAME_TIME / DT))
    return int(right), int(told)


def _collisions(boxes: Boxes, vehicles: int) -> float:
    """Share of (sample, vehicle) that touch another box; the log, the last one, left out."""
    return float(touching(boxes, vehicles, np.ones(1))[0, :-1].mean())


def _share(counts: NDArray[np.number]) -> NDArray[np.float64]:
    """Of (..., 2) right ones and all of them; NaN where there are none."""
    right, told = counts[..., 0], counts[..., 1]
    return np.asarray(np.divide(right, told, out=np.full(told.shape, np.nan), where=told > 0))


def _known(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return values[np.isfinite(values)]


@njit(cache=True)
def _orders(position, cos, sin, seen, truth, known, longest, same):  # type: ignore[no-untyped-def]
    right, told = 0, 0
    for k in range(position.shape[0]):
        box, pace = bounds(position[k], seen[k]), paces(position[k], seen[k])
        for a in range(known.shape[0]):
            for b in range(a):
                apart = max(box[a, 0] - box[b, 2], box[b, 0] - box[a, 2], box[a, 1] - box[b, 3], box[b, 1] - box[a, 3])
                if apart >= SAME_PLACE:
                    continue
                least, s, t = nearest_visits(position[k], cos[k], sin[k], seen[k], a, b, pace[b], longest)
                if same <= least <= longest:
                    later = _later(position[k], truth, known, a, b, s, t)
                    told += abs(later) >= same
                    right += abs(later) >= same and (later > 0) == (t > s)
    return right, told


@njit(cache=True)
def _later(position, truth, known, a, b, s, t):  # type: ignore[no-untyped-def]
    """By how many steps b comes after a in the log where it is at step t, and a at step s, of a sample; 0 if not known."""
    at_a, at_b = _arrival(position, truth, known, a, s), _arrival(position, truth, known, b, t)
    if at_a >= 0 and at_b >= 0:
        return at_b - at_a
    if at_a >= 0 and _on_its_way(position, truth, known, b, t, at_a):
        return known.shape[1]
    if at_b >= 0 and _on_its_way(position, truth, known, a, s, at_b):
        return -known.shape[1]
    return 0


@njit(cache=True)
def _arrival(position, truth, known, n, step):  # type: ignore[no-untyped-def]
    """First step at which vehicle n of the log is where it is at `step` of the sample; -1 if it never is."""
    for t in range(known.shape[1]):
        dx, dy = truth[n, t, 0] - position[n, step, 0], truth[n, t, 1] - position[n, step, 1]
        if known[n, t] and dx * dx + dy * dy < SAME_PLACE**2:
            return t
    return -1


@njit(cache=True)
def _on_its_way(position, truth, known, n, step, seen):  # type: ignore[no-untyped-def]
    """Whether vehicle n's log lasts until step `seen` and ends on the sample's way to where it is at `step`."""
    last = -1
    for t in range(known.shape[1]):
        if known[n, t]:
            last = t
    if last < seen:
        return False
    for t in range(step + 1):
        dx, dy = truth[n, last, 0] - position[n, t, 0], truth[n, last, 1] - position[n, t, 1]
        if dx * dx + dy * dy < SAME_PLACE**2:
            return True
    return False
