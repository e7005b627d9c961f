"""Maps go out as OpenDRIVE and come back with their lanes and ways, whoever the lanes are for."""

import re

import pytest

from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import arc_length
from drivegen.maps.build import build_map
from drivegen.maps.imports import Window, import_map
from drivegen.maps.opendrive import Extent, export_opendrive, losses, read_back, read_opendrive
from drivegen.sumo.network import Network, read_network
from drivegen.words.writer import Writer

KINDS = (
    "four-way crossing with signals, two lanes each way and left turn lanes",
    "roundabout with four arms and two lanes",
    "highway with three lanes and an on-ramp",
    "a 3 by 3 grid of streets with blocks of 200 m and one lane each",
    "a straight road with two lanes each way, left-hand traffic",
)


@pytest.mark.parametrize("text", KINDS)
def test_a_map_comes_back_with_its_lanes_ways_and_lengths(text: str) -> None:
    built = build_map(text, 7, Writer())
    before, after = Extent.of(built.road_map), Extent.of(read_back(export_opendrive(built.network), "a.xodr").map)
    assert before.lanes[0] > 0
    assert after.holds(before)
    assert after.kilometres == pytest.approx(before.kilometres, rel=0.01)


SIDES = "A crossing with side roads that give way. Every arm has 1 lane in each direction. The {} arm has no priority."
APART = "which two directions are one road, at 8 of 8 lanes of two-way roads"


@pytest.mark.parametrize(
    ("text", "lost"),
    [
        (SIDES.format("second arm has no priority. The fourth"), ["right of way at 8 of 12 ways compared", APART]),
        ("an all-way stop, one lane each way", ["right of way at 12 of 12 ways compared", APART]),
        (SIDES.format("first arm has no priority. The third"), [APART]),  # so it is guessed
        (KINDS[0], ["which two directions are one road, at 16 of 36 lanes of two-way roads"]),
        ("highway with three lanes and an on-ramp", []),
    ],
)
def test_what_comes_back_otherwise_is_told(text: str, lost: list[str]) -> None:
    built = build_map(text, 7, Writer())
    told = losses(Network.read(built.network, "net"), read_back(export_opendrive(built.network), "a.xodr"))
    assert [sentence.split(":")[0] for sentence in told] == lost


@pytest.fixture(scope="module")
def shared() -> bytes:
    """A crossing of streets, each with a lane for cars, one for bicycles and lorries and one for buses and trams."""
    network = build_map("four-way crossing with three lanes each way, no turn lanes", 7, Writer()).network
    network = re.sub(
        rb'(<lane id="[^:"][^"]*_0" [^>]*?)(?: (?:dis)?allow="[^"]*")?( speed)', rb'\1 allow="bicycle delivery"\2', network
    )
    return re.sub(rb'(<lane id="[^:"][^"]*_2" [^>]*?)(?: (?:dis)?allow="[^"]*")?( speed)', rb'\1 allow="bus tram"\2', network)


def test_lanes_for_buses_and_bicycles_come_back_as_such(shared: bytes) -> None:
    before = Extent.of(read_network(shared, "net"))
    assert before.lanes == (8, 8, 8)
    xodr = export_opendrive(shared)
    assert b'type="restricted"' not in xodr
    assert Extent.of(read_back(xodr, "a.xodr").map).lanes == before.lanes


def test_lanes_that_a_foreign_file_restricts_are_nobodys(shared: bytes) -> None:
    foreign = export_opendrive(shared).replace(b'type="bus"', b'type="restricted"')
    assert Extent.of(read_back(foreign, "a.xodr").map).lanes == (8, 0, 8)


def test_the_same_network_gives_the_same_bytes(shared: bytes) -> None:
    assert export_opendrive(shared) == export_opendrive(shared)
    assert read_opendrive(export_opendrive(shared)) == read_opendrive(export_opendrive(shared))


ROAD = """<OpenDRIVE><header revMajor="1" revMinor="5"/><road name="" length="200" id="1" junction="-1">{types}
<planView><geometry s="0" x="0" y="0" hdg="0" length="200"><line/></geometry></planView><lanes>
<laneSection s="0"><center><lane id="0" type="none"/></center><right><lane id="-1" type="driving">
<width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane><lane id="-2" type="driving">
<width sOffset="0" a="3.5" b="0" c="0" d="0"/><speed sOffset="0" max="9"/></lane></right>
</laneSection></lanes></road></OpenDRIVE>"""
KIND = '<type s="{}" type="town"><speed max="{}" unit="{}"/></type>'


