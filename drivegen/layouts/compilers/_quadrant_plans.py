"""Where the ramps of interchanges with loops lie: distances, radii and lines, for traffic on the right.

Carriageway i heads east, north, west or south (i = 0 to 3) and leaves the bridge beside quadrant i. A ramp is named by its kind
and quadrant: "loop0" lies in the south-east.
"""

from dataclasses import dataclass
from functools import cached_property
from math import cos, radians, sin, sqrt

import numpy as np

from drivegen.layouts.compilers import _lines as lines
from drivegen.layouts.quadrants import QUADRANTS, QuadrantInterchange
from drivegen.layouts.values import HIGHWAY_LANE
from drivegen.sumo.plain import Point

ACCELERATION = 200.0
"""Length of the lane over which direct ramps join [m]."""

WEST = 2
"""The quadrant of a trumpet's loop, in the north-west."""

_DIRECT_RADIUS = 180.0
"""Of a direct ramp without a loop between it and the corner [m]: it leaves and joins beyond the lanes beside loops."""

_CLEARANCE = 8.0
"""Between a loop and the direct ramp around it where they are nearest [m]: shoulders and a verge."""

_AROUND, _JOINING, _JOINING_RADIUS = 135.0, 45.0, 120.0
"""Turns of the ramp around a trumpet's loop, to the left and back [degrees], and the radius of the latter [m]."""

_ANGLE = 40.0
"""At which ramps to a street lie between their bends [degrees]."""

_SETBACK = 12.0
"""Straight part of a loop before the street's edge [m]: it meets the street squarely, and two cars may wait there."""

_BESIDE_LOOP, _BEFORE_BEND = 15.0, 40.0
"""[m] From the street a direct ramp runs along the highway until so far beyond the loop, lest it bend towards that; without a
loop, for so long."""

_OFF_LOOP, _WITHOUT_LOOP = 30.0, 70.0
"""[m] The crossing of direct ramps lies so far beyond the loops, as seen from the highway, for the ramps' own width and a
queue between both crossings; without loops, so far from the highway."""


@dataclass(frozen=True)
class Plan:
    """Where everything lies: distances from the middle of the bridge [m]."""

    spec: QuadrantInterchange

    def loops(self, q: int) -> bool:
        """Whether quadrant q has a loop."""
        return QUADRANTS[q % 4] in self.spec.loops

    def direct(self, q: int) -> bool:
        """Whether quadrant q has a direct ramp."""
        return QUADRANTS[q % 4] in self.spec.directs

    def half(self, i: int) -> float:
        """From the middle of the road of carriageway i to its outer edge."""
        return self.spec.median / 2 + HIGHWAY_LANE * (self.spec.road_lanes if i % 2 else self.spec.lanes)

    @property
    def lanes(self) -> int:
        """Of ramps; those into which a road ends have no more than it."""
        return min(self.spec.ramp_lanes, self.spec.road_lanes) if self.spec.trumpet else self.spec.ramp_lanes

    @property
    def loop_radius(self) -> float:
        """Of the left edge of a loop, which is its outer one."""
        return self.spec.loop_radius + self.lanes * HIGHWAY_LANE / 2

    def near(self, i: int) -> float:
        """Where loops leave or join carriageway i. A trumpet's loop goes on as a carriageway, beside the median."""
        return self.loop_radius + (self.spec.median / 2 if self.spec.trumpet else self.half(i + 1))

    def direct_radius(self, q: int) -> float:
        """Of the left edge of the direct ramp of quadrant q, which passes outside of the loop."""
        loop = (1 + sqrt(2)) ** 2 * self.loop_radius + (1 + sqrt(2)) * _CLEARANCE
        return max(_DIRECT_RADIUS, loop) if self.loops(q) else _DIRECT_RADIUS

    def far(self, i: int, q: int) -> float:
        """Where the direct ramp of quadrant q leaves or joins carriageway i."""
        if q % 4 == WEST and self.spec.trumpet:
            return -float(self.around[-1][0])
        return self.half(i + 1) + self.direct_radius(q)

    @property
    def top(self) -> float:
        """How far north the carriageways of a road without its northern leg reach: to the height of the loop's centre."""
        return self.half(0) + self.loop_radius

    @cached_property
    def around(self) -> lines.Line:
        """The ramp around a trumpet's loop, as far from it as the carriageways are from one another."""
        inner = self.loop_radius + self.spec.median
        fallen = self.loop_radius + inner * np.cos(radians(_JOINING)) - _JOINING_RADIUS * (1 - np.cos(radians(_JOINING)))
        steps = [(_AROUND, inner), (0.0, fallen / np.sin(radians(_JOINING))), (-_JOINING, _JOINING_RADIUS)]
        return lines.path((self.spec.median / 2, self.top), 90.0, steps)

    @cached_property
    def leg(self) -> float:
        """The length of every leg."""
        ends = [self.far(i, q) for q in range(4) if self.direct(q) for i in (q, q + 1)]
        return max([*ends, self.near(0), self.near(1)]) + ACCELERATION + self.spec.leg_length

    @property
    def ramps(self) -> tuple[str, ...]:
        """All ramps by name."""
        kinds = (("loop", self.loops), ("direct", self.direct))
        return tuple(f"{kind}{q}" for kind, there in kinds for q in range(4) if there(q))

    def line(self, name: str, start: Point) -> lines.Line:
        """The left edge of a ramp that begins at `start`."""
        q = int(name[-1])
        if name.startswith("loop"):
            return lines.path(start, 90.0 * q, [(-270.0, self.loop_radius)])
        if self.spec.trumpet and q == WEST:
            return self.around
        return lines.path(start, 90.0 * (q + 1), [(-90.0, self.direct_radius(q))])


