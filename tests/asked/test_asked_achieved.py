"""Was it done? Motion that is something else does not count, and real lane changes do."""

import numpy as np
import pytest

from drivegen.asked.achieved import does, stands
from drivegen.asked.goals import Duty
from drivegen.asked.offered import side_of
from drivegen.core.roadmap import RoadMap
from drivegen.core.scenario import DT, Trajectories
from drivegen.placement.ways import crossed
from drivegen.placement.where import Relation
from drivegen.roads.graph import LaneGraph
from drivegen.roads.line import Route
from drivegen.roads.routes import feasible_routes
from drivegen.words.request import Manoeuvre
from tests.scenes import beside, crossing, drive, joined, road_map, scenario, stack, straight_road

CROSSING = crossing()
STRAIGHT, FROM_LEFT, FROM_RIGHT = ((0, 8, 4), (3, 17, 7), (1, 11, 5))


BESIDE = [Relation(f"{side}{where}") for side in ("left", "right") for where in ("", "_ahead", "_behind")]


def way(lanes: tuple[int, ...], start: float, speed: float) -> Trajectories:
    """A car on the lanes of the crossing."""
    return drive(joined(CROSSING, *lanes), start, speed, 101)


def done(roads: RoadMap, target: Trajectories, other: Trajectories) -> set[Manoeuvre]:
    """Lane changes and cut-ins that the other vehicle is said to have made."""
    lines = [keeping(roads, track) for track in (target, other)]
    asked = (Manoeuvre.CHANGE_LEFT, Manoeuvre.CHANGE_RIGHT, Manoeuvre.CUT_IN)
    return {m for m in asked if does(Duty(1, m, None), stack([target, other]), lines[0][:1], lines[1], roads)}


def turns(track: Trajectories) -> set[Manoeuvre]:
    """Turns that the vehicle is said to have made."""
    both = stack([way(STRAIGHT, 0, 8), track])
    return {m for m in (Manoeuvre.TURN_LEFT, Manoeuvre.TURN_RIGHT) if does(Duty(1, m, None), both, (), (), CROSSING)}


def keeping(roads: RoadMap, track: Trajectories) -> list[Route]:
    graph, speed = LaneGraph.of(roads), float(track.speed[0])
    routes = feasible_routes(graph, track.position[0], float(track.heading[0]), speed, 150.0)
    return [route for route in routes if route.lane_changes == 0]


def arc(radius: float, side: float = 1.0, length: float = 250.0) -> np.ndarray:
    """A line from the origin along +x that bends to its left (`side` 1) or right (-1)."""
    angle = np.arange(0.0, length / radius, 2.0 / radius)
    return np.stack([radius * np.sin(angle), side * radius * (1 - np.cos(angle))], axis=1)


@pytest.mark.parametrize("lanes", [(0, 9, 5), (0, 10, 7)])
def test_a_turn_at_a_junction_is_no_lane_change(lanes):
    assert done(CROSSING, way(STRAIGHT, 20, 8), way(lanes, 40, 9)) == set()


@pytest.mark.parametrize("speed", [4.0, 9.0])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_nor_is_the_wide_branch_of_a_fork(side, speed):
    ahead = np.stack([np.linspace(0, 250, 51), np.zeros(51)], axis=1)
    into = ahead - [250.0, 0.0]
    fork = road_map([into, ahead, arc(60.0, side)], links=[(0, 1), (0, 2)])
    turning = drive(np.concatenate([into, arc(60.0, side)[1:]]), 240, speed, 101)
    assert done(fork, drive(np.concatenate([into, ahead[1:]]), 200, 4, 101), turning) == set()


def test_whoever_drives_straight_on_through_a_ring_has_turned_to_neither_side():
    swing = np.concatenate([np.zeros(30), np.linspace(0, -60, 6), np.linspace(-60, 60, 15), np.linspace(60, 0, 6), np.zeros(60)])
    steps = 2.0 * np.stack([np.cos(np.deg2rad(swing)), np.sin(np.deg2rad(swing))], axis=1)
    through = drive(np.cumsum(steps, axis=0), 40, 9, 101)
    assert turns(through) == set()


@pytest.mark.parametrize(("lanes", "turn"), [((0, 9, 5), Manoeuvre.TURN_LEFT), ((0, 10, 7), Manoeuvre.TURN_RIGHT)])
def test_whoever_leaves_a_crossing_to_a_side_has_turned(lanes, turn):
    assert turns(way(lanes, 40, 9)) == {turn}


@pytest.mark.parametrize(("side", "turn"), [(1.0, Manoeuvre.TURN_LEFT), (-1.0, Manoeuvre.TURN_RIGHT)])
def test_along_a_bend_without_a_junction_nobody_turns(side, turn):
    bend = arc(60.0, side)
    both = stack([drive(bend, 0, 8, 101), drive(bend, 20, 12, 101)])
    assert abs(np.ptp(np.unwrap(both.heading[1]))) > np.deg2rad(80)
    assert not does(Duty(1, turn, None), both, (), (), road_map([bend]))


