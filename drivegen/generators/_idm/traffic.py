"""Closed loop of all vehicles of many samples at once: each on its own way, each an IDM driver that sees all others."""

from dataclasses import dataclass
from typing import Self

import numpy as np
import torch
from numba import njit
from numpy.typing import NDArray

from drivegen.core.geometry import wrap_angle
from drivegen.core.scenario import DT, Scenario, Trajectories
from drivegen.core.signals import SignalState
from drivegen.drivers.idm import Plugin as Idm
from drivegen.world.observation import PATH_SPACING, Observation, Paths

EVERY = 3
"""Steps for which a decision holds."""

SEEN_NEAR, SEEN_SECONDS = 30.0, 5.0
"""[m], [s] Others farther away than the one plus the way of the other are not looked at."""

SEEN_BEHIND = 10.0
"""[m] Whose centre is farther behind is not looked at: its box does not reach ahead."""

TURNED = 15.0
"""[m] Over so much of its way a vehicle turns from its first heading into the way's, which need not be the same."""

BODY = 2.0
"""[m] A vehicle heads as the chord of its way from so far behind it to so far ahead: points a metre apart have kinks."""


@dataclass(frozen=True)
class Crowd:
    """R samples of one scenario's N vehicles, each with its way; B = R N boxes drive.

    Attributes:
        point: (B, P, 2) [m], limit: (B, P) [m/s] of each one's way, its own wish applied; stop: (B, G) [m] where signal g
            guards its way, inf if it does not.
        speed: (B,) [m/s] at step 0. size: (B, 2) [m]. parked: (B,) bool. group: N.
        heading: (B,) [rad] at step 0.
        actor, actor_heading, actor_velocity, actor_there: (A, T, ...) context as replayed. actor_size: (A, 2).
        closed: (G, T) bool signals that show red or yellow.
    """

    point: NDArray[np.float32]
    limit: NDArray[np.float32]
    stop: NDArray[np.float32]
    speed: NDArray[np.float32]
    size: NDArray[np.float32]
    heading: NDArray[np.float32]
    parked: NDArray[np.bool_]
    group: int
    actor: Trajectories
    actor_size: NDArray[np.float32]
    closed: NDArray[np.bool_]

    @classmethod
    def of(
        cls,
        scenario: Scenario,
        point: NDArray[np.float32],
        limit: NDArray[np.float32],
        lane: NDArray[np.int32],
        parked: NDArray[np.bool_],
    ) -> Self:
        """`point`, `limit`, `lane` are the ways (R N, P, ...) of R samples, vehicle after vehicle in each."""
        vehicles, signals = scenario.vehicles, scenario.signals.held()
        samples = len(point) // len(vehicles)
        guarded = lane[:, :, None] == signals.lane
        entered = np.where(guarded.any(1), guarded.argmax(1), 0) * PATH_SPACING
        return cls(
            point,
            limit,
            np.where(entered > 0, entered, np.inf).astype(np.float32),  # 0: on that lane already, or never
            np.tile(vehicles.speed, samples),
            np.tile(vehicles.size[:, :2], (samples, 1)),
            np.tile(vehicles.heading, samples),
            np.tile(parked, samples),
            len(vehicles),
            scenario.context.motion,
            scenario.context.size[:, :2],
            np.isin(signals.state, (SignalState.RED, SignalState.YELLOW)),
        )


