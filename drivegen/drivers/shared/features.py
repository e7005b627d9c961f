"""What a driver sees as one row of numbers, for policies that are networks.

All numbers are about 1 and clipped to [-LIMIT, LIMIT]. A target's own acceleration is none of them: who imitates logs would copy
it.

    name             count  unit of 1    what
    speed            1      15 m/s       of the target
    length           1      10 m         of the target
    offset           1      2 m          to the left of its path
    course           1      rad          its heading, seen from its path
    limit            1      15 m/s       speed limit at its front, 13.9 m/s where unknown
    over_limit       1      15 m/s       speed less the limit
    gap              1      30 m         to the nearest box on its way, or a metre before a line where it has to halt, at
                                         most 60 m
    closing          1      15 m/s       how fast this gap closes, 0 where there is none
    brake            1      4 m/s2       constant braking that avoids running into it, at most 8 m/s2
    urgency          1      1 /s         closing by gap
    crossing         1      5 s          until the first box ahead that comes from the side is on the target's way, at most 10 s
    crossing_at      1      30 m         to where it is now, at most 60 m
    limits           8      15 m/s       speed limits at DISTANCES ahead
    bends            8      rad          heading of the path there, seen from here
    neighbours       8 x 8               the nearest boxes, nearest first: ahead 30 m, left 10 m, speed along the path less the
                                         target's 15 m/s, speed to the left 15 m/s, half length 5 m, half width 5 m,
                                         distance 30 m, present 1 or 0 (the rest is 0 then)
    line             1      50 m         to the next line at which rules hold, at most 100 m
    red, yellow      2      1            its signal
    stop, give_way   2      1            its sign
    halted           1      1            the target has stood before it
    arrives          1      10 s         until the first who has right of way is there, at most 20 s

Where the world does not look for rules, the last ones are as where no line is ahead.
"""

import numpy as np
import torch
from numba import njit
from numpy.typing import NDArray
from torch import Tensor

from drivegen.core.roadmap import LaneControl
from drivegen.core.signals import SignalState
from drivegen.world.observation import PATH_SPACING, Observation

DISTANCES = (5.0, 10.0, 15.0, 20.0, 30.0, 40.0, 60.0, 80.0)
"""[m] ahead of the target's front."""

NEAREST = 8
COUNT = 12 + 2 * len(DISTANCES) + 8 * NEAREST + 7
"""Numbers in a row."""

VERSION = 2
"""Of what the numbers mean; weights that learned from others are refused. 1 had `gap` reach to the line itself."""

LIMIT = 5.0

_UNKNOWN_LIMIT, _FARTHEST, _HARDEST = 13.9, 60.0, 8.0
_SPEED, _GAP = 15.0, 30.0
_SLOWEST, _LATEST, _COMFORTABLE = 0.1, 10.0, 3.0
_BEFORE_LINE = 1.0  # [m] logs of SUMO halt 0.9 to 1.2 m before a red line: who is a little late then still halts before it
_FAR = 1e6
_DISTANCES = np.array(DISTANCES, np.float32)  # for compiled code


def features(view: Observation) -> Tensor:
    """(S, COUNT) float32 of S targets."""
    on_cpu = view.speed.device.type == "cpu"
    leading, side, neighbours = _compiled(view) if on_cpu else (leader(view), crossing(view), nearest_boxes(view))
    road = _compiled_road(view) if on_cpu else road_ahead(view)
    parts = [_own(view, *_halting(view, *leading), *side), *road, neighbours, _rules(view)]
    return torch.cat(parts, dim=1).clamp_(-LIMIT, LIMIT)


def _own(view: Observation, gap: Tensor, closing: Tensor, comes: Tensor, comes_at: Tensor) -> Tensor:
    limit = view.speed_limit.nan_to_num(_UNKNOWN_LIMIT)
    brake = (closing.clamp_min(0) ** 2 / (2 * gap.clamp_min(0.5))).clamp_max(_HARDEST)
    numbers = (
        view.speed / _SPEED, view.length / 10, view.offset / 2, view.course, limit / _SPEED, (view.speed - limit) / _SPEED,
        gap / _GAP, closing / _SPEED, brake / 4, closing.clamp_min(0) / gap.clamp_min(0.5), comes / 5, comes_at / _GAP,
    )  # fmt: skip
    return torch.stack(numbers, dim=1)


