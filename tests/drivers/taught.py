"""Drivers for tests: from their settings, or taught in seconds how to drive on a straight road."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from drivegen.core import plugins
from drivegen.core.scenario import Scenario
from drivegen.core.settings import build
from drivegen.drivers.base import Driver
from drivegen.drivers.idm import Plugin as Idm
from drivegen.drivers.shared.lessons import Lessons
from drivegen.drivers.shared.teaching import Taught, teach
from drivegen.simulators.batch import Plugin as Batch
from stages._door import read_section
from tests.scenes import drive, scenario, stack, straight_road

PARAMS = Path(__file__).parents[2] / "params.yaml"


def settings_of(name: str) -> Any:
    """Those of params.yaml."""
    section = f"drive.drivers.{name}"
    return build(plugins.load("drivers", name).settings_type, read_section(section, PARAMS), section)


def teaching(name: str, **changed: Any) -> Any:
    """How params.yaml teaches the driver `name`, some of it `changed`."""
    section = f"train_driver.drivers.{name}"
    return build(plugins.load("drivers", name).lessons_type(), {**read_section(section, PARAMS), **changed}, section)


def quick(name: str) -> Any:
    """A teaching of seconds that is enough for straight roads."""
    ppo = {**read_section("train_driver.drivers.gail.ppo", PARAMS), "rows": 32, "batch": 1024}
    few: dict[str, dict[str, Any]] = {
        "gail": {"course": {"rounds": 2, "grade_every": 1}, "clone_steps": 500, "ppo": ppo},
        "sac": {"course": {"rounds": 6, "grade_every": 1}, "rows": 16, "updates": 1, "batch": 128, "rewards": 10, "pull": 0.02},
    }
    return teaching(name, **few[name])


def make(name: str, folder: Path) -> Driver:
    """The driver `name`; one that learns is taught for seconds and keeps its weights in `folder`."""
    plugin = plugins.load("drivers", name)
    if not issubclass(plugin, Taught):
        return plugin(settings_of(name))
    how, lessons = quick(name), straight_lessons(24)
    policy, _ = teach(plugin.pupil(how, lessons, 7), how.course, lessons, 7, None, lambda _: None)
    policy.write(folder, name)
    return plugin(replace(settings_of(name), weights=str(folder)))


def straight_lessons(count: int) -> Lessons:
    """Straight roads, free or with somebody who stands or drives ahead, as IDM drives there."""
    random = np.random.default_rng(7)
    road = straight_road()
    line = road.centreline[0].astype(np.float64)
    scenes: list[Scenario] = []
    for n in range(count):
        own, ahead = random.uniform(4, 13), random.uniform(30, 90)
        others = [drive(line, 10 + ahead, (0.0, 0.0, 6.0)[n % 3], 101)] if n % 4 else []
        scenes.append(scenario(road, stack([drive(line, 10, own, 101), *others]), f"straight-{n}"))
    motion = [scene.log for scene in scenes if scene.log is not None]
    driven = Batch().run(Idm(settings_of("idm")), scenes, motion).motion
    logs = [stack([driven[n], *(log[i] for i in range(1, len(log.valid)))]) for n, log in enumerate(motion)]
    return Lessons.of(list(zip(scenes, logs, strict=True)))
