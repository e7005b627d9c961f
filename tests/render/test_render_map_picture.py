"""Pictures of maps show what is there, and are the same for the same map."""

import cv2
import numpy as np

from drivegen.maps.compile import compile_map
from drivegen.maps.spec import MapSpec
from drivegen.render.map_picture import draw_map, encode_png
from drivegen.sumo.network import read_network

ARMS = [{"angle": angle, "length": 60} for angle in (0, 90, 180, 270)]


def picture(control: str) -> np.ndarray:
    network = compile_map(MapSpec.model_validate({"road": {"kind": "crossing", "arms": ARMS, "control": control}}))
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


def test_the_same_map_gives_the_same_png() -> None:
    first = encode_png(picture("signals"))
    assert first == encode_png(picture("signals"))
    assert cv2.imdecode(np.frombuffer(first, np.uint8), cv2.IMREAD_COLOR).shape[2] == 3
