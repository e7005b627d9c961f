"""Pictures of maps show what is there, and are the same for the same map."""

import tracemalloc
from dataclasses import replace

import cv2
import numpy as np
import pytest

from drivegen.core.roadmap import LaneControl
from drivegen.layouts.compile import compile_map
from drivegen.layouts.spec import MapSpec
from drivegen.render.map_picture import draw_map
from drivegen.render.png import png
from drivegen.render.stop_lines import shown_stop_lines
from drivegen.sumo.network import read_network
from tests.scenes import road_map

ARMS = [{"angle": angle, "length": 60} for angle in (0, 90, 180, 270)]


def picture(control: str, arms: list[dict] = ARMS) -> np.ndarray:
    network = compile_map(MapSpec.model_validate({"road": {"kind": "crossing", "arms": arms, "control": control}}))
    return draw_map(read_network(network, "test"), "a crossing")


def pixels_of(image: np.ndarray, colour: tuple[int, int, int]) -> int:
    above_the_key = image[:-64]
    return int((above_the_key == colour).all(-1).sum())


def test_a_picture_shows_asphalt_markings_and_what_controls_the_crossing() -> None:
    lit, stop = picture("signals"), picture("all_way_stop")
    assert pixels_of(lit, (92, 88, 86)) > 5000
    assert pixels_of(lit, (245, 245, 245)) > 500
    assert pixels_of(lit, (80, 190, 60)) > 50
    assert pixels_of(stop, (80, 190, 60)) == 0
    assert pixels_of(stop, (40, 40, 210)) > 50


def dots_of(image: np.ndarray, colour: tuple[int, int, int]) -> int:
    above_the_key = image[:-64]
    return cv2.connectedComponents((above_the_key == colour).all(-1).astype(np.uint8))[0] - 1


@pytest.mark.parametrize(
    ("angles", "side", "control", "dots"),
    [
        ((0, 90, 180, 270), (90, 270), "yield", 2),  # left turns off the main road yield, too, but who drives on does not
        ((0, 180, 270), (270,), "yield", 1),  # nobody drives straight on from the side street, and whoever comes out of it yields
        ((0, 180, 270), (), "uncontrolled", 1),  # right before left: driving on yields where the side road is on the right
        ((0, 90, 180, 270), (), "all_way_stop", 0),
    ],
)
def test_a_dot_says_what_holds_for_who_drives_on(angles, side, control, dots) -> None:
    arms = [{"angle": angle, "length": 60, "main": angle not in side} for angle in angles]
    assert dots_of(picture(control, arms), (30, 150, 250)) == dots


def test_a_line_that_holds_for_turns_off_the_main_road_alone_is_not_shown() -> None:
    arms = [arm | {"main": arm["angle"] in (0, 180)} for arm in ARMS]
    spec = MapSpec.model_validate({"road": {"kind": "crossing", "arms": arms, "control": "yield"}})
    roads = read_network(compile_map(spec), "test")
    along_x = [np.ptp(ends[:, 0]) > np.ptp(ends[:, 1]) for ends in roads.stop_lines]
    shown = shown_stop_lines(roads)
    assert 0 < sum(along_x) < len(along_x)
    assert [np.ptp(ends[:, 0]) > np.ptp(ends[:, 1]) for ends, _ in shown] == [True] * 2  # across the side roads
    assert {control for _, control in shown} == {LaneControl.YIELD}


def test_a_line_whose_lane_lies_beyond_the_edge_of_the_map_keeps_what_holds_there() -> None:
    spec = MapSpec.model_validate({"road": {"kind": "crossing", "arms": ARMS, "control": "signals"}})
    roads = read_network(compile_map(spec), "test")
    cut = replace(roads, links=roads.links[roads.in_junction[roads.links[:, 0]]])
    assert {control for _, control in shown_stop_lines(cut)} == {LaneControl.SIGNAL}


def test_the_same_map_gives_the_same_png() -> None:
    first = png(picture("signals"))
    assert first == png(picture("signals"))
    assert cv2.imdecode(np.frombuffer(first, np.uint8), cv2.IMREAD_COLOR).shape[2] == 3


def test_the_close_up_of_a_large_map_takes_no_memory_for_each_pair_of_its_ways() -> None:
    """2500 ways across junctions, most of them at one place."""
    place = np.concatenate([np.zeros((1500, 2)), np.stack([np.linspace(100, 2000, 1000), np.zeros(1000)], axis=1)])
    lines = [at + np.array([[0.0, 0.0], [6.0, 0.0]]) for at in place]
    roads = road_map(lines, in_junction=range(2500))
    tracemalloc.start()
    shown = draw_map(roads, "many ways")
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert shown.shape[0] > 560
    assert most < 60e6  # a number for each pair takes 100 MB
