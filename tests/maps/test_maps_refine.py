"""Edits in words change the specification as they say, and keep a history."""

from pathlib import Path

import orjson
import pytest

from drivegen.errors import UnusableInput
from drivegen.maps.build import ACCOUNT, build_map
from drivegen.maps.refine import refine, refine_map
from drivegen.maps.spec import MapSpec
from drivegen.maps.spec_crossings import Crossing, Roundabout
from drivegen.maps.spec_highways import Highway, Interchange
from drivegen.maps.spec_quadrants import QuadrantInterchange
from drivegen.maps.writers.offline import Plugin

CROSSING = Plugin().write("a four-way intersection with traffic lights, two lanes in each direction", 7).spec
MOTORWAY = Plugin().write("a motorway with two lanes and an on-ramp", 7).spec


def crossing_after(edit: str) -> Crossing:
    road = refine(CROSSING, edit)[0].road
    assert isinstance(road, Crossing)
    return road


def motorway_after(edit: str) -> Highway:
    road = refine(MOTORWAY, edit)[0].road
    assert isinstance(road, Highway)
    return road


def test_lanes_signals_and_limits_change_as_said() -> None:
    assert {arm.lanes_in for arm in crossing_after("add a lane").arms} == {3}
    assert {arm.lanes_out for arm in crossing_after("one lane per direction, please").arms} == {1}
    assert crossing_after("remove the signals").control == "yield"
    assert crossing_after("use stop signs instead").control == "stop"
    assert {round(arm.speed * 3.6) for arm in crossing_after("limit 30").arms} == {30}
    assert all(arm.left_turn_lane for arm in crossing_after("add left turn lanes").arms)


def test_no_loop_ramp_or_road_over_the_highway_is_faster_than_the_limit() -> None:
    road = refine(MapSpec(road=QuadrantInterchange()), "limit 30")[0].road
    assert isinstance(road, QuadrantInterchange)
    assert {round(v * 3.6) for v in (road.speed, road.road_speed, road.ramp_speed, road.loop_speed)} == {30}
    road = refine(MapSpec(road=Interchange()), "limit 120")[0].road
    assert isinstance(road, Interchange)
    assert [round(v * 3.6) for v in (road.speed, road.road_speed, road.ramp_speed)] == [120, 50, 50]


def test_an_interchange_has_legs_that_become_longer_and_a_graph_has_no_length_to_set() -> None:
    road = refine(MapSpec(road=QuadrantInterchange()), "make it 100 m longer")[0].road
    assert isinstance(road, QuadrantInterchange)
    assert road.leg_length == 250
    road = refine(MapSpec(road=Interchange()), "300 m long")[0].road
    assert isinstance(road, Interchange)
    assert road.road_length == 300
    ends = [{"name": name, "x": x, "y": 0.0} for name, x in (("a", 0.0), ("b", 200.0))]
    graph = MapSpec.model_validate({"road": {"kind": "graph", "nodes": ends, "roads": [{"name": "r", "start": "a", "end": "b"}]}})
    with pytest.raises(UnusableInput, match="a graph has no length that could be set"):
        refine(graph, "100 m longer")


def test_a_crossing_becomes_a_roundabout_with_the_same_arms() -> None:
    road = refine(CROSSING, "make it a roundabout")[0].road
    assert isinstance(road, Roundabout)
    assert [arm.angle for arm in road.arms] == [arm.angle for arm in crossing_after("add a lane").arms]


def test_a_ramp_moves_and_the_road_grows_where_it_must() -> None:
    before = motorway_after("limit 100 km/h").events[0].position
    assert motorway_after("move the ramp 100 m further downstream").events[0].position == before + 100
    assert motorway_after("move the on-ramp 100 m upstream").events[0].position == before - 100
    assert motorway_after("move the ramp 2 km downstream").alignment.length > 2000


@pytest.mark.parametrize("edit", ["sing a song", "", "add forty lanes", "move the ramp 9 km upstream"])
def test_edits_that_make_no_sense_are_refused(edit: str) -> None:
    with pytest.raises(UnusableInput):
        refine(MOTORWAY, edit)


def test_a_map_is_refined_twice_and_remembers_both_edits(tmp_path: Path) -> None:
    build_map("a crossroads with traffic lights", 7, folder=tmp_path)
    refine_map(tmp_path, "remove the signals").save(tmp_path)
    refine_map(tmp_path, "add a lane").save(tmp_path)
    account = orjson.loads((tmp_path / ACCOUNT).read_bytes())
    assert [step["edit"] for step in account["history"]] == ["remove the signals", "add a lane"]
    road = MapSpec.model_validate(account["spec"]).road
    assert isinstance(road, Crossing)
    assert (road.control, road.arms[0].lanes_in) == ("yield", 2)


def test_a_folder_without_a_specification_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UnusableInput, match="make the map first"):
        refine_map(tmp_path, "add a lane")
    (tmp_path / ACCOUNT).write_text("[]")
    with pytest.raises(UnusableInput, match="no map specification"):
        refine_map(tmp_path, "add a lane")
