import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.geometry import arc_length, project
from drivegen.drivers.shared.features import features, road_ahead
from drivegen.roads.graph import LaneGraph
from drivegen.world.observation import Action
from drivegen.world.paths import packed, target_paths
from drivegen.world.replay import replay
from drivegen.world.rules import _lines
from drivegen.world.scenes import Scenes
from drivegen.world.world import World
from tests.scenes import LIMIT, beside, crossing, drive, joined, road_map, scenario, stack, straight_road

CROSS = crossing()


def path_of(scene):
    paths = target_paths([scene], [scene.log])
    return paths.point[0, : int(paths.length[0]) + 1], paths


def test_a_path_follows_the_log_and_goes_on_along_the_lanes():
    left = joined(CROSS, 0, 9, 5)
    scene = scenario(CROSS, stack([drive(left, 60, 4, 101)]))  # gets 40 m far, into the turn
    line, paths = path_of(scene)
    assert np.allclose(line[0], scene.log.position[0, 0], atol=1e-4)
    assert max(abs(project(left, point)[1]) for point in line[:90].astype(np.float64)) < 0.6
    assert paths.length[0] >= 200
    assert np.nanmax(paths.speed_limit) == pytest.approx(LIMIT)


def test_points_are_a_metre_apart_and_beyond_the_map_the_path_goes_straight_on():
    scene = scenario(straight_road(100), stack([drive(straight_road(100).centreline[0].astype(np.float64), 20, 10, 101)]))
    line, _ = path_of(scene)
    steps = np.hypot(*np.diff(line, axis=0).T)
    assert steps == pytest.approx(1.0, abs=1e-3)
    assert line[-1, 0] > 200
    assert np.abs(line[:, 1]).max() < 0.01


def test_the_driven_offset_from_the_lane_fades_out_beyond_the_end_of_the_log():
    road = straight_road()
    aside = road.centreline[0].astype(np.float64) + np.array([0.0, 1.0])
    line, _ = path_of(scenario(road, stack([drive(aside, 20, 5, 101)])))  # gets 50 m far
    assert line[:50, 1] == pytest.approx(1.0, abs=0.01)
    assert line[66:, 1] == pytest.approx(0.0, abs=0.01)
    assert np.abs(np.diff(line[:, 1])).max() < 0.1


@pytest.mark.parametrize("speed", [8.0, 30.0])
def test_a_path_is_long_enough_for_who_drives_a_quarter_faster_than_the_log(speed):
    road = straight_road(900)
    _, paths = path_of(scenario(road, stack([drive(road.centreline[0].astype(np.float64), 20, speed, 101)])))
    assert paths.length[0] >= 1.25 * max(speed, 20.0) * 10 - 1


def ring(lanes=4, radius=12.0):
    """A ring of lanes, each of which leads to the next."""
    turns = [np.linspace(n, n + 1, 12) * 2 * np.pi / lanes for n in range(lanes)]
    lines = [radius * np.stack([np.cos(turn), np.sin(turn)], axis=1) for turn in turns]
    return road_map(lines, links=[(n, (n + 1) % lanes) for n in range(lanes)], in_junction=[2])


def round_and_round(roads, metres):
    """A target that drives so far in ten seconds on the ring, half a metre outside of the middle."""
    laps = np.concatenate([line.astype(np.float64)[:-1] for line in roads.centreline] * 4)
    return scenario(roads, stack([drive(beside(laps, -0.5), 5, metres / 10, 101)]))


@pytest.mark.parametrize("metres", [47.0, 61.0, 75.0, 138.0])
@pytest.mark.parametrize("radius", [9.0, 12.0, 14.5])
def test_on_a_ring_the_path_goes_on_where_the_target_was_and_its_lines_are_those_of_the_first_lap(radius, metres):
    roads = ring(radius=radius)
    scene = round_and_round(roads, metres)
    line, _ = path_of(scene)
    assert len(line) >= 180
    assert np.hypot(*line[:180].T) == pytest.approx(radius, abs=0.7)  # it never leaves the ring
    (first, lane), *_ = _lines(Scenes.of([scene], [scene.log]), 0, LaneGraph.of(roads))
    assert lane == 2
    assert first == pytest.approx(np.pi * radius - 5, abs=2.5)


def test_a_parked_target_gets_a_route_to_drive_nevertheless():
    scene = scenario(CROSS, stack([drive(joined(CROSS, 0), 30, 0, 101)]))
    line, _ = path_of(scene)
    assert arc_length(line.astype(np.float64))[-1] > 150


