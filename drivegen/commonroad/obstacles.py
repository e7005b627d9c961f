"""CommonRoad's obstacles as tracks: `<obstacle>` with a role in 2018b, `<dynamicObstacle>`, `<staticObstacle>` in 2020a.

A state's position is the origin of its shape, which is the middle of the box unless the shape says otherwise. (In the
NGSIM recordings, boxes set up at their middle overlap least: 14 pairs in every tenth frame of ten recordings, 31 if the
position were the front bumper, 41 if it were the rear one.) Speeds run along the orientation.
"""

from dataclasses import dataclass
from xml.etree.ElementTree import Element  # the type only: parsing is safe_xml's

import numpy as np
from numpy.typing import NDArray

from drivegen.commonroad.values import Points, centre, identity, pair, points, refuse, required, value
from drivegen.core.geometry import rotate, unit, wrap_angle
from drivegen.core.recorded_log import FARTHEST, LONGEST, expect_few_cells
from drivegen.core.scenario import DT, Trajectories, VehicleKind

KINDS = {
    "car": VehicleKind.CAR,
    "taxi": VehicleKind.CAR,
    "priorityVehicle": VehicleKind.CAR,
    "parkedVehicle": VehicleKind.CAR,
    "truck": VehicleKind.TRUCK,
    "bus": VehicleKind.BUS,
    "motorcycle": VehicleKind.MOTORCYCLE,
    "bicycle": VehicleKind.CYCLIST,
    "pedestrian": VehicleKind.PEDESTRIAN,
}
"""Types that become tracks; trains, construction zones, buildings and the like are skipped and counted."""

MOST_STEPS = 20_000
"""A recording that goes on for longer [steps] is refused: half an hour at 10 Hz."""

FASTEST = 500.0
"""Greater velocities [m/s] are no measurements at all; what is merely too fast for a car is judged later."""

MOST_OBSTACLES = 5000
"""A file with more is refused: all pairs of them are compared."""


@dataclass(frozen=True)
class Tracks:
    """M tracks over T steps of 0.1 s in the map's frame.

    Attributes:
        track_id: (M,) str. kind: (M,) uint8 VehicleKind.
        size: (M, 3) float32 length, width, NaN [m]: CommonRoad is flat.
        motion: Trajectories (M, T).
        skipped: obstacles left out, by type.
    """

    track_id: NDArray[np.str_]
    kind: NDArray[np.uint8]
    size: NDArray[np.float32]
    motion: Trajectories
    skipped: dict[str, int]


@dataclass(frozen=True)
class _Obstacle:
    """One obstacle: id, kind, length and width [m], and its states; a fixed one has one state, which lasts.

    Attributes:
        step: (S,) int64. position, velocity: (S, 2) [m, m/s]. heading: (S,) [rad].
    """

    name: int
    kind: VehicleKind
    size: tuple[float, float]
    fixed: bool
    step: NDArray[np.int64]
    position: Points
    heading: NDArray[np.float64]
    velocity: Points


def read_tracks(root: Element, origin: Points, stride: int, place: str) -> Tracks:
    """The tracks of a file, in the frame at `origin` (2,); every `stride`-th of the file's time steps is kept.

    Raises UnusableInput where an obstacle has no state, shape or number that it needs, two states at one time or none.
    """
    obstacles: list[_Obstacle] = []
    skipped: dict[str, int] = {}
    for element in root:
        role = _role(element)
        if role is None:
            continue
        word = element.findtext("type", "unknown").strip()
        if role in ("static", "dynamic") and word in KINDS and element.find("occupancySet") is None:
            obstacles.append(_obstacle(element, KINDS[word], role == "static", stride, place))
        else:
            name = "occupancy set" if element.find("occupancySet") is not None else word
            skipped[name] = skipped.get(name, 0) + 1
    obstacles = [one for one in obstacles if len(one.step)]
    if not obstacles:
        refuse(f"{place} has no vehicle", "no-vehicles")
    if len(obstacles) > MOST_OBSTACLES:
        refuse(f"{place} has {len(obstacles)} obstacles, more than {MOST_OBSTACLES}", "too-large")
    if len({one.name for one in obstacles}) < len(obstacles):
        refuse(f"{place} has two obstacles of one id", "duplicate-rows")
    size = np.array([(*one.size, np.nan) for one in obstacles], np.float32)
    names = np.array([str(one.name) for one in obstacles], np.str_)
    return Tracks(names, np.array([one.kind for one in obstacles], np.uint8), size, _dense(obstacles, origin, place), skipped)


def _role(element: Element) -> str | None:
    """Static, dynamic or another role; None for what is no obstacle."""
    if element.tag == "obstacle":
        return element.findtext("role", "dynamic").strip()
    return element.tag.removesuffix("Obstacle") if element.tag.endswith("Obstacle") else None


