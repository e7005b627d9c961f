"""Places where three to eight roads meet: crossings and roundabouts."""

import math
from typing import Annotated, Literal, NamedTuple

from pydantic import Field, field_validator, model_validator

from drivegen.layouts.values import (
    STREET_LANE,
    Angle,
    Control,
    LaneWidth,
    Length,
    Median,
    NoOrMoreLanes,
    Part,
    Pocket,
    Side,
    Speed,
    TurnLaneCount,
)

SMALLEST_RING, SMALLEST_WIDE_RING = 14.0, 24.0
"""Least outer diameter of a roundabout [m], a mini-roundabout's with one lane on its ring, and with more lanes."""

SIGNS = (("left", 1), ("right", -1))
"""Of turns [degrees] to either side."""

STRAIGHT = 40.0
"""Who turns by less [degrees] goes straight on."""

LEAST_ANGLE = 20.0
"""Degrees between two arms at least."""

RING_LANE = 4.0
"""Width of a lane of a ring [m]."""

LEAST_ARC, LEAST_WIDE_ARC = 7.8, 9.0
"""Least distance along the ring between two roads [m], on a ring with one lane (a mini-roundabout's) and with more."""


class TurnLanes(NamedTuple):
    """How many turn lanes an approach has on either side, and their length [m]."""

    left: int
    right: int
    length: float


NO_TURN_LANES = TurnLanes(0, 0, 0.0)


class Arm(Part):
    """One road that meets a crossing or a roundabout, seen from there.

    Turn lanes are `pocket` long, half the arm at most; those to the left or right of who comes in, as `turn_bans` are. Rings
    have neither, nor roads with a `median` between their directions [m], which nobody may drive on.
    """

    angle: Angle
    lanes_in: NoOrMoreLanes = 1
    lanes_out: NoOrMoreLanes = 1
    speed: Speed = 50 / 3.6
    length: Length = 150.0
    left_turn_lanes: TurnLaneCount = 0
    right_turn_lanes: TurnLaneCount = 0
    pocket: Pocket = 60.0
    turn_bans: Annotated[tuple[Side, ...], Field(max_length=2)] = ()
    median: Median = 0.0
    main: bool = True

    @model_validator(mode="after")
    def _is_a_road(self) -> "Arm":
        if self.lanes_in + self.lanes_out == 0:
            raise ValueError("an arm needs at least one lane in or out")
        if self.median and 0 in (self.lanes_in, self.lanes_out):
            raise ValueError("a one-way road has no median")
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
    lane_width: LaneWidth = STREET_LANE

    @field_validator("arms", mode="after")
    @classmethod
    def _turn_lanes_lead_somewhere(cls, arms: tuple[Arm, ...]) -> tuple[Arm, ...]:
        """Without turn lanes where there is nowhere to turn, as ahead of a T: nobody is told of what no network has."""
        return tuple(_without_idle_lanes(arm, _turns(arms, i)) for i, arm in enumerate(arms))

    @model_validator(mode="after")
    def _turns_lead_somewhere(self) -> "Crossing":
        for i, arm in enumerate(self.arms):
            turns, (left, right, _) = self.turns(i), self.turn_lanes(i)
            if arm.lanes_in and not turns:
                raise ValueError(f"who comes in over arm {i + 1} can go nowhere")
            for lanes, (_, side) in zip((left, right), SIGNS, strict=True):
                if lanes > max((self.arms[k].lanes_out for k, turn in turns.items() if side * turn > STRAIGHT), default=lanes):
                    raise ValueError(f"{lanes} turn lanes need a road with {lanes} lanes to turn into")
        return self

    def turns(self, here: int) -> dict[int, float]:
        """By the other arms with a way out the turn towards them [degrees, left positive], banned turns left out."""
        return _turns(self.arms, here)

    def turn_lanes(self, here: int) -> TurnLanes:
        """Those of an arm."""
        arm = self.arms[here]
        return TurnLanes(arm.left_turn_lanes, arm.right_turn_lanes, min(arm.pocket, arm.length / 2))


def turned(here: float, there: float) -> float:
    """The turn of who comes over the arm at angle `here` into that at `there`, all in degrees, left positive."""
    return (there - here) % 360.0 - 180.0


def _turns(arms: tuple[Arm, ...], here: int) -> dict[int, float]:
    arm = arms[here]
    turns = {i: turned(arm.angle, other.angle) for i, other in enumerate(arms) if i != here and other.lanes_out}
    banned = {"left": 1, "right": -1}
    return {i: turn for i, turn in turns.items() if not any(banned[side] * turn > STRAIGHT for side in arm.turn_bans)}


def _without_idle_lanes(arm: Arm, turns: dict[int, float]) -> Arm:
    used = {side: bool(arm.lanes_in) and any(sign * turn > STRAIGHT for turn in turns.values()) for side, sign in SIGNS}
    lanes = {f"{side}_turn_lanes": getattr(arm, f"{side}_turn_lanes") * used[side] for side in used}
    return arm.model_copy(update=lanes | ({} if any(lanes.values()) else {"pocket": Arm.model_fields["pocket"].default}))


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
        if any(arm.left_turn_lanes or arm.right_turn_lanes for arm in self.arms):
            raise ValueError("roads that meet a roundabout have no turn lanes here")
        if any(arm.turn_bans for arm in self.arms):
            raise ValueError("who enters a roundabout may leave it anywhere: no turn can be banned")
        if any(arm.median for arm in self.arms):
            raise ValueError("roads that meet a roundabout have no median here")
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
