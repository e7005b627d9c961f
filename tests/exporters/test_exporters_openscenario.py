"""OpenSCENARIO as other programs read it: everybody within 0.1 m of where it was, on a road that netconvert takes in."""

from dataclasses import replace

import numpy as np
import pytest
from scenariogeneration import xosc

from drivegen.core import plugins
from drivegen.core.geometry import unit
from drivegen.core.safe_xml import parse
from drivegen.core.scenario import DT
from drivegen.maps.opendrive import read_back
from tests.scenes import any_scenario, busy_crossing, drive, joined, road_map, scenario, stack


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


@pytest.mark.parametrize("name", plugins.names("exporters"))
def test_same_scenario_same_bytes(name, tmp_path):
    scene = any_scenario(3)
    assert plugins.about("exporters", name)["title"]
    written = []
    for folder in (tmp_path / "a", tmp_path / "b"):
        folder.mkdir()
        plugins.load("exporters", name)().write(scene, scene.log, folder, "one")
        written.append({file.relative_to(folder): file.read_bytes() for file in folder.rglob("*.*") if file.is_file()})
    assert written[0] == written[1] != {}


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


def test_netconvert_reads_the_road_with_all_its_ways(tmp_path):
    scene = busy_crossing()
    plugins.load("exporters", "openscenario")().write(scene, scene.log, tmp_path, "one")
    extent = read_back((tmp_path / "one.xodr").read_bytes(), "one")
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
