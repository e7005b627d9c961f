"""The driving environment: steps per CPU-second of the batched one beside one environment at a time, and memory."""

import gc
import resource
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from drivegen.bench import _scene
from drivegen.bench._row import Row, best_cpu_seconds
from drivegen.drivers.shared.conditions import Rewards, Settings, Traffic
from drivegen.gym.env import DriveEnv
from drivegen.gym.sb3 import DriveVecEnv
from drivegen.gym.vector import DriveVectorEnv, Floats
from drivegen.world.reactive import Reaction

ROWS, STEPS, FEW = 512, 200, 100
DIFFERENT = 64
"""Different scenes that episodes are drawn from."""

SETTINGS = Settings(
    motion="path", neighbours="replayed", rules=False, reaction=Reaction(0.75, 6.0, 0.6, 1.0, 1.5, 3.0),
    rewards=Rewards(progress=0.1, comfort=-0.005, speeding=-0.03, collision=-10.0, hit=-3.0, red=-3.0, off_road=-10.0),
)  # fmt: skip

UNIT = "environment steps per CPU-second"
ALONE = "one environment at a time"
LATER = 1000
"""Steps of ROWS after which memory is looked at again."""


def rows() -> Iterator[Row]:
    """Observations, rewards and resets are in the clock; packing the scenes is not."""
    traffic = [(scene, scene.log) for scene in map(_scene.scene, range(DIFFERENT)) if scene.log is not None]
    reacting = replace(SETTINGS, neighbours="reactive")
    one, one_reacting = _alone(traffic, SETTINGS), _alone(traffic, reacting)
    vector = DriveVectorEnv(traffic, ROWS, SETTINGS)
    vector.reset(seed=0)
    yield Row(f"environment, {ROWS} rows, replayed", _rate(vector.step, ROWS), UNIT, 400_000, False, one, ALONE)
    adapter = DriveVecEnv(traffic, ROWS, SETTINGS)
    adapter.reset()
    yield Row(
        f"the same as VecEnv of Stable-Baselines3, {ROWS} rows", _rate(adapter.step, ROWS), UNIT, 100_000, False, one, ALONE
    )
    reactive = DriveVectorEnv(traffic, ROWS, reacting)
    reactive.reset(seed=0)
    yield Row(f"environment, {ROWS} rows, reactive", _rate(reactive.step, ROWS), UNIT, 50_000, False, one_reacting, ALONE)
    yield Row(f"memory that {LATER} steps more of {ROWS} rows take", _growth(reactive.step), "MB", 20.0, True)


def _rate(step: Callable[[Floats], object], rows: int, steps: int = STEPS) -> float:
    actions = np.random.default_rng(0).uniform(-0.3, 0.4, (steps, rows, 1)).astype(np.float32)
    return rows * steps / best_cpu_seconds(lambda: [step(action) for action in actions], turns=3)


def _alone(traffic: list[Traffic], settings: Settings) -> float:
    env = DriveEnv(traffic, settings)
    env.reset(seed=0)

    def step(action: Floats) -> None:
        _, _, terminated, truncated, _ = env.step(action[0])
        if terminated or truncated:
            env.reset()

    return _rate(step, 1, FEW)


def _growth(step: Callable[[Floats], object]) -> float:
    """[MB] by which the most memory that this process has held rises."""
    action = np.zeros((ROWS, 1), np.float32)
    gc.collect()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(LATER):
        step(action)
    return float(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
