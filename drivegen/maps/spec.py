"""The typed map specification: what a road looks like, before any coordinates.

A specification is either a kind with parameters or a free graph of nodes and roads. Whoever writes it (rules, a
language model, a person) fills these types; `compile.py` turns them into a network, always the same one. Metres, metres
per second, degrees counter-clockwise from east; lanes are counted per direction. Every number is bounded, because a
specification may come from a model.
"""

import math
from typing import Annotated, Literal, NamedTuple

from pydantic import Field, model_validator

from drivegen.maps.spec_graph import Graph
from drivegen.maps.spec_quadrants import QuadrantInterchange
from drivegen.maps.spec_values import Angle, Control, Lanes, Length, NoOrMoreLanes, Part, Pocket, Radius, Side, Speed, Turn

SMALLEST_RING, SMALLEST_WIDE_RING = 14.0, 24.0
"""Least outer diameter of a roundabout [m], a mini-roundabout's with one lane on its ring, and with more lanes."""

RING_LANE = 4.0
"""Width of a lane of a ring [m]."""

LEAST_ARC, LEAST_WIDE_ARC = 7.8, 9.0
"""Least distance along the ring between two roads [m], on a ring with one lane (a mini-roundabout's) and with more."""

SHORTEST_STRAIGHT = 30.0
"""Roads are straight for so long before their first bend and behind their last one at least [m]."""

POCKET_SHARE = 0.4
"""Turn lanes along a corridor take so much of the way between two junctions at most, for both may have some on it."""


_MOST_ON_A_SIDE = 3


class Alignment(Part):
    """The line of a road seen from above, from its start heading east.

    `angle` is the turn of each bend, positive to the left; a hairpin is a curve of about 180 degrees, the loop of a ramp one
    of about 270. `bends` is how many follow one another, to the left and right in turn; None: two in an S-curve, else one.
    Bends that differ are told one by one in `arcs`, each as (angle, radius); `angle`, `radius` and `bends` are left out then.
    """

    shape: Literal["straight", "curve", "s_curve", "hairpin"] = "straight"
    length: Length = 600.0
    angle: Turn = 90.0
    radius: Radius = 60.0
    bends: Annotated[int, Field(ge=1, le=8)] | None = None
    arcs: Annotated[tuple[tuple[Turn, Radius], ...], Field(max_length=8)] = ()

    @model_validator(mode="after")
    def _bends_are_told_once(self) -> "Alignment":
        if self.arcs and (self.shape == "straight" or (abs(self.angle), self.radius, self.bends) != (90.0, 60.0, None)):
            raise ValueError("arcs stand for the angle, radius and number of bends of a road that is not straight")
        return self

    @property
    def curves(self) -> tuple[tuple[float, float], ...]:
        """The turn [degrees] and radius [m] of every bend, in order."""
        count = self.bends or {"straight": 0, "s_curve": 2}.get(self.shape, 1)
        alike = tuple((self.angle * (-1) ** i, self.radius) for i in range(count if self.shape != "straight" else 0))
        return self.arcs or alike

    @property
    def turns(self) -> tuple[float, ...]:
        """The turn of every bend [degrees], in order."""
        return tuple(angle for angle, _ in self.curves)

    @property
    def straight(self) -> float:
        """Length of each of the straights [m]: beside the bends, and between hairpins."""
        arcs = sum(abs(math.radians(angle)) * radius for angle, radius in self.curves)
        return max(SHORTEST_STRAIGHT, (self.length - arcs) / self.straights) if self.curves else self.length / 2

    @property
    def spans(self) -> tuple[tuple[float, float], ...]:
        """Where along the road every bend begins and ends [m]."""
        found, at = [], self.straight
        for angle, radius in self.curves:
            arc = abs(math.radians(angle)) * radius
            found.append((at, at + arc))
            at += arc + (self.straight if self.shape == "hairpin" else 0.0)
        return tuple(found)

    @property
    def straights(self) -> int:
        """How many straights there are: two, or one more than hairpins."""
        return len(self.curves) + 1 if self.shape == "hairpin" else 2


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
        if min(gaps) < 20:
            raise ValueError("arms must be at least 20 degrees apart")
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
        _check_ring(self.ring_lanes, self.diameter)
        least = _least_diameter([arm.angle for arm in self.arms], self.ring_lanes)
        if self.diameter < least:
            raise ValueError(f"{len(self.arms)} roads need a roundabout of at least {math.ceil(least)} m across")
        return self


def _least_diameter(angles: list[float], lanes: int) -> float:
    """The smallest outer diameter [m] at which the roads that meet a ring are far enough apart."""
    ordered = sorted(angle % 360 for angle in angles)
    gaps = [b - a for a, b in zip(ordered, [*ordered[1:], ordered[0] + 360], strict=True)]
    arc = LEAST_ARC if lanes == 1 else LEAST_WIDE_ARC
    return 2 * arc / math.radians(min(gaps)) + lanes * RING_LANE


def _check_ring(lanes: int, diameter: float) -> None:
    if lanes > 1 and diameter < SMALLEST_WIDE_RING:
        raise ValueError(f"a ring with {lanes} lanes must be at least {SMALLEST_WIDE_RING:.0f} m across, not {diameter:g} m")


