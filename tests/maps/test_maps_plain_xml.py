"""SUMO XML that somebody else wrote: what is sound becomes our types, what is not is told line by line and goes nowhere."""

import pytest

from drivegen.maps.examine import WrittenNetwork, examine
from drivegen.maps.plain_xml import MAX_BYTES, MOST_PROBLEMS, UnusableXml, read_plain
from drivegen.sumo.plain import Connection

NODES = '<nodes><node id="a" x="0" y="0"/><node id="b" x="200" y="0" type="priority"/><node id="c" x="400" y="0"/></nodes>'
EDGE = '<edge id="{}" from="{}" to="{}" numLanes="2" speed="13.9"/>'
EDGES = f"<edges>{EDGE.format('ab', 'a', 'b')}{EDGE.format('bc', 'b', 'c')}</edges>"
LINKS = '<connections><connection from="ab" to="bc" fromLane="0" toLane="0"/></connections>'


def problems(nodes: str = NODES, edges: str = EDGES, links: str = LINKS) -> str:
    with pytest.raises(UnusableXml) as refusal:
        read_plain(nodes, edges, links)
    assert 1 <= len(refusal.value.problems) <= MOST_PROBLEMS
    assert all(line == " ".join(line.split()) and len(line) < 200 for line in refusal.value.problems)
    return "\n".join(refusal.value.problems)


def test_a_sound_network_is_read_and_built():
    network = read_plain(NODES, EDGES, LINKS)
    assert [node.id for node in network.nodes] == ["a", "b", "c"]
    assert network.connections == [Connection("ab", "bc", 0, 0)]
    found = examine(WrittenNetwork(network, {"lanes": 2, "junctions": 0}))
    assert [check.passed for check in found.checks] == [True] * 4
    assert read_plain(NODES, EDGES, "").connections == []


def test_lanes_rings_and_shapes_are_read():
    inner = '<lane index="1" speed="10" width="3.5"/>'
    edges = EDGES.replace('speed="13.9"/>', f'speed="13.9" shape="0,0 100,5 200,0" width="3" priority="2">{inner}</edge>', 1)
    edges = edges.replace("</edges>", '<roundabout nodes="a b" edges="ab"/></edges>')
    network = read_plain(NODES, edges, LINKS)
    assert network.edges[0].per_lane[1].width == 3.5
    assert network.edges[0].shape == ((0, 0), (100, 5), (200, 0))
    assert network.roundabouts[0].edges == ("ab",)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('x="0"', 'x="1e9"', "x must be -5000 to 5000, not 1e9"),
        ('x="0"', 'x="nan"', "x must be"),
        ('x="0"', 'x="٣"', "x must be"),
        ('id="a"', 'id="../../etc"', "id must be 1 to 32 letters"),
        ('id="a"', 'id="b"', "two nodes have the id b"),
        ('x="0" y="0"', 'x="200" y="0"', "two nodes lie at 200,0"),
        ('type="priority"', 'type="rail_signal"', "type must be one of"),
        ('y="0"', 'y="0" onload="x"', "the attribute onload is not allowed"),
        (' x="0"', "", "the attribute x is missing"),
        ("<node id", '<include href="x"/><node id', "includes another file"),
        ("<nodes>", '<nodes evil="1">', "may not have the attribute evil"),
        ("<nodes>", "<net>", "is not XML"),
        ("<nodes>", '<!DOCTYPE x [<!ENTITY e SYSTEM "file:///etc/passwd">]><nodes>', "DTD or an entity"),
        ("<nodes>", f"<nodes>{' ' * MAX_BYTES}", "larger than 64 kB"),
        ("/><node id", "><param/></node><node id", "may hold nothing"),
    ],
)
def test_nodes_that_are_refused(old, new, said):
    assert said in problems(nodes=NODES.replace(old, new, 1))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('numLanes="2"', 'numLanes="100000"', "numLanes must be a whole number 1 to 8, not 100000"),
        ('numLanes="2"', 'numLanes="-1"', "numLanes must be"),
        ('speed="13.9"', 'speed="900"', "speed must be 3 to 45"),
        ('from="a"', 'from="z"', "there is no node z"),
        ('from="a"', 'from="b"', "begins and ends at the node b"),
        ('id="bc"', 'id="ab"', "two edges have the id ab"),
        ("<edges>", '<edges><roundabout nodes="q" edges="ab"/>', "roundabout: there is no q"),
        ('speed="13.9"', 'speed="13.9" shape="0,0"', "must have 2 to 100 points"),
        ('speed="13.9"', 'speed="13.9" shape="0,0 1;2"', "must be points x,y"),
        ('speed="13.9"', 'speed="13.9" type="file"', "the attribute type is not allowed"),
        ('speed="13.9"/>', 'speed="13.9"><lane index="7"/></edge>', "index must be a whole number 0 to 1"),
        ('speed="13.9"/>', 'speed="13.9"><lane index="1"/><lane index="1"/></edge>', "two lanes have the index 1"),
        ('speed="13.9"/>', 'speed="13.9"><stopOffset value="1"/></edge>', "may hold lane only"),
        ('speed="13.9"', 'speed="13.9" spreadType="x"', "spreadType must be one of"),
        ("<edges>", "<edges>" + EDGE.format("q", "a", "b") * 401, "more than 400"),
    ],
)
def test_edges_that_are_refused(old, new, said):
    assert said in problems(edges=EDGES.replace(old, new, 1))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('from="ab"', 'from="zz"', "there is no edge zz"),
        ('to="bc"', 'to="ab"', "must end at the node where the second begins"),
        ('toLane="0"', 'toLane="5"', "toLane below 2"),
        ("</connections>", LINKS[13:], "two connections are the same"),
    ],
)
def test_connections_that_are_refused(old, new, said):
    assert said in problems(links=LINKS.replace(old, new, 1))


def test_everything_that_is_wrong_is_told_at_once():
    told = problems(nodes=NODES.replace('x="0"', 'x="nan"'), edges=EDGES.replace('speed="13.9"', 'speed="0"'))
    assert "node a" in told
    assert "edge ab" in told
    assert "edge bc" in told


def test_roads_that_cross_without_a_node_are_found():
    nodes = "".join(
        f'<node id="{n}" x="{x}" y="{y}"/>' for n, x, y in (("w", -200, 0), ("e", 200, 0), ("s", 0, -200), ("n", 0, 200))
    )
    edges = EDGE.format("we", "w", "e") + EDGE.format("sn", "s", "n")
    found = examine(WrittenNetwork(read_plain(f"<nodes>{nodes}</nodes>", f"<edges>{edges}</edges>", "")))
    assert [(check.name, check.passed) for check in found.checks] == [("nobody stuck", True), ("no overlapping roads", False)]
    assert "sn and we near" in found.checks[1].got[0]