@pytest.mark.parametrize(
    ("types", "limit"),
    [
        (KIND.format(0, 36, "km/h"), 10),
        (KIND.format(0, 10, "m/s"), 10),
        (KIND.format(0, 30, "mph"), 13.41),
        (KIND.format(0, "no limit", "km/h"), 45),
        (KIND.format(0, "undefined", "km/h"), 13.89),
        ("", 13.89),
    ],
)
def test_a_roads_limit_is_that_of_its_lanes_that_have_none_of_their_own(types: str, limit: float) -> None:
    road_map = read_network(read_opendrive(ROAD.format(types=types).encode()), "net")
    assert sorted(road_map.speed_limit.tolist()) == pytest.approx(sorted([9, limit]), abs=0.01)


@pytest.mark.parametrize(
    ("types", "limits"),
    [
        (KIND.format(0, 36, "km/h") + KIND.format(80, "no limit", "") + KIND.format(140, 72, "km/h"), {10: 80, 45: 60, 20: 60}),
        (KIND.format(0, 36, "km/h") + '<type s="80" type="town"/>', {10: 80, 13.89: 120}),
        (KIND.format(80, 36, "km/h"), {13.89: 80, 10: 120}),
    ],
)
def test_a_roads_limit_may_change_on_the_way(types: str, limits: dict[float, float]) -> None:
    road_map = read_network(read_opendrive(ROAD.format(types=types).encode()), "net")
    lanes = [i for i, speed in enumerate(road_map.speed_limit.tolist()) if speed != 9 and not road_map.in_junction[i]]
    found = {float(road_map.speed_limit[i]): float(arc_length(road_map.centreline[i])[-1]) for i in lanes}
    assert {round(speed, 2): round(metres) for speed, metres in found.items()} == limits


def test_a_road_without_a_lane_section_is_refused_in_a_sentence() -> None:
    road = ROAD.format(types=KIND.format(0, 36, "km/h"))
    damaged = road[: road.index("<laneSection")] + road[road.index("</laneSection>") + len("</laneSection>") :]
    with pytest.raises(UnusableInput, match=r"a\.xodr"):
        import_map(damaged.encode(), "a.xodr")


@pytest.mark.parametrize(
    ("kind", "lanes"),
    [("driving", (2, 0, 0)), ("stop", (1, 0, 0)), ("parking", (1, 0, 0)), ("connectingRamp", (2, 0, 0)), ("slipLane", (2, 0, 0))],
)
def test_one_drives_on_ramps_and_on_no_hard_shoulder(kind: str, lanes: tuple[int, int, int]) -> None:
    road = ROAD.format(types="").replace('id="-2" type="driving"', f'id="-2" type="{kind}"')
    assert Extent.of(read_back(road.encode(), "a.xodr").map).lanes == lanes


PROJECTED = "<geoReference><![CDATA[+proj=utm +zone=32 +datum=WGS84 +units=m]]></geoReference>"
OFFSET = '<offset x="690000" y="5330000" z="0" hdg="0"/>'


@pytest.mark.parametrize("header", ["", PROJECTED, OFFSET, PROJECTED + OFFSET])
def test_coordinates_are_those_of_the_file(header: str) -> None:
    moved = ROAD.format(types="").replace('x="0" y="0"', 'x="1000" y="-500"')
    network = read_opendrive(moved.replace('revMinor="5"/>', f'revMinor="5">{header}</header>').encode())
    ends = (read_network(network, "net"), read_network(read_opendrive(export_opendrive(network)), "net"))
    for road_map in ends:
        assert (road_map.centreline.points + road_map.origin).min(0) == pytest.approx([1000, -505.25], abs=0.02)


def test_a_window_is_cut_where_the_file_has_it() -> None:
    moved = ROAD.format(types="").replace('x="0" y="0"', 'x="1000" y="-500"').encode()
    assert import_map(moved, "a.xodr", Window(50.0, around=(1100.0, -500.0))).structure.edges == 1


@pytest.mark.parametrize(
    ("lane", "refused"),
    [
        ('direction="reversed" type="driving"', True),
        ('direction="both" type="biking"', True),
        ('type="bidirectional"', True),
        ('direction="standard" type="driving"', False),
        ('direction="both" type="sidewalk"', False),
    ],
)
def test_lanes_that_run_against_their_side_or_both_ways_are_refused(lane: str, refused: bool) -> None:
    file = ROAD.format(types="").replace('id="-2" type="driving"', f'id="-2" {lane}').encode()
    if not refused:
        assert import_map(file, "a.xodr").structure.edges == 1
        return
    with pytest.raises(UnusableInput, match=r"a\.xodr: lane -2 of road '1' runs against its side") as caught:
        import_map(file, "a.xodr")
    assert caught.value.reason == "two-way-lane"
