"""Routes over the lane graph: all feasible ones of a vehicle, ten seconds ahead."""

from collections.abc import Iterator

import numpy as np

from drivegen.bench import _scene
from drivegen.bench._row import Row, cpu_seconds
from drivegen.lanes.routes import feasible_routes

SCENES = 8
REACH = 150.0


def rows() -> Iterator[Row]:
    """One millisecond per vehicle is wanted."""
    graph = _scene.graph()
    starts = []
    for number in range(SCENES):
        vehicles = _scene.scene(number).vehicles
        starts += list(zip(vehicles.position, vehicles.heading, vehicles.speed, strict=True))

    def all_routes() -> None:
        for position, heading, speed in starts:
            feasible_routes(graph, position, float(heading), float(speed), REACH)

    def without_index() -> None:
        points, start = _scene.road_map().centreline.points, _scene.road_map().centreline.start
        for position, _, _ in starts:
            np.minimum.reduceat(np.hypot(*(points - position).T), start[:-1])

    value = cpu_seconds(all_routes) / len(starts) * 1e3
    reference = cpu_seconds(without_index) / len(starts) * 1e3
    yield Row("routes of a vehicle", value, "ms", 1.0, True, reference, "distance to all lanes alone, without an index")
