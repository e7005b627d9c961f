"""The typed map specification: what a road looks like, before any coordinates.

A specification is either a kind with parameters or a free graph of nodes and roads. Whoever writes it (rules, a
language model, a person) fills these types; `compile.py` turns them into a network, always the same one. Metres, metres
per second, degrees counter-clockwise from east; lanes are counted per direction. Every number is bounded, because a
specification may come from a model.
"""

from typing import Annotated

from pydantic import Field

from drivegen.layouts.crossings import Crossing, Roundabout
from drivegen.layouts.graph import Graph
from drivegen.layouts.highways import Fork, Highway, Interchange
from drivegen.layouts.quadrants import QuadrantInterchange
from drivegen.layouts.streets import Corridor, Grid
from drivegen.layouts.values import Part

Road = Annotated[
    Crossing | Roundabout | Corridor | Grid | Highway | Fork | Interchange | QuadrantInterchange | Graph,
    Field(discriminator="kind"),
]


class MapSpec(Part):
    """A whole map: one road layout and the side that traffic keeps to."""

    road: Road
    left_hand: bool = False
