"""Closed-loop simulation: the batch simulator on a thousand scenarios beside libsumo on a few."""

from collections.abc import Iterator

from drivegen.bench import _scene
from drivegen.bench._row import Row, cpu_seconds
from drivegen.drivers.idm import Plugin as Idm
from drivegen.drivers.idm import Settings
from drivegen.scenario import Scenario
from drivegen.simulators._paths import target_paths
from drivegen.simulators.base import Simulator
from drivegen.simulators.batch import Plugin as Batch
from drivegen.simulators.sumo import Plugin as Sumo

MANY, FEW = 1024, 8
DIFFERENT = 16
"""Different scenes among the many; they are repeated."""

DRIVER = Settings(
    desired_speed=13.9, headway=1.5, min_gap=2.0, acceleration=1.5, braking=2.0, emergency_braking=9.0, exponent=4.0,
    side_margin=0.2, look_ahead=0.0,
)  # fmt: skip


def rows() -> Iterator[Row]:
    """300 000 scenario-steps per CPU-second are wanted."""
    scenes = [_scene.scene(number) for number in range(DIFFERENT)]
    many = scenes * (MANY // DIFFERENT)
    value = _steps_per_second(Batch(), many)
    reference = _steps_per_second(Sumo(), scenes[:FEW])
    yield Row("batch simulator with IDM", value, "scenario-steps per CPU-second", 300_000, False, reference, "libsumo")


def _steps_per_second(simulator: Simulator, scenes: list[Scenario]) -> float:
    """Replay and stepping; the targets' paths are found once, before, as when one driver after another is tried."""
    logs = [scene.log for scene in scenes if scene.log is not None]
    paths = target_paths(scenes, logs)
    return len(scenes) * _scene.STEPS / cpu_seconds(lambda: simulator.run(Idm(DRIVER), scenes, logs, paths), turns=2)
