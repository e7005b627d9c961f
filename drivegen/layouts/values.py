"""The bounded numbers and words that map specifications are made of.

Metres, metres per second, degrees counter-clockwise from east; lanes are counted per direction.
"""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

Lanes = Annotated[int, Field(ge=1, le=8)]
NoOrMoreLanes = Annotated[int, Field(ge=0, le=8)]
Speed = Annotated[float, Field(ge=1.0, le=45.0, allow_inf_nan=False)]
Length = Annotated[float, Field(ge=20.0, le=10000.0, allow_inf_nan=False)]
TurnLaneCount = Annotated[int, Field(ge=0, le=3)]
LaneWidth = Annotated[float, Field(ge=2.5, le=5.0, allow_inf_nan=False)]
Pocket = Annotated[float, Field(ge=15.0, le=500.0, allow_inf_nan=False)]
Angle = Annotated[float, Field(ge=-360.0, le=360.0, allow_inf_nan=False)]
Turn = Annotated[float, Field(ge=-280.0, le=280.0, allow_inf_nan=False)]
Radius = Annotated[float, Field(ge=12.0, le=3000.0, allow_inf_nan=False)]
Median = Annotated[float, Field(ge=0.0, le=30.0, allow_inf_nan=False)]
Coordinate = Annotated[float, Field(ge=-10000.0, le=10000.0, allow_inf_nan=False)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,23}$")]

Control = Literal["signals", "all_way_stop", "stop", "yield", "uncontrolled"]
"""Who goes first: signals; everybody stops; the side roads stop or yield; right before left."""

Side = Literal["left", "right"]

USUAL_MEDIAN = 4.0
"""Of a road that is divided, where nothing more is said [m]."""

STREET_LANE, HIGHWAY_LANE = 3.2, 3.5
"""Usual widths of lanes [m]; SUMO's own is that of streets."""

CONVENTION = (
    "'N lanes in each direction' is always right. 'N lanes' are in each direction, 'a four-lane road' has four in both "
    "directions together. On motorways, one-way roads, ramps, forks and rings every number of lanes is that of one carriageway. "
    "Turn lanes are counted on each road into a junction."
)
"""How lanes are counted, for help and for language models."""


class Part(BaseModel):
    """A part of a specification: nothing but its fields, and never changed."""

    model_config = ConfigDict(extra="forbid", frozen=True)
