"""A picture of one scenario from above: road, what was logged, K samples over one another, goals and rejects.

Colours: target orange, others blue, the log black and dashed, illegal samples red, what was planned and turned down before
them pale red, thin and dashed, goals violet. RGB, on white.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import Floats, box_corners
from drivegen.core.rejections import Rejected
from drivegen.core.roadmap import RoadMap
from drivegen.core.scenario import TARGET, Scenario, Trajectories
from drivegen.core.signals import SignalState
from drivegen.core.viewport import window

Image = NDArray[np.uint8]
Colour = tuple[int, int, int]

PAPER: Colour = (250, 250, 249)
ROAD: Colour = (226, 229, 234)
JUNCTION: Colour = (218, 222, 229)
EDGE: Colour = (190, 196, 205)
CROSSING: Colour = (170, 177, 188)
STOP: Colour = (120, 128, 140)
TARGET_COLOUR: Colour = (234, 105, 20)
SOCIAL_COLOUR: Colour = (37, 112, 196)
ACTOR_COLOUR: Colour = (96, 140, 30)
ILLEGAL_COLOUR: Colour = (214, 40, 70)
REJECTED_COLOUR: Colour = (246, 128, 152)
LOG_COLOUR: Colour = (30, 34, 40)
GOAL_COLOUR: Colour = (124, 66, 214)
SIGNAL_COLOURS = {SignalState.GREEN: (38, 166, 91), SignalState.YELLOW: (230, 170, 20), SignalState.RED: ILLEGAL_COLOUR}

NARROWEST, WIDEST = 60.0, 200.0
"""Of pictures [m]."""
_DASH = 5.0
"""Length of the dashes of what was rejected [pixels]."""
_SHIFT = 4
"""Fractional bits of OpenCV's pixel coordinates."""
_FAR = 20_000.0
"""Pixels beyond this are clipped, far outside any picture: OpenCV's fixed-point coordinates overflow."""


@dataclass(frozen=True)
class View:
    """A square window: `centre` (2,) [m], `width` [m] across, `pixels` across; +y is up."""

    centre: NDArray[np.floating]
    width: float
    pixels: int

    @property
    def scale(self) -> float:
        """Pixels a metre."""
        return self.pixels / self.width

    def fixed(self, points: Floats) -> NDArray[np.int32]:
        """World points (..., 2) as OpenCV's fixed-point pixels."""
        local = (points - self.centre) * self.scale * np.array([1.0, -1.0]) + self.pixels / 2
        fixed: NDArray[np.int32] = np.rint(np.clip(local, -_FAR, _FAR) * 2**_SHIFT).astype(np.int32)
        return fixed


def view_of(motion: Trajectories, pixels: int) -> View:
    """The window of the picture: see `drivegen.core.viewport`."""
    return View(*window(motion, NARROWEST, WIDEST), pixels)


def scene_picture(
    scenario: Scenario,
    samples: Trajectories | None,
    illegal: NDArray[np.bool_] | None = None,
    goals: Floats | None = None,
    pixels: int = 720,
    view: View | None = None,
    rejected: Rejected | None = None,
) -> Image:
    """(pixels, pixels, 3) of `scenario` with samples (K, N, T) over its log.

    `illegal` (K, N) draws those samples red; `goals` (C, 2) [m] are marked; what was `rejected` and
    replaced lies above the samples. Boxes stand at the first step. Without a `view` it is fitted to what moves.
    """
    if view is None:
        shown = [motion for motion in (scenario.log, samples) if motion is not None]
        view = view_of(shown[-1], pixels) if shown else View(scenario.vehicles.position[TARGET], 120.0, pixels)
    pixels = view.pixels
    image = np.full((pixels, pixels, 3), PAPER, np.uint8)
    _draw_roads(image, view, scenario.map)
    _draw_signals(image, view, scenario)
    if samples is not None:
        image = _draw_samples(image, view, samples, illegal)
    if rejected is not None:
        _draw_rejected(image, view, rejected)
    if scenario.log is not None:
        for i in range(len(scenario.vehicles)):
            for path in scenario.log[i].stretches():
                _draw_dashed(image, view, path, LOG_COLOUR)
    for goal in () if goals is None else goals:
        _draw_diamond(image, view, goal)
    _draw_boxes(image, view, scenario)
    _draw_scale_bar(image, view)
    return image


def _draw_roads(image: Image, view: View, roads: RoadMap) -> None:
    for outline in roads.drivable.lines():
        _fill(image, view, outline, ROAD)
    for lane in np.argsort(roads.in_junction, kind="stable"):
        ribbon = np.concatenate([roads.left[int(lane)], roads.right[int(lane)][::-1]])
        _fill(image, view, ribbon, JUNCTION if roads.in_junction[lane] else ROAD)
    for lane in np.flatnonzero(~roads.in_junction & roads.for_vehicles):
        for line in (roads.left[int(lane)], roads.right[int(lane)]):
            cv2.polylines(image, [view.fixed(line)], False, EDGE, 1, cv2.LINE_AA, _SHIFT)
    for outline in roads.crossings.lines():
        cv2.polylines(image, [view.fixed(outline)], True, CROSSING, 1, cv2.LINE_AA, _SHIFT)
    for line in roads.stop_lines:
        cv2.polylines(image, [view.fixed(line)], False, STOP, 2, cv2.LINE_AA, _SHIFT)


