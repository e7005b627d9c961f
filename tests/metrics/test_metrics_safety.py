"""Rates of violations by hand."""

import pytest

from drivegen.metrics.safety import safety_rates, violation_shares
from drivegen.samples import Samples, Violation
from drivegen.scenario import Trajectories


def samples() -> Samples:
    """Two samples of four vehicles: one collides with another and a pedestrian, one leaves the road and speeds."""
    made = Samples.without_goals("s", "m", Trajectories.empty(2, 4, 3))
    made.violation[0, 0] = Violation.COLLISION
    made.violation[0, 1] = Violation.COLLISION | Violation.COLLISION_WITH_CONTEXT
    made.violation[0, 2] = Violation.OFF_ROAD | Violation.SPEED
    return made


def test_rates_per_vehicle_and_per_scene():
    rates = safety_rates(samples())
    assert (rates.collision_per_vehicle, rates.collision_per_scene) == (2 / 8, 1 / 2)
    assert (rates.off_road_per_vehicle, rates.off_road_per_scene) == (1 / 8, 1 / 2)
    assert (rates.illegal_per_vehicle, rates.illegal_per_scene) == (3 / 8, 1 / 2)


def test_leaving_a_vehicle_out_counts_as_illegal():
    made = samples()
    made.dropped[1, 3] = True
    rates = safety_rates(made)
    assert (rates.illegal_per_vehicle, rates.illegal_per_scene, rates.dropped_per_vehicle) == (4 / 8, 1.0, 1 / 8)


def test_every_kind_of_violation_has_its_share():
    shares = violation_shares(samples())
    assert len(shares) == len(Violation.__members__) - 1
    assert shares["collision"] == pytest.approx(2 / 8)
    assert (shares["collision_with_context"], shares["speed"], shares["red_light"]) == (1 / 8, 1 / 8, 0.0)
