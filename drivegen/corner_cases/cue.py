"""The first perceivable cue of a collision: from when on somebody who looks could have seen it coming.

At a step there is a cue where one of two things holds of the other:
* conflict: if it kept its velocity, seen from the target's path, and the target its speed, their boxes would come within CLOSE of
  one another, to the side, within SEEN;
* cut-in: it goes the target's way, no farther ahead than the target drives in SEEN, and has come nearer to the target's way by
  more than WANDER within the last seconds (UN R157 on cut-ins: the zone in which vehicles wander without meaning anything).

The cue of a collision is the beginning of the last stretch of such steps before it, gaps of at most GAP bridged.
"""

from typing import TypeAlias

import numpy as np
import torch
from numpy.typing import NDArray

from drivegen.core.geometry import rotate
from drivegen.corner_cases.encounters import ALONG, LOOK_BACK
from drivegen.corner_cases.reenactment import Reenactment
from drivegen.world.observation import PATH_SPACING

Reals: TypeAlias = NDArray[np.float32]

SEEN = 3.0
"""[s]"""

CLOSE = 0.3
"""[m]"""

WANDER = 0.375
"""[m] UN R157."""

GAP = 5
"""[steps]"""

BEFORE, AHEAD = 20.0, 60.0
"""[m] The stretch of the path behind and ahead of the target on which the other is looked for."""


def cues(cases: Reenactment) -> NDArray[np.int64]:
    """(C,) the step of the first cue of each case's collision, that of the collision itself where there is none."""
    there = _conflict(*(view := _views(cases))) | _cuts_in(*view)
    steps = np.arange(there.shape[1])
    out = cases.contact.copy()
    for c, contact in enumerate(cases.contact.tolist()):
        on = steps[:contact][there[c, :contact]]
        if len(on) and contact - on[-1] <= GAP:
            breaks = np.flatnonzero(np.diff(on) > GAP)
            out[c] = on[breaks[-1] + 1] if len(breaks) else on[0]
    return out


def _views(cases: Reenactment) -> tuple[Reals, Reals, Reals, NDArray[np.bool_]]:
    """Of the one that is hit: its frame (C, 6, T) from the target on; the target's speed (C, T), half sizes (C, 2, 1).

    And whether both are there (C, T). The frame is as in `Replay`, but of the stretch of the path around the target alone: a path
    that comes back to where it was has several feet.
    """
    count, steps = cases.driven.valid.shape
    rows, step = (torch.from_numpy(index.ravel()) for index in np.indices((count, steps)))
    ego, paths = cases.ego(rows, step), cases.scenes.paths[rows]
    place = torch.arange(-BEFORE, AHEAD, PATH_SPACING)
    points = paths.position(ego.along[:, None] + place).numpy()
    other, half = cases.other, 0.5 * cases.other_size[:, None]
    apart = points - other.position.reshape(-1, 1, 2)
    nearest = np.square(apart[:, :-1]).sum(-1).argmin(1)
    at = np.arange(len(points)), nearest
    heading = np.arctan2(*(points[at[0], nearest + 1] - points[at]).T[::-1])
    moved = rotate(-apart[at], -heading)
    velocity = rotate(other.velocity.reshape(-1, 2), -heading)
    turned = other.heading.ravel() - heading
    cos, sin = np.abs(np.cos(turned)), np.abs(np.sin(turned))
    length, width = (np.broadcast_to(half[..., i], (count, steps)).ravel() for i in (0, 1))
    channels = (
        place.numpy()[nearest] + moved[:, 0],
        moved[:, 1] - ego.offset.numpy(),
        length * cos + width * sin,
        length * sin + width * cos,
        velocity[:, 0],
        velocity[:, 1],
    )
    frame = np.stack([channel.reshape(count, steps) for channel in channels], 1).astype(np.float32)
    return frame, cases.driven.speed, 0.5 * cases.scenes.replay.target_size[:, :, None], other.valid & cases.driven.valid


def _conflict(frame: Reals, speed: Reals, half: Reals, both: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(C, T) the boxes would come as near within SEEN."""
    ahead, left, half_length, half_width, along, across = frame.swapaxes(0, 1)
    enters, leaves = _meets(ahead, along - speed, half_length + half[:, 0])
    enters_too, leaves_too = _meets(left, across, half_width + half[:, 1] + np.float32(CLOSE))
    return both & (np.maximum(enters, enters_too) < np.minimum(np.minimum(leaves, leaves_too), SEEN))


def _meets(apart: Reals, rate: Reals, reach: Reals) -> tuple[Reals, Reals]:
    """From when until when [s] from now on |apart + rate t| < reach; an empty stretch where never."""
    rate = np.where(np.abs(rate) < 1e-6, np.float32(1e-6), rate)
    ends = np.stack([(-reach - apart) / rate, (reach - apart) / rate])
    return np.maximum(ends.min(0), 0), ends.max(0)


def _cuts_in(frame: Reals, speed: Reals, half: Reals, both: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(C, T) it comes into the target's way from beside it."""
    ahead, left, half_length, _, along, across = frame.swapaxes(0, 1)
    same_way = along > np.cos(ALONG) * np.hypot(along, across)
    away = np.where(both, np.abs(left), 0)
    before = np.stack([away] + [np.pad(away, ((0, 0), (k, 0)))[:, :-k] for k in range(1, LOOK_BACK + 1)]).max(0)
    near = (ahead + half_length > -half[:, 0]) & (ahead - half_length - half[:, 0] < SEEN * speed)
    return np.asarray(both & same_way & near & (before - away > WANDER))
