"""Quality metrics of 10 samples of 16 vehicles over 100 steps: errors, realism; and diversity of a set of scenes."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegen.bench import _scene
from drivegen.bench._row import Row, best_cpu_seconds
from drivegen.core.geometry import boxes_gap
from drivegen.core.scenario import Trajectories
from drivegen.core.seeds import rng
from drivegen.metrics.displacement import scene_errors
from drivegen.metrics.diversity import own_frames, plain_differences, random_pairs, squared_differences
from drivegen.metrics.features import scene_features
from drivegen.metrics.realism import realism
from drivegen.metrics.road_edge import RoadEdges
from drivegen.metrics.surroundings import Boxes, surroundings
from drivegen.roads.drivable import CELL, road_field

TURNS = 50
SCENES = 20


def rows() -> Iterator[Row]:
    """Half a millisecond a scene; the reference for errors is av2's way, a call per actor, without masks."""
    scenario = _scene.scene(0)
    motion, log = _scene.samples(scenario).motion, scenario.log
    assert log is not None
    future, truth = np.moveaxis(motion.position[:, :, 1:], 0, 1), log.position[:, 1:]
    value = best_cpu_seconds(lambda: [scene_errors(motion, log) for _ in range(TURNS)]) / TURNS * 1e3
    reference = best_cpu_seconds(lambda: [_actor_by_actor(future, truth) for _ in range(TURNS)]) / TURNS * 1e3
    yield Row("scene errors, 16 x 10 samples", value, "ms", 0.48, True, reference, "av2's formulas, actor by actor")

    frames = own_frames([_scene.scene(number).log for number in range(SCENES)])  # type: ignore[misc]  # bench scenes have logs
    pairs = random_pairs(SCENES, TURNS, rng(0, "bench"))
    value = best_cpu_seconds(lambda: squared_differences(frames, pairs)) / len(pairs) * 1e3
    reference = best_cpu_seconds(lambda: plain_differences(frames, pairs)) / len(pairs) * 1e3
    yield Row("diversity of a pair of scenes", value, "ms", 0.1, True, reference, "all pairs of vehicles, plain norm")

    field = road_field(scenario.map)
    edges = RoadEdges(field.outside, field.origin, CELL, field.beyond_rim)
    value = best_cpu_seconds(lambda: realism(scene_features(scenario, motion, log, edges)[0])) * 1e3
    boxes = Boxes.of(motion, scenario.vehicles.size, scenario.context)
    reference = best_cpu_seconds(lambda: _gaps_pair_by_pair(motion, scenario.vehicles.size[:, :2]), turns=1) * 1e3
    nearest = best_cpu_seconds(lambda: surroundings(boxes, len(scenario.vehicles))) * 1e3
    yield Row("distances to nearest boxes", nearest, "ms", 4.0, True, reference, "exact gaps of all pairs, on arrays")
    yield Row("realism score of a scene, 16 x 10 samples", value, "ms", 10.0, True)


def _gaps_pair_by_pair(motion: Trajectories, size: NDArray[np.float32]) -> float:
    """All gaps (K, T) between each two vehicles, without any bound that spares most of them."""
    least = np.inf
    for a in range(len(size)):
        for b in range(a):
            gap = boxes_gap(
                motion.position[:, a], motion.heading[:, a], size[a], motion.position[:, b], motion.heading[:, b], size[b]
            )
            least = min(least, float(gap.min()))
    return least


def _actor_by_actor(future: NDArray[np.float32], truth: NDArray[np.float32]) -> tuple[NDArray[Any], NDArray[Any]]:
    distances = [np.linalg.norm(worlds - line, axis=-1) for worlds, line in zip(future, truth, strict=True)]
    return np.mean([d.mean(axis=-1) for d in distances], axis=0), np.mean([d[:, -1] for d in distances], axis=0)
