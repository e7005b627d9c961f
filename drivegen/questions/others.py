"""Who else is there, as a question tells it: a letter for each in the picture, where it is on the road, its way and its speed."""

from collections.abc import Sequence
from dataclasses import dataclass
from string import ascii_uppercase

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import Floats, to_vehicle_frame, wrap_angle
from drivegen.core.scenario import TARGET, Scenario, VehicleKind
from drivegen.goals.traffic import IN_LANE, SAME_WAY
from drivegen.questions.ways import WIDTH
from drivegen.render.goal_window import Reach
from drivegen.roads.frenet import to_frenet
from drivegen.roads.line import SPACING, Route
from drivegen.roads.parked import STANDING

MOST_TOLD = 20
"""The nearest so many get letters and rows; no scene as delivered has more."""

ONCOMING = np.deg2rad(135)
"""Headings that differ by more are of opposite ways [rad]."""

BESIDE = 2
"""Vehicles so many lanes to the side are told by lane."""


@dataclass(frozen=True)
class Others:
    """Everybody else at the first frame: M vehicles and context actors, nearest first, and the letters of the first of them.

    Attributes:
        number: (M,) vehicles by number, then context actors that are there. kind: (M,). local: (M, 2) [m] forward and left.
        position, absolute, speed, length: as in the scenario, `absolute` being the heading; heading: against the vehicle's [rad].
        inside: (M,) in the picture.
        letters: of those in the picture, by number.
    """

    number: NDArray[np.intp]
    kind: NDArray[np.uint8]
    local: Floats
    position: Floats
    absolute: Floats
    heading: Floats
    speed: Floats
    length: Floats
    inside: NDArray[np.bool_]
    letters: dict[int, str]

    @classmethod
    def of(cls, scenario: Scenario, vehicle: int, reach: Reach) -> "Others":
        """As seen by `vehicle` in a picture that goes as far as `reach`."""
        now = scenario.present()
        local = to_vehicle_frame(now.position, now.position[vehicle], now.heading[vehicle])
        order = np.argsort(np.hypot(*local.T), kind="stable")
        order = order[order != vehicle]
        inside = reach.holds(local[order])
        letters = dict(zip(order[inside][:MOST_TOLD].tolist(), ascii_uppercase, strict=False))
        turned = wrap_angle(now.heading[order] - float(now.heading[vehicle]))
        seen = (local[order], now.position[order], now.heading[order], turned, now.speed[order], now.size[order, 0])
        return cls(order, now.kind[order], *seen, inside, letters)

    def table(self, routes: Sequence[Route]) -> str:
        """A row for each that has a letter; lanes are told against the one that `routes` begin on, the likeliest first."""
        rows = [self._row(i, routes) for i, n in enumerate(self.number.tolist()) if n in self.letters]
        left = int(self.inside.sum()) - len(rows)
        more = [f"{left} more in the picture have no letter."] if left else []
        if not rows:
            return "Nobody else is in the picture."
        return "\n".join(["vehicle: kind; where its middle is; where it goes; speed", *rows, *more])

    def _row(self, i: int, routes: Sequence[Route]) -> str:
        forward, left = self.local[i].tolist()
        kind = VehicleKind(self.kind[i]).name.lower() + (" (the target)" if self.number[i] == TARGET else "")
        facts = (f"{self.letters[int(self.number[i])]}: {kind}", where(forward, left), self._way(i, routes), pace(self.speed[i]))
        return "; ".join(facts)

    def _way(self, i: int, routes: Sequence[Route]) -> str:
        """Against the vehicle's own way: in its lane, lanes beside, oncoming, across."""
        if self.kind[i] == VehicleKind.PEDESTRIAN:
            return "on foot"
        angle = float(self.heading[i])
        for route in routes[:1]:
            s, d, turn = (float(a[0]) for a in self._on(route, slice(i, i + 1)))
            along = 0 <= s <= route.length or abs(self.local[i, 1]) < (BESIDE + 0.5) * WIDTH
            lanes = 0 if abs(d) < IN_LANE else round(abs(d) / WIDTH) or 1
            if turn < SAME_WAY and along and lanes <= BESIDE:
                side = "left" if d > 0 else "right"
                return "in its lane" if not lanes else f"{'one lane' if lanes == 1 else 'two lanes'} to the {side}, same way"
            angle = turn if turn > ONCOMING else angle
        if any(i in [row for row, _, _ in self.in_lane(route)] for route in routes[1:]):
            return "on another way on from its lane"
        if abs(angle) > ONCOMING:
            return "oncoming"
        if abs(angle) < SAME_WAY:
            return "same way, on another road or lane"
        return f"across, heading to the {'left' if angle > 0 else 'right'}"

    def _on(self, route: Route, rows: slice) -> tuple[Floats, Floats, Floats]:
        """s and d [m] on a route of some rows, and by how much they head elsewhere [rad]."""
        s, d = to_frenet(route, self.position[rows]).T
        at = np.clip(s / SPACING, 0, len(route.heading) - 1).astype(int)
        return s, d, np.abs(wrap_angle(self.absolute[rows] - route.heading[at]))

    def in_lane(self, route: Route) -> list[tuple[int, float, float]]:
        """(row, [m] of its middle along the route, its speed [m/s]) of those on `route` ahead, nearest first."""
        if not len(self.number):
            return []
        s, d, turn = self._on(route, slice(None))
        there = np.flatnonzero((s > 0) & (np.abs(d) < IN_LANE) & (turn < SAME_WAY) & (s < route.length))
        there = there[np.argsort(s[there], kind="stable")]
        return [(i, float(s[i]), float(self.speed[i])) for i in there.tolist()]

    def name(self, i: int) -> str:
        """Its letter, or what it is."""
        return self.letters.get(int(self.number[i]), f"a {VehicleKind(self.kind[i]).name.lower()} outside the picture")


def where(forward: float, left: float) -> str:
    """Metres ahead and aside, in words.

    >>> where(12.3, -3.4)
    '12 m ahead, 3 m right'
    """
    return f"{abs(forward):.0f} m {'ahead' if forward >= 0 else 'behind'}, {abs(left):.0f} m {'left' if left >= 0 else 'right'}"


def pace(speed: float) -> str:
    """A speed now, in words.

    >>> pace(-3.0), pace(0.2), pace(1.24), pace(13.6)
    ('rolls backward', 'stands', 'creeps at 1.2 m/s', '14 m/s')
    """
    if speed <= -STANDING:
        return "rolls backward"
    if speed < STANDING:
        return "stands"
    return f"creeps at {speed:.1f} m/s" if speed < 2 else f"{speed:.0f} m/s"
