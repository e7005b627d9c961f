"""Retrieve vehicles from the asset table (paper: by the number and type of vehicles)."""

import numpy as np
from numpy.typing import NDArray

from drivegen.assets.table import Table
from drivegen.errors import UnusableInput
from drivegen.scenario import VehicleKind

ANY_LENGTH = (0.0, float("inf"))


def retrieve(
    table: Table, kind: VehicleKind, number: int, random: np.random.Generator, length: tuple[float, float] = ANY_LENGTH
) -> NDArray[np.intp]:
    """Rows (number,) of vehicles of `kind` whose length [m] lies in a range, drawn as often as they were seen.

    Only rows of the best provenance that the kind has in that range are drawn; a row may come twice.
    Raises UnusableInput, reason `no-assets`, where nothing fits.
    """
    fits = (table.kind == kind) & (table.size[:, 0] >= length[0]) & (table.size[:, 0] <= length[1])
    if not fits.any():
        low, high = length
        raise UnusableInput(f"the asset table has no {kind.name.lower()} between {low:g} and {high:g} m long", reason="no-assets")
    rows = np.flatnonzero(fits & (table.provenance == table.provenance[fits].min()))
    share = table.count[rows] / table.count[rows].sum()
    return random.choice(rows, size=number, p=share)


def draw_kinds(shares: dict[VehicleKind, float], number: int, random: np.random.Generator) -> list[VehicleKind]:
    """`number` kinds drawn by `shares`, which need not sum to one."""
    weight = np.array(list(shares.values()), np.float64)
    if not len(weight) or (weight < 0).any() or not weight.sum() > 0:
        raise UnusableInput("shares of vehicle kinds must not be negative, and one must be positive")
    drawn = random.choice(len(weight), size=number, p=weight / weight.sum())
    kinds = list(shares)
    return [kinds[i] for i in drawn.tolist()]
