import gzip
import importlib.util
import json
import os
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.av2.maps import write_map
from drivegen.core.errors import UnusableInput
from drivegen.core.roadmap import NO_LANE, LaneControl, LaneKind
from drivegen.core.signals import SignalState
from drivegen.roads.leaving import Exits
from drivegen.sumo.network import Network, read_network
from tests.refusals import assert_one_sentence
from tests.sumo.nets import CROSS
from tests.timing import cpu_seconds, yardstick

RAW = CROSS.encode()
REAL = Path(os.environ.get("DRIVEGEN_REAL_DATA", Path(__file__).parents[3] / "shared" / "data")) / "sumo"
SUMO = Path(importlib.util.find_spec("sumo").origin).parent


@pytest.fixture(scope="module")
def net() -> Network:
    return Network.read(RAW, "cross")


def lane(net: Network, name: str) -> int:
    return net.lane_names.index(name)


def test_foot_and_rail_lanes_are_left_out_and_kinds_follow_vehicle_classes(net):
    assert not {"w_in_0", "rails_0", ":c_c0_0", ":c_w0_0"} & set(net.lane_names)
    kinds = {name: LaneKind(int(kind)) for name, kind in zip(net.lane_names, net.map.kind, strict=True)}
    assert kinds["w_in_1"] == LaneKind.VEHICLE
    assert kinds["n_out_0"] == LaneKind.BUS
    assert kinds["s_in_0"] == LaneKind.BIKE


def test_links_run_through_internal_lanes(net):
    links = {(net.lane_names[a], net.lane_names[b]) for a, b in net.map.links}
    assert links == {
        ("w_in_2", ":c_0_0"),
        (":c_0_0", "e_out_0"),
        ("w_in_2", ":c_1_0"),
        (":c_1_0", ":c_2_0"),
        (":c_2_0", "n_out_0"),
        ("s_in_0", ":c_3_0"),
        (":c_3_0", "n_out_0"),
        ("w_in_1", "w_out_0"),
    }
    assert net.map.dangling == 1  # "nowhere"; the rails were left out on purpose
    assert {net.lane_names[i] for i in np.flatnonzero(net.map.in_junction)} == {":c_0_0", ":c_1_0", ":c_2_0", ":c_3_0"}


def test_control_guards_the_lane_that_is_entered(net):
    control = {name: LaneControl(int(c)) for name, c in zip(net.lane_names, net.map.control, strict=True)}
    assert control[":c_0_0"] == control[":c_3_0"] == LaneControl.SIGNAL
    assert control[":c_1_0"] == control[":c_2_0"] == LaneControl.YIELD
    assert control["w_out_0"] == LaneControl.STOP
    assert control["e_out_0"] == LaneControl.FREE
    assert control["w_in_1"] == LaneControl.UNKNOWN  # nothing leads there


def test_stop_lines_cross_the_end_of_the_lane_before(net):
    entered = {net.lane_names[i] for i in net.map.stop_lane}
    assert entered == {":c_0_0", ":c_1_0", ":c_2_0", ":c_3_0", "w_out_0"}
    line = net.map.stop_lines[list(net.map.stop_lane).index(lane(net, ":c_0_0"))] + net.map.origin
    assert np.allclose(line, [[90, 96.8], [90, 100.0]], atol=1e-3)  # right end first, 3.2 m wide


def test_neighbours_know_direction_and_whether_one_may_change(net):
    right, left = lane(net, "w_in_1"), lane(net, "w_in_2")
    assert net.map.neighbour[right].tolist() == [left, NO_LANE]
    assert net.map.neighbour[left].tolist() == [lane(net, "w_out_0"), right]
    assert net.map.same_direction[left].tolist() == [False, True]
    assert net.map.may_change[right].tolist() == [True, False]
    assert net.map.may_change[left].tolist() == [False, False]  # changeRight="emergency"
    assert net.map.neighbour[lane(net, "w_out_0"), 0] == left


BUS_LANE = RAW.replace(
    b'speed="13.89" length="90" shape="0,95.2 90,95.2"', b'allow="bus" speed="13.89" length="90" shape="0,95.2 90,95.2"'
)


