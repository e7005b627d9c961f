"""A picture of a road map that a person can judge: lanes with directions, markings, stop lines, signals, scale bar.

North is up. A large map gets a close-up of its busiest junction beside the overview. Drawn by OpenCV with sub-pixel
coordinates; the same map gives the same pixels.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from drivegen.core.geometry import Floats, arc_length, interpolate
from drivegen.core.roadmap import NO_LANE, LaneControl, LaneKind, RoadMap
from drivegen.render.stop_lines import shown_stop_lines

Picture = NDArray[np.uint8]
Colour = tuple[int, int, int]

# Colours are blue, green, red.
_GROUND: Colour = (206, 222, 214)
_ASPHALT: Colour = (92, 88, 86)
_JUNCTION: Colour = (104, 100, 98)
_BUS: Colour = (84, 84, 128)
_BIKE: Colour = (104, 126, 96)
_WHITE: Colour = (245, 245, 245)
_YELLOW: Colour = (70, 200, 245)
_WAY: Colour = (150, 146, 144)
_INK: Colour = (45, 45, 45)
_CONTROL_COLOURS: dict[int, Colour] = {
    LaneControl.SIGNAL: (80, 190, 60),
    LaneControl.STOP: (40, 40, 210),
    LaneControl.YIELD: (30, 150, 250),
}
_CONTROL_NAMES = {LaneControl.SIGNAL: "signal", LaneControl.STOP: "stop", LaneControl.YIELD: "yield"}

_SHIFT = 4
_WIDEST, _HIGHEST = 1500, 1100
_MARGIN = 15.0
_ARROW_SPACING = 40.0
_CLOSE_UP = 55.0
_CLOSE_UP_BELOW = 4.5


@dataclass(frozen=True)
class _View:
    """A window on the map: `low` (2,) its south-west corner [m], `scale` [pixels per metre], size in pixels."""

    low: Floats
    scale: float
    width: int
    height: int

    def pixels(self, points: Floats) -> NDArray[np.int32]:
        """Pixel coordinates (..., 2) in fixed point for OpenCV."""
        flipped = np.stack([points[..., 0] - self.low[0], self.height / self.scale - (points[..., 1] - self.low[1])], -1)
        clipped = np.clip(flipped * self.scale, -20000, 20000)
        return np.round(clipped * (1 << _SHIFT)).astype(np.int32)

    def sees(self, line: Floats) -> bool:
        """Whether the line's bounding box touches the window."""
        high = self.low + np.array([self.width, self.height]) / self.scale
        return bool((line.max(0) >= self.low).all() and (line.min(0) <= high).all())


def draw_map(road_map: RoadMap, caption: str) -> Picture:
    """The picture (H, W, 3) uint8, blue-green-red, at most `_WIDEST` pixels wide, with `caption` below."""
    points = road_map.centreline.points
    low, high = points.min(0) - _MARGIN, points.max(0) + _MARGIN
    extent = high - low
    scale = float(min(_WIDEST / extent[0], _HIGHEST / extent[1], 10.0))
    size = np.maximum(np.ceil(extent * scale), [640.0, 300.0])
    centred = (low + high) / 2 - size / scale / 2
    overview = _View(centred, scale, int(size[0]), int(size[1]))
    picture = _draw(road_map, overview)
    if scale < _CLOSE_UP_BELOW:
        picture = _with_close_up(road_map, overview, picture)
    return _captioned(picture, caption)


def _draw(road_map: RoadMap, view: _View) -> Picture:
    picture = np.full((view.height, view.width, 3), _GROUND, np.uint8)
    seen = [i for i in range(len(road_map)) if view.sees(road_map.centreline[i])]
    _draw_surfaces(picture, road_map, view, seen)
    _draw_ways(picture, road_map, view, [i for i in seen if road_map.in_junction[i]])
    lanes = [i for i in seen if not road_map.in_junction[i]]
    _draw_crossings(picture, road_map, view)
    _draw_markings(picture, road_map, view, lanes)
    _draw_arrows(picture, road_map, view, lanes)
    _draw_stops(picture, road_map, view)
    _draw_scale_bar(picture, view)
    return picture


