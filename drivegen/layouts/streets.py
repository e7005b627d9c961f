"""Streets with junctions along them: corridors and grids."""

import math
from functools import cached_property
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from drivegen.layouts.alignment import Alignment
from drivegen.layouts.crossings import NO_TURN_LANES, SMALLEST_RING, Arm, Crossing, TurnLanes, check_ring, least_diameter
from drivegen.layouts.values import (
    STREET_LANE,
    Control,
    Lanes,
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

LEAST_ROOM = 20.0
"""Metres of road between two junctions, and between one and the road's ends, at least."""

POCKET_SHARE = 0.4
"""Turn lanes along a corridor take so much of the way between two junctions at most, for both may have some on it."""

_MOST_ON_A_SIDE = 3
"""Roads join on one side of a junction at most: they are 45 degrees apart then."""


class Junction(Part):
    """One place along a corridor where side roads join: at `position` along it, on the sides named; several on one side are
    spread evenly over it, so that three to eight roads meet.

    At a crossing the main road may have turn lanes, in each direction that has a side road to turn to; they are `pocket`
    long, at most `POCKET_SHARE` of the way from what lies before the crossing. `turn_bans` are those of the main road,
    `side_turn_bans` those of the side roads, left and right of who drives there. A roundabout has none of these, and who
    enters it gives way.
    """

    position: Annotated[float, Field(ge=30.0, le=10000.0, allow_inf_nan=False)]
    sides: Annotated[tuple[Side, ...], Field(min_length=1, max_length=6)] = ("left", "right")
    form: Literal["crossing", "roundabout"] = "crossing"
    control: Control = "yield"
    side_lanes: Lanes = 1
    side_speed: Speed = 50 / 3.6
    side_length: Length = 120.0
    left_turn_lanes: TurnLaneCount = 0
    right_turn_lanes: TurnLaneCount = 0
    pocket: Pocket = 60.0
    turn_bans: Annotated[tuple[Side, ...], Field(max_length=2)] = ()
    side_turn_bans: Annotated[tuple[Side, ...], Field(max_length=2)] = ()
    dead_end: bool = False
    ring_lanes: Annotated[int, Field(ge=1, le=3)] = 1
    diameter: Annotated[float, Field(ge=SMALLEST_RING, le=120.0, allow_inf_nan=False)] = 40.0

    @model_validator(mode="after")
    def _lanes_fit_into_the_ring(self) -> "Junction":
        if max(self.sides.count("left"), self.sides.count("right")) > _MOST_ON_A_SIDE:
            raise ValueError(f"at most {_MOST_ON_A_SIDE} roads join on one side of a junction along a road")
        if self.form == "roundabout":
            if self.control != "yield":
                raise ValueError("who enters a roundabout gives way: it has neither signals nor other signs here")
            if self.left_turn_lanes or self.right_turn_lanes or self.turn_bans or self.side_turn_bans:
                raise ValueError("a roundabout along a road has neither turn lanes nor banned turns")
            check_ring(self.ring_lanes, self.diameter)
            least = least_diameter([0.0, 180.0, *self.directions], self.ring_lanes)
            if self.diameter < least:
                raise ValueError(f"{2 + len(self.sides)} roads need a roundabout of at least {math.ceil(least)} m across")
        return self

    @property
    def directions(self) -> tuple[float, ...]:
        """Directions of the side roads against the corridor's own [degrees, to the left], in the order of `sides`."""
        directions_of = []
        for i, side in enumerate(self.sides):
            step = 180.0 / (1 + self.sides.count(side))
            directions_of.append(step * (1 + self.sides[:i].count(side)) + (0.0 if side == "left" else 180.0))
        return tuple(directions_of)


class Corridor(Part):
    """A road of any line with junctions along it: crossings or roundabouts in a row, side streets, a staggered junction.

    Without junctions it is a plain street. `dead_end` closes its far end with a turning place (cul-de-sac). `median` lies
    between its directions [m]; at roundabouts and turning places it ends.
    """

    kind: Literal["corridor"] = "corridor"
    alignment: Alignment = Alignment()
    lanes: Lanes = 1
    lanes_back: NoOrMoreLanes = 1
    speed: Speed = 50 / 3.6
    junctions: Annotated[tuple[Junction, ...], Field(max_length=12)] = ()
    dead_end: bool = False
    median: Median = 0.0
    lane_width: LaneWidth = STREET_LANE

    @model_validator(mode="after")
    def _junctions_fit(self) -> "Corridor":
        if min(self.ways()) < LEAST_ROOM:
            raise ValueError(f"junctions must be in order, at least {LEAST_ROOM:.0f} m apart and that far from the road's ends")
        if self.lanes_back == 0 and (self.dead_end or any(j.form == "roundabout" for j in self.junctions)):
            raise ValueError("a one-way street can neither be a dead end nor lead through roundabouts here")
        if self.lanes_back == 0 and self.median:
            raise ValueError("a one-way road has no median")
        if self.lane_width != STREET_LANE and any(j.form == "roundabout" for j in self.junctions):
            raise ValueError("rings have lanes of their own width, so that of a road with roundabouts cannot be set")
        _ = self.crossings  # raises ValueError where a turn leads nowhere
        return self

    def ways(self) -> list[float]:
        """Metres between the road's start, its junctions and its end, the halves of rings left out."""
        places = [0.0, *(j.position for j in self.junctions), self.alignment.length]
        rooms = [0.0, *(j.diameter / 2 if j.form == "roundabout" else 0.0 for j in self.junctions), 0.0]
        return [places[i + 1] - places[i] - (rooms[i] + rooms[i + 1]) for i in range(len(places) - 1)]

    @cached_property
    def crossings(self) -> tuple[Crossing | None, ...]:
        """The junctions, seen with the road heading east: its arms ahead, behind, then side roads; None for a ring."""
        return tuple(map(self._crossing, self.junctions))

    def _crossing(self, junction: Junction) -> Crossing | None:
        if junction.form == "roundabout":
            return None
        road: Any = {name: getattr(junction, name) for name in ("left_turn_lanes", "right_turn_lanes", "turn_bans")}
        side: Any = {"lanes_in": junction.side_lanes, "lanes_out": junction.side_lanes, "turn_bans": junction.side_turn_bans}
        ahead = Arm(angle=0.0, lanes_in=self.lanes_back, lanes_out=self.lanes, **road)
        behind = Arm(angle=180.0, lanes_in=self.lanes, lanes_out=self.lanes_back, **road)
        return Crossing(arms=(ahead, behind, *(Arm(angle=angle, **side) for angle in junction.directions)))

    def turn_lanes(self, number: int, back: bool = False) -> TurnLanes:
        """Those that the road gets ahead of junction `number` (from 0), or on the way `back`: towards sides with a road."""
        if (crossing := self.crossings[number]) is None:
            return NO_TURN_LANES
        length = min(self.junctions[number].pocket, POCKET_SHARE * self.ways()[number + back])
        return crossing.turn_lanes(0 if back else 1)._replace(length=length)


class Grid(Part):
    """Streets in both directions that cross at `rows` x `columns` places and go on beyond them.

    `beyond` is how far [m]; None: as far as the streets are apart.
    """

    kind: Literal["grid"] = "grid"
    rows: Annotated[int, Field(ge=1, le=8)] = 3
    columns: Annotated[int, Field(ge=1, le=8)] = 3
    spacing: Annotated[float, Field(ge=40.0, le=1000.0, allow_inf_nan=False)] = 120.0
    beyond: Annotated[float, Field(ge=20.0, le=1000.0, allow_inf_nan=False)] | None = None
    lanes: Annotated[int, Field(ge=1, le=4)] = 1
    speed: Speed = 50 / 3.6
    control: Control = "yield"
    one_way: bool = False
    lane_width: LaneWidth = STREET_LANE
