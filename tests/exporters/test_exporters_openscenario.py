"""OpenSCENARIO as other programs read it: everybody within 0.1 m of where it was, on a road that netconvert takes in."""

from dataclasses import replace

import numpy as np
import pytest
from scenariogeneration import xosc

from drivegen.core import plugins
from drivegen.core.crop import take_lanes
from drivegen.core.geometry import Polylines, unit
from drivegen.core.safe_xml import parse
from drivegen.core.scenario import DT
from drivegen.maps.opendrive import Extent, read_back
from tests.scenes import busy_crossing, crossing, drive, joined, road_map, scenario, stack


def tracks(file):
    """By entity: times (T,), the middle of its box (T, 2) and its length, as the file has them."""
    root = parse(file.read_bytes(), str(file), root="OpenSCENARIO")
    box = {o.get("name"): o.find(".//BoundingBox") for o in root.iter("ScenarioObject")}
    out = {}
    for group in root.iter("ManeuverGroup"):
        who, vertices = group.get("name"), list(group.iter("Vertex"))
        time = np.array([float(v.get("time")) for v in vertices])
        place = [v.find(".//WorldPosition") for v in vertices]
        x, y, h = (np.array([float(p.get(name)) for p in place]) for name in "xyh")
        ahead = float(box[who].find("Center").get("x"))
        length = float(box[who].find("Dimensions").get("length"))
        out[who] = time, np.stack([x, y], -1) + ahead * unit(h), length
    return out


def test_everybody_is_where_it_was_when_it_is_read_back(tmp_path):
    scene = busy_crossing()
    log = replace(scene.log, valid=scene.log.valid.copy())
    log.valid[3, :20] = log.valid[4, 60:] = False  # one comes later, one goes
    plugins.load("exporters", "openscenario")().write(scene, log, tmp_path, "one")
    xosc.ParseOpenScenario(str(tmp_path / "one.xosc"))
    found = tracks(tmp_path / "one.xosc")
    assert list(found) == ["Ego"] + [f"Vehicle{n}" for n in range(1, 8)]
    for n, (time, position, length) in enumerate(found.values()):
        steps = np.flatnonzero(log.valid[n])
        assert np.allclose(time, steps * DT)
        assert np.hypot(*(position - log.position[n, steps]).T).max() < 0.1
        assert length == pytest.approx(scene.vehicles.size[n, 0])


@pytest.mark.parametrize("steps", [slice(0, 1), slice(30, 31), slice(20, 61), slice(0, 100), slice(100, 101)])
def test_who_comes_and_goes_is_there_at_its_own_steps_and_no_others(steps, tmp_path):
    scene = busy_crossing()
    log = replace(scene.log, valid=scene.log.valid.copy())
    log.valid[0] = False
    log.valid[0, steps] = True
    plugins.load("exporters", "openscenario")().write(scene, log, tmp_path, "one")
    root = parse((tmp_path / "one.xosc").read_bytes(), "one", root="OpenSCENARIO")
    time = {"drives": None, "comes": -1.0 if root.find(".//Private[@entityRef='Ego']") is not None else None, "goes": np.inf}
    for event in root.find(".//ManeuverGroup[@name='Ego']").iter("Event"):
        time[event.get("name").split()[1]] = float(event.find(".//SimulationTimeCondition").get("value"))
    now = np.round(np.arange(scene.steps) * DT, 1)
    assert np.array_equal((now >= time["comes"]) & (now < time["goes"]), log.valid[0])


def test_netconvert_reads_the_road_with_all_its_ways(tmp_path):
    scene = busy_crossing()
    plugins.load("exporters", "openscenario")().write(scene, scene.log, tmp_path, "one")
    extent = Extent.of(read_back((tmp_path / "one.xodr").read_bytes(), "one").map)
    assert extent.lanes == (8, 0, 0)
    assert extent.ways == 12


