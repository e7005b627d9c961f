"""Outlooks: the motion to expect towards each candidate goal, coarse and cheap, before any planner is asked.

A vehicle is expected to keep to the candidate's route: its speed goes from the present one to the goal's by a smooth ramp
that covers the distance, its offset from the route's line fades into the goal's. Two candidates exclude each other where
the boxes of their outlooks meet: a follower can't end beyond its leader, nor two vehicles cross at once. Who leaves the map on
the way is in nobody's way from then on.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.boxes import bounds, depth_of_turned
from drivegen.core.geometry import Floats, wrap_angle
from drivegen.core.scenario import DT, TARGET, Scenario, Trajectories
from drivegen.goals.candidates import Candidates
from drivegen.roads.leaving import Exits
from drivegen.roads.line import SPACING

STRIDE = 4
"""Every fourth step is looked at [steps]."""


@dataclass(frozen=True)
class Outlooks:
    """Outlooks towards the Q candidates of all N vehicles of a scenario, one vehicle's after the other's.

    Attributes:
        start: (N + 1,) int64 rows of each vehicle. owner: (Q,) int64 the vehicle of each row.
        distance: (Q,) [m] to the goal along its route, straight where it has none.
        position: (Q, S, 2) float32 [m], heading: (Q, S) float32 [rad], at every STRIDE-th step.
        valid: (Q, S) bool, until the vehicle leaves the map.
        size: (Q, 2) float32 length, width [m].
        target_steps: (N,) int64 the target is in vehicle n's way before this step only.
    """

    start: NDArray[np.int64]
    owner: NDArray[np.int64]
    distance: Floats
    position: NDArray[np.float32]
    heading: NDArray[np.float32]
    valid: NDArray[np.bool_]
    size: NDArray[np.float32]
    target_steps: NDArray[np.int64]

    @classmethod
    def of(cls, scenario: Scenario, candidates: Sequence[Candidates], target_steps: NDArray[np.int64]) -> "Outlooks":
        """Outlooks over the scenario's horizon; with `target_steps` of the scenario's steps the target counts throughout."""
        counts = [len(c) for c in candidates]
        owner = np.repeat(np.arange(len(counts)), counts)
        vehicles = scenario.vehicles
        goal, turn, speed, step, s, d = (
            np.concatenate([getattr(c, name) for c in candidates]) for name in ("position", "heading", "speed", "step", "s", "d")
        )
        offset = np.concatenate([_own_offset(c) for c in candidates])
        own = vehicles.heading[owner]
        way, turning = goal - vehicles.position[owner], wrap_angle(turn - own)
        routed = np.concatenate([c.route >= 0 for c in candidates])
        distance = np.where(routed, np.maximum(s, 0.0), np.hypot(way[:, 0], way[:, 1]))
        time = np.arange(0, scenario.steps, STRIDE) * DT
        gone = distances(time, np.maximum(step, 1) * DT, distance, vehicles.speed[owner], speed)
        poses = (vehicles.position[owner], own, way, turning)
        position, heading = _motion(gone, distance, offset, d, *poses, *_lines(candidates, routed))
        size = np.ascontiguousarray(vehicles.size[owner, :2], np.float32)
        whole = np.ones(heading.shape, np.bool_)
        way_there = Trajectories(position, heading, np.zeros_like(position), whole)
        visible = Exits.of(scenario.map).leave(way_there, size[:, 0])
        return cls(
            start=np.cumsum([0, *counts]),
            owner=owner,
            distance=distance,
            position=visible.position,
            heading=visible.heading,
            valid=visible.valid,
            size=size,
            target_steps=target_steps,
        )

    def exclusions(self) -> NDArray[np.bool_]:
        """(Q, Q) whether two candidates of different vehicles exclude each other."""
        met = np.zeros((len(self.owner), len(self.owner)), np.bool_)
        x, y = np.ascontiguousarray(np.where(self.valid[..., None], self.position, np.nan).T)
        last = -(-self.target_steps // STRIDE)
        _exclusions(x, y, self.position, self.heading, self.valid, self.size, self.start, last, met)
        return met

    def meetings(self, vehicle: int, committed: Trajectories, sizes: NDArray[np.float32]) -> NDArray[np.int64]:
        """(C,) with how many of the scenario's N vehicles, moving as `committed` (N, T), each candidate's outlook meets."""
        rows = slice(self.start[vehicle], self.start[vehicle + 1])
        position, heading = (np.ascontiguousarray(a[:, ::STRIDE]) for a in (committed.position, committed.heading))
        valid = committed.valid[:, ::STRIDE].copy()
        valid[vehicle] = False
        valid[TARGET, -(-self.target_steps[vehicle] // STRIDE) :] = False
        met = np.zeros(rows.stop - rows.start, np.int64)
        own = (self.position[rows], self.heading[rows], self.valid[rows], self.size[rows])
        _meetings(*own, position, heading, valid, sizes, met)
        return met


def _own_offset(candidates: Candidates) -> NDArray[np.float32]:
    """(C,) offset [m] of the vehicle itself from each candidate's route."""
    routes = np.append(candidates.offset, np.float32(0.0))  # the last is that of NO_ROUTE, -1
    return np.asarray(routes[candidates.route])


