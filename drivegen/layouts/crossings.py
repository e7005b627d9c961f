"""Places where three to eight roads meet: crossings and roundabouts."""

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from drivegen.layouts.values import Angle, Control, Length, NoOrMoreLanes, Part, Pocket, Speed

SMALLEST_RING, SMALLEST_WIDE_RING = 14.0, 24.0
"""Least outer diameter of a roundabout [m], a mini-roundabout's with one lane on its ring, and with more lanes."""

LEAST_ANGLE = 20.0
"""Degrees between two arms at least."""

RING_LANE = 4.0
"""Width of a lane of a ring [m]."""

LEAST_ARC, LEAST_WIDE_ARC = 7.8, 9.0
"""Least distance along the ring between two roads [m], on a ring with one lane (a mini-roundabout's) and with more."""


class Arm(Part):
    """One road that meets a crossing or a roundabout, seen from there; its turn lanes are `pocket` long, half the arm at most."""

    angle: Angle
    lanes_in: NoOrMoreLanes = 1
    lanes_out: NoOrMoreLanes = 1
    speed: Speed = 50 / 3.6
    length: Length = 150.0
    left_turn_lane: bool = False
    right_turn_lane: bool = False
    pocket: Pocket = 60.0
    main: bool = True

    @model_validator(mode="after")
    def _is_a_road(self) -> "Arm":
        if self.lanes_in + self.lanes_out == 0:
            raise ValueError("an arm needs at least one lane in or out")
        return self


class _Arms(Part):
    arms: Annotated[tuple[Arm, ...], Field(min_length=3, max_length=8)]

    @model_validator(mode="after")
    def _arms_are_apart(self) -> "_Arms":
        angles = sorted(arm.angle % 360 for arm in self.arms)
        gaps = [b - a for a, b in zip(angles, [*angles[1:], angles[0] + 360], strict=True)]
        if min(gaps) < LEAST_ANGLE:
            raise ValueError(f"arms must be at least {LEAST_ANGLE:.0f} degrees apart")
        if not any(arm.lanes_in for arm in self.arms) or not any(arm.lanes_out for arm in self.arms):
            raise ValueError("there must be a way in and a way out")
        return self


class Crossing(_Arms):
    """Three to eight roads that meet at one place (T, Y, four-way, five-way, one-way streets, ...)."""

    kind: Literal["crossing"] = "crossing"
    control: Control = "yield"


class Roundabout(_Arms):
    """A ring that three to eight roads meet; `diameter` is that of its outer edge.

    One with a single ring lane may be a mini-roundabout of 14 m, if its arms are not too near to one another for that.
    """

    kind: Literal["roundabout"] = "roundabout"
    ring_lanes: Annotated[int, Field(ge=1, le=4)] = 1
    diameter: Annotated[float, Field(ge=SMALLEST_RING, le=200.0, allow_inf_nan=False)] = 40.0
    ring_speed: Speed = 30 / 3.6

    @model_validator(mode="after")
    def _lanes_fit_into_the_ring(self) -> "Roundabout":
        check_ring(self.ring_lanes, self.diameter)
        least = least_diameter([arm.angle for arm in self.arms], self.ring_lanes)
        if self.diameter < least:
            raise ValueError(f"{len(self.arms)} roads need a roundabout of at least {math.ceil(least)} m across")
        return self


def least_diameter(angles: list[float], lanes: int) -> float:
    """The smallest outer diameter [m] at which the roads that meet a ring are far enough apart."""
    ordered = sorted(angle % 360 for angle in angles)
    gaps = [b - a for a, b in zip(ordered, [*ordered[1:], ordered[0] + 360], strict=True)]
    arc = LEAST_ARC if lanes == 1 else LEAST_WIDE_ARC
    return 2 * arc / math.radians(min(gaps)) + lanes * RING_LANE


def check_ring(lanes: int, diameter: float) -> None:
    """Raise ValueError where a ring of so many lanes is too small, whoever meets it."""
    if lanes > 1 and diameter < SMALLEST_WIDE_RING:
        raise ValueError(f"a ring with {lanes} lanes must be at least {SMALLEST_WIDE_RING:.0f} m across, not {diameter:g} m")
