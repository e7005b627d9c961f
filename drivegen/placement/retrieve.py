"""Retrieve vehicles from the asset table (paper: by the number and type of vehicles), also by size and usual speed."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import VehicleKind
from drivegen.placement.table import Table

Range = tuple[float, float]

ANY: Range = (0.0, float("inf"))


@dataclass(frozen=True)
class Asked:
    """What vehicles may be like, ends included: `length`, `width`, `height` [m], usual `speed` [m/s]."""

    length: Range = ANY
    width: Range = ANY
    height: Range = ANY
    speed: Range = ANY

    def fits(self, table: Table) -> NDArray[np.bool_]:
        """(A,) rows within all ranges."""
        values = np.column_stack([table.size, table.usual_speed])
        low, high = np.array([self.length, self.width, self.height, self.speed], np.float32).T
        anything = (low == 0) & np.isinf(high)  # also what nobody knows
        return np.asarray((anything | ((values >= low) & (values <= high))).all(-1))

    def __str__(self) -> str:
        ranges = {"long": self.length, "wide": self.width, "high": self.height, "fast": self.speed}
        phrases = [f"{a:g} to {b:g} {'m/s' if how == 'fast' else 'm'} {how}" for how, (a, b) in ranges.items() if (a, b) != ANY]
        return ", ".join(phrases) or "of any size"


def retrieve(
    table: Table, kind: VehicleKind, number: int, random: np.random.Generator, asked: Asked | None = None
) -> NDArray[np.intp]:
    """Rows (number,) of vehicles of `kind` that are as `asked`, drawn as often as they were seen.

    Only rows of the best provenance that the kind has in those ranges are drawn; a row may come twice. Where each is from
    stands in the table (`provenance`, `source`). Raises UnusableInput, reason `no-assets`, where nothing fits.
    """
    asked = asked or Asked()
    fits = (table.kind == kind) & asked.fits(table)
    if not fits.any():
        raise UnusableInput(f"the asset table has no {kind.name.lower()} {asked}", reason="no-assets")
    rows = np.flatnonzero(fits & (table.provenance == table.provenance[fits].min()))
    share = table.count[rows] / table.count[rows].sum()
    return random.choice(rows, size=number, p=share)


def draw_kinds(shares: dict[VehicleKind, float], number: int, random: np.random.Generator) -> list[VehicleKind]:
    """`number` kinds drawn by `shares`, which need not sum to one."""
    weight = np.array(list(shares.values()), np.float64)
    if not len(weight) or (weight < 0).any() or not weight.sum() > 0:
        raise UnusableInput("shares of vehicle kinds must not be negative, and one must be positive")
    indices = random.choice(len(weight), size=number, p=weight / weight.sum())
    kinds = list(shares)
    return [kinds[i] for i in indices.tolist()]
