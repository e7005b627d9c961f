"""Reference lines of roads: alignments as polylines, and points beside them in Frenet coordinates."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import Floats, arc_length
from drivegen.layouts.alignment import Alignment
from drivegen.sumo.plain import Point

Line = NDArray[np.float64]

Ends = tuple[float, float]
"""A value at the beginning and at the end of a way."""

_SWERVE = 12  # points
_BEND_STEP = np.radians(4.0)
_SHORTEST_ARC = 0.1


def draw(alignment: Alignment) -> Line:
    """The polyline (P, 2) of an alignment, from (0, 0) heading east; straights beside its bends and between hairpins."""
    ends = alignment.straight
    pieces, heading = [np.zeros((1, 2)), np.array([[ends, 0.0]])], 0.0
    for i, (angle, radius) in enumerate(alignment.curves):
        if i and alignment.shape == "hairpin":  # hairpins have a straight between them
            pieces.append(pieces[-1][-1:] + ends * np.array([[np.cos(heading), np.sin(heading)]]))
        if abs(np.radians(angle)) * radius > _SHORTEST_ARC:
            pieces.append(_arc(pieces[-1][-1], heading, np.radians(angle), radius))
        heading += np.radians(angle)
    end = pieces[-1][-1] + ends * np.array([np.cos(heading), np.sin(heading)])
    return np.concatenate([*pieces, end[None]])


def _arc(start: Line, heading: float, angle: float, radius: float) -> Line:
    steps = max(2, int(np.ceil(abs(angle) / _BEND_STEP)))
    turned = np.linspace(0.0, angle, steps + 1)[1:]
    side = np.copysign(1.0, angle)
    centre = start + side * radius * np.array([-np.sin(heading), np.cos(heading)])
    around = heading + turned - side * np.pi / 2
    points: Line = centre + radius * np.stack([np.cos(around), np.sin(around)], axis=-1)
    return points


def path(start: Point, heading: float, steps: Sequence[tuple[float, float]]) -> Line:
    """The polyline (P, 2) of `steps` from `start`, `heading` so many degrees: (turn [degrees], radius [m]), or (0, length)."""
    pieces, direction = [np.array([start])], np.radians(heading)
    for angle, size in steps:
        here = pieces[-1][-1]
        ahead = here + size * np.array([np.cos(direction), np.sin(direction)])
        pieces.append(_arc(here, direction, np.radians(angle), size) if angle else ahead[None])
        direction += np.radians(angle)
    return np.concatenate(pieces)


def length(line: Line) -> float:
    """Length of the polyline (P, 2) [m]."""
    return float(arc_length(line)[-1])


def beside(line: Line, along: Line, left: Line) -> Line:
    """Points (S, 2) at distance `along` (S,) on the polyline and `left` (S,) of it; the line goes on straight beyond its ends."""
    at = arc_length(line)
    step = np.diff(line, axis=0)
    direction = step / np.linalg.norm(step, axis=1, keepdims=True)
    segment = np.clip(np.searchsorted(at, along, side="right") - 1, 0, len(step) - 1)
    forward = direction[segment]
    point = line[segment] + (along - at[segment])[:, None] * forward
    # The normal turns evenly along a bend, so that offset lines stay smooth.
    vertex = np.concatenate([direction[:1], direction[:-1] + direction[1:], direction[-1:]])
    share = np.clip((along - at[segment]) / (at[segment + 1] - at[segment]), 0.0, 1.0)[:, None]
    tangent = vertex[segment] / _norm(vertex[segment]) * (1 - share) + vertex[segment + 1] / _norm(vertex[segment + 1]) * share
    tangent /= _norm(tangent)
    moved: Line = point + np.asarray(left)[:, None] * np.stack([-tangent[:, 1], tangent[:, 0]], axis=-1)
    return moved


def part(line: Line, start: float, end: float, left: float = 0.0) -> Line:
    """The piece of the polyline between two distances along it, moved to the left by `left` [m]."""
    at = arc_length(line)
    inner = at[(at > start + 0.5) & (at < end - 0.5)]
    along = np.concatenate([[start], inner, [end]])
    return beside(line, along, np.full(len(along), left))


def strip(line: Line, at: float, half: float, left: Ends, right: Ends) -> tuple[Point, ...]:
    """The outline of a strip across the polyline, from `half` [m] before `at` to `half` behind it, between two offsets."""
    there = np.linspace(at - half, at + half, _SWERVE)
    outline = beside(line, np.concatenate([there, there[::-1]]), np.concatenate([_eased(left), _eased(right)[::-1]]))
    return points(outline)


def swerve(line: Line, at: float, half: float, left: Ends) -> tuple[Point, ...]:
    """The way over such a strip from one offset to another."""
    along = at + half * (2 * np.linspace(0.0, 1.0, _SWERVE) - 1)
    return points(beside(line, along, _eased(left)))


def _eased(ends: Ends) -> Line:
    """From one value to another, neither beginning nor ending abruptly."""
    share = np.linspace(0.0, 1.0, _SWERVE)
    between: Line = ends[0] + (ends[1] - ends[0]) * share**2 * (3 - 2 * share)
    return between


def points(line: Floats) -> tuple[Point, ...]:
    """The polyline as SUMO takes it."""
    return tuple((float(x), float(y)) for x, y in line)


def _norm(vectors: Line) -> Line:
    norm: Line = np.linalg.norm(vectors, axis=1, keepdims=True)
    return norm