def distances(time: Floats, duration: Floats, distance: Floats, v0: Floats, v1: Floats) -> Floats:
    """(Q, S) distance [m] gone at `time` (S,) towards goals at `distance` (Q,) after `duration` (Q,).

    Where both ramps alone cover more than the distance, each is shortened and the vehicle stands between them.
    """
    gone: Floats = _distances(time, duration, *(np.asarray(a, np.float32) for a in (distance, v0, v1)))
    return gone


def _lines(candidates: Sequence[Candidates], routed: NDArray[np.bool_]) -> tuple[NDArray[np.generic], ...]:
    """Points (P, 2) and headings (P,) of all routes, one after the other; where that of each candidate begins in them (Q,),
    -1 where it has none, and its last point, counted from there (Q,).
    """
    routes = [route for c in candidates for route in c.routes]
    if not routes:
        none = np.full(len(routed), -1)
        return np.zeros((0, 2), np.float32), np.zeros(0, np.float32), none, none
    counts = [len(c.routes) for c in candidates]
    first = np.repeat(np.cumsum(counts) - counts, [len(c) for c in candidates])
    number = np.where(routed, np.concatenate([c.route for c in candidates]) + first, 0)
    lengths = np.array([len(r.line) for r in routes])
    begin = np.where(routed, (np.cumsum(lengths) - lengths)[number], -1)
    line, heading = np.concatenate([r.line for r in routes]), np.concatenate([r.heading for r in routes])
    return line, heading, begin, lengths[number] - 1


@njit(cache=True)
def _distances(time, duration, distance, v0, v1):  # type: ignore[no-untyped-def]
    gone = np.empty((len(duration), len(time)))
    for q in range(len(duration)):
        both, full = v0[q] + v1[q], duration[q]
        whole = full * both / 2
        ramp = full if distance[q] >= whole else np.float64(np.float32(2) * distance[q] / max(both, np.float32(1e-6)))
        ramp, rest = max(ramp, 1e-3), max(distance[q] - whole, 0.0)
        for k in range(len(time)):
            t = min(time[k], full)
            u, last, middle = min(t / ramp, 1.0), max(1 - (full - t) / ramp, 0.0), t / full
            ramps = v0[q] * ramp * (u - u**3 + u**4 / 2) + v1[q] * ramp * (last**3 - last**4 / 2)
            gone[q, k] = ramps + rest * middle**3 * (10 - 15 * middle + 6 * middle**2) + v1[q] * (time[k] - t)
    return gone


@njit(cache=True)
def _motion(gone, distance, offset, d, start, own, way, turning, line, angle, begin, last):  # type: ignore[no-untyped-def]
    """Positions (Q, S, 2) and headings (Q, S) of who has `gone` (Q, S) [m] along its route, or straight on where it has none."""
    position, heading = np.empty((*gone.shape, 2), np.float32), np.empty(gone.shape, np.float32)
    for q in range(len(gone)):
        position[q, 0, 0], position[q, 0, 1], heading[q, 0] = start[q, 0], start[q, 1], own[q]
        for k in range(1, gone.shape[1]):
            s = gone[q, k]
            share = s / max(distance[q], np.float32(1e-6))
            fade = min(max(share, 0.0), 1.0)
            if begin[q] < 0:
                position[q, k, 0], position[q, k, 1] = start[q, 0] + share * way[q, 0], start[q, 1] + share * way[q, 1]
                heading[q, k] = own[q] + turning[q] * fade
                continue
            left = offset[q] + (d[q] - offset[q]) * (fade * fade) * (3 - 2 * fade)
            at = min(max(s / SPACING, 0.0), float(last[q]))
            first = min(int(at), last[q] - 1)
            part, low, beyond = at - first, begin[q] + first, s - at * SPACING
            angled = angle[low] + part * (angle[low + 1] - angle[low])
            cos, sin = np.cos(angled), np.sin(angled)
            x = line[low, 0] + part * (line[low + 1, 0] - line[low, 0])
            y = line[low, 1] + part * (line[low + 1, 1] - line[low, 1])
            position[q, k, 0], position[q, k, 1] = x + beyond * cos - left * sin, y + beyond * sin + left * cos
            heading[q, k] = angled
    return position, heading


