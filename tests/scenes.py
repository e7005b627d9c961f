"""Small hand-made scenes for tests: a straight road, a signalised crossing, vehicles that drive along given lines."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import Polylines, arc_length, interpolate
from drivegen.core.rejections import Rejected
from drivegen.core.roadmap import NO_LANE, LaneControl, LaneKind, RoadMap, open_ends
from drivegen.core.samples import Samples, Violation
from drivegen.core.scenario import DT, Actors, Scenario, Trajectories, VehicleKind, Vehicles
from drivegen.core.signals import Signals, SignalState

LANE_WIDTH = 3.5
LIMIT = 13.9


def road_map(
    lines, links=(), in_junction=(), control=(), neighbours=(), drivable=(), stop_lines=(), stop_lane=(), whole=False
) -> RoadMap:
    """Lanes of 3.5 m about `lines` (list of (P, 2)); `neighbours` are pairs (left lane, right lane) of one direction.

    A stretch of road that goes on at every end without a link, or the `whole` network.
    """
    lines = [np.asarray(line, np.float64) for line in lines]
    count = len(lines)
    neighbour = np.full((count, 2), NO_LANE, np.int32)
    for left, right in neighbours:
        neighbour[right, 0], neighbour[left, 1] = left, right
    links = np.array(sorted(links), np.int32).reshape(-1, 2)
    controls = np.full(count, LaneControl.FREE, np.uint8)
    for lane, kind in control:
        controls[lane] = kind
    return RoadMap(
        origin=np.zeros(2),
        lane_id=np.arange(100, 100 + count, dtype=np.int64),
        kind=np.full(count, LaneKind.VEHICLE, np.uint8),
        centreline=Polylines.of(lines),
        left=Polylines.of([beside(line, LANE_WIDTH / 2) for line in lines]),
        right=Polylines.of([beside(line, -LANE_WIDTH / 2) for line in lines]),
        speed_limit=np.full(count, LIMIT, np.float32),
        in_junction=np.isin(np.arange(count), in_junction),
        control=controls,
        links=links,
        neighbour=neighbour,
        same_direction=neighbour >= 0,
        may_change=neighbour >= 0,
        cut=open_ends(links, count) & (not whole),
        drivable=Polylines.of([np.asarray(outline, np.float64) for outline in drivable]),
        crossings=Polylines.of([]),
        stop_lines=np.asarray(stop_lines, np.float32).reshape(-1, 2, 2),
        stop_lane=np.asarray(stop_lane, np.int32),
    )


def beside(line: NDArray[np.floating], offset: float) -> NDArray[np.floating]:
    """The line moved `offset` to its left."""
    step = np.gradient(line, axis=0)
    step /= np.hypot(step[:, :1], step[:, 1:])
    return line + offset * np.stack([-step[:, 1], step[:, 0]], axis=1)


def straight_road(length: float = 300.0, lanes: int = 2, whole: bool = False) -> RoadMap:
    """`lanes` lanes side by side along +x from x = 0; lane 0 is the rightmost, centred on y = 0. `whole`: see `road_map`."""
    xs = np.arange(0, length + 1, 10.0)
    lines = [np.stack([xs, np.full_like(xs, i * LANE_WIDTH)], axis=1) for i in range(lanes)]
    low, high = -LANE_WIDTH / 2, (lanes - 0.5) * LANE_WIDTH
    outline = [(0, low), (length, low), (length, high), (0, high)]
    return road_map(lines, neighbours=[(i + 1, i) for i in range(lanes - 1)], drivable=[outline], whole=whole)


def across(x: float) -> NDArray[np.floating]:
    """A line that crosses the straight road at `x`, from right to left."""
    return np.stack([np.full(60, float(x)), np.linspace(-120, 120, 60)], axis=1)


def crossing(arm: float = 80.0, half: float = 10.0, control: LaneControl = LaneControl.SIGNAL, whole: bool = False) -> RoadMap:
    """Four arms of one lane each way about the origin, with all turns; right-hand traffic.

    Lanes 0..3 come in heading 0, 90, 180, 270 degrees, 4..7 go out likewise; then for each way in: straight, left, right.
    """
    side = LANE_WIDTH / 2
    into = np.array([[x, -side] for x in np.linspace(-half - arm, -half, 12)])
    out = np.array([[x, -side] for x in np.linspace(half, half + arm, 12)])
    turns = [0, 1, 3]
    lines = [_turned(into, k) for k in range(4)] + [_turned(out, k) for k in range(4)]
    links, controls, stops = [], [], []
    for k in range(4):
        for turn in turns:
            lane, goal = len(lines), (k + turn) % 4
            lines.append(_arc(lines[k][-1], lines[4 + goal][0], k * np.pi / 2, goal * np.pi / 2))
            links += [(k, lane), (lane, 4 + goal)]
            controls.append((lane, control))
        stops.append(_turned(np.array([[-half, 0.0], [-half, -2 * side]]), k))
    reach, wide = half + arm, LANE_WIDTH
    bars = [
        [(-reach, -wide), (reach, -wide), (reach, wide), (-reach, wide)],
        [(-half, -half), (half, -half), (half, half), (-half, half)],
    ]
    bars.append([(y, x) for x, y in bars[0]][::-1])
    stop_lane = [8 + 3 * k for k in range(4)]
    return road_map(lines, links, list(range(8, 20)), controls, (), bars, stops, stop_lane, whole)


def _turned(line: NDArray[np.floating], quarter: int) -> NDArray[np.floating]:
    cos, sin = [(1, 0), (0, 1), (-1, 0), (0, -1)][quarter % 4]
    return line @ np.array([[cos, sin], [-sin, cos]])


def _arc(start, end, heading_in: float, heading_out: float, points: int = 12) -> NDArray[np.floating]:
    """A cubic Bezier line between two poses."""
    reach = np.hypot(*(end - start)) * (0.33 if abs(heading_in - heading_out) < 1e-6 else 0.55)
    a = start + reach * np.array([np.cos(heading_in), np.sin(heading_in)])
    b = end - reach * np.array([np.cos(heading_out), np.sin(heading_out)])
    t = np.linspace(0, 1, points)[:, None]
    return (1 - t) ** 3 * start + 3 * (1 - t) ** 2 * t * a + 3 * (1 - t) * t**2 * b + t**3 * end


def joined(roads: RoadMap, *lanes: int) -> NDArray[np.floating]:
    """The centrelines of `lanes` as one line."""
    parts = [roads.centreline[lanes[0]]] + [roads.centreline[lane][1:] for lane in lanes[1:]]
    return np.concatenate(parts).astype(np.float64)


def drive(line: NDArray[np.floating], start: float, speed: float, steps: int, acceleration: float = 0.0) -> Trajectories:
    """One trajectory (T,) along `line` from `start` [m] at `speed`, never backwards; beyond its end it goes straight on."""
    direction = (line[-1] - line[-2]) / np.hypot(*(line[-1] - line[-2]))
    line = np.concatenate([line, [line[-1] + 1000 * direction]])
    t = np.arange(steps) * DT
    if acceleration < 0:
        t = np.minimum(t, speed / -acceleration)
    along = start + speed * t + acceleration * t**2 / 2
    pace = speed + acceleration * t
    position = interpolate(line, along)
    ahead = interpolate(line, along + 0.5) - interpolate(line, np.maximum(along - 0.5, 0))
    heading = np.arctan2(ahead[:, 1], ahead[:, 0])
    velocity = pace[:, None] * np.stack([np.cos(heading), np.sin(heading)], axis=1)
    valid = np.ones(steps, np.bool_)
    assert arc_length(line)[-1] > along[-1]
    return Trajectories(position.astype(np.float32), heading.astype(np.float32), velocity.astype(np.float32), valid)


def stack(motions: list[Trajectories]) -> Trajectories:
    """Trajectories of equal shape with a new leading dimension."""
    return Trajectories(*(np.stack([getattr(m, name) for m in motions]) for name in ("position", "heading", "velocity", "valid")))


def scenario(roads: RoadMap, log: Trajectories, scenario_id: str = "scene-0", signals: Signals | None = None) -> Scenario:
    """A scenario of cars that move as `log` (N, T); the target is row 0."""
    count, steps = log.valid.shape
    vehicles = Vehicles(
        track_id=np.array([f"track-{i}" for i in range(count)]),
        kind=np.full(count, VehicleKind.CAR, np.uint8),
        size=np.tile(np.float32([4.6, 1.9, 1.6]), (count, 1)),
        size_source=np.zeros(count, np.uint8),
        position=log.position[:, 0].copy(),
        heading=log.heading[:, 0].copy(),
        speed=log.speed[:, 0].copy(),
    )
    lights = signals if signals is not None else Signals.none(steps)
    return Scenario(scenario_id, "hand-made scenes", "testville", roads, vehicles, steps - 1, log, Actors.none(steps), lights)


def busy_crossing(steps: int = 101, scenario_id: str = "crossing-0") -> Scenario:
    """Eight cars at a signalised crossing: the target goes straight, others cross, turn, wait and follow."""
    roads = crossing()
    log = stack(
        [
            drive(joined(roads, 0, 8, 4), 20, 11, steps),
            drive(joined(roads, 0, 8, 4), 4, 9, steps),
            drive(joined(roads, 2, 15, 7), 30, 8, steps),
            drive(joined(roads, 2, 14, 6), 10, 10, steps),
            drive(joined(roads, 1, 11, 5), 45, 8, steps, -1.0),
            drive(joined(roads, 3, 19, 6), 60, 4, steps),
            drive(joined(roads, 3, 17, 7), 40, 6, steps, -0.6),
            drive(joined(roads, 4), 30, 12, steps),
        ]
    )
    lanes = np.arange(8, 20, dtype=np.int32)
    green = np.isin(lanes, [8, 9, 10, 14, 15, 16])
    states = np.where(green[:, None], SignalState.GREEN, SignalState.RED).astype(np.uint8)
    return scenario(roads, log, scenario_id, Signals(lanes, np.tile(states, (1, steps))))


def noisy_samples(base: Scenario, count: int = 10, seed: int = 0, method: str = "drivegen") -> Samples:
    """`count` samples: the log, faster and slower along itself; sample 0 has a collision between vehicles 0 and 1."""
    assert base.log is not None
    random = np.random.default_rng(seed)
    pace = random.uniform(0.8, 1.15, (count, len(base.vehicles)))
    motions = [stack([_rescaled(base.log[i], pace[k, i]) for i in range(len(base.vehicles))]) for k in range(count)]
    samples = Samples.without_goals(base.scenario_id, method, stack(motions))
    samples.violation[0, :2] = Violation.COLLISION
    samples.first_violation[0, :2] = 40
    return samples


def rejected_of(samples: Samples, violation: int = Violation.SPEED) -> Rejected:
    """As if every vehicle of every sample had first been planned beside where it then went, 2 m to the left on the map."""
    k, n = (index.ravel().astype(np.int32) for index in np.indices(samples.violation.shape))
    position = samples.motion.position[k, n] + np.float32([0, 2])
    flags = np.full(len(k), violation, np.uint16)
    return Rejected(samples.scenario_id, samples.method, position, k, n, flags, np.zeros(len(k), np.bool_))


def _rescaled(motion: Trajectories, pace: float) -> Trajectories:
    line = motion.position.astype(np.float64)
    if np.hypot(*(line[-1] - line[0])) < 1.0:
        return motion
    keep = np.concatenate([[True], np.hypot(*np.diff(line, axis=0).T) > 1e-3])
    line = np.concatenate([line[keep], line[-1:] + 2 * (line[keep][-1:] - line[keep][-3:-2])])
    along = arc_length(motion.position.astype(np.float64)) * pace
    position = interpolate(line, np.minimum(along, arc_length(line)[-1]))
    heading = motion.heading.copy()
    return Trajectories(position.astype(np.float32), heading, motion.velocity * np.float32(pace), motion.valid.copy())


def any_scenario(seed: int, scenario_id: str = "any-0") -> Scenario:
    """A scenario with all that files may hold: a far origin, fragments, people, signals, unknown limits, bus lanes, notes."""
    random = np.random.default_rng(seed)
    base = busy_crossing(int(random.integers(2, 30)), scenario_id)
    assert base.log is not None
    steps, roads, log = base.steps, base.map, base.log
    valid = random.random(log.valid.shape) < 0.8
    valid[:, 0] = True
    limit = np.where(random.random(len(roads)) < 0.3, np.nan, random.uniform(5, 40, len(roads))).astype(np.float32)
    kind = random.choice([LaneKind.VEHICLE, LaneKind.BUS], len(roads)).astype(np.uint8)
    control = random.choice(list(LaneControl), len(roads)).astype(np.uint8)
    origin = np.round(random.uniform(-20_000, 20_000, 2))
    crossings = Polylines.of([np.float64([(0, 0), (4, 0), (4, 3), (0, 3)]) + random.uniform(-50, 50, 2) for _ in range(2)])
    people = int(random.integers(0, 3))
    walk = Trajectories(
        random.uniform(-60, 60, (people, steps, 2)).astype(np.float32),
        random.uniform(-3, 3, (people, steps)).astype(np.float32),
        random.uniform(-2, 2, (people, steps, 2)).astype(np.float32),
        np.ones((people, steps), np.bool_),
    )
    kinds = random.choice([VehicleKind.PEDESTRIAN, VehicleKind.CYCLIST, VehicleKind.MOTORCYCLE], people).astype(np.uint8)
    size = random.uniform(0.3, 2.0, (people, 3)).astype(np.float32)
    return replace(
        base,
        map=replace(
            roads,
            origin=origin,
            speed_limit=limit,
            kind=kind,
            control=control,
            crossings=crossings,
            yields_to=np.array([[8, 11 + seed % 5], [9, 17]], np.int32),
            dangling=int(random.integers(5)),
        ),
        log=replace(log, valid=valid),
        context=Actors(np.array([f"person-{i}" for i in range(people)], np.str_), kinds, size, walk),
        signals=Signals(base.signals.lane, random.integers(0, 4, base.signals.state.shape).astype(np.uint8)),
        notes={"target": "AV, because the focal track is no vehicle"} if random.random() < 0.5 else {},
    )