def _draw_surfaces(picture: Picture, road_map: RoadMap, view: _View, seen: list[int]) -> None:
    for outline in road_map.drivable.lines():
        _fill(picture, view, outline, _ASPHALT)
    for i in sorted(seen, key=lambda i: not road_map.in_junction[i]):
        ground = (
            _JUNCTION if road_map.in_junction[i] else {LaneKind.BUS: _BUS, LaneKind.BIKE: _BIKE}.get(road_map.kind[i], _ASPHALT)
        )
        _fill(picture, view, np.concatenate([road_map.left[i], road_map.right[i][::-1]]), ground)


def _draw_ways(picture: Picture, road_map: RoadMap, view: _View, ways: list[int]) -> None:
    for i in ways:
        _line(picture, view, road_map.centreline[i], _WAY, 0.12)


def _draw_crossings(picture: Picture, road_map: RoadMap, view: _View) -> None:
    for corners in road_map.crossings.lines():
        if len(corners) == 4 and view.sees(corners):
            for share in np.arange(0.05, 0.95, 0.12):
                a = corners[0] + share * (corners[1] - corners[0])
                b = corners[3] + share * (corners[2] - corners[3])
                _line(picture, view, np.stack([a, b]), _WHITE, 0.35)


def _draw_markings(picture: Picture, road_map: RoadMap, view: _View, lanes: list[int]) -> None:
    """Edge lines solid, lines between lanes of one direction dashed, between directions yellow."""
    for i in lanes:
        for side, line in ((0, road_map.left[i]), (1, road_map.right[i])):
            if road_map.neighbour[i, side] == NO_LANE:
                _line(picture, view, line, _WHITE, 0.18)
            elif not road_map.same_direction[i, side]:
                _line(picture, view, line, _YELLOW, 0.22)
            elif side == 0:
                _dashes(picture, view, line)


def _dashes(picture: Picture, view: _View, line: Floats) -> None:
    total = float(arc_length(line)[-1])
    for start in np.arange(1.0, total - 1.0, 9.0):
        ends = np.linspace(start, min(start + 3.0, total), 4).astype(line.dtype)
        _line(picture, view, interpolate(line, ends), _WHITE, 0.15)


def _draw_arrows(picture: Picture, road_map: RoadMap, view: _View, lanes: list[int]) -> None:
    size = max(4.0, 9.0 / view.scale)
    for i in lanes:
        line = road_map.centreline[i]
        total = float(arc_length(line)[-1])
        if total < 2 * size:
            continue
        count = max(1, int(total / max(_ARROW_SPACING, 70 / view.scale)))
        places = (np.arange(count) + 0.5) / count * total
        middle = interpolate(line, places.astype(line.dtype))
        ahead = interpolate(line, np.minimum(places + 1.0, total).astype(line.dtype)) - middle
        for at, heading in zip(middle, np.arctan2(ahead[:, 1], ahead[:, 0]), strict=True):
            _arrow(picture, view, at, float(heading), size)


def _arrow(picture: Picture, view: _View, at: Floats, heading: float, size: float) -> None:
    forward = np.array([np.cos(heading), np.sin(heading)])
    left = np.array([-forward[1], forward[0]])
    _line(picture, view, np.stack([at - forward * size / 2, at + forward * size * 0.15]), _WHITE, 0.25)
    tip, wing = at + forward * size / 2, min(size * 0.22, 1.1)
    base = at + forward * size * 0.05
    _fill(picture, view, np.stack([tip, base + left * wing, base - left * wing]), _WHITE)


def _draw_stops(picture: Picture, road_map: RoadMap, view: _View) -> None:
    """Stop lines, and a dot for what holds there on each of them."""
    for ends, control in shown_stop_lines(road_map):
        if not view.sees(ends):
            continue
        _line(picture, view, ends, _WHITE, 0.5)
        if control in _CONTROL_COLOURS:
            radius = int(max(0.75 * view.scale, 3.0) * (1 << _SHIFT))
            middle = view.pixels(ends.mean(0))
            cv2.circle(picture, middle.tolist(), radius + 24, _INK, -1, cv2.LINE_AA, _SHIFT)
            cv2.circle(picture, middle.tolist(), radius, _CONTROL_COLOURS[control], -1, cv2.LINE_AA, _SHIFT)