def test_two_crossings_in_a_row_are_two_junctions(tmp_path):
    lines = [np.array([[x, 0.0], [x + 50, 0.0]]) for x in range(0, 250, 50)]
    roads = road_map(lines, [(n, n + 1) for n in range(4)], in_junction=[1, 3])
    scene = scenario(roads, stack([drive(joined(roads, 0, 1), 20, 12, 20)]))
    plugins.load("exporters", "openscenario")().write(scene, scene.log, tmp_path, "one")
    root = parse((tmp_path / "one.xodr").read_bytes(), "xodr", root="OpenDRIVE")
    incoming = {c.get("connectingRoad"): c.get("incomingRoad") for c in root.iter("connection")}
    assert len(root.findall("junction")) == 2
    assert incoming == {"1": "0", "3": "2"}
    between = root.find("road[@id='2']/link")
    ends = [between.find(name).get("elementId") for name in ("predecessor", "successor")]
    assert ends == [j.get("id") for j in root.findall("junction")]


def exported(roads, folder):
    """The OpenDRIVE of a car's scene on these roads."""
    scene = scenario(roads, stack([drive(joined(roads, 0, 1), 20, 12, 20)]))
    plugins.load("exporters", "openscenario")().write(scene, scene.log, folder, "one")
    return parse((folder / "one.xodr").read_bytes(), "xodr", root="OpenDRIVE")


def test_lanes_are_linked_where_their_roads_are(tmp_path):
    lines = [np.array([[x, 0.0], [x + 50, 0.0]]) for x in range(0, 200, 50)]
    root = exported(road_map(lines, [(n, n + 1) for n in range(3)], in_junction=[2]), tmp_path)
    found = {}
    for road in root.iter("road"):
        at_road = [e.tag for e in road.find("link") if e.get("elementType") == "road"]
        own = road.find(".//lane[@id='-1']/link")
        assert [(e.tag, e.get("id")) for e in own] == [(tag, "-1") for tag in at_road]
        found[road.get("id")] = at_road
    assert found == {"0": ["successor"], "1": ["predecessor"], "2": ["predecessor", "successor"], "3": []}


def test_a_way_across_with_two_lanes_before_and_two_after_it_is_linked_to_the_first(tmp_path):
    ends = [[(0, 0), (50, 0)], [(50, 0), (80, 0)], [(0, 20), (50, 0)], [(80, 0), (120, 0)], [(80, 0), (120, 20)]]
    root = exported(road_map(np.array(ends, float), [(0, 1), (2, 1), (1, 3), (1, 4)], in_junction=[1]), tmp_path)
    assert [e.get("elementId") for e in root.find("road[@id='1']/link")] == ["0", "3"]
    assert [c.get("incomingRoad") for c in root.iter("connection")] == ["0", "2"]


def test_a_way_across_that_begins_where_the_map_is_cut_is_a_road(tmp_path):
    lines = [np.array([[x, 0.0], [x + 50, 0.0]]) for x in range(0, 200, 50)]
    root = exported(road_map(lines, [(n, n + 1) for n in range(3)], in_junction=[0, 2]), tmp_path)
    assert [road.get("junction") for road in root.iter("road")] == ["-1", "-1", "4", "-1"]
    assert [len(junction) for junction in root.iter("junction")] == [1]
    assert root.find("road[@id='0']/link/successor").get("elementId") == "1"


def test_a_way_across_that_the_map_cuts_in_two_is_one_road(tmp_path):
    lines = [np.array([[x, 0.0], [x + 50, 0.0]]) for x in range(0, 250, 50)]
    root = exported(road_map(lines, [(n, n + 1) for n in range(4)], in_junction=[1, 2, 3]), tmp_path)
    assert [float(road.get("length")) for road in root.iter("road")] == [50, 150, 50]
    assert [(c.get("incomingRoad"), c.get("connectingRoad")) for c in root.iter("connection")] == [("0", "1")]
    assert [e.get("elementId") for e in root.find("road[@id='1']/link")] == ["0", "2"]


