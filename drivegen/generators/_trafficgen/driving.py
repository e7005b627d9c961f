"""TrafficGen in closed loop: modes are drawn, a part of each is driven, everything is encoded again."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from drivegen.core.geometry import rotate
from drivegen.core.scenario import DT, Trajectories
from drivegen.generators._trafficgen.net import KNOT, MotionNet
from drivegen.generators._trafficgen.vectors import Surroundings
from drivegen.generators.shared.closed_loop import Crowd, Tracks
from drivegen.generators.shared.lanes import LaneVectors

CHUNK = 256
"""Vehicles that go through the network at once, always: sums differ between batch sizes."""


@dataclass(frozen=True)
class Driver:
    """A network and how it drives.

    Attributes:
        net: in evaluation mode. counts: lane pieces and boxes that a vehicle sees.
        look: [s] where a vehicle then is, is the middle of what it sees. commit, temperature: as in `TrafficGenSettings`.
    """

    net: MotionNet
    counts: tuple[int, int]
    look: float
    commit: int
    temperature: float

    def drive(
        self,
        vectors: LaneVectors,
        scenes: NDArray[np.integer],
        tracks: Tracks,
        copies: int,
        chances: Sequence[np.random.Generator],
    ) -> None:
        """Drive all vehicles of `tracks` from step 0 to the end, in place.

        `tracks` has `copies` copies side by side, the same at step 0, of each of `scenes` (S,) of `vectors`; `chances` (S,)
        draw the modes of one scene each.
        """
        box = np.flatnonzero(tracks.planned)
        group = tracks.scene(box)
        vehicles = np.bincount(group // copies, minlength=len(chances))
        groups = np.arange(len(tracks.start) - 1)
        for step in range(0, tracks.valid.shape[1] - 1, self.commit):
            chance = np.concatenate([c.random(n) for c, n in zip(chances, vehicles, strict=True)])
            crowd = tracks.at(groups, np.full(len(groups), step))
            logit, velocity, turn = self._predicted(vectors, scenes, crowd, group, box, step, copies)
            tracks.drive(box, step, self._drawn(crowd.state[box], logit, velocity, turn, chance))

    def _predicted(
        self,
        vectors: LaneVectors,
        scenes: NDArray[np.integer],
        crowd: Crowd,
        group: NDArray[np.integer],
        box: NDArray[np.integer],
        step: int,
        copies: int,
    ) -> list[NDArray[np.float32]]:
        """Logits (R, P), velocities (R, P, Q, 2) and turns (R, P, Q) of all vehicles.

        At step 0 the copies of a scene are the same, so the first stands for all.
        """
        scene, device = group // copies, next(self.net.parameters()).device
        first = np.flatnonzero(group % copies == 0) if step == 0 else np.arange(len(box))
        parts = []
        for low in range(0, len(first), CHUNK):
            count = min(CHUNK, len(first) - low)
            rows = np.resize(first[low : low + count], CHUNK)
            around = Surroundings.of(
                vectors, crowd, group[rows], box[rows], scenes[scene[rows]], np.full(CHUNK, step), self.counts, self.look
            )
            inputs = (around.lanes, around.lane_there, around.boxes, around.box_there)
            modes = self.net(*(torch.from_numpy(a).to(device) for a in inputs))
            parts.append([m[:count].cpu().numpy() for m in (modes.logit, modes.velocity, modes.turn)])
        outputs = [np.concatenate(part) for part in zip(*parts, strict=True)]
        if step:
            return outputs
        within = box - crowd.start[group]  # number of each vehicle in its scene
        row_of = {key: row for row, key in enumerate(zip(scene[first].tolist(), within[first].tolist(), strict=True))}
        same = np.array([row_of[key] for key in zip(scene.tolist(), within.tolist(), strict=True)])
        return [values[same] for values in outputs]

    def _drawn(
        self,
        state: NDArray[np.float32],
        logit: NDArray[np.float32],
        velocity: NDArray[np.float32],
        turn: NDArray[np.float32],
        chance: NDArray[np.float64],
    ) -> Trajectories:
        """Motion (R, commit) of one mode per vehicle, drawn with `chance` (R,) in [0, 1)."""
        share = (logit - logit.max(axis=1, keepdims=True)).astype(np.float64) / self.temperature
        odds = np.exp(share).cumsum(axis=1)
        mode = (odds <= (chance * odds[:, -1])[:, None]).sum(axis=1)
        rows = np.arange(len(state))
        return between_knots(state, velocity[rows, mode], turn[rows, mode], self.commit)


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
