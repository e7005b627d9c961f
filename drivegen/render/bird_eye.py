"""Candidate goals from above, as question goals-1 and recordings show them: 200 m x 200 m around one vehicle, its heading up,
its candidate goals numbered.

Paper, "Scenario Rollout". Marks as in Set-of-Mark prompting (Yang et al., 2023): dark discs, white digits, no overlaps,
a line from a disc that had to move to its place. Goals outside the window sit on its border with their distance and lane.
Discs cover no vehicle: whatever is in the window can be read from the pixels alone, and a test does.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import Floats, Polylines, box_corners, to_vehicle_frame, unit
from drivegen.core.roadmap import LaneKind, RoadMap
from drivegen.core.scenario import TARGET, Scenario
from drivegen.core.signals import SignalState
from drivegen.render.marks import place_marks

Picture = NDArray[np.uint8]
Colour = tuple[int, int, int]

EXTENT = 200.0
"""Side of the window [m]."""

# Colours are red, green, blue.
_GROUND: Colour = (232, 236, 228)
_ASPHALT: Colour = (186, 186, 190)
_BUS: Colour = (196, 180, 160)
_BIKE: Colour = (206, 214, 200)
_EDGE: Colour = (250, 250, 250)
_CENTRE: Colour = (140, 140, 146)
_OTHER: Colour = (70, 110, 180)
_TARGET: Colour = (230, 140, 20)
_THIS: Colour = (200, 0, 130)  # not red: red is a signal's
_ACTOR: Colour = (120, 60, 150)
_DISC: Colour = (25, 25, 30)
_SPEED: Colour = (60, 60, 66)
_WHITE: Colour = (255, 255, 255)
_SIGNALS: dict[int, Colour] = {
    SignalState.GREEN: (30, 170, 60),
    SignalState.YELLOW: (240, 190, 0),
    SignalState.RED: (220, 20, 20),
}

_SHIFT = 4
_FAR = 20000
_FONT = cv2.FONT_HERSHEY_SIMPLEX
_RADIUS = 13
_GAP = 2
_DIGIT_SIZE, _NOTE_SIZE = 0.5, 0.35
_SMALLEST = 0.8
"""People are drawn at least this wide [m]."""

_SCALE_BAR = (14.0, 130.0, 24.0)
"""Left and right end of the scale bar and its words, and their height above the lower border [px]."""


@dataclass(frozen=True)
class Marks:
    """Where the numbers went: disc centres (C, 2) [px], the places they mark (C, 2) [px], whether those are in the window."""

    disc: NDArray[np.float64]
    place: NDArray[np.float64]
    inside: NDArray[np.bool_]


@dataclass(frozen=True)
class View:
    """A window: pose of the vehicle whose heading is up, pixels per metre.

    Attributes:
        size: (2,) its width and height [px]. middle: (2,) where the vehicle is in it [px].
    """

    position: Floats
    heading: float
    scale: float
    size: NDArray[np.int64]
    middle: NDArray[np.float64]

    @classmethod
    def around(cls, position: Floats, heading: float, size: int) -> "View":
        """A square one of EXTENT, with the vehicle in its middle."""
        return cls(position, heading, size / EXTENT, np.array([size, size]), np.array([size / 2, size / 2]))

    def pixels(self, points: Floats) -> NDArray[np.float64]:
        """Pixel coordinates (..., 2): forward is up, left is left."""
        flat = np.asarray(points, np.float64).reshape(-1, 2)
        local = to_vehicle_frame(flat, np.asarray(self.position, np.float64), np.asarray(self.heading))
        return np.asarray(self.middle - local[:, ::-1] * self.scale, np.float64).reshape(*points.shape)


def draw_bird_eye(
    scenario: Scenario, vehicle: int, position: Floats, lane: NDArray[np.integer], size: int = 768
) -> tuple[Picture, Marks]:
    """The picture (size, size, 3) uint8 red-green-blue at the first frame, and where the numbers are.

    Candidate i is at `position[i]` (C, 2) [m] on lane `lane[i]` (-1 for none) and is numbered i.
    """
    v = scenario.vehicles
    view = View.around(v.position[vehicle], float(v.heading[vehicle]), size)
    picture: Picture = np.empty((size, size, 3), np.uint8)
    cv2.rectangle(picture, (0, 0), (size, size), _GROUND, cv2.FILLED)
    draw_roads(picture, scenario.map, view)
    _draw_signals(picture, scenario, view)
    boxes = _boxes(scenario, view)
    marks, notes = _placed(view, np.asarray(position, np.float64), lane, boxes)
    _draw_ties(picture, marks)
    _draw_vehicles(picture, scenario, vehicle, boxes)
    _draw_scale_bar(picture, view)
    _draw_discs(picture, marks, notes)
    return picture, marks


@dataclass(frozen=True)
class _Boxes:
    """Everybody at the first frame: corners (B, 4, 2) [px] from front left, and where each is one second later (B, 2) [px]."""

    corners: NDArray[np.float64]
    next: NDArray[np.float64]


def _boxes(scenario: Scenario, view: View) -> _Boxes:
    """Vehicles, then the context actors that are there."""
    now, count = scenario.present(), len(scenario.vehicles)
    size = np.concatenate([now.size[:count], np.maximum(now.size[count:], _SMALLEST)])
    corners = box_corners(now.position, now.heading, size[:, 0], size[:, 1])
    return _Boxes(view.pixels(corners), view.pixels(now.position + now.speed[:, None] * unit(now.heading)))


def fixed(points: Floats) -> NDArray[np.int32]:
    """Fixed point for OpenCV; far points are clipped, since it overflows."""
    return np.rint(np.clip(points, -_FAR, _FAR) * (1 << _SHIFT)).astype(np.int32)


def _seen(lines: Polylines, pixels: NDArray[np.float64], size: NDArray[np.int64]) -> NDArray[np.bool_]:
    """(L,) lines whose bounding box touches the window."""
    if len(lines) == 0:
        return np.zeros(0, np.bool_)
    first = lines.start[:-1]
    low, high = np.minimum.reduceat(pixels, first), np.maximum.reduceat(pixels, first)
    return np.asarray(((high >= 0) & (low <= size)).all(-1))


def draw_roads(picture: Picture, road_map: RoadMap, view: View) -> None:
    """Surfaces, boundaries, centrelines with arrows."""
    pixels = {name: view.pixels(getattr(road_map, name).points) for name in ("drivable", "left", "right", "centreline")}
    drawn = {name: fixed(points) for name, points in pixels.items()}

    def part(name: str, i: int) -> NDArray[np.int32]:
        start = getattr(road_map, name).start
        return drawn[name][start[i] : start[i + 1]]

    for i in np.flatnonzero(_seen(road_map.drivable, pixels["drivable"], view.size)).tolist():
        cv2.fillPoly(picture, [part("drivable", i)], _ASPHALT, cv2.LINE_8, _SHIFT)
    lanes = np.flatnonzero(_seen(road_map.centreline, pixels["centreline"], view.size)).tolist()
    for i in lanes:
        colour = {LaneKind.BUS: _BUS, LaneKind.BIKE: _BIKE}.get(LaneKind(road_map.kind[i]), _ASPHALT)
        cv2.fillPoly(picture, [np.concatenate([part("left", i), part("right", i)[::-1]])], colour, cv2.LINE_8, _SHIFT)
    plain = [i for i in lanes if not road_map.in_junction[i]]
    edges = [part(side, i) for side in ("left", "right") for i in plain]
    cv2.polylines(picture, edges, False, _EDGE, 1, cv2.LINE_8, _SHIFT)
    cv2.polylines(picture, [part("centreline", i) for i in lanes], False, _CENTRE, 1, cv2.LINE_8, _SHIFT)
    arrows = fixed(_arrows(pixels["centreline"], road_map.centreline.start, np.array(lanes, int)))
    cv2.polylines(picture, list(arrows), False, _CENTRE, 1, cv2.LINE_8, _SHIFT)


def _arrows(pixels: NDArray[np.float64], start: NDArray[np.int32], lanes: NDArray[np.integer]) -> NDArray[np.float64]:
    """Chevrons (L, 3, 2) in the middle of lanes, pointing the way they run."""
    middle = (start[lanes] + start[lanes + 1]) // 2
    tip, step = pixels[middle], pixels[middle] - pixels[middle - 1]
    forward = step / np.maximum(np.hypot(step[:, 0], step[:, 1]), 1e-6)[:, None]
    left = np.stack([forward[:, 1], -forward[:, 0]], axis=-1)
    return np.stack([tip - 5 * forward + 4 * left, tip, tip - 5 * forward - 4 * left], axis=1)


def _draw_signals(picture: Picture, scenario: Scenario, view: View) -> None:
    """A coloured bar where each guarded lane begins."""
    lines = scenario.map.centreline
    for lane, state in zip(scenario.signals.lane.tolist(), scenario.signals.state[:, 0].tolist(), strict=True):
        if state not in _SIGNALS:
            continue
        a, b = view.pixels(lines[lane][:2])
        step = (b - a) / max(float(np.hypot(*(b - a))), 1e-6)
        across = np.array([step[1], -step[0]]) * 1.4 * view.scale
        cv2.line(picture, point(a - across), point(a + across), _SIGNALS[state], 3, cv2.LINE_8, _SHIFT)


def _draw_vehicles(picture: Picture, scenario: Scenario, vehicle: int, boxes: _Boxes) -> None:
    """This vehicle magenta, the target orange, others blue, context actors violet.

    Each has a white outline, thick at the front, and a thin line to where it will be in a second.
    """
    count = len(scenario.vehicles)
    corners, ahead = fixed(boxes.corners), fixed(boxes.next)
    middle = fixed(boxes.corners.mean(1))
    for i in range(len(corners)):
        cv2.line(picture, middle[i].tolist(), ahead[i].tolist(), _SPEED, 1, cv2.LINE_8, _SHIFT)
    for i in [*range(vehicle), *range(vehicle + 1, len(corners)), vehicle]:
        colour = _ACTOR if i >= count else _OTHER
        colour = _THIS if i == vehicle else _TARGET if i == TARGET else colour
        cv2.fillConvexPoly(picture, corners[i], colour, cv2.LINE_AA, _SHIFT)
        cv2.polylines(picture, [corners[i]], True, _WHITE, 1, cv2.LINE_AA, _SHIFT)
        cv2.line(picture, corners[i][0].tolist(), corners[i][3].tolist(), _WHITE, 2, cv2.LINE_AA, _SHIFT)


def _placed(view: View, position: Floats, lane: NDArray[np.integer], boxes: _Boxes) -> tuple[Marks, list[str]]:
    """Where discs go, clear of vehicles and the scale bar, and what is written beside those at the border."""
    place = view.pixels(position)
    size = int(view.size[0])
    middle = size / 2
    inside = np.asarray((np.abs(place - middle) <= middle).all(-1))
    onto_border = np.maximum(np.abs(place - middle).max(-1, keepdims=True) / middle, 1.0)
    distance = np.hypot(*(position - view.position).T)
    notes = ["" if inside[i] else _note(distance[i], int(lane[i])) for i in range(len(place))]
    width = np.array([cv2.getTextSize(note, _FONT, _NOTE_SIZE, 1)[0][0] + 4 if note else 0 for note in notes])
    half = np.stack([_RADIUS + width / 2, np.full(len(place), float(_RADIUS))], axis=-1)
    first = np.argsort(~inside, kind="stable")  # those at the border make way
    mark = np.empty_like(place)
    mark[first] = place_marks((middle + (place - middle) / onto_border)[first], half[first], _GAP, size, _taken(view, boxes))
    disc = mark - np.stack([width / 2, np.zeros(len(place))], axis=-1)
    return Marks(disc, place, inside), notes


def _taken(view: View, boxes: _Boxes) -> NDArray[np.float64]:
    """(B, 4) low x, low y, high x, high y [px] of what no disc may cover."""
    around = np.concatenate([boxes.corners.min(1), boxes.corners.max(1)], axis=-1)
    left, right, height = _SCALE_BAR
    return np.concatenate([around, [[left, view.size[1] - height, right, view.size[1]]]])


def _draw_ties(picture: Picture, marks: Marks) -> None:
    """Dots at the places, lines from discs that moved."""
    for i in np.flatnonzero(marks.inside).tolist():
        cv2.circle(picture, point(marks.place[i]), 3 << _SHIFT, _DISC, cv2.FILLED, cv2.LINE_8, _SHIFT)
        cv2.line(picture, point(marks.place[i]), point(marks.disc[i]), _DISC, 1, cv2.LINE_8, _SHIFT)


def _draw_discs(picture: Picture, marks: Marks, notes: list[str]) -> None:
    """Discs with their numbers on top of everything, notes of those at the border."""
    for i, centre in enumerate(marks.disc):
        cv2.circle(picture, point(centre), _RADIUS << _SHIFT, _DISC, cv2.FILLED, cv2.LINE_AA, _SHIFT)
        (wide, high), _ = cv2.getTextSize(str(i), _FONT, _DIGIT_SIZE, 1)
        corner = (round(centre[0] - wide / 2), round(centre[1] + high / 2))
        cv2.putText(picture, str(i), corner, _FONT, _DIGIT_SIZE, _WHITE, 1, cv2.LINE_AA)
        corner = (round(centre[0]) + _RADIUS + 3, round(centre[1]) + 4)
        cv2.putText(picture, notes[i], corner, _FONT, _NOTE_SIZE, _DISC, 1, cv2.LINE_AA)


def _note(distance: float, lane: int) -> str:
    """Distance and lane of a goal outside the window."""
    return f"{distance:.0f} m" + (f" L{lane}" if lane >= 0 else "")


def _draw_scale_bar(picture: Picture, view: View) -> None:
    """20 m at the bottom left."""
    y, x = int(view.size[1]) - 14, 14
    end = round(x + 20 * view.scale)
    for a, b in (((x, y), (end, y)), ((x, y - 4), (x, y + 4)), ((end, y - 4), (end, y + 4))):
        cv2.line(picture, a, b, _DISC, 1, cv2.LINE_8)
    cv2.putText(picture, "20 m", (end + 6, y + 4), _FONT, 0.4, _DISC, 1, cv2.LINE_AA)


def point(pixel: NDArray[np.float64]) -> tuple[int, int]:
    """A pixel (2,) in OpenCV's fixed point."""
    x, y = fixed(pixel).tolist()
    return x, y
