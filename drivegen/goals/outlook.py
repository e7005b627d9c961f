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

from drivegen.core.boxes import bounds, depth
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
        way = goal - vehicles.position[owner]
        routed = np.concatenate([c.route >= 0 for c in candidates])
        distance = np.where(routed, np.maximum(s, 0.0), np.hypot(way[:, 0], way[:, 1]))
        time = np.arange(0, scenario.steps, STRIDE) * DT
        gone = distances(time, np.maximum(step, 1) * DT, distance, vehicles.speed[owner], speed)
        share = gone / np.maximum(distance, 1e-6)[:, None]
        fade = np.clip(share, 0.0, 1.0)
        position, heading = _along_routes(candidates, gone, offset[:, None] + (d - offset)[:, None] * fade**2 * (3 - 2 * fade))
        own = vehicles.heading[owner]
        straight = vehicles.position[owner][:, None] + share[..., None] * way[:, None]
        position = np.where(routed[:, None, None], position, straight)
        heading = np.where(routed[:, None], heading, own[:, None] + wrap_angle(turn - own)[:, None] * fade)
        position[:, 0], heading[:, 0] = vehicles.position[owner], own
        size = np.ascontiguousarray(vehicles.size[owner, :2], np.float32)
        whole = np.ones(heading.shape, np.bool_)
        way_there = Trajectories(position.astype(np.float32), heading.astype(np.float32), np.zeros_like(position), whole)
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
        last = -(-self.target_steps // STRIDE)[self.owner]
        _exclusions(self.position, self.heading, self.valid, self.size, self.owner, last, met)
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
    t = np.minimum(time[None], duration[:, None])
    whole = duration * (v0 + v1) / 2
    ramp = np.where(distance >= whole, duration, 2 * distance / np.maximum(v0 + v1, 1e-6)).clip(1e-3)[:, None]
    rest = np.maximum(distance - whole, 0.0)[:, None]
    u, last = np.minimum(t / ramp, 1.0), np.maximum(1 - (duration[:, None] - t) / ramp, 0.0)
    middle = t / duration[:, None]
    gone = v0[:, None] * ramp * (u - u**3 + u**4 / 2) + v1[:, None] * ramp * (last**3 - last**4 / 2)
    gone = gone + rest * middle**3 * (10 - 15 * middle + 6 * middle**2)
    return np.asarray(gone + v1[:, None] * (time[None] - t))


def _along_routes(candidates: Sequence[Candidates], s: Floats, d: Floats) -> tuple[Floats, Floats]:
    """Positions (Q, S, 2) and headings (Q, S) at `s`, `d` (Q, S) of each candidate's route; anything where it has none."""
    routes = [route for c in candidates for route in c.routes]
    if not routes:
        return np.zeros((*s.shape, 2)), np.zeros(s.shape)
    first_route = np.cumsum([0, *(len(c.routes) for c in candidates)])[:-1]
    number = np.concatenate([np.maximum(c.route, 0) + first for c, first in zip(candidates, first_route, strict=True)])
    number = np.minimum(number, len(routes) - 1)
    line, angle = np.concatenate([r.line for r in routes]), np.concatenate([r.heading for r in routes])
    lengths = np.array([len(r.line) for r in routes])
    begin, last = (np.cumsum(lengths) - lengths)[number, None], (lengths - 1)[number, None]
    at = np.clip(s / SPACING, 0.0, last)
    first = np.minimum(at.astype(np.int64), last - 1)
    share, low = at - first, begin + first
    heading = angle[low] + share * (angle[low + 1] - angle[low])
    forward = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    left = np.stack([-forward[..., 1], forward[..., 0]], axis=-1)
    on_line = line[low] + share[..., None] * (line[low + 1] - line[low])
    return on_line + (s - at * SPACING)[..., None] * forward + d[..., None] * left, heading


# Rows are never cut out of arrays inside the loops: a cut costs as much as the whole test that it is for.


@njit(cache=True)
def _meet(pos_a, head_a, valid_a, size_a, a, pos_b, head_b, valid_b, size_b, b, last):  # type: ignore[no-untyped-def]
    """Whether the boxes of rows a and b meet before sample `last`, once they have been apart."""
    length_a, width_a, length_b, width_b = size_a[a, 0], size_a[a, 1], size_b[b, 0], size_b[b, 1]
    reach = np.float32(0.5) * (
        np.sqrt(length_a * length_a + width_a * width_a) + np.sqrt(length_b * length_b + width_b * width_b)
    )
    reach *= reach
    apart = False
    for t in range(min(last, head_a.shape[1])):
        if not (valid_a[a, t] and valid_b[b, t]):
            continue
        dx, dy = pos_b[b, t, 0] - pos_a[a, t, 0], pos_b[b, t, 1] - pos_a[a, t, 1]
        touching = dx * dx + dy * dy <= reach
        if touching:
            touching = depth(dx, dy, head_a[a, t], length_a, width_a, head_b[b, t], length_b, width_b) > 0
        if touching and apart:
            return True
        apart = apart or not touching
    return False


@njit(cache=True)
def _exclusions(position, heading, valid, size, owner, target_last, met):  # type: ignore[no-untyped-def]
    boxes = bounds(position, valid)
    for a in range(len(owner)):
        mine = np.float32(0.5) * (size[a, 0] + size[a, 1])
        low_x, low_y, high_x, high_y = boxes[a, 0] - mine, boxes[a, 1] - mine, boxes[a, 2] + mine, boxes[a, 3] + mine
        for b in range(a):
            if owner[a] == owner[b]:
                break
            theirs = np.float32(0.5) * (size[b, 0] + size[b, 1])
            if low_x > boxes[b, 2] + theirs or high_x < boxes[b, 0] - theirs:
                continue
            if low_y > boxes[b, 3] + theirs or high_y < boxes[b, 1] - theirs:
                continue
            last = target_last[a] if owner[b] == TARGET else position.shape[1]
            step = _meet(position, heading, valid, size, a, position, heading, valid, size, b, last)
            met[a, b], met[b, a] = step, step


@njit(cache=True)
def _meetings(position, heading, valid, size, other_position, other_heading, other_valid, other_size, met):  # type: ignore[no-untyped-def]
    boxes = bounds(position, valid)
    others = bounds(other_position, other_valid)
    for a in range(len(heading)):
        for b in range(len(other_heading)):
            reach = np.float32(0.5) * (size[a, 0] + size[a, 1] + other_size[b, 0] + other_size[b, 1])
            across = max(boxes[a, 0] - others[b, 2], others[b, 0] - boxes[a, 2])
            along = max(boxes[a, 1] - others[b, 3], others[b, 1] - boxes[a, 3])
            if max(across, along) <= reach:
                met[a] += _meet(
                    position, heading, valid, size, a, other_position, other_heading, other_valid, other_size, b, heading.shape[1]
                )
