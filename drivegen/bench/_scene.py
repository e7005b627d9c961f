"""The scenes that benchmarks work on: a street grid of our own with vehicles that follow its lanes; no file is needed."""

from functools import cache

import numpy as np

from drivegen.core.geometry import interpolate
from drivegen.core.roadmap import RoadMap
from drivegen.core.samples import Samples
from drivegen.core.scenario import DT, Actors, Scenario, SizeSource, Trajectories, VehicleKind, Vehicles
from drivegen.core.seeds import rng
from drivegen.core.signals import Signals
from drivegen.layouts.compile import compile_map
from drivegen.layouts.spec import MapSpec
from drivegen.roads.graph import LaneGraph
from drivegen.roads.routes import feasible_routes
from drivegen.sumo.network import read_network

STEPS = 101
SEED = 7
_CAR = (4.6, 1.9, 1.6)


@cache
def road_map() -> RoadMap:
    """A grid of signalised streets with two lanes each way, about 200 lanes, ways across junctions included."""
    spec = MapSpec.model_validate({"road": {"kind": "grid", "rows": 2, "columns": 2, "control": "signals"}})
    return read_network(compile_map(spec), "benchmark grid")


@cache
def graph() -> LaneGraph:
    """The lane graph of `road_map`."""
    return LaneGraph.of(road_map())


def scene(number: int, vehicles: int = 16) -> Scenario:
    """Scenario `number`: cars that start on lanes drawn by it and follow a route at 3 to 12 m/s, braking or speeding up."""
    stream = rng(SEED, "bench", number)
    lanes = np.flatnonzero(road_map().for_vehicles & ~road_map().in_junction)
    chosen = stream.choice(lanes, vehicles, replace=len(lanes) < vehicles)
    motion = Trajectories.joined([_drive(int(lane), stream)[np.newaxis] for lane in chosen])
    return Scenario(
        scenario_id=f"bench-{number}",
        source="benchmark grid",
        city="grid",
        map=road_map(),
        vehicles=_cars(motion),
        horizon=STEPS - 1,
        log=motion,
        context=Actors.none(STEPS),
        signals=Signals.none(STEPS),
    )


def samples(scenario: Scenario, count: int = 10) -> Samples:
    """`count` futures of the scenario: its log, shifted sideways by up to a metre."""
    assert scenario.log is not None
    log, stream = scenario.log, rng(SEED, "bench", "samples", scenario.scenario_id)
    shift = stream.uniform(-1, 1, (count, len(scenario.vehicles), 1, 1)).astype(np.float32)
    left = np.stack([-np.sin(log.heading), np.cos(log.heading)], axis=-1)
    many = Trajectories(
        log.position + shift * left,
        np.repeat(log.heading[None], count, axis=0),
        np.repeat(log.velocity[None], count, axis=0),
        np.repeat(log.valid[None], count, axis=0),
    )
    return Samples.without_goals(scenario.scenario_id, "bench", many)


def _drive(lane: int, stream: np.random.Generator) -> Trajectories:
    line = road_map().centreline[lane].astype(np.float64)
    start = interpolate(line, np.array([stream.uniform(0.1, 0.6) * np.hypot(*np.diff(line, axis=0).T).sum()]))[0]
    heading = float(np.arctan2(*(line[-1] - line[0])[::-1]))
    speed = float(stream.uniform(3, 12))
    routes = feasible_routes(graph(), start, heading, speed, reach=150.0)
    route = routes[int(stream.integers(len(routes)))]
    pace = np.maximum(speed + float(stream.uniform(-0.5, 0.5)) * DT * np.arange(STEPS), 0.0)
    along = np.concatenate([[0.0], np.cumsum(pace[:-1] * DT)])
    facing = np.interp(along, np.arange(len(route.line)), np.unwrap(route.heading))
    velocity = pace[:, None] * np.stack([np.cos(facing), np.sin(facing)], axis=1)
    position = interpolate(route.line.astype(np.float64), along)
    arrays = [a.astype(np.float32) for a in (position, facing, velocity)]
    return Trajectories(arrays[0], arrays[1], arrays[2], np.ones(STEPS, np.bool_))


def _cars(motion: Trajectories) -> Vehicles:
    count = len(motion.valid)
    return Vehicles(
        track_id=np.array([str(i) for i in range(count)]),
        kind=np.full(count, VehicleKind.CAR, np.uint8),
        size=np.tile(np.array(_CAR, np.float32), (count, 1)),
        size_source=np.full(count, SizeSource.ASSUMED, np.uint8),
        position=motion.position[:, 0],
        heading=motion.heading[:, 0],
        speed=motion.speed[:, 0],
    )
