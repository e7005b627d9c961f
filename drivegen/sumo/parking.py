"""Cars parked beside the outer lanes of slower streets: nobody drives them, and nobody of the traffic comes near them.

They stand off the road, so they are seen and avoided as in Argoverse 2, where parked cars are vehicles like others, and no rule
of the road is judged or calibrated by them (`roads.parked`).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from drivegen.core.geometry import arc_length, box_corners, boxes_overlap, interpolate
from drivegen.core.roadmap import NO_LANE, LaneKind, RoadMap
from drivegen.core.scenario import TARGET, Scenario, SizeSource, Trajectories, VehicleKind, Vehicles
from drivegen.core.settings import NotNegative, Positive, Share
from drivegen.roads.graph import LaneGraph
from drivegen.sumo.network import Network
from drivegen.sumo.traffic import Traffic

CLEAR = 0.3
"""Nobody of the traffic comes nearer to a parked car than this [m]."""

NOT_STRAIGHT = 0.03
"""Standard deviation of a parked car's angle to its street [rad]."""


@dataclass(frozen=True)
class ParkingSettings:
    """Who is parked where.

    Attributes:
        share: of the outer lanes of slow streets, those beside which somebody parks. fastest: limit of a slow street [m/s].
        spacing: from the middle of one place to that of the next [m]. taken: share of the places that are.
        gap: least and most between the lane's edge and a car [m].
        from_end: there is no place nearer than this to where a lane begins or ends, which is where junctions are [m].
    """

    share: Share
    fastest: Positive
    spacing: Positive
    taken: Share
    gap: tuple[float, float]
    from_end: NotNegative


def park(network: Network, traffic: Traffic, settings: ParkingSettings, random: np.random.Generator) -> Vehicles:
    """Cars of the sizes of the traffic's, in the map's frame, clear of every lane, of each other and of all who drive."""
    road_map, outward = network.map, -1.0 if network.left_hand else 1.0
    models = np.flatnonzero(traffic.kind == VehicleKind.CAR)
    places = _places(network, settings, random)
    if not len(models):
        places = places[:0]
    size = traffic.size[random.choice(models, len(places))] if len(places) else np.zeros((0, 3), np.float32)
    aside = random.uniform(*settings.gap, len(places)) + size[:, 1] / 2
    out = outward * np.stack([np.sin(places[:, 2]), -np.cos(places[:, 2])], axis=-1)
    cars = Vehicles(
        track_id=np.array([f"parked-{i}" for i in range(len(places))], np.str_),
        kind=np.full(len(places), VehicleKind.CAR, np.uint8),
        size=size,
        size_source=np.full(len(places), SizeSource.MEASURED, np.uint8),
        position=(places[:, :2] + aside[:, None] * out).astype(np.float32),
        heading=(places[:, 2] + random.normal(0.0, NOT_STRAIGHT, len(places))).astype(np.float32),
        speed=np.zeros(len(places), np.float32),
    )
    cars = cars[_off_lanes(road_map, cars)]
    cars = cars[_apart(cars)]
    return cars[_clear_of(cars, traffic)]


def with_parked(scenario: Scenario, cars: Vehicles, origin: NDArray[np.float64], radius: float) -> Scenario:
    """The scenario with those of the `cars`, which are in a frame at `origin`, that stand within `radius` [m] of its target.

    Each is seen while it is that near. Where the scenario has no lane near it, nobody knows that it stands beside one.
    """
    if scenario.log is None or not len(cars):
        return scenario
    cars = replace(cars, position=(cars.position + (origin - scenario.map.origin)).astype(np.float32))
    seen = np.hypot(*np.moveaxis(cars.position[:, None] - scenario.log.position[TARGET], -1, 0)) <= radius
    shown = seen.any(-1) & np.isfinite(LaneGraph.of(scenario.map).distance_to_lanes(cars.position))
    cars, seen = cars[shown], seen[shown]
    standing = Trajectories(
        np.where(seen[..., None], cars.position[:, None], 0).astype(np.float32),
        np.where(seen, cars.heading[:, None], 0).astype(np.float32),
        np.zeros((*seen.shape, 2), np.float32),
        seen,
    )
    names = ("track_id", "kind", "size", "size_source", "position", "heading", "speed")
    vehicles = Vehicles(*(np.concatenate([getattr(scenario.vehicles, name), getattr(cars, name)]) for name in names))
    return replace(scenario, vehicles=vehicles, log=Trajectories.joined([scenario.log, standing]))


