"""TrafficGen (Feng et al., ICRA 2023): a vector encoder, modes of motion per vehicle, short steps one after the other.

What is the paper's: every vehicle is the centre of its own vectors, pieces of lanes and boxes of others; stacked
multi-context gating (MultiPath++) encodes the boxes, then the lanes in their context; learnt anchors, gated by both
contexts, give several modes with odds; training is winner takes all (the mode that ends nearest moves, and its odds rise);
a scene is driven on by a part of what was predicted, then encoded again. Vehicles choose their modes independently.

What is reduced: width and number of gates, vectors per vehicle and the horizon (paper: 9 s); knots every half second
instead of every step; one head for position and velocity (the integral of the other) instead of two; only the present
state of others, since only the first frame is given. What is added: distances near the vehicle are told on a finer scale
as well, and gates are residual with normalisation, without which so small a network learnt next to nothing in minutes; what
is driven is what a vehicle can do, so modes say how hard to accelerate and to steer; half of the examples begin somewhat
beside the logged way, as roll-outs soon are.

The initialisation of the paper, its other half, is `Plugin.place`, see `_trafficgen.placement`.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from torch import Tensor, nn

from drivegen.core import seeds
from drivegen.core.methods import Method
from drivegen.core.scenario import DT, Scenario, Trajectories, Vehicles
from drivegen.core.settings import Count, Positive
from drivegen.generators._trafficgen.driving import between_knots, drawn
from drivegen.generators._trafficgen.learning import HELD_OUT, Disturbance, MotionExamples, TrafficGenObjective
from drivegen.generators._trafficgen.net import KNOT, Modes, MotionNet
from drivegen.generators._trafficgen.placement import PlacementExamples, PlacementNet, Regions, place
from drivegen.generators._trafficgen.vectors import Surroundings
from drivegen.generators.shared.closed_loop import Crowd
from drivegen.generators.shared.driving import Agents, ClosedLoop, Draw, expect_commits
from drivegen.generators.shared.lanes import LaneVectors, Logs
from drivegen.generators.shared.learned import Placement
from drivegen.training import loop

ABOUT = Method(
    title="TrafficGen",
    line="A vector encoder, modes of motion per vehicle, short steps one after the other (Feng et al., ICRA 2023).",
    kind="learned",
    goals=None,
    trains_on="the logs",
    places=True,
    additions=(),
)


@dataclass(frozen=True)
class TrafficGenSettings:
    """Values stand in params.yaml, `train_generator.generators.trafficgen`.

    Attributes:
        piece: length of the lane pieces [m]. lanes, boxes: how many of each a vehicle sees, the nearest.
        width, layers: of the gates. modes: per vehicle.
        horizon: steps that are predicted. commit: steps of them that are driven before the next prediction, at most all;
            multiples of 5.
        disturbance: of the training examples.
        placement_width: of the gates of the initialisation. placement_lanes: regions around the target, the nearest.
        training: see `training.loop.Settings`.
    """

    piece: Positive
    lanes: Count
    boxes: Count
    width: Count
    layers: Count
    modes: Count
    horizon: Count
    commit: Count
    disturbance: Disturbance
    placement_width: Count
    placement_lanes: Count
    training: loop.Settings

    def __post_init__(self) -> None:
        expect_commits("train_generator.generators.trafficgen", self.horizon, self.commit, KNOT)


class TrafficGenNet(nn.Module):
    """Both halves of TrafficGen, which share no weights."""

    def __init__(self, settings: TrafficGenSettings) -> None:
        super().__init__()
        self.motion = MotionNet(settings.width, settings.layers, settings.modes, settings.horizon // KNOT)
        self.placement = PlacementNet(settings.placement_width, settings.layers)

    def forward(self, half: str, lanes: Tensor, lane_there: Tensor, boxes: Tensor, box_there: Tensor) -> Modes | Regions:
        """The `half` "motion" or "placement" of `Surroundings`."""
        output: Modes | Regions = getattr(self, half)(lanes, lane_there, boxes, box_there)
        return output


class Plugin(ClosedLoop):
    """See `generators.shared.driving.ClosedLoop`."""

    name = "trafficgen"
    tempered = True
    chunk = 256
    about = ABOUT
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
        return Logs.of(scenarios, settings.piece)

    @classmethod
    def objective(
        cls, settings: TrafficGenSettings, net: TrafficGenNet, train: Logs, validation: Logs, seed: int
    ) -> TrafficGenObjective:
        """See `Learned`."""
        del net, seed
        shape = settings.horizon // KNOT, (settings.lanes, settings.boxes), _look(settings)
        motion = MotionExamples(train, *shape), MotionExamples(validation, *shape, most=HELD_OUT)
        placement = PlacementExamples(train, _around_target(settings))
        return TrafficGenObjective(*motion, placement, settings.disturbance)

    def place(self, scenario: Scenario, count: int, seed: int) -> Vehicles:
        """TrafficGen's initialisation: the scenario's target, and others drawn around it, `count` in all if there is room.

        Map, target and signals at step 0 are read, nothing else.
        """
        counts, random = _around_target(self.settings), seeds.rng(seed, self.name, "place", scenario.scenario_id)
        return place(self.net.placement, scenario, counts, self.settings.piece, count, random)

    def placements(self, logs: Iterable[Scenario], seed: int) -> dict[str, Placement]:
        """See `Learned`."""
        del logs
        return {self.about.title: lambda scenario: self.place(scenario, len(scenario.vehicles), seed)}

    def roads(self, scenarios: Sequence[Scenario]) -> LaneVectors:
        """See `ClosedLoop`."""
        return LaneVectors.of(scenarios, self.settings.piece)

    def planned(self, roads: LaneVectors, agents: Agents, crowd: Crowd, draw: Draw) -> Trajectories:
        """See `ClosedLoop`."""
        s = self.settings

        def ask(box: NDArray[np.integer]) -> tuple[Tensor, ...]:
            modes = self.net.motion(*Surroundings.of(roads, crowd, box, (s.lanes, s.boxes), _look(s)).tensors())
            return modes.logit, modes.velocity, modes.turn

        logit, velocity, turn = (part.numpy() for part in agents.asked(crowd, self.chunk, ask))
        mode = drawn(logit, draw(), float(self.temperature))
        rows = np.arange(len(mode))
        return between_knots(crowd.state[agents.box], velocity[rows, mode], turn[rows, mode], s.commit)


def _look(settings: TrafficGenSettings) -> float:
    """Half the horizon [s]: where a vehicle then is, is the middle of what it sees."""
    return settings.horizon * DT / 2


def _around_target(settings: TrafficGenSettings) -> tuple[int, int]:
    """Regions and boxes of the initialisation."""
    return settings.placement_lanes, settings.boxes
