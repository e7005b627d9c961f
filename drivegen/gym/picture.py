"""The first row of an environment as a picture from above."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import TARGET, Scenario
from drivegen.core.signals import Signals
from drivegen.drivers.shared.environment import Environment
from drivegen.render.bird_eye import draw_bird_eye

SIZE = 512
"""Side of the picture [px]; it shows 200 m."""


def picture(environment: Environment) -> NDArray[np.uint8]:
    """(SIZE, SIZE, 3) red, green, blue: the target in the middle, driving upwards, with everybody and all signals as they are."""
    image, _ = draw_bird_eye(present(environment), TARGET, np.zeros((0, 2)), np.zeros(0, np.int64), SIZE)
    return image


def present(environment: Environment) -> Scenario:
    """The first row's scenario as if it began now."""
    world = environment.world
    scenario, _ = environment.traffic[int(world.scene[0])]
    step, boxes = min(int(world.step[0]), scenario.horizon), world.neighbours.boxes(world)
    along, across = world.neighbours.seen(world)[0][0, 4:].cpu().numpy()  # who brakes is slower than planned
    social, at = len(scenario.vehicles) - 1, int(boxes.at[0])
    vehicles, ego = scenario.vehicles, world.ego
    here = np.flatnonzero(np.concatenate([[True], boxes.valid[at, :social].cpu().numpy()]))
    now = replace(
        vehicles,
        position=np.concatenate([ego.position[:1].cpu().numpy(), boxes.position[at, :social].cpu().numpy()]),
        heading=np.concatenate([ego.heading[:1].cpu().numpy(), boxes.heading[at, :social].cpu().numpy()]),
        speed=np.concatenate([ego.speed[:1].cpu().numpy(), np.hypot(along, across)[:social]]),
    )
    people, signals = scenario.context, scenario.signals
    return replace(
        scenario,
        vehicles=now[here],
        horizon=scenario.horizon - step,
        log=None,
        context=replace(people, motion=people.motion.between(step, scenario.steps)),
        signals=Signals(signals.lane, signals.state[:, step:]),
    )
