"""TrafficGen (Feng et al., ICRA 2023): a vector encoder, modes of motion per vehicle, short steps one after the other.

What is the paper's: every vehicle is the centre of its own vectors, pieces of lanes and boxes of others; stacked
multi-context gating (MultiPath++) encodes the boxes, then the lanes in their context; learnt anchors, gated by both
contexts, give several modes with odds; training is winner takes all (the mode that ends nearest moves, and its odds rise);
a scene is driven on by a part of what was predicted, then encoded again. Vehicles choose their modes independently.

What is reduced: width and number of gates, vectors per vehicle and the horizon (paper: 9 s); knots every half second
instead of every step; one head for position and velocity (the integral of the other) instead of two; only the present
state of others, since only the first frame is given. What is added: distances near the vehicle are told on a finer scale
as well, and gates are residual with normalisation, without which so small a network learnt next to nothing in minutes.

The initialisation of the paper, its other half, is `Plugin.place`, see `_trafficgen.placement`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from drivegen import seeds
from drivegen.generators._closed_loop import Crowd, Tracks
from drivegen.generators._learned import Learned
from drivegen.generators._trafficgen.learning import HELD_OUT, Logs, MotionExamples, TrafficGenObjective
from drivegen.generators._trafficgen.net import KNOT, Modes, MotionNet
from drivegen.generators._trafficgen.placement import PlacementExamples, PlacementNet, Regions, place
from drivegen.generators._trafficgen.vectors import LaneVectors, Surroundings
from drivegen.geometry import rotate
from drivegen.samples import Samples
from drivegen.scenario import DT, Scenario, Trajectories, Vehicles
from drivegen.training import loop

CHUNK = 256
"""Vehicles that go through the network at once, always: sums differ between batch sizes."""

SCENES = 16
"""Scenarios that are driven on together; bounds memory."""


@dataclass(frozen=True)
class TrafficGenSettings:
    """Values stand in params.yaml, `train_generator.generators.trafficgen`.

    Attributes:
        piece: length of the lane pieces [m]. lanes, boxes: how many of each a vehicle sees, the nearest.
        width, layers: of the gates. modes: per vehicle.
        horizon: steps that are predicted. commit: steps of them that are driven before the next prediction; multiples of 5.
        temperature: modes are drawn from `p ** (1 / temperature)`, normalised.
        placement_width: of the gates of the initialisation. placement_lanes: regions around the target, the nearest.
        training: see `training.loop.Settings`.
    """

    piece: float
    lanes: int
    boxes: int
    width: int
    layers: int
    modes: int
    horizon: int
    commit: int
    temperature: float
    placement_width: int
    placement_lanes: int
    training: loop.Settings


class TrafficGenNet(nn.Module):
    """Both halves of TrafficGen, which share no weights."""

    def __init__(self, settings: TrafficGenSettings) -> None:
        super().__init__()
        self.motion = MotionNet(settings.width, settings.layers, settings.modes, settings.horizon // KNOT)
        self.placement = PlacementNet(settings.placement_width, settings.layers)

    def forward(self, half: str, lanes: Tensor, lane_there: Tensor, boxes: Tensor, box_there: Tensor) -> Modes | Regions:
        """The `half` "motion" or "placement" of `Surroundings`."""
        found: Modes | Regions = getattr(self, half)(lanes, lane_there, boxes, box_there)
        return found


class Plugin(Learned):
    """See `generators._learned.Learned`."""

    name = "trafficgen"
    Settings = TrafficGenSettings
    Examples = Logs
    settings: TrafficGenSettings
    net: TrafficGenNet

    @classmethod
    def network(cls, settings: TrafficGenSettings) -> TrafficGenNet:
        """See `Learned`."""
        return TrafficGenNet(settings)

    @classmethod
    def examples(cls, settings: TrafficGenSettings, scenarios: Sequence[Scenario]) -> Logs:
        """See `Learned`."""
        logged = [s for s in scenarios if s.log is not None]
        return Logs(Tracks.of_logs(logged), LaneVectors.of(logged, settings.piece))

    @classmethod
    def objective(
        cls, settings: TrafficGenSettings, net: TrafficGenNet, train: Logs, validation: Logs, seed: int
    ) -> TrafficGenObjective:
        """See `Learned`."""
        del net, seed
        shape = settings.horizon // KNOT, (settings.lanes, settings.boxes), _look(settings)
        motion = MotionExamples(train, *shape), MotionExamples(validation, *shape, most=HELD_OUT)
        return TrafficGenObjective(*motion, PlacementExamples(train.tracks, train.vectors, _around_target(settings)))

    def place(self, scenario: Scenario, count: int, seed: int) -> Vehicles:
        """TrafficGen's initialisation: the scenario's target, and others drawn around it, `count` in all if there is room.

        Map, target and signals at step 0 are read, nothing else.
        """
        counts, random = _around_target(self.settings), seeds.rng(seed, self.name, "place", scenario.scenario_id)
        return place(self.net.placement, scenario, counts, self.settings.piece, count, random)

    def generate(self, scenarios: Sequence[Scenario], samples: int, seed: int) -> list[Samples]:
        """K = `samples` futures of each scenario, driven in closed loop."""
        made = []
        with torch.inference_mode():
            for low in range(0, len(scenarios), SCENES):
                made += self._driven(scenarios[low : low + SCENES], samples, seed)
        return made

    def _driven(self, scenarios: Sequence[Scenario], samples: int, seed: int) -> list[Samples]:
        vectors = LaneVectors.of(scenarios, self.settings.piece)
        tracks = Tracks.of_beginnings(scenarios, samples)
        box = np.flatnonzero(tracks.planned)
        group = tracks.scene[box]
        chances = [seeds.rng(seed, self.name, s.scenario_id) for s in scenarios]
        for step in range(0, tracks.valid.shape[1] - 1, self.settings.commit):
            chance = [c.random(samples * len(s.vehicles)) for c, s in zip(chances, scenarios, strict=True)]
            groups = np.arange(len(tracks.start) - 1)
            crowd = tracks.at(groups, np.full(len(groups), step))
            logit, velocity, turn = self._predicted(vectors, crowd, group, box, group // samples, step, samples)
            tracks.drive(box, step, self._drawn(crowd.state[box], logit, velocity, turn, np.concatenate(chance)))
        return tracks.samples(scenarios, samples, self.name)

    def _predicted(
        self,
        vectors: LaneVectors,
        crowd: Crowd,
        group: NDArray[np.integer],
        box: NDArray[np.integer],
        scene: NDArray[np.integer],
        step: int,
        samples: int,
    ) -> list[NDArray[np.float32]]:
        """Logits (R, P), velocities (R, P, Q, 2) and turns (R, P, Q) of all vehicles.

        At step 0 the samples of a scenario are the same, so the first stands for all.
        """
        first = np.flatnonzero(group % samples == 0) if step == 0 else np.arange(len(box))
        parts = []
        for low in range(0, len(first), CHUNK):
            count = min(CHUNK, len(first) - low)
            rows = np.resize(first[low : low + count], CHUNK)
            around = Surroundings.of(
                vectors, crowd, group[rows], box[rows], scene[rows], np.full(CHUNK, step),
                (self.settings.lanes, self.settings.boxes), _look(self.settings),
            )  # fmt: skip
            modes = self.net.motion(
                *(torch.from_numpy(a) for a in (around.lanes, around.lane_there, around.boxes, around.box_there))
            )
            parts.append([m[:count].numpy() for m in (modes.logit, modes.velocity, modes.turn)])
        found = [np.concatenate(part) for part in zip(*parts, strict=True)]
        if step:
            return found
        within = box - crowd.start[group]  # number of each vehicle in its scenario
        row_of = {key: row for row, key in enumerate(zip(scene[first].tolist(), within[first].tolist(), strict=True))}
        same = np.array([row_of[key] for key in zip(scene.tolist(), within.tolist(), strict=True)])
        return [values[same] for values in found]

    def _drawn(
        self,
        state: NDArray[np.float32],
        logit: NDArray[np.float32],
        velocity: NDArray[np.float32],
        turn: NDArray[np.float32],
        chance: NDArray[np.float64],
    ) -> Trajectories:
        """Motion (R, commit) of one mode per vehicle, drawn with `chance` (R,) in [0, 1)."""
        share = (logit - logit.max(axis=1, keepdims=True)).astype(np.float64) / self.settings.temperature
        odds = np.exp(share).cumsum(axis=1)
        mode = (odds <= (chance * odds[:, -1])[:, None]).sum(axis=1)
        rows = np.arange(len(state))
        return between_knots(state, velocity[rows, mode], turn[rows, mode], self.settings.commit)


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


def _look(settings: TrafficGenSettings) -> float:
    """Half the horizon [s]: where a vehicle then is, is the middle of what it sees."""
    return settings.horizon * DT / 2


def _around_target(settings: TrafficGenSettings) -> tuple[int, int]:
    """Regions and boxes of the initialisation."""
    return settings.placement_lanes, settings.boxes
