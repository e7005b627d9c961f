"""Labels of scenes whose manoeuvres and conflicts are known."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.core.roadmap import LaneControl, Polylines
from drivegen.metrics.labels import conflict_type, label, manoeuvre
from tests.scenes import busy_crossing, crossing, drive, joined, scenario, stack, straight_road

ROADS = crossing()


@pytest.mark.parametrize(
    ("lanes", "speed", "acceleration", "wanted"),
    [
        ((0, 8, 4), 10, 0.0, "straight"),
        ((0, 9, 5), 8, 0.0, "left"),
        ((0, 10, 7), 8, 0.0, "right"),
        ((0, 8, 4), 6, -1.0, "stop"),
        ((0, 8, 4), 0, 0.0, "stationary"),
    ],
)
def test_manoeuvres_at_a_crossing(lanes, speed, acceleration, wanted):
    assert manoeuvre(drive(joined(ROADS, *lanes), 50, speed, 101, acceleration)) == wanted


def test_changing_lanes_is_a_shift_and_turning_round_a_u_turn():
    s = np.linspace(0, 120, 60)
    change = np.stack([s, 3.5 / (1 + np.exp(-(s - 50) / 8))], axis=1)
    assert manoeuvre(drive(change, 0, 11, 101)) == "shift_left"
    assert manoeuvre(drive(change * [1, -1], 0, 11, 101)) == "shift_right"
    angle = np.linspace(0, np.pi, 40)
    back = np.concatenate([np.stack([8 * np.sin(angle), -8 * np.cos(angle)], axis=1), [[-60, 8]]])
    assert manoeuvre(drive(back, 0, 7, 101)) == "u_turn"


def test_a_vehicle_that_was_seen_once_is_stationary():
    motion = drive(joined(ROADS, 0), 0, 10, 50)
    motion.valid[1:] = False
    assert manoeuvre(motion) == "stationary"


@pytest.mark.parametrize(
    ("other", "start", "wanted"),
    [((0, 8, 4), 8, "following"), ((1, 11, 5), 30, "crossing"), ((1, 13, 4), 28, "merging"), ((2, 14, 6), 5, "none")],
)
def test_conflicts_of_a_target_that_goes_straight(other, start, wanted):
    target = drive(joined(ROADS, 0, 8, 4), 30, 10, 101)
    assert conflict_type(stack([target, drive(joined(ROADS, *other), start, 10, 101)])) == wanted


def test_head_on_is_oncoming():
    line = joined(ROADS, 0, 8, 4)
    target = drive(line, 0, 12, 101)
    assert conflict_type(stack([target, drive(line[::-1], 0, 12, 101)])) == "oncoming"


def test_road_kinds():
    assert label(busy_crossing(), busy_crossing().log).road == "signalised junction"
    log = stack([drive(joined(ROADS, 0, 8, 4), 30, 10, 101)])
    assert label(scenario(crossing(control=LaneControl.YIELD), log), log).road == "junction"
    roads = straight_road()
    along = stack([drive(roads.centreline[0], 20, 10, 101)])
    assert label(scenario(roads, along), along).road == "road"
    roads.speed_limit[:] = 33
    assert label(scenario(roads, along), along).road == "fast road"


def test_a_long_lane_without_a_point_near_the_path_is_driven_on():
    roads = straight_road()
    ends = Polylines.of([line[[0, -1]] for line in roads.centreline.lines()])
    along = stack([drive(roads.centreline[0], 100, 5, 101)])
    sparse = replace(roads, centreline=ends, speed_limit=np.full(len(roads), 33.0, np.float32))
    assert label(scenario(sparse, along), along).road == "fast road"
    beside = replace(along, position=along.position + np.float32([0.0, 40.0]))
    assert label(scenario(sparse, beside), beside).road == "road"


def test_rows_hold_one_label_an_aspect_and_count_manoeuvres():
    scene = busy_crossing()
    rows = label(scene, scene.log).as_rows()
    assert {name.split(".")[1] for name in rows if name.startswith("label.")} == {"road", "manoeuvre", "conflict", "density"}
    assert sum(count for name, count in rows.items() if name.startswith("manoeuvre.")) == len(scene.vehicles)


def test_density_counts_the_neighbours_of_the_first_frame():
    roads = straight_road()
    few, many = (stack([drive(roads.centreline[0], 60 + 8 * i, 10, 20) for i in range(n)]) for n in (2, 7))
    assert (label(scenario(roads, few), few).density, label(scenario(roads, many), many).density) == ("sparse", "medium")
