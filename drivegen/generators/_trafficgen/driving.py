"""What TrafficGen drives: a mode is drawn for each vehicle, and filled in between its knots."""

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import rotate
from drivegen.core.scenario import DT, Trajectories
from drivegen.generators._trafficgen.net import KNOT


def drawn(logit: NDArray[np.float32], chance: NDArray[np.float64], temperature: float) -> NDArray[np.intp]:
    """A mode (R,) of each vehicle by logits (R, P), drawn with `chance` (R,) in [0, 1)."""
    share = (logit - logit.max(axis=1, keepdims=True)).astype(np.float64) / temperature
    odds = np.exp(share).cumsum(axis=1)
    return np.asarray((odds <= (chance * odds[:, -1])[:, None]).sum(axis=1))


def between_knots(
    state: NDArray[np.float32], velocity: NDArray[np.float32], turn: NDArray[np.float32], steps: int
) -> Trajectories:
    """Motion (R, steps) on the map from states (R, 5), velocities (R, Q, 2) in their frames and turns (R, Q) at knots."""
    heading = state[:, 2:3]
    velocity = np.concatenate([state[:, None, 3:5], rotate(velocity, heading)], axis=1)
    turn = np.concatenate([np.zeros((len(turn), 1), np.float32), turn], axis=1)
    at = np.arange(1, steps + 1) / KNOT
    left = np.minimum(at.astype(np.intp), velocity.shape[1] - 2)
    part = (at - left).astype(np.float32)
    now = velocity[:, left] + (velocity[:, left + 1] - velocity[:, left]) * part[:, None]
    before = np.concatenate([velocity[:, :1], now[:, :-1]], axis=1)
    place = state[:, None, :2] + ((before + now) * np.float32(DT / 2)).cumsum(axis=1)
    angle = heading + turn[:, left] + (turn[:, left + 1] - turn[:, left]) * part
    return Trajectories(place, angle, now, np.ones(angle.shape, np.bool_))
