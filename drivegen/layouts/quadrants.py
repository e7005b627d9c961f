"""Two roads on different levels whose ramps lie in the quadrants between their legs: cloverleaves, trumpets, single loops."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from drivegen.layouts.values import USUAL_MEDIAN, Control, Length, Part, Speed

QUADRANTS = ("south_east", "north_east", "north_west", "south_west")
"""Counter-clockwise, as the carriageways that leave the bridge beside them head: east, north, west, south."""

_SIDES = ("north", "south")

Ramps = Literal["none", "direct", "loop", "both"]
"""What lies in a quadrant: nothing; a direct ramp around its corner; a loop of 270 degrees; a direct ramp around a loop."""


class QuadrantInterchange(Part):
    """A highway from west to east under a road from south to north, with loops and direct ramps in their four quadrants.

    Where traffic keeps right, a direct ramp leads to the right, from one leg to the next, and a loop to the left: it leaves
    behind the bridge and turns 270 degrees to the right; where traffic keeps left the other way round. Nothing crosses
    anything, so there is no junction: who has no ramp for a turn cannot turn. All four loops are a full cloverleaf, some of
    them a partial one.

    With a `control` the road is a street in both directions, on which ramps end at crossings: two on either side of the
    highway, one for loops and one for direct ramps. There all turns are possible, so left turns need no loop.

    Where the road ends at the highway (`north_leg` or `south_leg` false) it is a trumpet: behind the bridge one quadrant has
    "both", the other one "none". The loop is one carriageway of the road then, and the direct ramp, which leads around it,
    the other one.

    Attributes:
        lanes, speed: of the highway, per carriageway. road_lanes, road_speed: of the road above it.
        ramp_lanes: of every ramp. ramp_speed: limit on direct ramps. loop_radius: of loops [m], in the middle of the ramp.
        median: between the carriageways of either road [m]. leg_length: of each leg beyond its ramps [m].
        control: of the street's crossings; None where the road has carriageways of its own and ramps that join them.
    """

    kind: Literal["quadrant_interchange"] = "quadrant_interchange"
    north_east: Ramps = "both"
    north_west: Ramps = "both"
    south_west: Ramps = "both"
    south_east: Ramps = "both"
    north_leg: bool = True
    south_leg: bool = True
    lanes: Annotated[int, Field(ge=1, le=6)] = 2
    speed: Speed = 120 / 3.6
    road_lanes: Annotated[int, Field(ge=1, le=4)] = 2
    road_speed: Speed = 100 / 3.6
    ramp_lanes: Annotated[int, Field(ge=1, le=2)] = 1
    ramp_speed: Speed = 60 / 3.6
    loop_radius: Annotated[float, Field(ge=25.0, le=80.0, allow_inf_nan=False)] = 45.0
    loop_speed: Speed = 40 / 3.6
    median: Annotated[float, Field(ge=2.0, le=30.0, allow_inf_nan=False)] = USUAL_MEDIAN
    leg_length: Length = 150.0
    control: Control | None = None

    @model_validator(mode="after")
    def _ramps_have_legs(self) -> "QuadrantInterchange":
        if not (self.loops or self.directs):
            raise ValueError("an interchange needs at least one ramp")
        if self.north_leg and self.south_leg:
            return self
        if self.control is not None:
            raise ValueError("a trumpet has no crossings that could be controlled")
        if not (self.north_leg or self.south_leg):
            raise ValueError("a road over the highway has at least one leg")
        behind, before = ("south", "north") if self.north_leg else ("north", "south")
        if {getattr(self, f"{behind}_east"), getattr(self, f"{behind}_west")} != {"both", "none"}:
            raise ValueError(f"where the road has no {behind} leg, one {behind}ern quadrant has both ramps and the other none")
        if any(name.startswith(before) for name in self.loops):
            raise ValueError(f"where the road has no {behind} leg, there are no loops in the {before}ern quadrants")
        return self

    @property
    def loops(self) -> tuple[str, ...]:
        """The quadrants with a loop."""
        return tuple(name for name in QUADRANTS if getattr(self, name) in ("loop", "both"))

    @property
    def directs(self) -> tuple[str, ...]:
        """The quadrants with a direct ramp."""
        return tuple(name for name in QUADRANTS if getattr(self, name) in ("direct", "both"))

    @property
    def trumpet(self) -> bool:
        """Whether the road ends at the highway."""
        return not (self.north_leg and self.south_leg)

    @property
    def terminals(self) -> tuple[int, ...]:
        """Roads that meet at each of the street's crossings, most first."""
        sides = [[name for name in ramps if name.startswith(side)] for ramps in (self.loops, self.directs) for side in _SIDES]
        return tuple(sorted((2 + len(ramps) for ramps in sides if ramps), reverse=True)) if self.control is not None else ()