def leader(view: Observation) -> tuple[Tensor, Tensor]:
    """Gap (S,) [m] to the nearest box that reaches into the target's way, and how fast it closes [m/s]."""
    reach = view.half_width + (0.5 * view.width)[:, None]
    blocks = view.present & (view.ahead > 0) & ((view.left - view.offset[:, None]).abs() < reach)
    gap, nearest = torch.where(blocks, view.ahead - view.half_length, _FAR).min(dim=1)
    gap = (gap - 0.5 * view.length).clamp(0.0, _FARTHEST)
    closing = view.speed - view.speed_along.gather(1, nearest[:, None])[:, 0]
    return gap, torch.where(gap < _FARTHEST, closing, 0.0)


def _halting(view: Observation, gap: Tensor, closing: Tensor) -> tuple[Tensor, Tensor]:
    """The same, where a place to halt before a line is nearer: its signal is red, or yellow and the target still can."""
    if view.rules is None:
        return gap, closing
    distance, signal = view.rules.distance, view.rules.signal
    can = view.speed**2 <= 2 * _COMFORTABLE * distance
    halts = (distance > 0) & ((signal == SignalState.RED) | ((signal == SignalState.YELLOW) & can))
    room = (distance - _BEFORE_LINE).clamp_min(0.0)
    nearer = halts & (room < gap)
    return torch.where(nearer, room, gap), torch.where(nearer, view.speed, closing)


def crossing(view: Observation) -> tuple[Tensor, Tensor]:
    """When (S,) [s] the first box ahead that comes from the side is on the target's way, and how far (S,) [m] ahead it is now."""
    left, reach = view.left - view.offset[:, None], view.half_width + (0.5 * view.width)[:, None]
    inward = -left.sign() * view.speed_across
    comes = view.present & (view.ahead > 0) & (left.abs() >= reach) & (inward > _SLOWEST)
    time, first = torch.where(comes, (left.abs() - reach) / inward.clamp_min(_SLOWEST), _LATEST).min(dim=1)
    place = (view.ahead - view.half_length).gather(1, first[:, None])[:, 0] - 0.5 * view.length
    return time.clamp_max(_LATEST), torch.where(time < _LATEST, place.clamp(0.0, _FARTHEST), _FARTHEST)


def road_ahead(view: Observation) -> tuple[Tensor, Tensor]:
    """Speed limits and bends (S, len(DISTANCES)) in their units."""
    distances = torch.tensor(DISTANCES, device=view.speed.device)
    rows = view.paths.row((view.along + 0.5 * view.length)[:, None] + distances)
    here = view.paths.heading.gather(1, view.paths.row(view.along[:, None]))
    turned = view.paths.heading.gather(1, rows) - here
    bends = turned - 2 * torch.pi * (turned / (2 * torch.pi)).round()
    return view.paths.speed_limit.gather(1, rows).nan_to_num(_UNKNOWN_LIMIT) / _SPEED, bends


def nearest_boxes(view: Observation) -> Tensor:
    """(S, 8 * NEAREST) numbers of the nearest boxes."""
    across = view.left - view.offset[:, None]
    apart = torch.where(view.present, view.ahead**2 + across**2, torch.inf)
    if apart.shape[1] < NEAREST:
        raise ValueError(f"others are padded to {NEAREST} at least")
    squared, nearest = apart.topk(NEAREST, dim=1, largest=False)
    picked = [value.gather(1, nearest) for value in (
        view.ahead, across, view.speed_along, view.speed_across, view.half_length, view.half_width)]  # fmt: skip
    ahead, left, along, sideways, half_length, half_width = picked
    there = squared.isfinite()
    numbers = (
        ahead / _GAP, left / 10, (along - view.speed[:, None]) / _SPEED, sideways / _SPEED, half_length / 5, half_width / 5,
        squared.sqrt() / _GAP, there.float(),
    )  # fmt: skip
    return torch.where(there[..., None], torch.stack(numbers, dim=2), 0.0).flatten(1)


def _compiled(view: Observation) -> tuple[tuple[Tensor, Tensor], tuple[Tensor, Tensor], Tensor]:
    """`leader`, `crossing` and `nearest_boxes` by a loop, which on a processor is several times faster than tensors."""
    arrays = (
        view.ahead, view.left, view.half_length, view.half_width, view.speed_along, view.speed_across, view.present,
        view.offset, view.speed, view.length, view.width,
    )  # fmt: skip
    count = len(view.speed)
    gap, closing = np.empty(count, np.float32), np.zeros(count, np.float32)
    comes, comes_at = np.empty(count, np.float32), np.empty(count, np.float32)
    boxes = np.zeros((count, NEAREST, 8), np.float32)
    _look(*(array.numpy() for array in arrays), gap, closing, comes, comes_at, boxes)
    leading, side = (gap, closing), (comes, comes_at)
    return (_tensors(leading), _tensors(side), torch.from_numpy(boxes).flatten(1))


