"""What the picture of a question is of: a window as far as the places reach, who is in it, which signals."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import Floats, box_corners, unit
from drivegen.core.roadmap import LaneControl
from drivegen.core.scenario import Scenario
from drivegen.core.signals import SignalState
from drivegen.render.bird_eye import EXTENT, Colour, View

SIGNALS: dict[int, Colour] = {
    SignalState.UNKNOWN: (90, 90, 96),
    SignalState.GREEN: (20, 170, 60),
    SignalState.YELLOW: (245, 190, 0),
    SignalState.RED: (225, 15, 15),
}

STEP = 50.0
"""The window grows by this [m]."""

MARGIN = 15.0
"""From a place to the window's border at least [m]."""

LONGEST_SIDE = 1560
"""Of a picture [px]: vendors shrink longer ones."""

SMALLEST = (8.0, 4.0)
"""Length and width [px] that a vehicle is drawn with at least: more than it has where the window is long."""

_NOSE, _NOSE_SHARE = 6.0, 0.35  # of a vehicle, at most [px], and as a share of its length
_HALF_LINE = 1.5
"""Half the width of a stop line, along the road and as a signal's bar across it [m]."""


@dataclass(frozen=True)
class Reach:
    """How far the window goes from the vehicle: forward, back, left, right [m]."""

    forward: float
    back: float
    left: float
    right: float

    @classmethod
    def of(cls, local: Floats) -> "Reach":
        """The least window that holds places (P, 2) [m], forward and left of the vehicle, and EXTENT around it."""
        ends = np.concatenate([np.max(local, 0, initial=0.0), -np.min(local, 0, initial=0.0)]) + MARGIN
        forward, left, back, right = np.maximum(np.ceil(ends / STEP) * STEP, EXTENT / 2).tolist()
        return cls(forward, back, left, right)

    def holds(self, local: Floats) -> NDArray[np.bool_]:
        """(P,) whether points (P, 2) [m], forward and left of the vehicle, are in the window."""
        along = (local[:, 0] <= self.forward) & (local[:, 0] >= -self.back)
        return np.asarray(along & (local[:, 1] <= self.left) & (local[:, 1] >= -self.right))

    def view(self, scenario: Scenario, vehicle: int, pixels: int) -> View:
        """The window with about `pixels` x `pixels` pixels in all."""
        wide, high = self.left + self.right, self.forward + self.back
        scale = min(pixels / np.sqrt(wide * high), LONGEST_SIDE / max(wide, high))
        v = scenario.vehicles
        size = np.array([round(wide * scale), round(high * scale)])
        return View(v.position[vehicle], float(v.heading[vehicle]), scale, size, np.array([self.left, self.forward]) * scale)


@dataclass(frozen=True)
class Boxes:
    """Everybody at the first frame [px]: corners (B, 4, 2) from front left, where the front is one second later (B, 2)."""

    corners: NDArray[np.float64]
    next: NDArray[np.float64]

    @classmethod
    def of(cls, scenario: Scenario, view: View) -> "Boxes":
        """Vehicles, then the context actors that are there."""
        now = scenario.present()
        size = np.maximum(now.size[:, :2], np.array(SMALLEST) / view.scale)
        corners = box_corners(now.position, now.heading, size[:, 0], size[:, 1])
        ahead = (size[:, :1] / 2 + now.speed[:, None]) * unit(now.heading)
        return cls(view.pixels(corners), view.pixels(now.position + ahead))

    @property
    def front(self) -> NDArray[np.float64]:
        """(B, 2) the middle of each one's front."""
        return np.asarray((self.corners[:, 0] + self.corners[:, 3]) / 2)

    @property
    def outlines(self) -> NDArray[np.float64]:
        """(B, 5, 2) as they are drawn: pointed at the front."""
        left, right, behind, beside = (self.corners[:, k] for k in (0, 3, 2, 1))
        along = behind - right
        nose = np.minimum(_NOSE_SHARE, _NOSE / np.maximum(np.hypot(*along.T), 1e-6))[:, None] * along
        return np.stack([self.front, right + nose, behind, beside, left + nose], axis=1)

    @property
    def around(self) -> NDArray[np.float64]:
        """(B, 4) low x, low y, high x, high y."""
        return np.concatenate([self.corners.min(1), self.corners.max(1)], axis=-1)


def signal_bars(scenario: Scenario, view: View) -> list[tuple[NDArray[np.float64], Colour]]:
    """Both ends (2, 2) [px] and colour of a bar where lanes with signals begin; grey where the state is not known.

    Where lanes begin together, as the ways on from one stop line do, they share the bar: who turns left has its left end.
    """
    road, signals = scenario.map, scenario.signals
    known = dict(zip(signals.lane.tolist(), signals.state[:, 0].tolist(), strict=True))
    lanes = sorted({*known, *np.flatnonzero(road.control == LaneControl.SIGNAL).tolist()})
    together: dict[tuple[int, ...], list[int]] = {}
    for lane in lanes:
        together.setdefault(tuple(np.rint(2 * road.centreline[lane][0]).astype(int).tolist()), []).append(lane)
    bars = []
    for ways in together.values():
        a, b = view.pixels(road.centreline[ways[0]][:2])
        step = (b - a) / max(float(np.hypot(*(b - a))), 1e-6)
        right = np.array([-step[1], step[0]])
        ways.sort(key=lambda way: (float((view.pixels(road.centreline[way][-1]) - a) @ right), way))
        states = [SIGNALS[known.get(way, SignalState.UNKNOWN)] for way in ways]
        parts = [states[0]] if len(set(states)) == 1 else states
        half = max(_HALF_LINE * view.scale, 4.0)
        cuts = a + np.linspace(-half, half, len(parts) + 1)[:, None] * right
        bars += [(cuts[i : i + 2], colour) for i, colour in enumerate(parts) if _near(cuts, view.size)]
    return bars


def _near(points: NDArray[np.float64], size: NDArray[np.int64]) -> bool:
    """Whether all points (Q, 2) [px] are in the window or just outside."""
    return bool(((points > -10) & (points < size + 10)).all())
