"""Highways and where they branch: ramps, forks, interchanges with a road above them."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from drivegen.layouts.alignment import Alignment
from drivegen.layouts.values import HIGHWAY_LANE, USUAL_MEDIAN, Control, Lanes, LaneWidth, Length, Part, Side, Speed

LEAST_BETWEEN = 40.0
"""Metres of plain road between two events, and behind the last one, at least."""


class HighwayEvent(Part):
    """What happens along a carriageway, `position` metres from its start.

    Attributes:
        kind: a ramp joins (on the outer side, over an acceleration lane `length` long) or leaves; lanes end or begin;
            or a ramp joins and another leaves with an auxiliary lane between them (weaving section).
        lanes: of the ramp, or by how many the carriageway changes.
        keeps: the ramp's lanes are the carriageway's outer ones: an off-ramp takes them along (exit only), an on-ramp brings
            them to stay. Else they are added and end beside it.
        side: of lanes that end or begin, the outer one (of a `MapSpec`) where none is said; ramps are always on that side.
    """

    kind: Literal["on_ramp", "off_ramp", "lane_drop", "lane_gain", "weaving"]
    position: Annotated[float, Field(ge=50.0, le=10000.0, allow_inf_nan=False)]
    lanes: Annotated[int, Field(ge=1, le=3)] = 1
    length: Annotated[float, Field(ge=50.0, le=1500.0, allow_inf_nan=False)] = 200.0
    ramp_speed: Speed = 60 / 3.6
    side: Side = "right"
    keeps: bool = False

    @property
    def change(self) -> int:
        """By how many lanes the carriageway is wider behind it."""
        if self.kind in ("lane_gain", "lane_drop") or (self.keeps and self.kind != "weaving"):
            return self.lanes if self.kind in ("lane_gain", "on_ramp") else -self.lanes
        return 0


class Highway(Part):
    """A road without crossings, one carriageway per direction with nodes of its own.

    `lanes` is the number at its start, per carriageway. Events happen on the first carriageway, and on the other one
    too, seen from its own start, where `both` says so. `carriageways` 1 is a one-way highway.
    """

    kind: Literal["highway"] = "highway"
    alignment: Alignment = Alignment(length=1000.0, radius=400.0)
    lanes: Lanes = 3
    speed: Speed = 120 / 3.6
    carriageways: Literal[1, 2] = 2
    median: Annotated[float, Field(ge=1.0, le=60.0, allow_inf_nan=False)] = USUAL_MEDIAN
    events: Annotated[tuple[HighwayEvent, ...], Field(max_length=8)] = ()
    both: bool = False
    lane_width: LaneWidth = HIGHWAY_LANE

    @model_validator(mode="after")
    def _events_fit(self) -> "Highway":
        here, lanes = 0.0, self.lanes
        for event in self.events:
            if event.position < here + LEAST_BETWEEN:
                raise ValueError(f"the {event.kind} at {event.position:.0f} m starts before what comes ahead of it has ended")
            here = event.position + (event.length if event.kind in ("on_ramp", "off_ramp", "weaving") else 0.0)
            lanes += event.change
            if not 1 <= lanes <= 8:
                raise ValueError(f"{lanes} lanes would be left after the {event.kind} at {event.position:.0f} m")
        if self.events and here + LEAST_BETWEEN > self.alignment.length:
            raise ValueError(f"the road is {self.alignment.length:.0f} m long, too short for what happens along it")
        return self


class Fork(Part):
    """A one-way road that splits into two branches, `angle` degrees apart; or, where `joins`, two that become one.

    `length` is that of each branch, `stem` that of the single road before the split, or behind it where `joins`; None: as
    long as the branches.
    """

    kind: Literal["fork"] = "fork"
    lanes: Lanes = 2
    left_lanes: Lanes = 1
    right_lanes: Lanes = 1
    angle: Annotated[float, Field(ge=10.0, le=120.0, allow_inf_nan=False)] = 40.0
    speed: Speed = 70 / 3.6
    length: Length = 200.0
    stem: Length | None = None
    joins: bool = False
    lane_width: LaneWidth = HIGHWAY_LANE

    @property
    def stem_length(self) -> float:
        """Length of the single road [m]."""
        return self.length if self.stem is None else self.stem

    @model_validator(mode="after")
    def _lanes_go_on(self) -> "Fork":
        if max(self.left_lanes, self.right_lanes) > self.lanes or self.left_lanes + self.right_lanes < self.lanes:
            raise ValueError("a branch has at most the road's lanes, and both together at least as many")
        return self


class Interchange(Part):
    """Where a highway and a road over it meet by ramps, which end at crossings on that road (ramp terminals).

    `form` says which of the four ramps there are: "diamond" all; "half_diamond" an off-ramp from the first carriageway and an
    on-ramp to the other one, both on one side of the road; "side" an off-ramp and an on-ramp of the first carriageway;
    "terminal" its off-ramp alone. The road passes over the highway without a junction, `HEIGHT` metres above it.
    """

    kind: Literal["interchange"] = "interchange"
    form: Literal["diamond", "half_diamond", "side", "terminal"] = "diamond"
    lanes: Annotated[int, Field(ge=1, le=6)] = 2
    speed: Speed = 100 / 3.6
    ramp_lanes: Annotated[int, Field(ge=1, le=2)] = 1
    ramp_speed: Speed = 50 / 3.6
    road_lanes: Annotated[int, Field(ge=1, le=4)] = 1
    road_speed: Speed = 50 / 3.6
    road_length: Length = 150.0
    control: Control = "signals"
