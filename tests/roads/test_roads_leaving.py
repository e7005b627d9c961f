"""Who crosses an end of the network leaves, for good; who crosses a cut end does not."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.geometry import rotate
from drivegen.core.roadmap import LaneKind
from drivegen.core.scenario import Trajectories
from drivegen.roads.leaving import STAYS, Exits
from tests.scenes import crossing, drive, joined, road_map, stack, straight_road

LENGTH = np.float32(4.6)
SEEDS = st.integers(0, 2**32 - 1)


def test_a_vehicle_leaves_at_the_step_at_which_its_front_is_out():
    roads = straight_road(100, 2, whole=True)
    motion = stack([drive(joined(roads, 0), 20, 10, 101), drive(joined(roads, 1), 10, 3, 101)])
    exits = Exits.of(roads)
    assert exits.crossings(motion, np.tile(LENGTH, 2)).tolist() == [78, STAYS]  # 20 + 2.3 + 10 * 7.8 >= 100
    left = exits.leave(motion, np.tile(LENGTH, 2))
    assert left.valid.sum(-1).tolist() == [78, 101]
    np.testing.assert_array_equal(left.position[0, 78:], np.tile(motion.position[0, 77], (23, 1)))
    assert (left.speed[0, 78:] == 0).all()
    assert motion.valid.all()  # what was given is not changed


def test_where_the_road_is_cut_nobody_leaves():
    roads = straight_road(100, 2)
    motion = drive(joined(roads, 0), 20, 10, 101)
    assert len(Exits.of(roads)) == 0
    assert Exits.of(roads).leave(motion, LENGTH) is motion


def test_a_lane_that_is_dropped_is_no_exit_and_a_lane_for_bicycles_is_none():
    lines = [[[0, 0], [100, 0]], [[0, 3.5], [100, 3.5]], [[100, 0], [200, 0]]]
    roads = road_map(lines, links=[(0, 2)], neighbours=[(1, 0)], whole=True)
    assert Exits.of(roads).lane.tolist() == [2]
    bikes = replace(roads, kind=np.full(3, LaneKind.BIKE, np.uint8))
    assert len(Exits.of(bikes)) == 0


def test_a_bus_lane_that_ends_beside_a_lane_that_goes_on_is_no_exit_and_one_that_ends_with_its_road_is():
    lines = [[[0, 0], [100, 0]], [[0, 3.5], [100, 3.5]], [[100, 0], [200, 0]]]
    roads = road_map(lines, links=[(0, 2)], neighbours=[(1, 0)], whole=True)
    roads.kind[1] = LaneKind.BUS
    assert Exits.of(roads).lane.tolist() == [2]
    roads = straight_road(100, 2, whole=True)
    roads.kind[0] = LaneKind.BUS
    assert Exits.of(roads).lane.tolist() == [0, 1]


def test_who_comes_in_by_an_exit_or_drives_by_beside_it_or_begins_beyond_it_does_not_leave():
    roads = straight_road(100, 1, whole=True)
    way_in = drive(np.array([[120.0, 0.0], [20.0, 0.0]]), 0, 8, 101)
    beside = drive(np.array([[0.0, 9.0], [200.0, 9.0]]), 50, 10, 101)
    beyond = drive(np.array([[103.0, 0.0], [300.0, 0.0]]), 0, 10, 101)
    assert (Exits.of(roads).crossings(stack([way_in, beside, beyond]), np.tile(LENGTH, 3)) == STAYS).all()


def test_a_box_across_the_exit_leaves_when_its_middle_is_out():
    roads = straight_road(100, 1, whole=True)
    motion = drive(joined(roads, 0), 99, 2, 51)
    assert Exits.of(roads).crossings(motion, LENGTH) == 5
    assert Exits.of(roads).crossings(drive(joined(roads, 0), 99, 0, 51), LENGTH) == STAYS


def wandering(seed: int, shape: tuple[int, ...] = (3, 5), steps: int = 60) -> tuple[Trajectories, np.ndarray]:
    """Vehicles that drive about a crossing in all directions, some of which come late, and their lengths."""
    random = np.random.default_rng(seed)
    heading = np.cumsum(random.normal(0, 0.05, (*shape, steps)), axis=-1) + random.uniform(-np.pi, np.pi, (*shape, 1))
    velocity = random.uniform(0, 30, (*shape, 1, 1)) * np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    position = random.uniform(-90, 90, (*shape, 1, 2)) + np.cumsum(velocity * 0.1, axis=-2)
    valid = np.arange(steps) >= random.integers(0, 10, (*shape, 1))
    motion = Trajectories(position.astype(np.float32), heading.astype(np.float32), velocity.astype(np.float32), valid)
    return motion, random.uniform(3, 14, shape).astype(np.float32)


@settings(max_examples=50, deadline=None)
@given(SEEDS)
def test_to_leave_twice_is_to_leave_once_and_nobody_minds_the_order(seed):
    exits = Exits.of(crossing(whole=True))
    motion, length = wandering(seed)
    left = exits.leave(motion, length)
    again = exits.leave(left, length)
    for name in ("position", "heading", "velocity", "valid"):
        np.testing.assert_array_equal(getattr(again, name), getattr(left, name))
    order = np.random.default_rng(seed).permutation(5)
    mixed = exits.leave(motion[:, order], length[:, order])
    np.testing.assert_array_equal(mixed.valid, left.valid[:, order])
    one = exits.leave(motion[1, 2], length[1, 2])
    np.testing.assert_array_equal(one.valid, left.valid[1, 2])


@settings(max_examples=50, deadline=None)
@given(SEEDS)
def test_leaving_is_that_of_loops_and_for_good(seed):
    roads = crossing(whole=True)
    exits = Exits.of(roads)
    motion, length = wandering(seed)
    found = exits.crossings(motion, length)
    left = exits.leave(motion, length)
    assert not (left.valid & ~motion.valid).any()
    for k, n in np.ndindex(found.shape):
        track = motion[k, n]
        firsts = []
        for point, forward, reach in zip(exits.point, exits.forward, exits.reach, strict=True):
            turn = np.float64(-np.arctan2(forward[1], forward[0]))
            for lead in (length[k, n] / 2, 0.0):
                nose = track.position + lead * np.stack([np.cos(track.heading), np.sin(track.heading)], axis=-1)
                local = rotate((nose - point).astype(np.float64), turn)
                for t in range(1, track.steps):
                    a, b = local[t - 1], local[t]
                    if track.valid[t - 1] and a[0] < 0 <= b[0]:
                        at = a[1] + (b[1] - a[1]) * a[0] / (a[0] - b[0])
                        firsts += [t] if abs(at) <= reach else []
        assert found[k, n] == min(firsts, default=STAYS)
        if firsts:
            assert not left.valid[k, n, min(firsts) :].any()


@pytest.mark.parametrize("angle", [0.0, 1.0, 2.5, -2.0])
def test_directions_do_not_matter(angle):
    line = np.stack([np.linspace(0, 100, 11), np.zeros(11)], axis=1)
    roads = road_map([rotate(line, np.float64(angle))], whole=True)
    assert Exits.of(roads).crossings(drive(joined(roads, 0), 20, 10, 101), LENGTH) == 78