@pytest.mark.parametrize("corner", [0.0, np.deg2rad(80)])
def test_a_bend_behind_a_junction_neither_makes_a_turn_nor_undoes_one(corner):
    turned = np.array([[np.cos(corner), np.sin(corner)], [-np.sin(corner), np.cos(corner)]])
    into = np.array([[-60.0, 0.0], [0.0, 0.0]])
    through = arc(12.0, 1.0, 18.0) if corner else np.array([[0.0, 0.0], [18.0, 0.0]])
    bend = np.array([25.0, 0.0]) + arc(40.0, -1.0 if corner else 1.0, 100.0)
    out = through[-1] + np.concatenate([np.zeros((1, 2)), bend]) @ turned
    roads = road_map([into, through, out], links=[(0, 1), (1, 2)], in_junction=[1])
    track = drive(np.concatenate([into, through[1:], out[1:]]), 40, 11, 101)
    assert abs(track.heading[-1] - corner) > np.deg2rad(60)
    assert does(Duty(1, Manoeuvre.TURN_LEFT, None), stack([track, track]), (), (), roads) == bool(corner)


def test_who_turns_round_has_not_turned_left():
    angle = np.linspace(0, np.pi, 20)
    half = np.stack([5 * np.sin(angle), -5 * np.cos(angle)], axis=1)
    line = np.concatenate([[[-60.0, -5.0]], half, [[-60.0, 5.0]]])
    track = drive(line, 30, 6, 101)
    assert turns(track) == set()


THREE_LANES = straight_road(600, 3)


def abreast(lane: float, start: float, *pace: float) -> Trajectories:
    """A car beside lane 0 by so many lanes, which goes from one speed [m/s] to the next, evenly over 10 s."""
    speed = np.interp(np.linspace(0, len(pace) - 1, 101) if len(pace) > 1 else np.zeros(101), np.arange(len(pace)), pace)
    x = start + np.concatenate([[0.0], np.cumsum(speed[:-1] * DT)])
    flat = np.zeros(101)
    position, velocity = np.stack([x, flat + lane * 3.5], axis=1), np.stack([speed, flat], axis=1)
    return Trajectories(*(a.astype(np.float32) for a in (position, flat, velocity)), np.ones(101, np.bool_))


def did(manoeuvre: Manoeuvre, other: Trajectories, within: float | None = None) -> bool:
    """Whether the other car did so to one that keeps lane 0 at 8 m/s."""
    target = abreast(0, 60, 8)
    own = keeping(THREE_LANES, other)
    return does(Duty(1, manoeuvre, within), stack([target, other]), keeping(THREE_LANES, target), own, THREE_LANES)


def test_who_falls_behind_again_or_passes_on_another_road_has_not_overtaken():
    assert did(Manoeuvre.OVERTAKE, abreast(1, 50, 14))
    assert not did(Manoeuvre.OVERTAKE, abreast(1, 50, 14), within=1.0)
    assert not did(Manoeuvre.OVERTAKE, abreast(1, 50, 16, 14, 0, 0, 0))
    assert not did(Manoeuvre.OVERTAKE, abreast(17, 50, 14))
    assert not did(Manoeuvre.OVERTAKE, abreast(1, 80, 14))


def test_who_comes_out_of_a_side_road_does_not_cut_in():
    angle = np.linspace(0, np.pi / 2, 12)
    corner = np.stack([230 + 12 * (1 - np.cos(angle)), -12 + 12 * np.sin(angle)], axis=1)
    for begins in (-60.0, -17.0):  # the second one is as near to the target's way as a lane beside it
        side_road = np.concatenate([[[230.0, begins]], corner, [[500.0, 0.0]]])
        assert not did(Manoeuvre.CUT_IN, drive(side_road, 12 if begins > -20 else 20, 9, 101))


def goes_straight(roads: RoadMap, track: Trajectories, within: float | None = None) -> bool:
    both = stack([track, track])
    return does(Duty(1, Manoeuvre.GO_STRAIGHT, within), both, (), keeping(roads, track), roads)


def test_whoever_gets_over_a_crossing_without_a_turn_goes_straight():
    assert goes_straight(CROSSING, way(STRAIGHT, 60, 8))
    assert goes_straight(CROSSING, way(FROM_LEFT, 60, 8))
    assert not goes_straight(CROSSING, way(STRAIGHT, 60, 8), within=2.0)
    assert not goes_straight(CROSSING, way(STRAIGHT, 5, 6))  # it does not get there
    assert not goes_straight(CROSSING, way(STRAIGHT, 90, 8))  # it begins within the junction
    assert not goes_straight(CROSSING, way(STRAIGHT, 120, 8))  # and this one behind it
    for turning in ((0, 9, 5), (0, 10, 7)):
        assert not goes_straight(CROSSING, way(turning, 60, 8))


