"""Hand-made rows of logged traffic to draw from."""

from dataclasses import replace

import numpy as np

from drivegen.placement.gaps import Gaps, measure_gaps
from tests.scenes import drive, scenario, stack, straight_road

LANE = np.array([[0.0, 0.0], [800.0, 0.0]])


def queue_rows(name: str, gap: float, speed: float, cars: int = 5, limit: float = 20.0) -> Gaps:
    """The rows of cars of 4.6 m on one lane, bumper to bumper `gap` apart, the foremost the target."""
    road = straight_road(800, 2)
    road.speed_limit[:] = limit
    scene = scenario(road, stack([drive(LANE, 300 - i * (gap + 4.6), speed, 3) for i in range(cars)]))
    return measure_gaps([replace(scene, scenario_id=name)])


def joined_rows(*parts: Gaps) -> Gaps:
    """All of them in order."""
    return Gaps(*(np.concatenate([getattr(part, name) for part in parts]) for name in vars(parts[0])))
