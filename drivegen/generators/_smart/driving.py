"""SMART in closed loop: a token for everybody is drawn and driven, then everything is seen again from where that led."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import DT, Scenario, Trajectories
from drivegen.generators._smart.around import PIECE
from drivegen.generators._smart.learning import seen_from
from drivegen.generators._smart.net import Seen, SmartNet
from drivegen.generators._smart.tokens import SPAN, STILL, gone, logged, pace
from drivegen.generators.shared.closed_loop import Tracks
from drivegen.generators.shared.lanes import LaneVectors


@dataclass(frozen=True)
class Driver:
    """A network and how its words are drawn.

    Attributes:
        net: in evaluation mode. counts: pieces of road and others that a vehicle sees.
        temperature: tokens are drawn from `p ** (1 / temperature)`, normalised. likely: of these the likeliest that have this
            share of the odds together, at least one.
    """

    net: SmartNet
    counts: tuple[int, int]
    temperature: float
    likely: float

    def drive(self, scenario: Scenario, tracks: Tracks, random: np.random.Generator) -> None:
        """Drive all vehicles of `tracks`, copies of the scenario's beginning, to the end, in place.

        What a copy is driven to is seen by its own vehicles alone. Of the signals the state at step 0 is told throughout.
        """
        roads, words = LaneVectors.of([scenario], PIECE), self.net.way.numpy()
        box = np.flatnonzero(tracks.planned)
        token, past = np.full(len(box), STILL, np.int64), None
        speed = np.hypot(*tracks.velocity[box, 0].T)
        for step in range(0, tracks.valid.shape[1] - 1, SPAN):
            logit, past = self.net(self._seen(roads, tracks, box, step, token, speed), past)
            token = drawn(logit[:, 0].numpy(), random.random(len(box)), self.temperature, self.likely)
            way = words[token]
            after, speed = gone(logged(tracks, box, np.full(len(box), step)), way), pace(way)
            still = np.zeros((len(box), SPAN, 2), np.float32)
            tracks.drive(box, step, Trajectories(after[..., :2], after[..., 2], still, np.ones(still.shape[:2], np.bool_)))
        tracks.velocity[box, 1:] = velocities(tracks.position[box])

    def _seen(
        self, roads: LaneVectors, tracks: Tracks, box: NDArray[np.integer], step: int, token: NDArray[np.integer],
        speed: NDArray[np.floating],
    ) -> Seen:  # fmt: skip
        """Everybody at `step`, one moment: (V, 1, ...)."""
        pace_of = np.hypot(*tracks.velocity[:, step].T)
        pace_of[box] = speed
        state = np.column_stack([tracks.position[:, step], tracks.heading[:, step], pace_of]).astype(np.float32)
        scenes, there, of_each = np.arange(len(tracks.start) - 1), tracks.valid[:, step, None], (len(box), 1)
        fresh, age, shown = np.full(of_each, step == 0), np.full(of_each, step * DT), np.zeros(of_each, np.int64)
        return seen_from(
            roads, self.counts, tracks, scenes, 0 * scenes, state[:, None], there, token[:, None], fresh, age, shown
        )  # fmt: skip


def drawn(logit: NDArray[np.floating], chance: NDArray[np.float64], temperature: float, likely: float) -> NDArray[np.int64]:
    """Tokens (V,) by logits (V, W) and `chance` (V,) in [0, 1): see `Driver`."""
    order = np.argsort(-logit, axis=1, kind="stable")
    share = np.take_along_axis(logit, order, axis=1).astype(np.float64) / temperature
    odds = np.exp(share - share[:, :1])
    total = odds.cumsum(axis=1)
    odds[total - odds > likely * total[:, -1:]] = 0.0
    total = odds.cumsum(axis=1)
    place = (total <= (chance * total[:, -1])[:, None]).sum(axis=1)
    return np.take_along_axis(order, place[:, None], axis=1)[:, 0]


def velocities(position: NDArray[np.float32]) -> NDArray[np.float32]:
    """(V, T - 1, 2) [m/s] at steps 1 .. T - 1 of positions (V, T, 2): half of the way from the step before to the one after."""
    last = 2 * position[:, -1:] - position[:, -2:-1]
    on = np.concatenate([position[:, 1:], last], axis=1)
    return np.asarray((on[:, 1:] - position[:, :-1]) / np.float32(2 * DT))
