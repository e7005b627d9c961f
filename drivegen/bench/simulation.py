"""Closed-loop simulation: the batch simulator on a thousand scenarios beside libsumo on a few."""

from collections.abc import Iterator

from drivegen.bench import _scene
from drivegen.bench._row import Row, best_cpu_seconds
from drivegen.core.scenario import Scenario
from drivegen.drivers.idm import Plugin as Idm
from drivegen.drivers.idm import Settings
from drivegen.simulators.base import Simulator
from drivegen.simulators.batch import Plugin as Batch
from drivegen.simulators.sumo import Plugin as Sumo
from drivegen.world.paths import target_paths

MANY, FEW = 1024, 8
DIFFERENT = 16
"""Different scenes among the many; they are repeated."""

DRIVER = Settings(
    desired_speed=13.9, headway=1.5, min_gap=2.0, acceleration=1.5, braking=2.0, emergency_braking=9.0, exponent=4.0,
    side_margin=0.2, look_ahead=0.0, heeds_rules=False, gives_way=True, accepted_gap=4.0,
)  # fmt: skip


def rows() -> Iterator[Row]:
    """300 000 scenario-steps per CPU-second are wanted of a run; finding the targets' paths comes once per traffic."""
    scenes = [_scene.scene(number) for number in range(DIFFERENT)]
    many = scenes * (MANY // DIFFERENT)
    unit = "scenario-steps per CPU-second"
    for paths_ready, clock, target in (
        (True, "replay, steps and collisions; paths known, as for a second driver", 300_000),
        (False, "the same and finding the paths, as for the first driver", None),
    ):
        value, reference = _steps_per_second(Batch(), many, paths_ready), _steps_per_second(Sumo(), scenes[:FEW], paths_ready)
        yield Row(f"batch simulator with IDM: {clock}", value, unit, target, False, reference, "libsumo, the same")


def _steps_per_second(simulator: Simulator, scenes: list[Scenario], paths_ready: bool) -> float:
    """Everything from logs to outcomes is in the clock; the targets' paths only if they are not `paths_ready`."""
    logs = [scene.log for scene in scenes if scene.log is not None]
    paths = target_paths(scenes, logs) if paths_ready else None
    return len(scenes) * _scene.STEPS / best_cpu_seconds(lambda: simulator.run(Idm(DRIVER), scenes, logs, paths), turns=2)
