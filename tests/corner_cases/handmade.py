"""Handmade corner cases: a driver on a scene, and the collision that it ends in."""

import torch

from drivegen.corner_cases.case import Case
from drivegen.drivers.idm import Plugin as IDM
from drivegen.simulators.batch import Plugin as Batch
from drivegen.world.observation import Action
from drivegen.world.outcome import CollisionKind
from tests.checking import IDM as SETTINGS
from tests.scenes import scenario, straight_road

ROAD = straight_road(600)
LINE = ROAD.centreline[0].astype(float)
NEXT = ROAD.centreline[1].astype(float)
SOUND = IDM(SETTINGS)


class Blind:
    """Drives on at its speed, whoever is there."""

    name = "blind"

    def act(self, seen):
        return Action(torch.zeros_like(seen.speed))


def collision(log, driver=None, roads=ROAD, attacker=1, **more):
    """The case that `driver`, blind if none is given, ends in on a scene of cars that move as `log` (N, T)."""
    driver = driver or Blind()
    scene = scenario(roads, log, **more)
    run = Batch().run(driver, [scene], [log])
    assert run.collided[0]
    return case_of(scene, log, run, 0, driver.name, attacker)


def case_of(scene, traffic, run, i, driver, attacker=1):
    """Run `i` of an outcome as a case."""
    return Case(
        scene, traffic, attacker, run.motion[i], int(run.step[i]), int(run.partner[i]), CollisionKind(int(run.kind[i])),
        bool(run.at_fault[i]), float(run.impact_speed[i]), 0, 0.1, 1, driver, "handmade",
    )  # fmt: skip
