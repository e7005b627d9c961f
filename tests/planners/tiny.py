"""Planners that are trained in a moment, and tracks to train them on."""

from pathlib import Path

import numpy as np

from drivegen.core import plugins
from drivegen.core.scenario import DT
from drivegen.planners.base import Examples, Planner
from drivegen.planners.shared.easing import HARD
from drivegen.planners.shared.requests import examples_from_logs
from drivegen.roads.graph import LaneGraph
from stages._door import build, read_section
from tests.scenes import crossing, drive, joined, scenario, stack

ROOT = Path(__file__).parents[2]
FEWER = {
    "width": 32,
    "blocks": 1,
    "layers": 1,
    "heads": 2,
    "tokens": 20,
    "bend": 4,
    "sampling_steps": 3,
    "euler_steps": 2,
    "bf16": False,
}
SHORT = {"steps": 6, "batch": 8, "report_every": 3, "checkpoint_every": 2, "bf16": False}
WAYS = [(0, 8, 4), (0, 9, 5), (0, 10, 7), (2, 14, 6), (2, 15, 7), (1, 11, 5), (3, 19, 6)]


def tiny(name: str) -> Planner:
    """The planner with its own parameters, but small."""
    params = read_section(f"train_planner.planners.{name}", ROOT / "params.yaml")
    small = {key: FEWER.get(key, value) for key, value in params.items()} | {"training": params["training"] | SHORT}
    plugin = plugins.load("planners", name)
    planner: Planner = plugin(build(plugin.Settings, small, "test"))
    return planner


def examples(count: int = 3, seed: int = 0, speed: tuple[float, float] = (4.0, 12.0)) -> Examples:
    """Tracks through a crossing, at first with a `speed` between two [m/s]: some brake, one is parked, one ends early."""
    random, roads, scenes = np.random.default_rng(seed), crossing(), []
    for number in range(count):
        motions = [
            drive(joined(roads, *way), random.uniform(2, 50), random.uniform(*speed), 101, random.choice([0.0, -1.0, 0.3]))
            for way in WAYS
        ]
        motions.append(drive(joined(roads, 3), 20, 0.0, 101))
        motions[1].valid[91:] = False
        scenes.append(scenario(roads, stack(motions), f"scene-{number}"))
    graph = LaneGraph.of(roads)
    return examples_from_logs(scenes, [graph] * count, 0.8, 7)


def calm(logs: Examples) -> Examples:
    """Those that take no bend faster than planners do, so that what is planned can be what they did."""
    heading = np.unwrap(np.where(logs.motion.valid, logs.motion.heading, 0.0), axis=1)
    across = logs.motion.speed[:, 5:-5] * np.abs(heading[:, 10:] - heading[:, :-10]) / (10 * DT)
    within = logs.motion.valid[:, :-10] & logs.motion.valid[:, 10:]
    return logs[(across * within).max(axis=1) < 0.9 * HARD]
