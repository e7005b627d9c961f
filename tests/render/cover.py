"""How much of vehicles and signals a question's marks hide: the picture with them against the one without, pixel by pixel."""

import cv2
import numpy as np

from drivegen.core.geometry import to_vehicle_frame
from drivegen.goals.departures import departures
from drivegen.questions.others import Others
from drivegen.render.goal_picture import draw_goal_picture
from drivegen.render.goal_window import Boxes, Reach, signal_bars
from drivegen.roads.leaving import Exits

ANOTHER = 50
"""Pixels that differ by more in a channel are of another colour."""


def covers(case, pixels=768):
    """(hidden, all) pixels of vehicles, of signals and of the lines of speed of one case."""
    scenario, n = case.scenario, case.vehicle
    v = scenario.vehicles
    place = departures(scenario, n, case.candidates, Exits.of(scenario.map)).place[case.order]
    reach = Reach.of(to_vehicle_frame(place, v.position[n], v.heading[n]))
    letters = Others.of(scenario, n, reach).letters
    marked, _ = draw_goal_picture(scenario, n, place, letters, reach, pixels)
    bare, _ = draw_goal_picture(scenario, n, place[:0], {}, reach, pixels)
    view = reach.view(scenario, n, pixels)
    boxes = Boxes.of(scenario, view)
    vehicles = filled(bare.shape[:2], boxes.outlines)
    signals = strokes(bare.shape[:2], [ends for ends, _ in signal_bars(scenario, view)], 4) & ~vehicles
    lines = strokes(bare.shape[:2], np.stack([boxes.front, boxes.next], 1), 1) & ~vehicles & ~signals
    return hidden(bare, marked, vehicles), hidden(bare, marked, signals), hidden(bare, marked, lines)


def hidden(bare, marked, mask):
    """How many pixels of `mask` are of another colour, and how many there are; an edge's blend with its ground is the same."""
    gap = np.abs(bare.astype(int) - marked.astype(int)).max(-1)
    return int((gap > ANOTHER)[mask].sum()), int(mask.sum())


def filled(shape, outlines):
    """(H, W) bool inside polygons [px]."""
    mask = np.zeros(shape, np.uint8)
    for corners in outlines:
        cv2.fillConvexPoly(mask, np.rint(np.clip(corners, -9000, 9000) * 16).astype(np.int32), 1, cv2.LINE_8, 4)
    return mask.astype(bool)


def strokes(shape, lines, width):
    """(H, W) bool on lines [px]."""
    mask = np.zeros(shape, np.uint8)
    for ends in lines:
        a, b = np.rint(np.asarray(ends) * 16).astype(int).tolist()
        cv2.line(mask, a, b, 1, width, cv2.LINE_8, 4)
    return mask.astype(bool)
