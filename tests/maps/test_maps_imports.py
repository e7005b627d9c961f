"""Maps from files: what they are is seen by their content, windows are cut out, damage is said."""

import gzip
import re
from pathlib import Path

import pytest

from drivegen.av2.maps import write_map
from drivegen.core.errors import UnusableInput
from drivegen.maps.build import build_map
from drivegen.maps.imports import Window, import_map
from drivegen.maps.opendrive import export_opendrive
from drivegen.sumo.netconvert import convert
from drivegen.words.writer import Writer
from tests.scenes import any_scenario

OSM = b"""<?xml version="1.0"?><osm version="0.6">
<node id="1" lat="52.0000" lon="13.0000"/><node id="2" lat="52.0000" lon="13.0030"/>
<node id="3" lat="52.0000" lon="13.0060"/><node id="4" lat="52.0015" lon="13.0030"/><node id="5" lat="51.9985" lon="13.0030"/>
<way id="10"><nd ref="1"/><nd ref="2"/><nd ref="3"/><tag k="highway" v="secondary"/></way>
<way id="11"><nd ref="4"/><nd ref="2"/><nd ref="5"/><tag k="highway" v="residential"/></way>
<way id="12"><nd ref="1"/><nd ref="4"/><tag k="highway" v="footway"/></way>
<way id="13"><nd ref="3"/><nd ref="5"/><tag k="railway" v="rail"/></way></osm>"""


@pytest.fixture(scope="module")
def grid() -> bytes:
    return build_map("a 3 by 3 grid of streets with blocks of 200 m and one lane each", 7, Writer()).network


def test_a_sumo_network_keeps_its_bytes_gzipped_or_not(grid: bytes) -> None:
    assert import_map(grid, "grid.net.xml").network == grid
    assert import_map(gzip.compress(grid), "grid.net.xml.gz").network == grid


def test_a_window_holds_the_busiest_junction_the_one_named_or_the_place_asked_for(grid: bytes) -> None:
    whole = import_map(grid, "grid.net.xml")
    for window in (Window(150.0), Window(150.0, junction="r2c2"), Window(150.0, around=(200.0, 200.0))):
        built = import_map(grid, "grid.net.xml", window)
        assert 0 < built.structure.edges < whole.structure.edges
        assert len(built.road_map) < len(whole.road_map)


@pytest.mark.parametrize(
    "window", [Window(150.0, junction="nowhere"), Window(-5.0), Window(100.0, around=(1e6, 1e6)), Window(float("nan"))]
)
def test_a_window_on_nothing_is_refused(grid: bytes, window: Window) -> None:
    with pytest.raises(UnusableInput):
        import_map(grid, "grid.net.xml", window)


@pytest.mark.parametrize("x", [b"abc", b"nan", b""])
def test_a_junction_without_a_place_is_refused(grid: bytes, x: bytes) -> None:
    broken = re.sub(rb'(<junction id="[^":]+" type="[^"]+" x=")[^"]*', rb"\g<1>" + x, grid)
    with pytest.raises(UnusableInput, match=r"grid\.net\.xml: junction '[^']+' has no place") as caught:
        import_map(broken, "grid.net.xml", Window(150.0))
    assert caught.value.reason == "bad-map"


def test_a_network_that_includes_a_file_is_refused(grid: bytes) -> None:
    with pytest.raises(UnusableInput, match=r"grid\.net\.xml includes another file"):
        import_map(grid.replace(b"</net>", b'<include href="more.xml"/></net>'), "grid.net.xml")


def test_openstreetmap_streets_are_kept_and_paths_and_rails_left_out() -> None:
    built = import_map(OSM, "town.osm")
    assert built.structure.arms == (4,)
    assert built.account["source"] == "OpenStreetMap"


def test_what_a_file_does_not_say_is_told_as_assumed(grid: bytes) -> None:
    log = write_map(any_scenario(3).map)
    assumed = [import_map(raw, "file").account["assumed"] for raw in (grid, export_opendrive(grid), OSM, log)]
    assert [len(lines) for lines in assumed] == [0, 1, 1, 1]
    assert all("50 km/h" in lines[0] for lines in (assumed[1], assumed[3]))
    assert "right of way is guessed" in assumed[1][0]
    assert "right-hand traffic" in assumed[2][0]
    assert all(word in assumed[3][0] for word in ("crosswalks", "junctions", "oncoming", "cut"))


def test_a_map_goes_out_as_opendrive_and_comes_back(grid: bytes) -> None:
    first = export_opendrive(grid)
    assert first == export_opendrive(grid)
    assert import_map(first, "grid.xodr").structure.junctions == 9


def test_opendrive_with_left_hand_roads_is_refused(grid: bytes) -> None:
    left = export_opendrive(grid).replace(b"<road ", b'<road rule="LHT" ')
    with pytest.raises(UnusableInput, match="has left-hand roads") as refused:
        import_map(left, "grid.xodr")
    assert refused.value.reason == "left-hand"


def test_an_imported_map_is_saved_with_its_picture(grid: bytes, tmp_path: Path) -> None:
    import_map(grid, "grid.net.xml", Window(120.0)).save(tmp_path)
    assert {file.name for file in tmp_path.iterdir()} == {"map.net.xml", "map.json", "map.png"}


def test_signals_without_lanes_within_junctions_are_refused_until_these_are_added() -> None:
    whole = build_map("a crossing with traffic lights", 7, Writer()).network

    def again(network: bytes, value: str) -> bytes:
        arguments = ["-s", "in.net.xml", "--no-internal-links", value, "-o", "out.net.xml"]
        return convert({"in.net.xml": network}, arguments, "out.net.xml", 60.0)

    bare = again(whole, "true")
    for window in (None, Window(150.0)):
        with pytest.raises(UnusableInput, match=r"bare.*netconvert.*--no-internal-links false") as caught:
            import_map(bare, "bare", window)
        assert caught.value.reason == "no-internal-lanes"
    assert len(import_map(again(bare, "false"), "mended").road_map) == len(import_map(whole, "whole").road_map)


@pytest.mark.parametrize(
    "raw",
    [b"", b"{", b'{"a": 1}', b"<html/>", b"<net", b"<net/>", b"<osm/>", b"<OpenDRIVE/>", gzip.compress(b"<net/>", mtime=0)[:9]],
)
def test_what_is_no_map_is_refused_by_name(raw: bytes) -> None:
    with pytest.raises(UnusableInput):
        import_map(raw, "some.file")


def test_roads_that_reach_into_a_window_stay_whole_also_where_nothing_follows_them_there() -> None:
    motorway = build_map("a motorway with an on-ramp at 400 m, 2000 m long", 7, Writer()).network
    ends = {place: import_map(motorway, "a.net.xml", Window(150.0, around=(place, 0.0))).structure.edges for place in (300, 900)}
    assert ends[300] >= 3  # both carriageways and the ramp
    assert ends[900] == 2


def test_opendrive_is_read_with_and_without_its_namespace() -> None:
    xodr = export_opendrive(build_map("a straight road with two lanes each way", 7, Writer()).network)
    named = xodr.replace(b"<OpenDRIVE", b'<OpenDRIVE xmlns="http://code.asam.net/simulation/standard/opendrive_schema"', 1)
    assert named != xodr
    assert import_map(named, "a.xodr").structure == import_map(xodr, "a.xodr").structure
    with pytest.raises(UnusableInput, match="left-hand roads"):
        import_map(named.replace(b"<road ", b'<road rule="LHT" ', 1), "a.xodr")
