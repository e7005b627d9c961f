"""The picture in a question about goals: as far as the places reach, and nothing on it covers a vehicle or a signal.

The paper's window of 200 m x 200 m is the least; where places lie farther (who drives 35 m/s may be 400 m on) the window grows
that way alone, at the same number of pixels. Numbered discs stand beside the road where they can, each tied to the dot of its
place; letters stand beside the vehicles that the question's words speak of. Discs, letters and ticks are placed clear of all
that they explain, ties and dots lie beneath it: the test measures what is hidden.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import Floats
from drivegen.core.roadmap import LaneControl
from drivegen.core.scenario import TARGET, Scenario
from drivegen.render.bird_eye import Colour, Picture, View, draw_roads, fixed, point
from drivegen.render.goal_window import STEP, Boxes, Reach, signal_bars
from drivegen.render.marks import place_marks
from drivegen.render.stop_lines import shown_stop_lines

# Colours are red, green, blue.
GROUND: Colour = (232, 236, 228)
OTHER: Colour = (40, 90, 190)
TARGETED: Colour = (240, 130, 0)
ASKED: Colour = (200, 0, 130)
ACTOR: Colour = (120, 60, 150)
DARK: Colour = (25, 25, 30)
TIE: Colour = (95, 95, 105)
LIGHT: Colour = (255, 255, 255)
THIN = 3.0
"""Below so many pixels per metre the lines of speed are thin."""

_SHIFT, _FONT = 4, cv2.FONT_HERSHEY_SIMPLEX
_RADIUS, _DIGIT, _LETTER, _TICK = 11, 0.42, 0.42, 0.36
_DOT = 3


@dataclass(frozen=True)
class GoalMarks:
    """Where numbers went: disc centres and the places they mark (P, 2) [px]; where letters went, by vehicle [px]."""

    disc: NDArray[np.float64]
    place: NDArray[np.float64]
    letter: dict[int, NDArray[np.float64]]


def draw_goal_picture(
    scenario: Scenario, vehicle: int, position: Floats, letters: Mapping[int, str], reach: Reach, pixels: int = 768
) -> tuple[Picture, GoalMarks]:
    """The picture (H, W, 3) uint8 red-green-blue at the first frame, about `pixels`² of it, and where the marks are.

    Place i is at `position[i]` (P, 2) [m] and is numbered i. `letters` name vehicles, by their number; context actors that are
    there at step 0 follow the vehicles.
    """
    view = reach.view(scenario, vehicle, pixels)
    picture: Picture = np.empty((int(view.size[1]), int(view.size[0]), 3), np.uint8)
    picture[:] = GROUND
    draw_roads(picture, scenario.map, view)
    boxes = Boxes.of(scenario, view)
    bars = signal_bars(scenario, view)
    marks = _placed(view, reach, np.asarray(position, np.float64), letters, boxes, bars)
    _draw_ticks(picture, view, reach)
    _draw_ties(picture, marks, boxes)
    _draw_stop_lines(picture, scenario, view)
    for ends, colour in bars:
        cv2.line(picture, point(ends[0]), point(ends[1]), colour, 4, cv2.LINE_8, _SHIFT)
    _draw_vehicles(picture, scenario, vehicle, boxes, view.scale)
    _draw_marks(picture, marks, letters)
    return picture, marks


def _placed(
    view: View,
    reach: Reach,
    position: Floats,
    letters: Mapping[int, str],
    boxes: Boxes,
    bars: list[tuple[NDArray[np.float64], Colour]],
) -> GoalMarks:
    """Letters near their vehicles, then discs near their places, all clear of what they explain and of one another."""
    place = view.pixels(position)
    seen = _seen(boxes.around, view.size)
    lines = _along(boxes.front[seen], boxes.next[seen])
    ends = np.stack([bar for bar, _ in bars]) if bars else np.zeros((0, 2, 2))
    lights = np.concatenate([ends.min(1) - 2, ends.max(1) + 2], axis=-1)
    dots = np.concatenate([place - _DOT, place + _DOT], axis=-1)
    taken = np.concatenate([boxes.around[seen], lights, lines, dots, [box for _, _, box in _ticks(view, reach)]])
    named = np.array(list(letters), int)
    half = np.array([_half(word) for word in letters.values()]).reshape(-1, 2)
    where = place_marks(boxes.corners[named].mean(1), half, 1, view.size, taken)
    taken = np.concatenate([taken, np.concatenate([where - half, where + half], axis=-1)])
    radius = np.full((len(place), 2), float(_RADIUS))
    disc = place_marks(place, radius, 2, view.size, taken)
    return GoalMarks(disc, place, dict(zip(letters, where, strict=True)))


def _half(word: str) -> tuple[float, float]:
    wide, high = cv2.getTextSize(word, _FONT, _LETTER, 1)[0]
    return wide / 2 + 1, high / 2 + 1


def _seen(around: NDArray[np.float64], size: NDArray[np.int64]) -> NDArray[np.bool_]:
    """(B,) boxes (B, 4) that touch the window."""
    return np.asarray(((around[:, 2:] >= 0) & (around[:, :2] <= size)).all(-1))


def _along(start: NDArray[np.float64], end: NDArray[np.float64], every: float = 8.0) -> NDArray[np.float64]:
    """(Q, 4) small boxes along lines (B, 2) to (B, 2): one around each would be as large as the line is long."""
    parts = []
    for a, b in zip(start, end, strict=True):
        share = np.linspace(0, 1, int(np.hypot(*(b - a)) // every) + 2)[:, None]
        dots = a + share * (b - a)
        parts.append(np.concatenate([dots - 1, dots + 1], axis=-1))
    return np.concatenate(parts) if parts else np.zeros((0, 4))


def _draw_ties(picture: Picture, marks: GoalMarks, boxes: Boxes) -> None:
    """Lines from discs to the dots at their places, from letters to vehicles."""
    for vehicle, letter in marks.letter.items():
        cv2.line(picture, point(boxes.corners[vehicle].mean(0)), point(letter), TIE, 1, cv2.LINE_AA, _SHIFT)
    for place, disc in zip(marks.place, marks.disc, strict=True):
        cv2.line(picture, point(place), point(disc), TIE, 1, cv2.LINE_AA, _SHIFT)
    for place in marks.place:
        cv2.circle(picture, point(place), _DOT << _SHIFT, DARK, cv2.FILLED, cv2.LINE_AA, _SHIFT)


def _draw_stop_lines(picture: Picture, scenario: Scenario, view: View) -> None:
    """White bars where one may have to wait without a signal."""
    for ends, control in shown_stop_lines(scenario.map):
        if control != LaneControl.SIGNAL:
            a, b = view.pixels(ends)
            cv2.line(picture, point(a), point(b), LIGHT, 3, cv2.LINE_8, _SHIFT)


def _draw_vehicles(picture: Picture, scenario: Scenario, vehicle: int, boxes: Boxes, scale: float) -> None:
    """Each with a pointed front and, from it, a line to where that is in a second: who stands has none."""
    count = len(scenario.vehicles)
    front, outlines = boxes.front, boxes.outlines
    for i in range(len(front)):
        cv2.line(picture, point(front[i]), point(boxes.next[i]), DARK, 1 if scale < THIN else 2, cv2.LINE_AA, _SHIFT)
    for i in [*range(vehicle), *range(vehicle + 1, len(front)), vehicle]:
        colour = ACTOR if i >= count else TARGETED if i == TARGET else OTHER
        outline = fixed(outlines[i])
        cv2.fillConvexPoly(picture, outline, ASKED if i == vehicle else colour, cv2.LINE_AA, _SHIFT)
        cv2.polylines(picture, [outline], True, LIGHT if i == vehicle else DARK, 1, cv2.LINE_AA, _SHIFT)


def _ticks(view: View, reach: Reach) -> list[tuple[float, str, NDArray[np.float64]]]:
    """Heights [px] of the ticks along the left border, their words and boxes (4,) [px]."""
    ticks = []
    for metres in np.arange(-reach.back + STEP, reach.forward, STEP).tolist():
        y = float(view.middle[1] - metres * view.scale)
        word = f"{abs(metres):.0f} m" + (" behind" if metres < 0 else " ahead" if metres > 0 else "")
        ticks.append((y, word, np.array([0.0, y - 7, cv2.getTextSize(word, _FONT, _TICK, 1)[0][0] + 14.0, y + 7])))
    return ticks


def _draw_ticks(picture: Picture, view: View, reach: Reach) -> None:
    """How far ahead and behind, along the left border."""
    for y, word, _ in _ticks(view, reach):
        cv2.line(picture, (0, round(y)), (8, round(y)), DARK, 1, cv2.LINE_8)
        cv2.putText(picture, word, (11, round(y) + 4), _FONT, _TICK, DARK, 1, cv2.LINE_AA)


def _draw_marks(picture: Picture, marks: GoalMarks, letters: Mapping[int, str]) -> None:
    """Letters, then discs with their numbers."""
    for vehicle, word in letters.items():
        _write(picture, word, marks.letter[vehicle], _LETTER, DARK)
    for i, centre in enumerate(marks.disc):
        cv2.circle(picture, point(centre), _RADIUS << _SHIFT, DARK, cv2.FILLED, cv2.LINE_AA, _SHIFT)
        _write(picture, str(i), centre, _DIGIT, LIGHT)


def _write(picture: Picture, word: str, centre: NDArray[np.float64], size: float, colour: Colour) -> None:
    wide, high = cv2.getTextSize(word, _FONT, size, 1)[0]
    cv2.putText(picture, word, (round(centre[0] - wide / 2), round(centre[1] + high / 2)), _FONT, size, colour, 1, cv2.LINE_AA)