class Junction(Part):
    """One place along a corridor where side roads join: at `position` along it, on the sides named; several on one side are
    spread evenly over it, so that three to eight roads meet.

    At a crossing the main road may have turn lanes, in each direction that has a side road to turn to; they are `pocket`
    long, at most `POCKET_SHARE` of the way from what lies before the crossing. A roundabout has none.
    """

    position: Annotated[float, Field(ge=30.0, le=10000.0, allow_inf_nan=False)]
    sides: Annotated[tuple[Side, ...], Field(min_length=1, max_length=6)] = ("left", "right")
    form: Literal["crossing", "roundabout"] = "crossing"
    control: Control = "yield"
    side_lanes: Lanes = 1
    side_speed: Speed = 50 / 3.6
    side_length: Length = 120.0
    left_turn_lane: bool = False
    right_turn_lane: bool = False
    pocket: Pocket = 60.0
    dead_end: bool = False
    ring_lanes: Annotated[int, Field(ge=1, le=3)] = 1
    diameter: Annotated[float, Field(ge=SMALLEST_RING, le=120.0, allow_inf_nan=False)] = 40.0

    @model_validator(mode="after")
    def _lanes_fit_into_the_ring(self) -> "Junction":
        if max(self.sides.count("left"), self.sides.count("right")) > _MOST_ON_A_SIDE:
            raise ValueError(f"at most {_MOST_ON_A_SIDE} roads join on one side of a junction along a road")
        if self.form == "roundabout":
            _check_ring(self.ring_lanes, self.diameter)
            least = _least_diameter([0.0, 180.0, *self.directions], self.ring_lanes)
            if self.diameter < least:
                raise ValueError(f"{2 + len(self.sides)} roads need a roundabout of at least {math.ceil(least)} m across")
        return self

    @property
    def directions(self) -> tuple[float, ...]:
        """Directions of the side roads against the corridor's own [degrees, to the left], in the order of `sides`."""
        found = []
        for i, side in enumerate(self.sides):
            step = 180.0 / (1 + self.sides.count(side))
            found.append(step * (1 + self.sides[:i].count(side)) + (0.0 if side == "left" else 180.0))
        return tuple(found)


class TurnLanes(NamedTuple):
    """How many turn lanes an approach has on either side, and their length [m]."""

    left: int
    right: int
    length: float


NO_TURN_LANES = TurnLanes(0, 0, 0.0)


class Corridor(Part):
    """A road of any line with junctions along it: crossings or roundabouts in a row, side streets, a staggered junction.

    Without junctions it is a plain street. `dead_end` closes its far end with a turning place (cul-de-sac).
    """

    kind: Literal["corridor"] = "corridor"
    alignment: Alignment = Alignment()
    lanes: Lanes = 1
    lanes_back: NoOrMoreLanes = 1
    speed: Speed = 50 / 3.6
    junctions: Annotated[tuple[Junction, ...], Field(max_length=12)] = ()
    dead_end: bool = False

    @model_validator(mode="after")
    def _junctions_fit(self) -> "Corridor":
        if min(self._ways()) < 20:
            raise ValueError("junctions must be in order, at least 20 m apart and that far from the road's ends")
        if self.lanes_back == 0 and (self.dead_end or any(j.form == "roundabout" for j in self.junctions)):
            raise ValueError("a one-way street can neither be a dead end nor lead through roundabouts here")
        return self

    def _ways(self) -> list[float]:
        """Metres between the road's start, its junctions and its end, the halves of rings left out."""
        places = [0.0, *(j.position for j in self.junctions), self.alignment.length]
        rooms = [0.0, *(j.diameter / 2 if j.form == "roundabout" else 0.0 for j in self.junctions), 0.0]
        return [places[i + 1] - places[i] - (rooms[i] + rooms[i + 1]) for i in range(len(places) - 1)]

    def turn_lanes(self, number: int, back: bool = False) -> TurnLanes:
        """Those that the road gets ahead of junction `number` (from 0), or on the way `back`: towards sides with a road."""
        junction, (left, right) = self.junctions[number], ("right", "left") if back else ("left", "right")
        here = junction.form == "crossing" and (not back or self.lanes_back > 0)
        return TurnLanes(
            int(here and junction.left_turn_lane and left in junction.sides),
            int(here and junction.right_turn_lane and right in junction.sides),
            min(junction.pocket, POCKET_SHARE * self._ways()[number + back]),
        )


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


class HighwayEvent(Part):
    """What happens along a carriageway, `position` metres from its start.

    Attributes:
        kind: a ramp joins (on the outer side, over an acceleration lane `length` long) or leaves; lanes end or begin;
            or a ramp joins and another leaves with an auxiliary lane between them (weaving section).
        lanes: of the ramp, or by how many the carriageway changes.
        keeps: the ramp's lanes are the carriageway's outer ones: an off-ramp takes them along (exit only), an on-ramp brings
            them to stay. Else they are added and end beside it.
        side: of lanes that end or begin; ramps are always on the outer side.
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
    median: Annotated[float, Field(ge=1.0, le=60.0, allow_inf_nan=False)] = 4.0
    events: Annotated[tuple[HighwayEvent, ...], Field(max_length=8)] = ()
    both: bool = False

    @model_validator(mode="after")
    def _events_fit(self) -> "Highway":
        here, lanes = 0.0, self.lanes
        for event in self.events:
            if event.position < here + 40:
                raise ValueError(f"the {event.kind} at {event.position:.0f} m starts before what comes ahead of it has ended")
            here = event.position + (event.length if event.kind in ("on_ramp", "off_ramp", "weaving") else 0.0)
            lanes += event.change
            if not 1 <= lanes <= 8:
                raise ValueError(f"{lanes} lanes would be left after the {event.kind} at {event.position:.0f} m")
        if self.events and here + 40 > self.alignment.length:
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


Road = Annotated[
    Crossing | Roundabout | Corridor | Grid | Highway | Fork | Interchange | QuadrantInterchange | Graph,
    Field(discriminator="kind"),
]


class MapSpec(Part):
    """A whole map: one road layout and the side that traffic keeps to."""

    road: Road
    left_hand: bool = False
