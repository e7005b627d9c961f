"""The line of a road seen from above: straights and bends."""

import math
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from drivegen.layouts.values import Length, Part, Radius, Turn

SHORTEST_STRAIGHT = 30.0
"""Roads are straight for so long before their first bend and behind their last one at least [m]."""

HAIRPIN = 180.0
"""The turn of a hairpin, where nothing is said of it [degrees]."""


class Alignment(Part):
    """The line of a road seen from above, from its start heading east.

    `angle` is the turn of each bend, positive to the left; a hairpin is a curve of about 180 degrees, which is its angle where
    none is given, the loop of a ramp one of about 270. `bends` is how many follow one another, to the left and right in turn;
    None: two in an S-curve, else one.
    Bends that differ are told one by one in `arcs`, each as (angle, radius); `angle`, `radius` and `bends` are left out then.
    """

    shape: Literal["straight", "curve", "s_curve", "hairpin"] = "straight"
    length: Length = 600.0
    angle: Turn = 90.0
    radius: Radius = 60.0
    bends: Annotated[int, Field(ge=1, le=8)] | None = None
    arcs: Annotated[tuple[tuple[Turn, Radius], ...], Field(max_length=8)] = ()

    @model_validator(mode="before")
    @classmethod
    def _hairpins_turn_back(cls, fields: Any) -> Any:
        """The fields with the angle of a hairpin that has none."""
        if not isinstance(fields, dict) or fields.get("shape") != "hairpin" or fields.get("arcs"):
            return fields
        return {"angle": HAIRPIN, **fields}

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
        return max(SHORTEST_STRAIGHT, (self.length - self._arcs) / self.straights) if self.curves else self.length / 2

    @property
    def too_short(self) -> bool:
        """Whether its bends make the road longer than `length`."""
        return bool(self.curves) and self.length < self._arcs + SHORTEST_STRAIGHT * self.straights

    @property
    def _arcs(self) -> float:
        return sum(abs(math.radians(angle)) * radius for angle, radius in self.curves)

    @property
    def spans(self) -> tuple[tuple[float, float], ...]:
        """Where along the road every bend begins and ends [m]."""
        arcs, at = [], self.straight
        for angle, radius in self.curves:
            arc = abs(math.radians(angle)) * radius
            arcs.append((at, at + arc))
            at += arc + (self.straight if self.shape == "hairpin" else 0.0)
        return tuple(arcs)

    @property
    def straights(self) -> int:
        """How many straights there are: two, or one more than hairpins."""
        return len(self.curves) + 1 if self.shape == "hairpin" else 2
