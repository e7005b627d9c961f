"""What is read from a network that is none, and which roads lie on one another."""

import re
import time

import pytest

from drivegen.core.errors import UnusableInput
from drivegen.core.safe_xml import parse
from drivegen.layouts.spec import MapSpec
from drivegen.maps.examine import examine
from drivegen.maps.imports import import_map
from drivegen.maps.overlaps import overlapping
from drivegen.maps.structure import measure

ARMS = [{"angle": angle, "lanes_in": 3, "lanes_out": 3, "left_turn_lanes": 1} for angle in (0, 30, 90, 180, 270)]
NETWORK = examine(MapSpec.model_validate({"road": {"kind": "crossing", "arms": ARMS, "control": "signals"}})).network


@pytest.mark.parametrize(
    "nasty", [b'speed="fast"', b'speed="nan"', b'speed="1e400"', b'length="4 2"', b'shape="1,x 2,3"', b'shape=""']
)
def test_a_network_with_numbers_that_are_none_is_refused_in_a_sentence(nasty):
    at = NETWORK.index(b'<edge id="a0_in"')
    edge = NETWORK[at : NETWORK.index(b"</edge>", at)]
    broken = NETWORK.replace(edge, re.sub(nasty.split(b"=")[0] + b'="[^"]*"', nasty, edge))
    assert broken != NETWORK
    with pytest.raises(UnusableInput, match=r"map\.net\.xml: edge 'a0_in' has no finite shape"):
        measure(parse(broken, "map.net.xml"), "map.net.xml")


def test_lanes_near_the_junction_that_they_share_do_not_lie_on_one_another():
    assert overlapping(parse(NETWORK, "map.net.xml"), "map.net.xml") == ()


LANE = '<edge id="{0}" from="{0}1" to="{0}2"><lane id="{0}_0" index="0" speed="9" length="9" {2} shape="{1}"/></edge>'


def net(*lanes: str) -> bytes:
    return f"<net>{''.join(lanes)}</net>".encode()


@pytest.mark.parametrize("shape", ["abc", "", "0,0 nan,5", "0,0 5,inf", "0,0 90000000,0"])
@pytest.mark.parametrize("users", ['allow="pedestrian"', 'allow="rail"'])
def test_lanes_for_nobody_who_drives_are_not_looked_at_for_bridges(shape, users):
    over = LANE.format("over", "0,0,9 100,0,9", ""), LANE.format("under", "50,-50,0 50,50,0", "")
    assert import_map(net(*over, LANE.format("path", shape, users)), "a.net.xml").structure.bridges == 1


@pytest.mark.parametrize(
    ("shape", "said"),
    [("0,0,x 5,0,1", "height"), ("0,0,nan 5,0,1", "height"), ("0,0,1 90000000,0,1", "longer than 1000 km")],
)
def test_a_lane_for_cars_without_a_height_or_an_end_is_refused(shape, said):
    with pytest.raises(UnusableInput, match=rf"a\.net\.xml: lane 'a_0' .*{said}"):
        measure(parse(net(LANE.format("a", shape, "")), "a.net.xml"), "a.net.xml")


@pytest.mark.parametrize("length", ["-9", "0", "1e308"])
def test_an_edge_without_a_possible_length_is_refused(length):
    edge = LANE.format("a", "0,0 100,0", "").replace('length="9"', f'length="{length}"')
    with pytest.raises(UnusableInput, match=r"a\.net\.xml: edge 'a' has no finite shape, speed and length \(0 to 1000 km\)"):
        import_map(net(edge), "a.net.xml")


@pytest.mark.parametrize("length", ["-9", "inf", "nan", "long"])
def test_a_lane_within_a_junction_without_a_possible_length_is_refused(length):
    broken = re.sub(rb'(<lane id=":c_0_0"[^>]* length=")[^"]*', rb"\g<1>" + length.encode(), NETWORK)
    assert broken != NETWORK
    with pytest.raises(UnusableInput, match=rf"map\.net\.xml: lane ':c_0_0' within a junction has length='{length}'"):
        measure(parse(broken, "map.net.xml"), "map.net.xml")


def in_a_row(count: int, closed: bool = False) -> bytes:
    """Edges of 10 m that follow one another on a line; `closed`: the last leads to the first."""
    nodes = [f"n{i}" for i in range(count)] + ["n0" if closed else "end"]
    lane = '<lane id="e{0}_0" index="0" speed="9" length="10" shape="{1},0 {2},0"/>'
    way = '<edge id="e{0}" from="{1}" to="{2}">' + lane.format("{0}", "{3}", "{4}") + "</edge>"
    edges = [way.format(i, nodes[i], nodes[i + 1], 10 * i, 10 * i + 10) for i in range(count)]
    ways = [f'<connection from="e{i}" to="e{(i + 1) % count}" fromLane="0" toLane="0"/>' for i in range(count - (not closed))]
    return f"<net>{''.join(edges + ways)}</net>".encode()


@pytest.mark.parametrize("closed", [True, False])
def test_a_road_of_many_pieces_is_measured_at_once(closed):
    begun = time.process_time()
    structure = measure(parse(in_a_row(4000, closed), "a.net.xml"), "a.net.xml")
    assert time.process_time() - begun < 5.0
    assert (structure.edges, structure.turn, structure.loops) == (4000, 0.0, 0)


def test_more_roads_on_one_line_than_any_network_has_are_refused():
    stacked = net(*(LANE.format(f"e{i}", "0,0,1 500,0,1", "") for i in range(400)))
    begun = time.process_time()
    with pytest.raises(UnusableInput, match=r"a\.net\.xml: more than 50 roads lie on one another near \(\d+, 0\)"):
        import_map(stacked, "a.net.xml")
    assert time.process_time() - begun < 5.0


@pytest.mark.parametrize(
    "road",
    [
        {"kind": "corridor", "lanes_back": 0, "alignment": {"shape": "curve", "angle": 270, "radius": 60, "length": 600}},
        {
            "kind": "highway",
            "carriageways": 1,
            "alignment": {"shape": "curve", "angle": -270, "radius": 60, "length": 1000},
        },
    ],
    ids=["street", "highway"],
)
def test_a_road_that_crosses_itself_is_told(road):
    lies = [c for c in examine(MapSpec.model_validate({"road": road})).checks if c.name == "no overlapping roads"]
    (pair,) = lies[0].got
    name, _, other = pair.partition(" near ")[0].partition(" and ")
    assert name == other


def test_two_roads_on_one_line_between_the_same_nodes_are_told():
    nodes = [{"name": name, "x": x, "y": 0} for name, x in (("w", -200), ("a", 0), ("b", 100), ("e", 300))]
    ways = [("i", "w", "a"), ("p", "a", "b"), ("q", "a", "b"), ("o", "b", "e")]
    roads = [{"name": name, "start": start, "end": end, "lanes_back": 0} for name, start, end in ways]
    found = examine(MapSpec.model_validate({"road": {"kind": "graph", "nodes": nodes, "roads": roads}}))
    (pair,) = next(c.got for c in found.checks if c.name == "no overlapping roads")
    assert pair.startswith("p and q near")
