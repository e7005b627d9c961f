"""The audit of the bird-eye image: a reader that is given the PNG alone finds every number and every vehicle.

What it knows: the colours of the key in the prompt, the typeface, metres per pixel. What it is compared with is known to the
test only.
"""

from functools import lru_cache

import cv2
import numpy as np
import pytest

from drivegen.core.geometry import box_corners, to_vehicle_frame
from drivegen.core.scenario import TARGET
from drivegen.goals.candidates import candidates
from drivegen.render import bird_eye
from drivegen.render.bird_eye import EXTENT, draw_bird_eye
from drivegen.render.png import png
from drivegen.roads.graph import LaneGraph
from tests import scenes
from tests.models import candidate_settings, two_lanes

COLOURS = {"this": bird_eye._THIS, "target": bird_eye._TARGET, "other": bird_eye._OTHER}
NEAR = 1.0
"""Vehicles are found within this distance [m]."""


def decoded(data):
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]


@lru_cache
def templates():
    """Each number as white on dark, in the middle of a square."""
    made = {}
    for number in range(41):
        tile = np.full((22, 26), 25, np.uint8)
        (wide, high), _ = cv2.getTextSize(str(number), cv2.FONT_HERSHEY_SIMPLEX, 0.5, 1)
        cv2.putText(tile, str(number), (13 - wide // 2, 11 + high // 2), cv2.FONT_HERSHEY_SIMPLEX, 0.5, 255, 1, cv2.LINE_AA)
        rows, columns = np.nonzero(tile > 120)
        made[number] = tile[rows.min() - 1 : rows.max() + 2, columns.min() - 1 : columns.max() + 2]
    return made


def read_numbers(image):
    """[(number, centre [px])] of the discs in the picture: dark rings with something white in them."""
    dark = (image.max(-1) < 90).astype(np.float32)
    away = np.hypot(*np.mgrid[-15:16, -15:16])
    ring, rim = (away > 10.5) & (away < 12.5), (away > 13.6) & (away < 14.6)
    filled, outside = (
        cv2.filter2D(dark, -1, (k / k.sum()).astype(np.float32), borderType=cv2.BORDER_CONSTANT) for k in (ring, rim)
    )
    score = np.where((filled > 0.93) & (outside < 0.6), filled - outside / 4, 0.0)
    found = []
    while score.max() > 0:
        y, x = np.unravel_index(score.argmax(), score.shape)
        ys, xs = np.nonzero(score[max(y - 3, 0) : y + 4, max(x - 3, 0) : x + 4] > score[y, x] - 0.02)
        centre = np.array([xs.mean() + max(x - 3, 0), ys.mean() + max(y - 3, 0)])
        score[max(y - 13, 0) : y + 14, max(x - 13, 0) : x + 14] = 0.0
        tile = np.full((25, 25), 25, np.uint8)
        seen = image[max(y - 12, 0) : y + 13, max(x - 12, 0) : x + 13, 1]
        tile[: seen.shape[0], : seen.shape[1]] = seen
        inside = np.hypot(*(np.mgrid[0:25, 0:25] - np.array([min(y, 12), min(x, 12)])[:, None, None])) < 11.0
        found.append((likeliest(np.where(inside, tile, 25)), centre))
    return found


def likeliest(tile):
    """The number whose picture differs least from what the tile holds."""
    rows, columns = np.nonzero(tile > 120)
    cut = tile[rows.min() - 1 : rows.max() + 2, columns.min() - 1 : columns.max() + 2].astype(float)

    def differs(shape):
        scaled = cv2.resize(shape, cut.shape[::-1], interpolation=cv2.INTER_LINEAR).astype(float)
        return np.abs(scaled - cut).mean() + 20 * abs(shape.shape[1] - cut.shape[1])

    return min(templates(), key=lambda number: differs(templates()[number]))


def read_vehicles(image, colour):
    """Centres (M, 2) [m], forward and left of the middle, of boxes in that colour."""
    mask = (np.abs(image.astype(int) - colour).max(-1) < 30).astype(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask)
    middles = []
    for i in range(1, count):
        if stats[i, cv2.CC_STAT_AREA] < 20:
            continue
        outline, _ = cv2.findContours((labels == i).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        middles.append(cv2.minAreaRect(outline[0])[0])
    size = len(image)
    return (size / 2 - np.array(middles).reshape(-1, 2)[:, ::-1]) * EXTENT / size


def crowded_road():
    """Ninety metres of two full lanes."""
    roads = scenes.straight_road(500, 2)
    log = [scenes.drive(scenes.joined(roads, lane), 100 + 7.0 * i + 2 * lane, 3.0, 101) for i in range(8) for lane in (0, 1)]
    return scenes.scenario(roads, scenes.stack(log), "crowded")


SCENES = {"crossing": scenes.busy_crossing(), "crowded": crowded_road(), "fast": two_lanes(14.0)}


@pytest.fixture(scope="module")
def drawn():
    """Every vehicle of every scene: (scene, vehicle, candidates, PNG, marks)."""
    made = []
    for scene in SCENES.values():
        graph = LaneGraph.of(scene.map)
        for n in range(len(scene.vehicles)):
            c = candidates(graph, scene, n, candidate_settings())
            picture, marks = draw_bird_eye(scene, n, c.position, c.lane)
            made.append((scene, n, c, png(picture), marks))
    return made


def test_a_reader_of_the_png_finds_every_number_where_it_is(drawn):
    for _, _, c, data, marks in drawn:
        read = read_numbers(decoded(data))
        assert sorted(number for number, _ in read) == list(range(len(c)))
        found = dict(read)
        gaps = [np.hypot(*(found[i] - marks.disc[i])) for i in range(len(c))]
        assert max(gaps) * EXTENT / 768 < NEAR


def test_a_reader_of_the_png_finds_every_vehicle_within_a_metre(drawn):
    for scene, vehicle, _, data, _ in drawn:
        v, image = scene.vehicles, decoded(data)
        boxes = box_corners(v.position, v.heading, v.size[:, 0], v.size[:, 1])
        corners = to_vehicle_frame(boxes.reshape(-1, 2), v.position[vehicle], v.heading[vehicle])
        inside = (np.abs(corners.reshape(-1, 4, 2)) < EXTENT / 2 - 1).all((1, 2))
        place = to_vehicle_frame(v.position, v.position[vehicle], v.heading[vehicle])
        role = np.full(len(v), "other", dtype=object)
        role[TARGET], role[vehicle] = "target", "this"
        for kind, colour in COLOURS.items():
            seen, there = read_vehicles(image, colour), place[inside & (role == kind)]
            gap = np.hypot(*(seen[:, None] - there).transpose(2, 0, 1)) if len(seen) else np.zeros((0, len(there)))
            assert not len(there) or gap.min(0).max() < NEAR, kind
            assert len(seen) <= ((role == kind) & (np.abs(place) < EXTENT / 2 + 10).all(1)).sum()  # and nothing that is none


def test_the_reader_can_fail(drawn):
    """Without it, the audit would prove nothing: a disc over a vehicle, a number too many, and both are noticed."""
    *_, data, marks = drawn[0]
    image = decoded(data).copy()
    cv2.circle(image, (384, 384), 13, bird_eye._DISC, -1)
    assert not len(read_vehicles(image, COLOURS["this"])) or np.hypot(*read_vehicles(image, COLOURS["this"])[0]) > NEAR

    image = decoded(data).copy()
    free = next(x for x in range(60, 700, 30) if np.hypot(*(marks.disc - (x, 60)).T).min() > 40)
    cv2.circle(image, (free, 60), 13, bird_eye._DISC, -1, cv2.LINE_AA)
    cv2.putText(image, "37", (free - 9, 66), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (255, 255, 255), 1, cv2.LINE_AA)
    numbers = sorted(number for number, _ in read_numbers(image))
    assert numbers == sorted([*(number for number, _ in read_numbers(decoded(data))), 37])
