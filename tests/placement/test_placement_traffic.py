"""Placement in mode data: what it keeps whatever is drawn, where it puts whom, and around a target that is given."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import boxes_overlap, wrap_angle
from drivegen.core.scenario import Vehicles
from drivegen.placement.draws import Draws
from drivegen.placement.gaps import Gaps
from drivegen.placement.place import Placement, Placer, PlaceSettings
from drivegen.placement.slots import Slots
from drivegen.placement.table import Table, build_table
from drivegen.placement.ways import Ways
from tests.placement.rows import joined_rows, queue_rows
from tests.scenes import busy_crossing, crossing, road_map, straight_road

SETTINGS = PlaceSettings("data", 60.0, 80.0, 0.15, 0.8, 2.0, 24)
MAPS = {"crossing": Slots(crossing()), "road": Slots(straight_road(600, 3))}
TABLE: Table = build_table([busy_crossing()])
INTO, ACROSS = np.arange(4), np.arange(8, 20, dtype=np.int32)


def logs() -> Gaps:
    """Queues that stand and drive, at offsets of up to 1.2 m; the first of some stand 5 m before a red light."""
    moving = [queue_rows(f"moving-{n}", 12.0 + n, 4.0 + n) for n in range(10)]
    standing = joined_rows(*(queue_rows(f"standing-{n}", 2.0 + n / 4, 0.0) for n in range(6)))
    first = ~standing.led
    standing = replace(standing, closed=first, to_junction=np.where(first, 5.0, standing.to_junction).astype(np.float32))
    rows = joined_rows(*moving, standing)
    return replace(rows, offset=np.linspace(-1.2, 1.2, len(rows)).astype(np.float32))


DRAWS = Draws(logs())
scenes = st.tuples(st.sampled_from(sorted(MAPS)), st.integers(1, 20), st.booleans(), st.integers(0, 2**32))


def placed(name: str, count: int, red: bool, seed: int, **more: object) -> Placement:
    random = np.random.default_rng(seed)
    closed = ACROSS if red and name == "crossing" else None
    return Placer(MAPS[name], TABLE, SETTINGS, more.pop("draws", DRAWS)).place([0] * count, random, closed, **more)


@settings(max_examples=60, deadline=None)
@given(scenes)
def test_whatever_is_drawn_nobody_overlaps_leaves_the_lane_or_is_too_fast(scene):
    placement, slots = placed(*scene), MAPS[scene[0]]
    v = placement.vehicles
    v.validate()
    assert len(v) + sum(placement.rejected.values()) == scene[1]
    assert set(placement.rejected) <= {"overlap", "time-gap", "does-not-fit"}
    a, b = np.triu_indices(len(v), 1)
    assert not boxes_overlap(v.position[a], v.heading[a], v.size[a, :2], v.position[b], v.heading[b], v.size[b, :2]).any()
    assert (np.hypot(*(v.position - v.position[0]).T) <= DRAWS.farthest + 2.0).all()
    for i, lane in enumerate(placement.lane.tolist()):
        begin, end = slots.map.centreline[lane][[0, -1]]
        course = (end - begin) / np.hypot(*(end - begin))
        x, y = v.position[i] - begin
        assert abs(wrap_angle(v.heading[i] - np.arctan2(course[1], course[0]))) < 0.01
        assert abs(course[0] * y - course[1] * x) <= (slots.width[lane] - v.size[i, 1]) / 2 + 1e-3
        assert v.speed[i] <= slots.map.speed_limit[lane] + 1e-3


@settings(max_examples=60, deadline=None)
@given(scenes)
def test_followers_keep_the_least_gaps_of_logs_and_can_still_brake(scene):
    placement = placed(*scene)
    v = placement.vehicles
    for i in range(len(v)):
        course = np.array([np.cos(v.heading[i]), np.sin(v.heading[i])])
        ahead = (v.position - v.position[i]) @ course
        for j in np.flatnonzero((placement.lane == placement.lane[i]) & (ahead > 0)):
            gap = ahead[j] - (v.size[i, 0] + v.size[j, 0]) / 2
            braking = max(v.speed[i] ** 2 - v.speed[j] ** 2, 0.0) / 6
            assert gap >= DRAWS.least_gap + DRAWS.least_time_gap * v.speed[i] + braking - 0.01


def test_the_same_seed_places_the_same():
    one, other = (placed("crossing", 12, True, 3) for _ in range(2))
    assert all(np.array_equal(getattr(one.vehicles, name), getattr(other.vehicles, name)) for name in vars(one.vehicles))
    assert not np.array_equal(one.vehicles.position, placed("crossing", 12, True, 4).vehicles.position)


def test_who_has_no_leader_stands_at_a_red_light_as_in_logs_and_a_queue_behind_it():
    standing = logs()
    draws = Draws(standing[np.char.startswith(standing.scenario_id, "standing")])
    distance = []
    for seed in range(20):
        placement = placed("crossing", 8, True, seed, draws=draws)
        assert (placement.vehicles.speed == 0.0).all()
        for lane in np.setdiff1d(np.intersect1d(placement.lane, INTO), placement.lane[:1]):
            line = MAPS["crossing"].map.centreline[lane]
            away = np.hypot(*(placement.vehicles.position[placement.lane == lane] - line[-1]).T)
            distance.append((away.min(), len(away)))
    nearest, length = np.array(distance).T
    assert np.mean(nearest <= 5.0 + 3.0) > 0.7
    assert length.max() >= 3


def test_vehicles_stand_no_farther_than_around_a_like_target_or_than_the_radius_said():
    near = Draws(joined_rows(*(queue_rows(f"log-{n}", 10.0, 5.0) for n in range(12))))
    for more, most in (({}, 4 * 14.6), ({"radius": 40.0}, 40.0)):
        for seed in range(6):
            v = placed("road", 5, False, seed, draws=near, **more).vehicles
            assert len(v) == 5
            assert np.hypot(*(v.position - v.position[0]).T).max() <= most + 2.0


def log_target(**changes: float) -> Vehicles:
    one = busy_crossing().vehicles[[0]]
    place = np.array([[changes.pop("x", 301.3), changes.pop("y", 3.3)]], np.float32)
    size, heading = np.float32([[5.2, 2.0, 1.7]]), np.float32([0.01])
    return replace(one, position=place, size=size, heading=heading, speed=np.float32([7.7]))


@pytest.mark.parametrize("mode", ["paper", "data"])
def test_a_target_that_is_given_stays_as_it_is_and_the_others_stand_around_it(mode):
    target, placer = log_target(), Placer(MAPS["road"], TABLE, replace(SETTINGS, mode=mode), DRAWS)
    for seed in range(6):
        placement = placer.place([1, *[0] * 9], np.random.default_rng(seed), target=target)
        v = placement.vehicles
        assert len(v) + sum(placement.rejected.values()) == 10
        assert len(v) > 5
        for name in ("kind", "size", "size_source", "position", "heading", "speed"):
            assert np.array_equal(getattr(v, name)[:1], getattr(target, name))
        assert len(set(v.track_id.tolist())) == len(v)
        assert placement.lane[0] == 1
        a, b = np.triu_indices(len(v), 1)
        assert not boxes_overlap(v.position[a], v.heading[a], v.size[a, :2], v.position[b], v.heading[b], v.size[b, :2]).any()


def test_a_given_target_off_all_lanes_is_refused():
    with pytest.raises(UnusableInput, match="on no lane") as caught:
        Placer(MAPS["road"], TABLE, SETTINGS, DRAWS).place([0], np.random.default_rng(0), target=log_target(y=60.0))
    assert caught.value.reason == "no-place"


def test_what_is_kept_of_driving_distances_does_not_grow_with_the_square_of_a_map():
    """A road of 1500 lanes, asked from each of them: only the next lanes are within reach."""
    lines = [np.array([[100.0 * i, 0.0], [100.0 * (i + 1), 0.0]]) for i in range(1500)]
    ways = Ways(road_map(lines, [(i, i + 1) for i in range(1499)]))
    lanes, alongs = np.arange(1500, dtype=np.int32), np.zeros(1500)
    tracemalloc.start()
    away = [ways.ahead(lane, 0.0, lanes, alongs)[lane : lane + 4].tolist() for lane in range(1490)]
    kept, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert away[700] == [0.0, 100.0, 200.0, np.inf]
    assert kept < 3e6  # a number for each pair of lanes takes 18 MB
