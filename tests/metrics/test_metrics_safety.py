"""Rates of violations by hand."""

import numpy as np
import pytest

from drivegen.core.samples import Samples, Violation
from drivegen.core.scenario import Trajectories
from drivegen.metrics.features import joined
from drivegen.metrics.safety import box_rates, safety_rates, violation_shares
from drivegen.metrics.surroundings import Boxes
from tests.scenes import busy_crossing


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


def test_rates_by_size_of_boxes_leave_the_log_out():
    scene = busy_crossing(41)
    worlds = scene.log[np.newaxis][np.zeros(2, np.intp)]
    worlds.position[0, 1, 20:] = worlds.position[0, 0, 20:] + np.float32([0, 2.0])  # half a width of air beside the target
    boxes = Boxes.of(joined(worlds, scene.log), scene.vehicles.size, scene.context)
    found = box_rates(boxes, 8, (0.9, 1.0, 1.1))
    assert [found[f"boxes_{percent}_collision"] for percent in (90, 100, 110)] == [0, 0, 2 / 16]
    assert (found["boxes_overlap_initial"], found["boxes_centres_meet"]) == (0, 0)
    worlds.position[1, 2, 30] = worlds.position[1, 3, 30]
    boxes = Boxes.of(joined(worlds, scene.log), scene.vehicles.size, scene.context)
    assert box_rates(boxes, 8, (1.0,))["boxes_centres_meet"] == 2 / 16
