"""A map as a free graph of nodes and roads, for what no kind of road describes."""

import math
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, model_validator

from drivegen.layouts.values import Control, Coordinate, Name, NoOrMoreLanes, Part, Speed

MOST_LANE_KILOMETRES = 1000.0
"""A free graph has so many kilometres of lanes at most: checking it for overlaps takes some seconds then."""


class GraphNode(Part):
    """A place of a free graph."""

    name: Name
    x: Coordinate
    y: Coordinate
    control: Control = "yield"


class GraphRoad(Part):
    """A road of a free graph, with lanes in each direction and a shape of points between its ends."""

    name: Name
    start: Name
    end: Name
    lanes: NoOrMoreLanes = 1
    lanes_back: NoOrMoreLanes = 1
    speed: Speed = 50 / 3.6
    main: bool = True
    shape: Annotated[tuple[tuple[Coordinate, Coordinate], ...], Field(max_length=100)] = ()


class LaneLink(Part):
    """Lane `from_lane` of a road leads into lane `to_lane` of another at node `at`; lane 0 is the outermost."""

    at: Name
    from_road: Name
    from_lane: Annotated[int, Field(ge=0, le=7)]
    to_road: Name
    to_lane: Annotated[int, Field(ge=0, le=7)]


class Graph(Part):
    """Any network: nodes with their control, roads between them, and lane connections where the usual ones are wrong."""

    kind: Literal["graph"] = "graph"
    nodes: Annotated[tuple[GraphNode, ...], Field(min_length=2, max_length=200)]
    roads: Annotated[tuple[GraphRoad, ...], Field(min_length=1, max_length=400)]
    links: Annotated[tuple[LaneLink, ...], Field(max_length=1000)] = ()

    @model_validator(mode="after")
    def _hangs_together(self) -> "Graph":
        nodes, roads = {n.name for n in self.nodes}, {r.name: r for r in self.roads}
        if len(nodes) != len(self.nodes) or len(roads) != len(self.roads):
            raise ValueError("two nodes or two roads share a name")
        for road in self.roads:
            if {road.start, road.end} - nodes or road.start == road.end:
                raise ValueError(f"road {road.name} must join two different nodes that exist")
            if road.lanes + road.lanes_back == 0:
                raise ValueError(f"road {road.name} has no lanes")
        if (kilometres := self._lane_kilometres()) > MOST_LANE_KILOMETRES:
            raise ValueError(f"the roads have {kilometres:.0f} km of lanes together, more than {MOST_LANE_KILOMETRES:.0f} km")
        for link in self.links:
            if link.from_road not in roads or link.to_road not in roads or link.at not in nodes:
                raise ValueError(f"a lane link at {link.at} names a road or node that does not exist")
        return self

    def _lane_kilometres(self) -> float:
        places = {node.name: (node.x, node.y) for node in self.nodes}
        lines = [((places[r.start], *r.shape, places[r.end]), r.lanes + r.lanes_back) for r in self.roads]
        return sum(lanes * math.dist(a, b) for line, lanes in lines for a, b in pairwise(line)) / 1000