def _draw_scale_bar(picture: Picture, view: _View) -> None:
    metres = next(m for m in (10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10**6) if m * view.scale >= 90)
    right, y = view.width - 20, view.height - 16
    left = int(right - metres * view.scale)
    cv2.rectangle(picture, (left - 8, y - 26), (right + 8, y + 10), _WHITE, -1)
    cv2.line(picture, (left, y), (right, y), _INK, 2, cv2.LINE_AA)
    for x in (left, right):
        cv2.line(picture, (x, y - 5), (x, y + 5), _INK, 2, cv2.LINE_AA)
    _text(picture, f"{metres} m", (left + 4, y - 8), 0.5)


def _with_close_up(road_map: RoadMap, overview: _View, picture: Picture) -> Picture:
    """The overview with a close-up of the busiest junction below it, and a frame where that is."""
    middle = _busiest_place(road_map)
    if middle is None:
        return picture
    scale, height = 8.0, 560
    size = np.array([picture.shape[1], height]) / scale
    view = _View(middle - size / 2, scale, picture.shape[1], height)
    corners = np.stack([view.low, view.low + size])
    a, b = overview.pixels(corners)
    cv2.rectangle(picture, a.tolist(), b.tolist(), (200, 60, 160), 2, cv2.LINE_AA, _SHIFT)
    rule = np.full((6, picture.shape[1], 3), (200, 60, 160), np.uint8)
    return np.concatenate([picture, rule, _draw(road_map, view)])


def _busiest_place(road_map: RoadMap) -> Floats | None:
    """Middle of the place (2,) [m] with most ways across a junction within reach; None without junctions."""
    ways = np.flatnonzero(road_map.in_junction & road_map.for_vehicles)
    if not len(ways):
        return None
    middles = np.stack([road_map.centreline[int(i)].mean(0) for i in ways])
    tree = cKDTree(middles)
    best = int(np.argmax(tree.query_ball_point(middles, _CLOSE_UP, return_length=True)))
    place: Floats = middles[sorted(tree.query_ball_point(middles[best], _CLOSE_UP))].mean(0)
    return place


def _captioned(picture: Picture, caption: str) -> Picture:
    """The caption and the key to the dots below the picture."""
    strip = np.full((64, picture.shape[1], 3), 255, np.uint8)
    plain = caption.encode("ascii", "replace").decode()
    room = int(picture.shape[1] / 9.5)
    _text(strip, plain if len(plain) <= room else plain[: room - 3] + "...", (14, 25), 0.55)
    x = 20
    for control, colour in _CONTROL_COLOURS.items():
        cv2.circle(strip, (x, 47), 6, colour, -1, cv2.LINE_AA)
        _text(strip, _CONTROL_NAMES[LaneControl(control)], (x + 12, 52), 0.45)
        x += 95
    _text(strip, "north is up", (x + 10, 52), 0.45)
    return np.concatenate([picture, strip])


def _text(picture: Picture, text: str, at: tuple[int, int], size: float) -> None:
    cv2.putText(picture, text, at, cv2.FONT_HERSHEY_SIMPLEX, size, _INK, 1, cv2.LINE_AA)


def _line(picture: Picture, view: _View, line: Floats, colour: Colour, width: float) -> None:
    thickness = max(1, round(width * view.scale))
    cv2.polylines(picture, [view.pixels(line)], False, colour, thickness, cv2.LINE_AA, _SHIFT)


def _fill(picture: Picture, view: _View, outline: Floats, colour: Colour) -> None:
    if len(outline) >= 3 and view.sees(outline):
        cv2.fillPoly(picture, [view.pixels(outline)], colour, cv2.LINE_AA, _SHIFT)
