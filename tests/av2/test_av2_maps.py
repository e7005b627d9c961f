"""Argoverse 2 maps in and out."""

from dataclasses import replace

import numpy as np
import orjson
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.av2.maps import read_map, write_map
from drivegen.core.errors import UnusableInput
from drivegen.core.roadmap import NO_LANE, LaneControl, RoadMap
from tests.refusals import assert_one_sentence
from tests.scenes import any_scenario, crossing, straight_road

LANES = ("lane_id", "kind", "in_junction", "control", "neighbour", "same_direction", "may_change")
INDEXED = (*LANES, "links", "yields_to", "stop_lane")
LINES = ("centreline", "left", "right", "drivable", "crossings")


def assert_same(one: RoadMap, other: RoadMap, tolerance: float = 1e-4) -> None:
    for name in INDEXED:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)
    np.testing.assert_array_equal(one.speed_limit, other.speed_limit)
    np.testing.assert_array_equal(one.origin, other.origin)
    assert one.dangling == other.dangling
    for name in LINES:
        np.testing.assert_array_equal(getattr(one, name).start, getattr(other, name).start)
        np.testing.assert_allclose(getattr(one, name).points, getattr(other, name).points, atol=tolerance)
    np.testing.assert_allclose(one.stop_lines, other.stop_lines, atol=tolerance)


@given(st.integers(0, 10_000))
@settings(max_examples=25, deadline=None)
def test_what_is_written_is_read_back(seed: int) -> None:
    written = any_scenario(seed).map
    again = read_map(write_map(written), "map.json")
    assert_same(written, again)
    assert write_map(again) == write_map(read_map(write_map(again), "map.json"))


def official(**changes: object) -> dict:
    """Two lanes side by side along +x, the left one the other way, as the official files have them; no centrelines."""

    def points(y: float, back: bool = False) -> list[dict]:
        line = [{"x": 1000.0 + x, "y": y, "z": 1.0} for x in (0.0, 10.0, 20.0)]
        return line[::-1] if back else line

    lane = {
        "id": 1,
        "is_intersection": False,
        "lane_type": "VEHICLE",
        "left_lane_boundary": points(2.0),
        "right_lane_boundary": points(-2.0),
        "left_lane_mark_type": "DASHED_WHITE",
        "right_lane_mark_type": "SOLID_WHITE",
        "left_neighbor_id": 2,
        "right_neighbor_id": 77,
        "successors": [3, 4],
        "predecessors": [],
    }
    other = lane | {
        "id": 2,
        "left_lane_boundary": points(2.0, back=True),
        "right_lane_boundary": points(6.0, back=True),
        "left_neighbor_id": 1,
        "right_neighbor_id": None,
        "successors": [],
    }
    third = lane | {"id": 3, "predecessors": [1], "successors": [], "left_neighbor_id": None, "right_neighbor_id": None}
    lanes = {"1": lane | changes, "2": other, "3": third}
    return {"lane_segments": lanes, "drivable_areas": {}, "pedestrian_crossings": {}}


def test_without_centrelines_the_midline_of_the_boundaries_stands_in() -> None:
    found = read_map(orjson.dumps(official()), "map.json")
    line = found.centreline[0] + found.origin
    np.testing.assert_allclose(line[[0, -1]], [[1000, 0], [1020, 0]])


def test_a_lane_beside_that_runs_the_other_way_is_no_lane_to_change_to() -> None:
    found = read_map(orjson.dumps(official()), "map.json")
    assert found.neighbour[0].tolist() == [1, NO_LANE]
    assert not found.same_direction.any()
    assert not found.may_change.any()


@pytest.mark.parametrize(
    ("mark", "allowed"),
    [("DASHED_WHITE", True), ("NONE", True), ("DASH_SOLID_YELLOW", True), ("SOLID_DASH_WHITE", False), ("SOLID_WHITE", False)],
)
def test_the_line_on_the_lanes_own_side_decides_about_lane_changes(mark: str, allowed: bool) -> None:
    tree = official(left_neighbor_id=3, left_lane_mark_type=mark)
    assert bool(read_map(orjson.dumps(tree), "map.json").may_change[0, 0]) is allowed


def test_links_to_lanes_that_a_cropped_map_lacks_are_counted() -> None:
    found = read_map(orjson.dumps(official()), "map.json")
    assert found.dangling == 1
    assert found.links.tolist() == [[0, 2]]


def test_crossings_have_four_corners_whichever_way_their_edges_point() -> None:
    corners = [{"x": 1000.0 + x, "y": y, "z": 0.0} for x, y in ((0, 0), (0, 6), (3, 0), (3, 6))]
    a, b, c, d = corners
    tree = official() | {
        "pedestrian_crossings": {
            "0": {"id": 0, "edge1": [a, b], "edge2": [c, d]},
            "1": {"id": 1, "edge1": [a, b], "edge2": [d, c]},
        }
    }
    found = read_map(orjson.dumps(tree), "map.json")
    assert len(found.crossings) == 2
    for polygon in found.crossings.lines():
        x, y = polygon.astype(np.float64).T
        assert abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2 == pytest.approx(18.0)