def _draw_signals(image: Image, view: View, scenario: Scenario) -> None:
    for lane, states in zip(scenario.signals.lane, scenario.signals.state, strict=True):
        colour = SIGNAL_COLOURS.get(SignalState(int(states[0])))
        if colour is not None:
            bar = np.stack([scenario.map.left[int(lane)][0], scenario.map.right[int(lane)][0]])
            cv2.polylines(image, [view.fixed(bar)], False, colour, 3, cv2.LINE_AA, _SHIFT)


def _draw_samples(image: Image, view: View, samples: Trajectories, illegal: NDArray[np.bool_] | None) -> Image:
    """Lines of all samples, half transparent, so that where many agree is darker; illegal ones last, on top."""
    worlds, vehicles = samples.valid.shape[:2]
    bad = np.zeros((worlds, vehicles), np.bool_) if illegal is None else illegal
    strength = 0.35 if worlds > 1 else 0.9
    for red in (False, True):
        for world in range(worlds):
            layer = image.copy()
            for i in np.flatnonzero(bad[world] == red):
                base = TARGET_COLOUR if i == TARGET else SOCIAL_COLOUR
                colour = ILLEGAL_COLOUR if red else base
                paths = samples[world, i].stretches()
                cv2.polylines(layer, [view.fixed(path) for path in paths], False, colour, 2, cv2.LINE_AA, _SHIFT)
                if paths:
                    cv2.circle(layer, view.fixed(paths[-1][-1]).tolist(), 3 << _SHIFT, colour, -1, cv2.LINE_AA, _SHIFT)
            image = cv2.addWeighted(layer, strength, image, 1 - strength, 0)
    return image


def _draw_rejected(image: Image, view: View, rejected: Rejected) -> None:
    """Thin pale dashes, which show on lines of samples too."""
    dashes = rejected.dashes(_DASH / view.scale)
    cv2.polylines(image, list(view.fixed(dashes)), False, REJECTED_COLOUR, 1, cv2.LINE_AA, _SHIFT)


def _draw_boxes(image: Image, view: View, scenario: Scenario) -> None:
    vehicles, actors = scenario.vehicles, scenario.context
    seen = np.flatnonzero(actors.motion.valid[:, 0])
    for i in seen:
        where, heading = actors.motion.position[i, 0], actors.motion.heading[i, 0]
        _draw_box(image, view, where, heading, np.maximum(actors.size[i], 0.8), ACTOR_COLOUR)
    for vehicle in reversed(range(len(vehicles))):
        colour = TARGET_COLOUR if vehicle == TARGET else SOCIAL_COLOUR
        _draw_box(image, view, vehicles.position[vehicle], vehicles.heading[vehicle], vehicles.size[vehicle], colour)


def _draw_box(image: Image, view: View, position: Floats, heading: Floats, size: Floats, colour: Colour) -> None:
    corners = box_corners(position, heading, size[0], size[1])
    _fill(image, view, corners, colour)
    front = (corners[[0, 3]] * 2 + corners[[1, 2]]) / 3
    cv2.polylines(image, [view.fixed(front)], False, PAPER, 1, cv2.LINE_AA, _SHIFT)
    cv2.polylines(image, [view.fixed(corners)], True, PAPER, 1, cv2.LINE_AA, _SHIFT)


def _draw_dashed(image: Image, view: View, path: Floats, colour: Colour) -> None:
    """Dashes of five steps, so that their length shows the speed."""
    for start in range(0, len(path) - 1, 10):
        cv2.polylines(image, [view.fixed(path[start : start + 6])], False, colour, 1, cv2.LINE_AA, _SHIFT)


def _draw_diamond(image: Image, view: View, place: Floats) -> None:
    reach = view.width / 150
    corners = place + reach * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
    _fill(image, view, corners, GOAL_COLOUR)
    cv2.polylines(image, [view.fixed(corners)], True, PAPER, 1, cv2.LINE_AA, _SHIFT)


def _draw_scale_bar(image: Image, view: View) -> None:
    metres = 20.0 if view.width < 150 else 50.0
    right, low = view.pixels - 16, view.pixels - 16
    left = int(right - metres * view.scale)
    cv2.line(image, (left, low), (right, low), STOP, 2, cv2.LINE_AA)
    cv2.putText(image, f"{metres:.0f} m", (left, low - 7), cv2.FONT_HERSHEY_SIMPLEX, 0.42, STOP, 1, cv2.LINE_AA)


def _fill(image: Image, view: View, outline: Floats, colour: Colour) -> None:
    cv2.fillPoly(image, [view.fixed(outline)], colour, cv2.LINE_AA, _SHIFT)