def test_where_nothing_crosses_nobody_goes_straight_over():
    merging = [
        np.array([[0.0, 0.0], [100.0, 0.0]]),
        np.array([[100.0, 0.0], [120.0, 0.0]]),
        np.array([[120.0, 0.0], [300.0, 0.0]]),
    ]
    ramp = [np.array([[0.0, -20.0], [100.0, -3.5]]), np.array([[100.0, -3.5], [120.0, 0.0]])]
    roads = road_map([*merging, *ramp], links=[(0, 1), (1, 2), (3, 4), (4, 2)], in_junction=[1, 4])
    assert not crossed(roads).any()
    assert not goes_straight(roads, drive(np.concatenate(merging), 60, 8, 101))


@pytest.mark.parametrize("across", [FROM_LEFT, FROM_RIGHT])
@pytest.mark.parametrize("start", [5, 20])
def test_crossing_traffic_does_not_cut_in(across, start):
    assert done(CROSSING, way(STRAIGHT, 20, 8), way(across, start, 11)) == set()


@pytest.mark.parametrize("seconds", [2.0, 4.0, 8.0])
@pytest.mark.parametrize("speed", [8.0, 15.0])
@pytest.mark.parametrize("bend", [1.0, -1.0])
def test_lane_changes_slow_and_quick_count_on_bends_too(bend, speed, seconds):
    right = arc(120.0, bend)
    left = beside(right, 3.5)
    roads = road_map([right, left], neighbours=[(1, 0)])
    share = np.clip((np.arange(len(right)) * 2.0 - 25) / (seconds * speed), 0, 1)[:, None]
    share = share * share * (3 - 2 * share)
    target = drive(right, 0, speed, 101)
    assert done(roads, target, drive(left + (right - left) * share, 20, speed, 101)) == {Manoeuvre.CHANGE_RIGHT, Manoeuvre.CUT_IN}
    assert done(roads, target, drive(right + (left - right) * share, 20, speed, 101)) == {Manoeuvre.CHANGE_LEFT}
    assert done(roads, target, drive(left, 20, speed, 101)) == set()


@pytest.mark.parametrize(("lanes", "relation"), [(FROM_LEFT, Relation.FROM_LEFT), (FROM_RIGHT, Relation.FROM_RIGHT)])
def test_who_comes_from_the_side_is_as_far_away_as_asked(lanes, relation):
    vehicles = scenario(CROSSING, stack([way(STRAIGHT, 40, 6), way(lanes, 20, 8)])).vehicles
    x = float(vehicles.position[1, 0] - vehicles.position[0, 0])
    assert 45 < x < 55
    assert stands([[], []], vehicles, 1, relation, None)
    got = [metres for metres in (10.0, 30.0, 50.0, 200.0) if stands([[], []], vehicles, 1, relation, metres)]
    assert got == [50.0]


@pytest.mark.parametrize("bend", [1.0, -1.0])
@pytest.mark.parametrize("far", [25.0, -25.0])
@pytest.mark.parametrize("lane", [-2, -1, 0, 1, 2])
def test_in_a_bend_who_is_left_ahead_is_in_the_next_lane_to_the_left(bend, far, lane):
    middle = arc(60.0, bend, 150.0)
    lines = [beside(middle, number * 3.2) for number in range(-2, 3)]
    roads = road_map(lines, neighbours=[(number + 1, number) for number in range(4)])
    tracks = [drive(lines[2], 60, 8, 101), drive(lines[2 + lane], (60 + far) * (1 - bend * lane * 3.2 / 60), 8, 101)]
    vehicles = scenario(roads, stack(tracks)).vehicles
    routes = [keeping(roads, track) for track in tracks]
    where = "ahead" if far > 0 else "behind"
    got = {relation for relation in BESIDE if stands(routes, vehicles, 1, relation, None)}
    assert got == {1: {Relation(f"left_{where}")}, -1: {Relation(f"right_{where}")}}.get(lane, set())


@pytest.mark.parametrize("bend", [1.0, -1.0])
def test_who_cuts_in_from_ahead_in_a_bend_changes_towards_the_targets_lane(bend):
    middle = arc(60.0, bend, 150.0)
    lines = [middle, beside(middle, -bend * 3.2)]  # seen from the target, the bend brings the outer lane to the other side
    tracks = [drive(line, start, 8, 101) for line, start in zip(lines, (20, 52), strict=True)]
    roads = road_map(lines, neighbours=[(0, 1) if bend > 0 else (1, 0)])
    scene = scenario(roads, stack(tracks))
    way = keeping(roads, tracks[0])[0]
    assert side_of(scene, 1, Manoeuvre.CUT_IN, way) == bend
