"""The typed map specification: what a road looks like, before any coordinates.

A specification is either a kind with parameters or a free graph of nodes and roads. Whoever writes it (rules, a
language model, a person) fills these types; `compile.py` turns them into a network, always the same one. Metres, metres
per second, degrees counter-clockwise from east; lanes are counted per direction. Every number is bounded, because a
specification may come from a model.
"""

from typing import Annotated, Any

from pydantic import Field, model_validator

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

    @model_validator(mode="before")
    @classmethod
    def _outer_side_where_none_is_said(cls, value: Any) -> Any:
        """Lanes end and begin on the outer side, which is the left one where traffic keeps left."""
        if not (isinstance(value, dict) and value.get("left_hand") is True and isinstance(value.get("road"), dict)):
            return value
        road = value["road"]
        if not isinstance(road.get("events"), list | tuple):
            return value
        events = [{"side": "left", **event} if isinstance(event, dict) else event for event in road["events"]]
        return {**value, "road": {**road, "events": events}}