def _compiled_road(view: Observation) -> tuple[Tensor, Tensor]:
    """`road_ahead` by a loop."""
    limits, bends = np.empty((2, len(view.speed), len(DISTANCES)), np.float32)
    arrays = (view.along, view.length, view.paths.heading, view.paths.speed_limit, view.paths.length)
    _look_along(*(array.numpy() for array in arrays), limits, bends)
    return _tensors((limits, bends))


@njit(cache=True, error_model="numpy")
def _look_along(along, length, heading, limit, end, limits, bends):  # type: ignore[no-untyped-def]
    turn = np.float32(2 * np.pi)
    for s in range(len(along)):
        front = along[s] + np.float32(0.5) * length[s]
        here = heading[s, _row(along[s], end[s])]
        for k in range(len(_DISTANCES)):
            row = _row(front + _DISTANCES[k], end[s])
            turned = heading[s, row] - here
            bends[s, k] = turned - turn * np.rint(turned / turn)
            limits[s, k] = (np.float32(_UNKNOWN_LIMIT) if np.isnan(limit[s, row]) else limit[s, row]) / np.float32(_SPEED)


@njit(cache=True, error_model="numpy", inline="always")
def _row(along, end):  # type: ignore[no-untyped-def]
    """`Paths.row` of one place."""
    return int(min(max(along, np.float32(0)), end - np.float32(PATH_SPACING)) / np.float32(PATH_SPACING))


def _tensors(arrays: tuple[NDArray[np.float32], NDArray[np.float32]]) -> tuple[Tensor, Tensor]:
    return torch.from_numpy(arrays[0]), torch.from_numpy(arrays[1])


@njit(cache=True, error_model="numpy")
def _look(  # type: ignore[no-untyped-def]
    ahead, left, half_length, half_width, along, sideways, present, offset, speed, length, width,
    gap, closing, comes, comes_at, boxes,
):  # fmt: skip
    apart = np.empty(present.shape[1], np.float32)  # squared [m2]
    for s in range(len(speed)):
        near = np.float32(_FAR)
        apart[:] = np.inf
        comes[s], comes_at[s] = _LATEST, _FARTHEST
        for m in range(present.shape[1]):
            if not present[s, m]:
                continue
            across = left[s, m] - offset[s]
            room = ahead[s, m] - half_length[s, m]
            beside = abs(across) - (half_width[s, m] + np.float32(0.5) * width[s])
            if ahead[s, m] > 0 and beside < 0 and room < near:
                near, closing[s] = room, speed[s] - along[s, m]
            inward = -np.sign(across) * sideways[s, m]
            if ahead[s, m] > 0 and beside >= 0 and inward > np.float32(_SLOWEST) and beside / inward < comes[s]:
                comes[s] = beside / inward
                comes_at[s] = min(max(room - np.float32(0.5) * length[s], np.float32(0)), np.float32(_FARTHEST))
            apart[m] = ahead[s, m] * ahead[s, m] + across * across
        gap[s] = min(max(near - np.float32(0.5) * length[s], np.float32(0)), np.float32(_FARTHEST))
        if gap[s] >= _FARTHEST:
            closing[s] = 0
        for box in boxes[s]:
            m = _least(apart)
            if apart[m] == np.inf:
                break
            box[0], box[1] = ahead[s, m] / np.float32(_GAP), (left[s, m] - offset[s]) / np.float32(10)
            box[2], box[3] = (along[s, m] - speed[s]) / np.float32(_SPEED), sideways[s, m] / np.float32(_SPEED)
            box[4], box[5] = half_length[s, m] / np.float32(5), half_width[s, m] / np.float32(5)
            box[6], box[7] = np.sqrt(apart[m]) / np.float32(_GAP), 1
            apart[m] = np.inf


@njit(cache=True, error_model="numpy", inline="always")
def _least(values):  # type: ignore[no-untyped-def]
    """The first place of the least of the values (M,)."""
    least = 0
    for m in range(1, len(values)):
        least = m if values[m] < values[least] else least
    return least


def _rules(view: Observation) -> Tensor:
    if view.rules is None:
        nothing = torch.zeros((len(view.speed), 7), device=view.speed.device)
        nothing[:, 0], nothing[:, 6] = 2.0, 2.0
        return nothing
    rules = view.rules
    signs = (
        rules.signal == SignalState.RED, rules.signal == SignalState.YELLOW, rules.control == LaneControl.STOP,
        rules.control == LaneControl.YIELD, rules.halted,
    )  # fmt: skip
    soonest = rules.arrives.amin(dim=1).clamp_max(20.0) / 10
    return torch.stack([rules.distance.clamp(-1.0, 100.0) / 50, *(sign.float() for sign in signs), soonest], dim=1)
