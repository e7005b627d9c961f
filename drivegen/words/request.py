"""What traffic is asked for: numbers, kinds, density, speed, places beside the target, manoeuvres with times.

The same types are what `drivegen.words` reads and what a language model answers. A request never says more than its
words: what is None or empty is left to the settings.
"""

from collections import Counter
from enum import StrEnum
from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from drivegen.core.relation import Relation
from drivegen.core.scenario import VehicleKind

MOST = 127
"""Vehicles beside the target at most."""


class Kind(StrEnum):
    """Kinds of vehicles that can be asked for; VEHICLE leaves the kind open."""

    CAR = "car"
    TRUCK = "truck"
    BUS = "bus"
    VEHICLE = "vehicle"

    @property
    def vehicle_kind(self) -> VehicleKind | None:
        """As the asset table has it; None where it is left open."""
        return None if self is Kind.VEHICLE else VehicleKind[self.name]


class Density(StrEnum):
    """How close together vehicles stand; NONE: there is nobody but the target."""

    NONE = "none"
    SPARSE = "sparse"
    MEDIUM = "medium"
    DENSE = "dense"


class Manoeuvre(StrEnum):
    """What one vehicle does within the scenario; left and right are the vehicle's own.

    CUT_IN: from a lane beside the target's into it, in front of the target. HARD_BRAKING: brakes by more than is
    comfortable, ahead of the target unless another place is asked for. STOPPED: stands throughout, ahead likewise. OVERTAKE:
    begins behind the target and ends ahead of it.
    TURN_LEFT_ACROSS: oncoming, turns left across the target's way. GO_STRAIGHT: straight on over a junction that others cross.
    """

    CUT_IN = "cut_in"
    HARD_BRAKING = "hard_braking"
    STOPPED = "stopped"
    OVERTAKE = "overtake"
    TURN_LEFT_ACROSS = "turn_left_across"
    TURN_LEFT = "turn_left"
    TURN_RIGHT = "turn_right"
    GO_STRAIGHT = "go_straight"
    CHANGE_LEFT = "change_left"
    CHANGE_RIGHT = "change_right"


AT_JUNCTIONS = frozenset({Manoeuvre.TURN_LEFT_ACROSS, Manoeuvre.TURN_LEFT, Manoeuvre.TURN_RIGHT, Manoeuvre.GO_STRAIGHT})
"""What can be done where roads meet alone."""


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Group(_Part):
    """Vehicles that are asked for together.

    `place` is where they stand at the first frame as seen from the target, `distance` [m] how far along the road from the
    target's centre to theirs, `queue` whether they stand one behind another in one lane. `speed` [m/s] is at the first frame.
    One vehicle of the group does `manoeuvre`, to be finished `within` [s] of the first frame.
    """

    count: Annotated[int, Field(ge=1, le=MOST)] = 1
    kind: Kind = Kind.VEHICLE
    place: Relation | None = None
    distance: Annotated[float, Field(ge=3, le=120)] | None = None
    speed: Annotated[float, Field(ge=0, le=60)] | None = None
    queue: bool = False
    manoeuvre: Manoeuvre | None = None
    within: Annotated[float, Field(gt=0, le=10)] | None = None

    @model_validator(mode="after")
    def _from_behind(self) -> Self:
        beside = (None, Relation.LEFT, Relation.RIGHT)
        if self.manoeuvre == Manoeuvre.OVERTAKE and self.place not in beside and not str(self.place).endswith("behind"):
            raise ValueError(f"who overtakes begins behind the target, not {self.place}")
        return self


class TrafficRequest(_Part):
    """Traffic around one target vehicle; `speed` [m/s] is about what everybody drives at the first frame.

    `target_kind`, `target_speed` [m/s], `target_does`: of the target itself.
    """

    groups: Annotated[tuple[Group, ...], Field(max_length=20)] = ()
    density: Density | None = None
    speed: Annotated[float, Field(ge=0, le=60)] | None = None
    target_kind: Kind | None = None
    target_speed: Annotated[float, Field(ge=0, le=60)] | None = None
    target_does: Manoeuvre | None = None

    @model_validator(mode="after")
    def _bounded(self) -> Self:
        if self.vehicles > MOST:
            raise ValueError(f"{self.vehicles} vehicles are asked for: {MOST} at most")
        if self.target_does in (Manoeuvre.CUT_IN, Manoeuvre.OVERTAKE, Manoeuvre.TURN_LEFT_ACROSS):
            raise ValueError(f"the target itself cannot {self.target_does}: that is what others do to it")
        return self

    @property
    def vehicles(self) -> int:
        """Asked for beside the target."""
        return sum(group.count for group in self.groups)

    @property
    def kinds(self) -> Counter[Kind]:
        """How many of each kind."""
        return Counter(group.kind for group in self.groups for _ in range(group.count))

    @property
    def manoeuvres(self) -> frozenset[Manoeuvre]:
        """What somebody is to do, the target included."""
        done = (self.target_does, *(group.manoeuvre for group in self.groups))
        return frozenset(manoeuvre for manoeuvre in done if manoeuvre is not None)

    def __bool__(self) -> bool:
        return self != TrafficRequest()