class StreetPlan(Plan):
    """The same where the road is a street: ramps end at crossings on it, squarely, so loops bend back by a quarter there."""

    @property
    def _beside(self) -> float:
        """From the street to the loops beside it."""
        return _SETBACK + self.spec.road_lanes * HIGHWAY_LANE + self._corner

    @property
    def _corner(self) -> float:
        """Radius of the bend by which a loop reaches the street."""
        return self.loop_radius / 3

    def near(self, i: int) -> float:  # noqa: ARG002
        """See `Plan.near`."""
        return self._beside + self.loop_radius

    def terminal(self, name: str) -> float:
        """How far north of the highway the ramp meets the street."""
        q = int(name[-1])
        side = (0, 3) if q in (0, 3) else (1, 2)
        away = self.loop_radius - self._corner
        if name.startswith("direct"):
            away = 2 * self.loop_radius + _OFF_LOOP if any(map(self.loops, side)) else _WITHOUT_LOOP
        return (away + self.half(0)) * (-1.0 if q in (0, 3) else 1.0)

    def _bends(self, q: int) -> float:
        """Radius of the two bends of the direct ramp of quadrant q."""
        return (abs(self.terminal(f"direct{q}")) - self.half(0)) / (2 - 2 * cos(radians(_ANGLE)))

    def _straight(self, q: int) -> float:
        """Length of the direct ramp of quadrant q that lies along the highway, outside of the loop."""
        return self._beside + 2 * self.loop_radius + _BESIDE_LOOP if self.loops(q) else _BEFORE_BEND

    def far(self, i: int, q: int) -> float:  # noqa: ARG002
        """See `Plan.far`."""
        return self._straight(q % 4) + 2 * self._bends(q % 4) * sin(radians(_ANGLE))

    def line(self, name: str, start: Point) -> lines.Line:
        """See `Plan.line`."""
        q = int(name[-1])
        if name.startswith("loop"):
            steps = [(-270.0, self.loop_radius), (90.0, self._corner), (0.0, self._beside - self._corner)]
            return lines.path(start, 90.0 * q, steps) if q % 2 == 0 else lines.path(start, 90.0 * (q - 1), steps[::-1])
        radius, straight = self._bends(q), (0.0, self._straight(q))
        if q % 2 == 0:
            return lines.path(start, 90.0 * q, [straight, (_ANGLE, radius), (-_ANGLE, radius)])
        return lines.path(start, 90.0 * (q + 1), [(-_ANGLE, radius), (_ANGLE, radius), straight])
