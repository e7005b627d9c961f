"""Free graphs: nodes and roads as they stand in the specification."""

from drivegen.layouts.compilers.crossings import MAIN, MINOR, NODE_TYPES
from drivegen.layouts.graph import Graph, GraphRoad, LaneLink
from drivegen.sumo.plain import Connection, Edge, Node, PlainNetwork


def compile_graph(spec: Graph, plain: PlainNetwork) -> None:
    """Draw every road as one edge per direction."""
    places = {node.name: (node.x, node.y) for node in spec.nodes}
    plain.nodes += [Node(node.name, node.x, node.y, NODE_TYPES[node.control]) for node in spec.nodes]
    for road in spec.roads:
        priority = MAIN if road.main else MINOR
        shape = (places[road.start], *road.shape, places[road.end]) if road.shape else ()
        if road.lanes:
            plain.edges.append(Edge(road.name, road.start, road.end, road.lanes, road.speed, priority, shape))
        if road.lanes_back:
            back = Edge(f"-{road.name}", road.end, road.start, road.lanes_back, road.speed, priority, shape[::-1])
            plain.edges.append(back)
    roads = {road.name: road for road in spec.roads}
    plain.connections += [_connection(link, roads) for link in spec.links]


def _connection(link: LaneLink, roads: dict[str, GraphRoad]) -> Connection:
    towards, away = roads[link.from_road], roads[link.to_road]
    source = towards.name if towards.end == link.at else f"-{towards.name}"
    target = away.name if away.start == link.at else f"-{away.name}"
    return Connection(source, target, link.from_lane, link.to_lane)