def _places(network: Network, settings: ParkingSettings, random: np.random.Generator) -> NDArray[np.float64]:
    """(P, 3) taken places: x, y [m] on the lane's outer edge and its heading there [rad]."""
    road_map = network.map
    beyond, edges = (road_map.neighbour[:, 0], road_map.left) if network.left_hand else (road_map.neighbour[:, 1], road_map.right)
    outer = (road_map.kind == LaneKind.VEHICLE) & ~road_map.in_junction & (beyond == NO_LANE)
    streets = np.flatnonzero(outer & (road_map.speed_limit <= settings.fastest))
    rows = [np.zeros((0, 3))]
    for lane in streets[random.uniform(size=len(streets)) < settings.share].tolist():
        edge = edges[lane].astype(np.float64)
        length = arc_length(edge)[-1]
        along = np.arange(settings.from_end + settings.spacing / 2, length - settings.from_end, settings.spacing)
        along = along[random.uniform(size=len(along)) < settings.taken]
        point = interpolate(edge, along)
        ahead = interpolate(edge, along + 0.5) - interpolate(edge, along - 0.5)
        rows.append(np.column_stack([point, np.arctan2(ahead[:, 1], ahead[:, 0])]))
    return np.concatenate(rows)


def _off_lanes(road_map: RoadMap, cars: Vehicles) -> NDArray[np.bool_]:
    """(P,) whether no corner, nor the middle of any side, is on the lane that is nearest to it, bicycle lanes among them."""
    graph = LaneGraph.of(replace(road_map, kind=np.full_like(road_map.kind, LaneKind.VEHICLE)))
    widest = np.maximum.reduceat(graph.half_width.max(-1), graph.line.start[:-1])
    corners = box_corners(cars.position, cars.heading, cars.size[:, 0], cars.size[:, 1])
    points = np.concatenate([corners, (corners + np.roll(corners, 1, axis=1)) / 2], axis=1)
    lane, hit = graph.nearest(points.reshape(-1, 2))
    return np.asarray(((lane == NO_LANE) | (hit[:, 3] > widest[lane])).reshape(points.shape[:2]).all(-1))


def _apart(cars: Vehicles) -> NDArray[np.bool_]:
    """(P,) who stands clear of all cars before it."""
    first, second = KDTree(cars.position).query_pairs(_reach(cars.size, cars.size), output_type="ndarray").T
    boxes = [(cars.position[i], cars.heading[i], cars.size[i, :2] + CLEAR) for i in (first, second)]
    return np.isin(np.arange(len(cars)), second[boxes_overlap(*boxes[0], *boxes[1])], invert=True)


def _clear_of(cars: Vehicles, traffic: Traffic) -> NDArray[np.bool_]:
    """(P,) whom nobody of the traffic ever comes near."""
    vehicle, step = np.nonzero(traffic.motion.valid)
    position, heading = traffic.motion.position[vehicle, step], traffic.motion.heading[vehicle, step]
    near = KDTree(position).query_ball_point(cars.position, _reach(cars.size, traffic.size))
    grown = cars.size[:, :2] + 2 * CLEAR
    clear = np.ones(len(cars), np.bool_)
    for i, rows in enumerate(near):
        others = position[rows], heading[rows], traffic.size[vehicle[rows], :2]
        clear[i] = not boxes_overlap(cars.position[i], cars.heading[i], grown[i], *others).any()
    return clear


def _reach(a: NDArray[np.float32], b: NDArray[np.float32]) -> float:
    """Middles of boxes (_, 3) that come near each other are no farther apart than this [m]."""
    return CLEAR + sum(float(np.hypot(size[:, 0], size[:, 1]).max(initial=0.0)) for size in (a, b)) / 2