def test_one_may_change_between_a_bus_lane_and_a_lane_for_cars_so_it_ends_beside_that_without_an_exit():
    ends = re.sub(rb'<connection from="w_in" to="[a-z_]*" fromLane="1".*/>', b"", BUS_LANE)
    net = Network.read(ends, "bus lane")
    right = lane(net, "w_in_1")
    assert net.map.kind[right] == LaneKind.BUS
    assert net.map.may_change[right].tolist() == [True, False]
    assert {net.lane_names[i] for i in Exits.of(net.map).lane} == {"w_out_0", "e_out_0", "n_out_0"}


@pytest.mark.parametrize("yes", [b"true", b"1"])
def test_left_hand_traffic_has_its_lane_zero_on_the_left(yes):
    net = Network.read(RAW.replace(b'version="1.20"', b'version="1.20" lefthand="' + yes + b'"'), "cross")
    assert net.map.neighbour[lane(net, "w_in_1"), 1] == lane(net, "w_in_2")
    assert net.map.neighbour[lane(net, "w_in_2"), 0] == lane(net, "w_in_1")


def test_boundaries_lie_half_a_width_beside_the_centreline(net):
    i = lane(net, "n_out_0")
    assert np.allclose(net.map.left[i] + net.map.origin, [[98.25, 110], [98.25, 200]], atol=1e-3)
    assert np.allclose(net.map.right[i] + net.map.origin, [[101.75, 110], [101.75, 200]], atol=1e-3)


def test_drivable_area_holds_the_junction_and_crossings_have_four_corners(net):
    outlines = [outline + net.map.origin for outline in net.map.drivable.lines()]
    assert any(np.allclose(outline, [[90, 90], [110, 90], [110, 110], [90, 110]]) for outline in outlines)
    (corners,) = net.map.crossings.lines()
    assert np.allclose(corners + net.map.origin, [[86, 94], [86, 106], [90, 106], [90, 94]])


def test_both_edges_of_a_crossing_run_the_way_that_people_walk_in_argoverse_2(net):
    (written,) = json.loads(write_map(net.map))["pedestrian_crossings"].values()
    for edge in ("edge1", "edge2"):
        assert [point["y"] for point in written[edge]] == [94, 106]


def test_a_way_across_a_junction_is_drawn_itself_only_where_the_junction_does_not_hold_it(net):
    small = Network.read(RAW.replace(b'shape="90,90 110,90 110,110 90,110"', b'shape="90,96 110,96 110,101 90,101"'), "cross")
    assert len(net.map.drivable) == 5 + 1  # lanes outside the junction, its outline
    assert len(small.map.drivable) == 5 + 3 + 1  # three ways poke out of it now, the one from west to east does not


def test_programs_say_what_each_light_shows_when(net):
    names = [net.lane_names[i] for i in net.signal_lane]
    assert names == [":c_0_0", ":c_3_0"]
    shown = net.signals(np.array([5.0, 34.9, 35.1, 39.9, 40.1, 64.9, 65.1, 4.9]))
    green, yellow, red = SignalState.GREEN, SignalState.YELLOW, SignalState.RED
    assert shown.state[0].tolist() == [green, green, yellow, yellow, red, red, green, red]
    assert shown.state[1].tolist() == [red, red, red, red, green, green, red, green]


def test_gzipped_networks_read_the_same_and_the_origin_keeps_coordinates(net):
    again = read_network(gzip.compress(RAW), "cross.gz")
    assert np.array_equal(again.centreline.points, net.map.centreline.points)
    assert np.allclose(again.centreline[lane(net, "e_out_0")] + again.origin, [[110, 98.4], [200, 98.4]])


def test_a_lane_of_no_length_points_where_the_lane_before_it_ends():
    raw = RAW.replace(b'shape="90,98.4 110,98.4"', b'shape="90,98.4 90,98.4"')
    net = Network.read(raw, "cross")
    line = net.map.centreline[lane(net, ":c_0_0")]
    assert np.allclose(line[1] - line[0], [0.05, 0.0], atol=1e-4)