@pytest.mark.parametrize("without", [[], [0], [0, 1], [4, 5]])
def test_every_way_across_is_entered_from_a_road(without, tmp_path):
    roads = take_lanes(crossing(), np.setdiff1d(np.arange(20), without))
    scene = scenario(roads, stack([drive(roads.centreline[0].astype(np.float64), 20, 12, 20)]))
    plugins.load("exporters", "openscenario")().write(scene, scene.log, tmp_path, "one")
    root = parse((tmp_path / "one.xodr").read_bytes(), "xodr", root="OpenDRIVE")
    inside = [road.get("id") for road in root.iter("road") if road.get("junction") != "-1"]
    assert [c.get("connectingRoad") for c in root.iter("connection")] == inside
    assert len(inside) == 12 - 3 * len({0, 1, 2, 3}.intersection(without))


def test_a_lane_is_as_wide_as_its_edges_are_apart_however_few_points_these_have(tmp_path):
    roads = road_map([np.array([[0.0, 0.0], [80.0, 0.0]]), np.array([[80.0, 0.0], [99.0, 0.0]])], [(0, 1)])
    left = [np.stack([np.linspace(0, 80, 41), np.full(41, 1.75)], -1), np.array([[80, 1.75], [99, 1.75]])]
    root = exported(replace(roads, left=Polylines.of(left)), tmp_path)
    assert [float(width.get("a")) for width in root.iter("width")] == [3.5, 3.5]


def test_a_lane_that_grows_is_as_wide_everywhere_as_its_map_says(tmp_path):
    """Its left edge leads away from 1.75 m at 40 m to 3.75 m at 80 m."""
    roads = road_map([np.array([[0.0, 0.0], [80.0, 0.0]]), np.array([[80.0, 0.0], [99.0, 0.0]])], [(0, 1)])
    left = [np.array([[0, 1.75], [40, 1.75], [80, 3.75]]), np.array([[80, 1.75], [99, 1.75]])]
    lanes = exported(replace(roads, left=Polylines.of(left)), tmp_path).find("road[@id='0']/lanes")
    for kind, place, beside in (("width", "sOffset", 3.5), ("laneOffset", "s", 1.75)):
        pieces = [[float(piece.get(name)) for name in (place, "a", "b")] for piece in lanes.iter(kind)]
        for along in (0.0, 39.0, 50.0, 61.0, 80.0):
            begin, at, growth = max(piece for piece in pieces if piece[0] <= along)
            assert at + growth * (along - begin) == pytest.approx(beside + max(along - 40, 0) * 0.05, abs=0.01)


def test_no_two_widths_of_a_lane_begin_at_one_place(tmp_path):
    turn = np.array([[np.cos(0.5), np.sin(0.5)], [-np.sin(0.5), np.cos(0.5)]])  # so that lengths of pieces are no whole numbers
    every = np.stack([np.linspace(0, 80, 81), np.zeros(81)], -1)
    left = [every + np.stack([np.zeros(81), 1.75 + 0.01 * every[:, 0]], -1), np.array([[80, 1.75], [99, 1.75]])]
    roads = road_map([every @ turn, np.array([[80.0, 0.0], [99.0, 0.0]]) @ turn], [(0, 1)])
    lanes = exported(replace(roads, left=Polylines.of([line @ turn for line in left])), tmp_path).find("road[@id='0']/lanes")
    for kind, place in (("width", "sOffset"), ("laneOffset", "s")):
        places = [float(piece.get(place)) for piece in lanes.iter(kind)]
        assert len(places) > 40
        assert (np.diff(places) > 0).all()


def test_nothing_is_said_that_no_map_knows(tmp_path):
    root = exported(road_map([np.array([[0.0, 0.0], [80.0, 0.0]]), np.array([[80.0, 0.0], [99.0, 0.0]])], [(0, 1)]), tmp_path)
    assert set(root.find("header").attrib) == {"name", "revMajor", "revMinor"}
    assert {kind.get("type") for kind in root.findall("road/type")} == {"unknown"}
    assert all(len(profile) == 1 for profile in root.iter("elevationProfile"))  # the standard's schema wants one
