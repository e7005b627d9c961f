"""Routes over the lane graph: all feasible ones of a vehicle, ten seconds ahead."""

from collections.abc import Iterator

from drivegen.bench import _scene
from drivegen.bench._row import Row, best_cpu_seconds
from drivegen.roads.routes import feasible_routes

SCENES = 8
REACH = 150.0


def rows() -> Iterator[Row]:
    """One millisecond per vehicle is wanted."""
    graph = _scene.graph()
    starts = []
    for number in range(SCENES):
        vehicles = _scene.scene(number).vehicles
        starts += list(zip(vehicles.position, vehicles.heading, vehicles.speed, strict=True))

    def routes() -> None:
        for position, heading, speed in starts:
            feasible_routes(graph, position, float(heading), float(speed), REACH)

    yield Row("routes of a vehicle", best_cpu_seconds(routes) / len(starts) * 1e3, "ms", 1.0, True)
