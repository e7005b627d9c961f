"""The legal checker on whole samples: 10 futures of 16 vehicles, 101 steps, all rules."""

from collections.abc import Iterator

import numpy as np

from drivegen.bench import _scene
from drivegen.bench._row import Row, best_cpu_seconds
from drivegen.checker.limits import Limits
from drivegen.checker.scene import SceneChecker
from drivegen.core.geometry import boxes_overlap
from drivegen.core.scenario import Trajectories

SCENES = 4
LIMITS = Limits(
    overlap=0.1, overlap_context=0.1, off_road=0.5, wrong_way=1.0, oncoming_lanes=0.5, speed=40.0, over_limit=5.0,
    acceleration=6.0, braking=9.0, lateral_acceleration=6.0, velocity_error=3.0, jump=0.7, velocity_step=1.0, curvature=0.3,
    side_slip=1.5, spin=1.5, red_grace=1.0, stop_speed=2.0, yield_gap=0.5,
)  # fmt: skip


def rows() -> Iterator[Row]:
    """One millisecond per scene; the reference does nothing but the collisions, by the same formula in NumPy."""
    scenes = [_scene.scene(number) for number in range(SCENES)]
    motions = [_scene.samples(scenario).motion for scenario in scenes]
    checkers = [SceneChecker(scenario, LIMITS) for scenario in scenes]
    pairs = np.triu_indices(len(scenes[0].vehicles), 1)

    def check() -> None:
        for checker, motion in zip(checkers, motions, strict=True):
            checker.check_samples(motion)

    def overlaps() -> None:
        for checker, motion in zip(checkers, motions, strict=True):
            _overlaps(motion, checker.size, pairs)

    value = best_cpu_seconds(check) / SCENES * 1e3
    reference = best_cpu_seconds(overlaps, turns=2) / SCENES * 1e3
    yield Row("checker, 16 x 10 samples", value, "ms", 1.0, True, reference, "NumPy, collisions alone")


def _overlaps(
    motion: Trajectories,
    size: "np.ndarray[tuple[int, ...], np.dtype[np.float32]]",
    pairs: "tuple[np.ndarray[tuple[int, ...], np.dtype[np.intp]], ...]",
) -> None:
    a, b = pairs
    first = (motion.position[:, a], motion.heading[:, a], size[a][None, :, None])
    boxes_overlap(*first, motion.position[:, b], motion.heading[:, b], size[b][None, :, None])