@pytest.mark.parametrize(
    ("raw", "reason"),
    [
        (RAW[:900], "truncated"),
        (b"", "empty"),
        (b"<nodes/>", "wrong-root"),
        (b"<net/>", "no-lanes"),
        (gzip.compress(RAW, mtime=0)[:400], "truncated"),
        (RAW.replace(b'shape="110,98.4 200,98.4"', b'shape="110,nan 200,98.4"'), "bad-map"),
        (RAW.replace(b'shape="110,98.4 200,98.4"', b'shape="110,98.4"'), "bad-map"),
        (RAW.replace(b'shape="110,98.4 200,98.4"', b'shape="110,98.4 9e7,98.4"'), "too-large"),
        (RAW.replace(b'speed="13.89"', b'speed="-1"'), "bad-map"),
        (re.sub(rb' id="[^"]*"', b"", RAW), "bad-map"),
        (RAW.replace(b'linkIndex="0"', b'linkIndex="x"'), "bad-map"),
        (RAW.replace(b'via=":c_0_0" tl', b"tl"), "no-internal-lanes"),
        (RAW.replace(b'duration="30"', b'duration="inf"'), "bad-map"),
        (b"<!DOCTYPE net [<!ENTITY e SYSTEM 'file:///etc/hostname'>]>" + RAW, "xml-dtd"),
    ],
)
def test_what_is_no_network_is_refused_with_file_and_reason(raw, reason):
    with pytest.raises(UnusableInput, match="somewhere") as caught:
        read_network(raw, "somewhere")
    assert caught.value.reason == reason


@settings(max_examples=50, deadline=None)
@given(st.integers(0, len(RAW) - 1), st.integers(1, 40), st.binary(max_size=20))
def test_a_damaged_network_is_refused_by_its_name_or_is_a_whole_map(at, cut, put):
    try:
        found = Network.read(RAW[:at] + put + RAW[at + cut :], "damaged")
    except UnusableInput as refusal:
        assert_one_sentence(refusal, "damaged")
    else:
        found.map.validate()
        assert 0 < len(found.map) <= len(read_network(RAW, "whole"))
        assert found.signals(np.arange(3.0)).state.shape == (len(found.signal_lane), 3)


@pytest.mark.parametrize("path", ["game/A10KW/osm.net.xml", "game/fkk_in/ingolstadt.net.xml.gz", "game/square/square.net.xml"])
def test_networks_that_come_with_sumo_read_in_a_second(path):
    raw = (SUMO / "tools" / path).read_bytes()
    assert cpu_seconds(lambda: Network.read(raw, path), times=3) < 10 * yardstick()
    assert_hangs_together(Network.read(raw, path))


@pytest.mark.skipif(not REAL.is_dir(), reason=f"{REAL} is not there")
@pytest.mark.parametrize("path", ["acosta/acosta_buslanes.net.xml", "pasubio/pasubio_buslanes.net.xml"])
def test_real_city_networks_read(path):
    net = Network.read((REAL / path).read_bytes(), path)
    assert_hangs_together(net)
    assert (net.map.kind == LaneKind.BUS).any()


def assert_hangs_together(net: Network) -> None:
    """Linked lanes touch, neighbours are mutual, controlled entries have stop lines."""
    m = net.map
    ends = m.centreline.points[m.centreline.start[m.links[:, 0] + 1] - 1]
    starts = m.centreline.points[m.centreline.start[m.links[:, 1]]]
    assert np.median(np.hypot(*(ends - starts).T)) < 0.05
    for i, j in np.argwhere(m.same_direction):
        assert m.neighbour[m.neighbour[i, j], 1 - j] == i
    controlled = np.isin(m.control[m.links[:, 1]], [LaneControl.SIGNAL, LaneControl.STOP, LaneControl.YIELD])
    assert len(m.stop_lines) == controlled.sum() > 0
    assert set(net.signal_lane.tolist()) <= set(np.flatnonzero(m.control == LaneControl.SIGNAL).tolist())
    assert not (m.may_change & ~m.same_direction).any()


def test_of_several_programs_the_last_one_runs_as_in_sumo():
    night = b'</tlLogic><tlLogic id="T" type="static" programID="night" offset="0"><phase duration="60" state="rr"/></tlLogic>'
    assert RAW.count(b"</tlLogic>") == 1
    shown = Network.read(RAW.replace(b"</tlLogic>", night), "cross").signals(np.array([5.0, 40.0]))
    assert (shown.state == SignalState.RED).all()