def _obstacle(element: Element, kind: VehicleKind, fixed: bool, stride: int, place: str) -> _Obstacle:
    name = identity(element, "id", place)
    place = f"{place}: obstacle {name}"
    length, width, offset = _box(element, place)
    initial = element.find("initialState")
    if initial is None:
        refuse(f"{place} has no state", "no-states")
    states = [initial] if fixed else [initial, *element.iterfind("trajectory/state")]
    step = np.array([_step(state, fixed, place) for state in states])
    order = np.argsort(step, kind="stable")
    step = step[order]
    if (np.diff(step) == 0).any():
        refuse(f"{place} has two states at one time step", "duplicate-rows")
    heading = np.array([required(state, "orientation", place) for state in states])[order]
    position = np.array([_position(state, place) for state in states])[order]
    position = (position + rotate(offset, heading)).astype(np.float64)
    if fixed:
        velocity = np.zeros((1, 2))
    else:
        velocity = _velocity(
            [states[i] for i in order.tolist()], (step * (DT / stride)).astype(np.float64), position, heading, place
        )
    keep = step % stride == 0
    columns = (step[keep] // stride, position[keep], heading[keep], velocity[keep])
    return _Obstacle(name, kind, (length, width), fixed, *columns)


def _step(state: Element, fixed: bool, place: str) -> int:
    time = (value(state, "time", place) or 0.0) if fixed else required(state, "time", place)
    if time != int(time) or not time >= 0:
        refuse(f"{place} has a state at time step {time:g}", "out-of-range")
    return 0 if fixed else int(time)  # whoever stands is there from the first step, whatever time its state names


def _position(state: Element, place: str) -> tuple[float, float]:
    position = state.find("position")
    if position is None:
        refuse(f"{place} has a state without position", "missing-value")
    return centre(position, place)


def _velocity(
    states: list[Element], time: NDArray[np.float64], position: Points, heading: NDArray[np.float64], place: str
) -> Points:
    """Velocities (S, 2) [m/s]: along the heading (and across it where 2020a says so); else how each position was reached.

    The first state, which was not reached, has the velocity that the file gives for it, or that of the second.
    """
    along = np.array([value(state, "velocity", place) for state in states], np.float64)  # None becomes NaN
    across = np.array([value(state, "velocityY", place) or 0.0 for state in states])
    velocity = rotate(np.stack([along, across], axis=-1), heading).astype(np.float64)
    if not np.isnan(along).any():
        return velocity
    if len(states) < 2:
        refuse(f"{place} has neither a velocity nor a second position", "missing-value")
    slope = np.diff(position, axis=0) / np.diff(time)[:, None]
    return np.where(np.isnan(along)[:, None], np.concatenate([slope[:1], slope]), velocity)


def _box(element: Element, place: str) -> tuple[float, float, Points]:
    """Length, width [m] and middle (2,) of the smallest box along the vehicle that holds all parts of its shape."""
    shape = element.find("shape")
    corners = [] if shape is None else [_corners(part, place) for part in shape]
    if not corners or not all(len(part) for part in corners):
        refuse(f"{place} has no rectangle, circle or polygon as shape", "missing-value")
    outline = np.concatenate(corners)
    low, high = outline.min(0), outline.max(0)
    length, width = (high - low).tolist()
    if not 0 < min(length, width) <= max(length, width) <= LONGEST:
        refuse(f"{place} measures {length:g} x {width:g} m", "out-of-range")
    return length, width, (low + high) / 2


def _corners(part: Element, place: str) -> Points:
    middle = part.find("center")
    at = np.zeros(2) if middle is None else np.array(pair(middle, place))
    if part.tag == "rectangle":
        half = np.array([_extent(part, "length", place), _extent(part, "width", place)]) / 2
        signs = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])
        return at + rotate(signs * half, np.array(value(part, "orientation", place) or 0.0))
    if part.tag == "circle":
        return at + _extent(part, "radius", place) * unit(np.arange(4) * np.pi / 2)
    return points(part, place) if part.tag == "polygon" else np.zeros((0, 2))


def _extent(part: Element, name: str, place: str) -> float:
    extent = required(part, name, place)
    if not 0 < extent <= LONGEST:
        refuse(f"{place} has the {name} {extent:g} m", "out-of-range")
    return extent


def _dense(obstacles: list[_Obstacle], origin: Points, place: str) -> Trajectories:
    steps = max([int(one.step[-1]) + 1 for one in obstacles if not one.fixed], default=1)
    if steps > MOST_STEPS:
        refuse(f"{place} goes on for {steps} time steps, more than {MOST_STEPS}", "out-of-range")
    expect_few_cells(len(obstacles), steps, place)
    motion = Trajectories.empty(len(obstacles), steps)
    for row, one in enumerate(obstacles):
        at = np.arange(steps) if one.fixed else one.step
        if np.abs(one.position - origin).max() > FARTHEST:
            refuse(f"{place}: obstacle {one.name} is more than {FARTHEST / 1000:g} km off the map", "out-of-range")
        if np.abs(one.velocity).max() > FASTEST:
            refuse(f"{place}: obstacle {one.name} is faster than {FASTEST:g} m/s", "out-of-range")
        motion.position[row, at] = one.position - origin
        motion.heading[row, at] = wrap_angle(one.heading)
        motion.velocity[row, at] = one.velocity
        motion.valid[row, at] = True
    return motion