# Rows are never cut out of arrays inside the loops: a cut costs as much as the whole test that it is for.


@njit(cache=True)
def _directions(heading):  # type: ignore[no-untyped-def]
    """Cosines and sines (..., 2) of headings (B, S)."""
    direction = np.empty((*heading.shape, 2), np.float32)
    for b in range(heading.shape[0]):
        for t in range(heading.shape[1]):
            direction[b, t, 0], direction[b, t, 1] = np.cos(heading[b, t]), np.sin(heading[b, t])
    return direction


@njit(cache=True)
def _reaches(size):  # type: ignore[no-untyped-def]
    """(B,) [m] from the middles of boxes (B, 2) to their corners."""
    return np.float32(0.5) * np.sqrt(size[:, 0] * size[:, 0] + size[:, 1] * size[:, 1])


@njit(cache=True)
def _meet(pos_a, turn_a, valid_a, size_a, a, pos_b, turn_b, valid_b, size_b, b, reach, last):  # type: ignore[no-untyped-def]
    """Whether the boxes of rows a and b, which reach `reach` [m] together, meet before sample `last`, having been apart."""
    apart = False
    for t in range(last):
        if not (valid_a[a, t] and valid_b[b, t]):
            continue
        dx, dy = pos_b[b, t, 0] - pos_a[a, t, 0], pos_b[b, t, 1] - pos_a[a, t, 1]
        touching = dx * dx + dy * dy <= reach * reach
        if touching:
            deep = depth_of_turned(
                dx, dy, turn_a[a, t, 0], turn_a[a, t, 1], size_a[a, 0], size_a[a, 1],
                turn_b[b, t, 0], turn_b[b, t, 1], size_b[b, 0], size_b[b, 1],
            )  # fmt: skip
            touching = deep > 0
        if touching and apart:
            return True
        apart = apart or not touching
    return False


@njit(cache=True)
def _come_near(x, y, reach, a, count, near):  # type: ignore[no-untyped-def]
    """Note in `near` (Q,) which of the first `count` rows ever come as near to row a as both reach; x, y are (S, Q) [m].

    Rows are looked at inside, samples outside, and without a way out: a processor does many rows at once.
    """
    near[:count] = False
    for t in range(len(x)):
        for b in range(count):
            dx, dy, both = x[t, b] - x[t, a], y[t, b] - y[t, a], reach[a] + reach[b]
            near[b] |= dx * dx + dy * dy <= both * both


@njit(cache=True)
def _exclusions(x, y, position, heading, valid, size, start, target_last, met):  # type: ignore[no-untyped-def]
    turn, reach, near = _directions(heading), _reaches(size), np.empty(len(size), np.bool_)
    for n in range(1, len(start) - 1):
        for a in range(start[n], start[n + 1]):
            _come_near(x, y, reach, a, start[n], near)
            for b in range(start[n]):
                if near[b]:
                    last = min(target_last[n], len(x)) if b < start[TARGET + 1] else len(x)
                    step = _meet(position, turn, valid, size, a, position, turn, valid, size, b, reach[a] + reach[b], last)
                    met[a, b], met[b, a] = step, step


@njit(cache=True)
def _meetings(position, heading, valid, size, other_position, other_heading, other_valid, other_size, met):  # type: ignore[no-untyped-def]
    boxes, turn, reach = bounds(position, valid), _directions(heading), _reaches(size)
    others, other_turn, other_reach = bounds(other_position, other_valid), _directions(other_heading), _reaches(other_size)
    for a in range(len(heading)):
        for b in range(len(other_heading)):
            both = reach[a] + other_reach[b]
            across = max(boxes[a, 0] - others[b, 2], others[b, 0] - boxes[a, 2])
            along = max(boxes[a, 1] - others[b, 3], others[b, 1] - boxes[a, 3])
            if max(across, along) <= both:
                met[a] += _meet(
                    position, turn, valid, size, a, other_position, other_turn, other_valid, other_size, b, both, heading.shape[1]
                )