def broken() -> dict[str, bytes]:
    good = orjson.dumps(official())
    return {
        "not JSON": b"<net></net>",
        "empty": b"",
        "cut short": good[: len(good) // 2],
        "a list": b"[]",
        "no lanes key": b"{}",
        "lanes are a list": b'{"lane_segments": [1]}',
        "a lane is a number": b'{"lane_segments": {"1": 5}}',
        "unknown lane type": orjson.dumps(official(lane_type="TRAM")),
        "point without y": orjson.dumps(official(left_lane_boundary=[{"x": 1.0}, {"x": 2.0}])),
        "coordinates are words": orjson.dumps(official(left_lane_boundary=[{"x": "a", "y": "b"}] * 2)),
        "coordinates are null": orjson.dumps(official(left_lane_boundary=[{"x": None, "y": 0.0}] * 2)),
        "boundary of one point": orjson.dumps(official(left_lane_boundary=[{"x": 1.0, "y": 2.0}])),
        "boundary of no points": orjson.dumps(official(left_lane_boundary=[])),
        "boundary of one place": orjson.dumps(official(left_lane_boundary=[{"x": 1.0, "y": 2.0}] * 3)),
        "point at the end of the world": orjson.dumps(official(left_lane_boundary=[{"x": 1.0, "y": 2.0}, {"x": 1e30, "y": 2.0}])),
        "two lanes of one id": orjson.dumps(official(id=2)),
        "id is a word": orjson.dumps(official(id="one")),
        "id beyond 64 bits": orjson.dumps(official()).replace(b'"id":1,', b'"id":18446744073709551615,'),
        "yields to a lane that is not there": orjson.dumps(official(yields_to=[77])),
        "less than no dangling links": orjson.dumps(official() | {"dangling_links": -1}),
        "more dangling links than 32 bits": orjson.dumps(official() | {"dangling_links": 10**12}),
        "limit is infinite": orjson.dumps(official(speed_limit=1e39)),
        "origin is far too large": orjson.dumps(official() | {"origin": [1e300]}),
        "area without points": orjson.dumps(official() | {"drivable_areas": {"1": {"area_boundary": []}}}),
    }


@pytest.mark.parametrize("what", broken())
def test_a_broken_map_is_refused_with_one_sentence_that_names_the_file(what: str) -> None:
    with pytest.raises(UnusableInput, match=r"log_map\.json") as caught:
        read_map(broken()[what], "log_map.json")
    assert caught.value.reason == "bad-map"
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("change", [{"lane_type": "TRAM"}, {"id": "one"}, {"left_lane_boundary": [{"x": 1.0, "y": 2.0}]}])
def test_the_lane_at_fault_is_named(change: dict[str, object]) -> None:
    tree = official()
    tree["lane_segments"]["3"] |= change
    tree["lane_segments"]["1"]["yields_to"] = [2]  # sound, beside the others
    with pytest.raises(UnusableInput, match="lane 3"):
        read_map(orjson.dumps(tree), "log_map.json")


def test_repeated_points_are_dropped_so_that_every_lane_leads_where_it_leads() -> None:
    tree, plain = official(), read_map(orjson.dumps(official()), "log_map.json")
    for lane in tree["lane_segments"].values():
        for side in ("left_lane_boundary", "right_lane_boundary"):
            lane[side] = [point for point in lane[side] for _ in range(3)]
        lane["centerline"] = [{"x": x, "y": 0.0} for x in (1000.0, 1000.0, 1020.0, 1020.0)]
    found = read_map(orjson.dumps(tree), "log_map.json")
    assert [len(found.centreline[i]) for i in range(3)] == [2, 2, 2]
    for side in ("left", "right"):
        np.testing.assert_array_equal(getattr(found, side).start, getattr(plain, side).start)
        np.testing.assert_array_equal(getattr(found, side).points + found.origin, getattr(plain, side).points + plain.origin)


def test_a_map_without_lanes_has_a_reason_of_its_own() -> None:
    with pytest.raises(UnusableInput) as caught:
        read_map(b'{"lane_segments": {}, "drivable_areas": {}}', "log_map.json")
    assert caught.value.reason == "no-lanes"


@given(st.data())
@settings(max_examples=40, deadline=None)
def test_a_file_with_changed_bytes_is_refused_by_its_name_or_is_a_map_that_can_be_written_again(data: st.DataObject) -> None:
    road = straight_road(60.0)
    raw = bytearray(write_map(road))
    for place, value in data.draw(st.lists(st.tuples(st.integers(0, len(raw) - 1), st.integers(0, 255)), min_size=1, max_size=6)):
        raw[place] = value
    try:
        found = read_map(bytes(raw), "map.json")
    except UnusableInput as refusal:
        assert_one_sentence(refusal, "map.json")
    else:
        found.validate()
        assert 0 < len(found) <= len(road)
        again = read_map(write_map(found), "again.json")
        assert again.lane_id.tolist() == found.lane_id.tolist()
        assert again.links.tolist() == found.links.tolist()


def test_controls_and_limits_survive() -> None:
    roads = replace(crossing(control=LaneControl.STOP), origin=np.array([512.0, -40.0]))
    again = read_map(write_map(roads), "map.json")
    assert (again.control[again.in_junction] == LaneControl.STOP).all()
    np.testing.assert_array_equal(again.speed_limit, roads.speed_limit)