def drive(crowd: Crowd, driver: Idm, steps: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Way driven (B, steps) [m] along each one's way, and speed (B, steps) [m/s]."""
    count = len(crowd.speed)
    length = np.full(count, (crowd.point.shape[1] - 1) * PATH_SPACING, np.float32)
    step = np.diff(crowd.point, axis=1)
    heading = np.arctan2(step[..., 1], step[..., 0])
    paths = Paths(*map(torch.from_numpy, (crowd.point, np.concatenate([heading, heading[:, -1:]], 1), crowd.limit, length)))
    along, speed = np.zeros((count, steps), np.float32), np.zeros((count, steps), np.float32)
    speed[:, 0] = crowd.speed
    acceleration = np.zeros(count, np.float32)
    with torch.inference_mode():
        for t in range(steps - 1):
            if t % EVERY == 0:
                acceleration = driver.act(_observed(crowd, paths, along[:, t], speed[:, t], t)).acceleration.numpy()
            faster = np.maximum(speed[:, t] + acceleration * np.float32(DT), 0)
            speed[:, t + 1] = np.where(crowd.parked, 0, faster)
            along[:, t + 1] = along[:, t] + speed[:, t + 1] * np.float32(DT)
    return along, speed


def _observed(crowd: Crowd, paths: Paths, along: NDArray[np.float32], speed: NDArray[np.float32], t: int) -> Observation:
    """What each of B drivers sees at step t: the others of its sample, the context, its closed signals as standing boxes."""
    position, heading = poses(crowd, along)
    there = crowd.actor.valid[:, t]
    frame = np.zeros((6, len(along), crowd.group + len(there) + crowd.stop.shape[1]), np.float32)
    present = np.zeros(frame.shape[1:], np.bool_)
    _see(
        crowd.point, along, position, heading, speed, crowd.size, crowd.group, crowd.actor.position[:, t],
        crowd.actor.heading[:, t], crowd.actor.velocity[:, t], crowd.actor_size, there, frame, present,
    )  # fmt: skip
    if crowd.stop.shape[1]:
        signals = slice(crowd.group + len(there), None)
        gap = crowd.stop - along[:, None]
        frame[0, :, signals] = np.where(np.isfinite(gap), gap, 0)
        present[:, signals] = crowd.closed[:, t] & np.isfinite(gap) & (gap > crowd.size[:, :1] / 2)
    row = np.minimum((along + crowd.size[:, 0] / 2) / PATH_SPACING, crowd.limit.shape[1] - 2).astype(np.intp)
    length, width = torch.from_numpy(crowd.size).unbind(-1)
    ahead, left, half_length, half_width, speed_along, speed_across = torch.from_numpy(frame)
    return Observation(
        step=torch.full((len(along),), t),
        along=torch.from_numpy(along),
        offset=torch.zeros(len(along)),
        course=torch.zeros(len(along)),
        speed=torch.from_numpy(speed),
        length=length,
        width=width,
        speed_limit=torch.from_numpy(crowd.limit[np.arange(len(along)), row]),
        ahead=ahead,
        left=left,
        half_length=half_length,
        half_width=half_width,
        speed_along=speed_along,
        speed_across=speed_across,
        present=torch.from_numpy(present),
        paths=paths,
    )


def poses(crowd: Crowd, along: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Positions (B, ..., 2) and headings (B, ...) at `along` (B, ...) [m] on the ways; straight on beyond their ends."""
    rows = np.arange(len(along)).reshape(-1, *[1] * (along.ndim - 1))
    before = np.minimum(along / PATH_SPACING, crowd.point.shape[1] - 2).astype(np.intp)
    first, step = crowd.point[rows, before], crowd.point[rows, before + 1] - crowd.point[rows, before]
    share = (along / PATH_SPACING - before)[..., None]
    return first + share * step, np.arctan2(step[..., 1], step[..., 0])


@njit(cache=True, error_model="numpy")
def _nearest(points, x, y, guess):  # type: ignore[no-untyped-def]
    """Downhill from the point `guess` to a point that is nearer to (x, y) than its neighbours."""
    best, count = guess, points.shape[0]
    least = (points[best, 0] - x) ** 2 + (points[best, 1] - y) ** 2
    for way in (1, -1):
        while 0 <= best + way < count:
            gap = (points[best + way, 0] - x) ** 2 + (points[best + way, 1] - y) ** 2
            if gap >= least:
                break
            best, least = best + way, gap
    return best


@njit(cache=True, error_model="numpy")
def _box(points, along, x, y, heading, vx, vy, length, width, out):  # type: ignore[no-untyped-def]
    """One box in the frame of a way, as `Observation` wants it; it starts to look abreast of the box, ahead of `along`."""
    last = points.shape[0] - 2
    own = min(int(along), last)
    dx, dy = x - points[own, 0], y - points[own, 1]
    guess = min(max(own + int(np.sqrt(dx * dx + dy * dy)), 0), last)
    i = min(_nearest(points, x, y, guess), last)
    sx, sy = points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1]
    size = max(np.sqrt(sx * sx + sy * sy), 1e-6)
    ux, uy = sx / size, sy / size
    dx, dy = x - points[i, 0], y - points[i, 1]
    hx, hy = np.cos(heading), np.sin(heading)
    cos, sin = abs(ux * hx + uy * hy), abs(ux * hy - uy * hx)
    out[0], out[1] = i + ux * dx + uy * dy - along, ux * dy - uy * dx
    out[2], out[3] = 0.5 * (length * cos + width * sin), 0.5 * (length * sin + width * cos)
    out[4], out[5] = ux * vx + uy * vy, ux * vy - uy * vx


@njit(cache=True, error_model="numpy")
def _see(  # type: ignore[no-untyped-def]
    point, along, position, heading, speed, size, group, actor, actor_heading, actor_velocity, actor_size, actor_there, frame,
    present,
):  # fmt: skip
    """Fill `frame` (6, B, group + A + G) and `present` with who is near ahead; the signals' columns stay as they are."""
    for b in range(len(along)):
        far = (SEEN_NEAR + SEEN_SECONDS * speed[b]) ** 2
        cos, sin = np.cos(heading[b]), np.sin(heading[b])
        for m in range(group + len(actor)):
            if m < group:
                other = b - b % group + m
                x, y = position[other, 0], position[other, 1]
                skip = other == b
            else:
                other = m - group
                x, y = actor[other, 0], actor[other, 1]
                skip = not actor_there[other]
            dx, dy = x - position[b, 0], y - position[b, 1]
            if skip or dx * dx + dy * dy > far or cos * dx + sin * dy < -SEEN_BEHIND:
                continue
            present[b, m] = True
            if m < group:
                vx, vy = speed[other] * np.cos(heading[other]), speed[other] * np.sin(heading[other])
                _box(point[b], along[b], x, y, heading[other], vx, vy, size[other, 0], size[other, 1], frame[:, b, m])
            else:
                _box(
                    point[b], along[b], x, y, actor_heading[other], actor_velocity[other, 0], actor_velocity[other, 1],
                    actor_size[other, 0], actor_size[other, 1], frame[:, b, m],
                )  # fmt: skip


def _headings(crowd: Crowd, along: NDArray[np.float32]) -> NDArray[np.float32]:
    """(B, T) at `along` (B, T) [m]: those of chords of the ways, into which each turns from its own at step 0."""
    chord = poses(crowd, along + np.float32(BODY))[0] - poses(crowd, np.maximum(along - np.float32(BODY), 0))[0]
    heading = np.arctan2(chord[..., 1], chord[..., 0])
    share = np.minimum(along / TURNED, 1.0)
    off = wrap_angle(crowd.heading - heading[:, 0])[:, None]
    return np.asarray(heading + off * (1 - share**2 * (3 - 2 * share)), np.float32)


def motion(crowd: Crowd, scenario: Scenario, along: NDArray[np.float32], speed: NDArray[np.float32]) -> Trajectories:
    """The crowd's motion (R, N, T) on the map; step 0 is the scenario's own, and parked vehicles keep their heading."""
    position, _ = poses(crowd, along)
    heading = _headings(crowd, along)
    heading[crowd.parked] = crowd.heading[crowd.parked, None]
    position[:, 0] = np.tile(scenario.vehicles.position, (len(position) // crowd.group, 1))
    velocity = np.stack([np.cos(heading), np.sin(heading)], axis=-1) * speed[..., None]
    shape = (-1, crowd.group, speed.shape[1])
    return Trajectories(
        position.reshape(*shape, 2).astype(np.float32),
        heading.reshape(shape).astype(np.float32),
        velocity.reshape(*shape, 2).astype(np.float32),
        np.ones((len(position) // crowd.group, *shape[1:]), np.bool_),
    )
