"""Small scenarios with their traffic, for tests of environments."""

import numpy as np

from drivegen.core.settings import read_params
from drivegen.drivers.shared.conditions import Settings
from tests.scenes import drive, scenario, stack, straight_road

SETTINGS = read_params("environment", Settings)
ROAD = straight_road(300, whole=True)
LINE = ROAD.centreline[0].astype(np.float64)
NEXT = ROAD.centreline[1].astype(np.float64)


def alone(start=10.0, speed=10.0, steps=51):
    log = stack([drive(LINE, start, speed, steps), drive(NEXT, 280, 0, steps)])
    return scenario(ROAD, log, f"alone-{start}"), log


def behind_a_parked_car(gap=30.0):
    log = stack([drive(LINE, 10, 10, 101), drive(LINE, 10 + gap, 0, 101)])
    return scenario(ROAD, log, "behind"), log


def hit_from_behind_at_once():
    log = stack([drive(LINE, 50, 5, 101), drive(LINE, 45, 20, 101)])
    return scenario(ROAD, log, "hit"), log


def met_at_once_by_who_appears():
    log = stack([drive(LINE, 50, 5, 101), drive(LINE, 52, 5, 101)])
    log.valid[1, 0] = False
    return scenario(ROAD, log, "met"), log