def test_a_target_off_all_lanes_goes_straight_on():
    far = np.array([[500.0, 500.0], [600.0, 500.0]])
    scene = scenario(CROSS, stack([drive(far, 0, 5, 101)]))
    line, paths = path_of(scene)
    assert np.abs(line[:, 1] - 500).max() < 0.1
    assert np.isnan(paths.speed_limit).all()


def test_beyond_its_end_a_path_goes_on_alike_beside_a_longer_one():
    roads = straight_road(900)
    line = roads.centreline[0].astype(np.float64)
    short, long = (scenario(roads, stack([drive(line, 20, speed, 61)]), f"at-{speed}") for speed in (20.0, 40.0))
    worlds = [World(Scenes.of(scenes, [s.log for s in scenes]), len(scenes)) for scenes in ([short], [short, long])]
    for _ in range(60):
        seen = [world.observe() for world in worlds]
        alone, beside = (features(view)[0] for view in seen)
        assert torch.equal(alone, beside)
        assert torch.equal(*(torch.cat(road_ahead(view), dim=1)[0] for view in seen))
        places = torch.tensor([[-5.0, 140.0, 149.5, 180.0]])
        assert torch.equal(worlds[0].paths.position(places)[0], worlds[1].paths.position(places.expand(2, -1))[0])
        for world in worlds:
            world.advance(Action(torch.full((len(world.scene),), 4.0)))
    assert float(worlds[0].ego.along[0]) > float(worlds[0].paths.length[0]) + 5


def test_boxes_are_seen_from_the_segment_beside_them_at_a_corner_and_at_both_ends():
    line = np.array([(x, 0.0) for x in range(51)] + [(50.0, y) for y in range(1, 51)])
    places = np.array([(49.7, -0.5), (50.5, 0.3), (-3.0, 1.0), (49.0, 53.0)])
    log = stack([drive(line, 5, 5, 11), *(drive(np.array([place, place + np.array([1.0, 0.0])]), 0, 0, 11) for place in places)])
    frame = replay([scenario(road_map([line]), log)], [log], packed([line], [np.full(101, np.nan)]), 1).frame
    for t in (0, 1):  # after a search of the whole path and after one from the last point
        np.testing.assert_allclose(frame[0, t, :2, :4].T, [(49.7, -0.5), (50.3, -0.5), (-3.0, 1.0), (103.0, 1.0)], atol=1e-4)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000))
def test_replayed_boxes_are_projected_like_by_exhaustive_search(seed):
    random = np.random.default_rng(seed)
    turns = np.cumsum(random.uniform(-0.03, 0.03, 150))
    line = np.cumsum(np.stack([np.cos(turns), np.sin(turns)], axis=1), axis=0)
    x, y = line[int(random.integers(20, 130))] + random.uniform(-8, 8, 2)
    angle = random.uniform(-3, 3)
    way = np.stack([x + np.array([0, 80]) * np.cos(angle), y + np.array([0, 80]) * np.sin(angle)], axis=1)
    log = stack([drive(line, 5, 5, 40), drive(way, 0, 6, 40)])
    paths = packed([line], [np.full(150, np.nan)])
    others = replay([scenario(road_map([line]), log)], [log], paths, 1)
    points = paths.point[0].astype(np.float64)
    for t in range(0, 40, 3):
        along, left = project(points, log.position[1, t].astype(np.float64))
        inside = 1 < along < 145
        if inside and abs(left) < 15:
            assert others.frame[0, t, 0, 0] == pytest.approx(along, abs=0.4)  # on the outside of a bend two feet tie
            assert others.frame[0, t, 1, 0] == pytest.approx(left, abs=0.1)
    half = np.hypot(4.6, 1.9) / 2
    assert (half + 1e-5 >= others.frame[0, :, 2:4, 0].T).all()
    assert np.allclose(np.hypot(others.frame[0, :, 4, 0], others.frame[0, :, 5, 0]), 6.0, atol=1e-4)


def test_on_a_path_that_comes_back_others_are_seen_where_the_target_is_about_then():
    angle = np.arange(0.0, 220.0) / 20.0  # 1.7 times round a circle of 126 m
    ring = 20.0 * np.stack([np.sin(angle), 1 - np.cos(angle)], 1)
    ahead, behind = drive(ring, 25, 10, 101), drive(ring, 20, 0, 101)  # one drives before the target, the other stands
    scene = scenario(straight_road(), stack([drive(ring, 10, 10, 101), ahead, behind]))
    seen = replay([scene], [scene.log], packed([ring[10:]], [np.full(210, LIMIT)]), 1).frame[0, :, 0]
    assert seen[:, 0] == pytest.approx(15 + np.arange(101), abs=0.5)
    round_once = 2 * np.pi * 20
    assert seen[[0, 30, 95], 1] == pytest.approx([10, 10, 10 + round_once], abs=0.5)
