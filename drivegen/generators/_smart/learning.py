"""What SMART learns from: logs as words, spoken with slips, and the odds of the word that comes next.

A vehicle's log is told in tokens one after the other, each the nearest to what it did from where the token before has led it.
Some are slips: one of the nearest few. The word to be learnt is then the one that leads back to the log, so that who is driven
by drawn words recovers from them.
"""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from drivegen.core.scenario import DT, VehicleKind
from drivegen.core.settings import Count, Share
from drivegen.generators._smart.around import LOOK, others, pose
from drivegen.generators._smart.net import AGE, Seen
from drivegen.generators._smart.tokens import SPAN, Vocabulary, gone, logged, pace, ways
from drivegen.generators.shared.closed_loop import Tracks
from drivegen.generators.shared.lanes import PACE, LaneVectors, Logs
from drivegen.generators.shared.objective import Objective

WORDS = 20
"""Tokens of a log that are learnt at most: 10 s."""

HELD_OUT = 48
"""Validation scenes that the loss is taken over, at most."""


@dataclass(frozen=True)
class Slips:
    """How logs are told to be learnt from.

    Attributes:
        share: of the tokens that are one of the `nearest`, each as likely, in place of the nearest.
        cut: share of the scenes in which everybody forgets all before some moment, which is another first frame.
    """

    share: Share
    nearest: Count
    cut: Share


@dataclass(frozen=True)
class Sequences:
    """V vehicles at T moments as they were told: what led there, where that is, what is to come.

    Attributes:
        pose: (V, T, 3), speed: (V, T) [m/s], token: (V, T), fresh: (V, T) as in `Seen`.
        target: (V, T) the token that comes next, -1 where the log doesn't say.
    """

    pose: NDArray[np.float32]
    speed: NDArray[np.float32]
    token: NDArray[np.int64]
    fresh: NDArray[np.bool_]
    target: NDArray[np.int64]


def tokenise(
    words: Vocabulary, tracks: Tracks, box: NDArray[np.integer], step: NDArray[np.integer], cut: NDArray[np.integer],
    slips: Slips, random: np.random.Generator,
) -> Sequences:  # fmt: skip
    """The logs of boxes (V,) in tokens from moment to moment, `step` (V, T), anew from moment `cut` (V,) on."""
    steps, count = tracks.valid.shape[1], step.shape[1]
    at = np.minimum(step, steps - 1)
    there = tracks.valid[box[:, None], at] & (step < steps)
    pose, speed = logged(tracks, box[:, None], at), np.hypot(*np.moveaxis(tracks.velocity[box[:, None], at], -1, 0))
    ahead = step[..., None] + np.arange(1, SPAN + 1)
    every = np.broadcast_to(box[:, None, None], ahead.shape)
    after = logged(tracks, every, ahead)
    labelled = there & (tracks.valid[every, np.minimum(ahead, steps - 1)] & (ahead < steps)).all(axis=-1)
    token, fresh, target = np.zeros(step.shape, np.int64), np.ones(step.shape, np.bool_), np.full(step.shape, -1, np.int64)
    for t in range(count):
        between = words.distances(ways(pose[:, t], after[:, t]))
        nearest = between.argmin(axis=1)
        target[:, t] = np.where(labelled[:, t], nearest, -1)
        slip = random.random(len(box)) < slips.share
        chosen = np.where(slip, words.disturbed(between, slips.nearest, random), nearest)
        if t + 1 < count:
            on = labelled[:, t] & there[:, t + 1] & (cut != t + 1)
            way = words.way[chosen[on]]
            pose[on, t + 1], speed[on, t + 1] = gone(pose[on, t], way)[:, -1], pace(way)
            token[on, t + 1], fresh[on, t + 1] = chosen[on], False
    return Sequences(pose, speed.astype(np.float32), token, fresh, target)


def seen_from(
    lanes: LaneVectors, counts: tuple[int, int], tracks: Tracks, scenes: NDArray[np.integer], maps: NDArray[np.integer],
    state: NDArray[np.float32], there: NDArray[np.bool_], token: NDArray[np.integer], fresh: NDArray[np.bool_],
    age: NDArray[np.floating], shown: NDArray[np.integer],
) -> Seen:  # fmt: skip
    """What the V vehicles of `scenes` (G,) of `tracks`, which lie on `maps` (G,) of `lanes`, see at T moments.

    Of all boxes of these scenes, `state` (X, T, 4) x, y, heading, speed, and `there` (X, T). Of the vehicles, `token`, `fresh`,
    `age` [s] since their first frame and the step whose signals are `shown` (V, T).
    """
    start, box = tracks.boxes(scenes)
    row, moments = np.flatnonzero(tracks.planned[box]), state.shape[1]
    group = np.searchsorted(start, row, side="right") - 1
    fixed = np.concatenate([tracks.size[box[row]] / (5.0, 2.0), np.eye(len(VehicleKind))[tracks.kind[box[row]]]], axis=1)
    changing = np.stack([state[row, :, 3] / PACE, age / AGE, fresh], axis=-1)
    own = np.concatenate([changing, fixed[:, None].repeat(moments, axis=1)], axis=-1).astype(np.float32)
    road, drawn = lanes.around(pose(state[row].reshape(-1, 4)), maps[group].repeat(moments), shown.reshape(-1), counts[0], LOOK)
    span = np.stack([start[group], start[group + 1]], axis=1)
    other, seen, who = others(span, row, state, there, tracks.size[box], tracks.planned[box], counts[1])
    number = np.full(len(box), -1, np.int64)
    number[row] = np.arange(len(row))
    roads = (near.reshape(len(row), moments, *near.shape[1:]) for near in (road, drawn))
    return Seen(*map(torch.from_numpy, (token, own, state[row, :, :3], fresh, *roads, other, seen, number[who])))


class Examples:
    """Scenes as sentences, at most `most`, evenly spread; `counts` are the pieces of road and the others that a vehicle sees."""

    def __init__(self, logs: Logs, words: Vocabulary, counts: tuple[int, int], most: int | None = None) -> None:
        self.logs, self.words, self.counts = logs, words, counts
        count = len(logs)
        self.scenes = np.linspace(0, count - 1, min(count, most or count)).astype(np.intp)

    def __len__(self) -> int:
        return len(self.scenes)

    def plain(self, rows: NDArray[np.integer]) -> tuple[Seen, Tensor]:
        """The batch of scenes `rows` (b,) from their first frames on, told without slips."""
        zero = np.zeros(len(rows), np.int64)
        return self.batch(rows, zero, zero, Slips(0.0, 1, 0.0), np.random.default_rng(0))

    def batch(
        self, rows: NDArray[np.integer], phase: NDArray[np.integer], cut: NDArray[np.integer], slips: Slips,
        random: np.random.Generator,
    ) -> tuple[Seen, Tensor]:  # fmt: skip
        """What the vehicles of scenes `rows` (b,) see, and their next tokens (V, T); they begin at step `phase` (b,)."""
        tracks, scenes = self.logs.tracks, self.scenes[rows]
        start, box = tracks.boxes(scenes)
        group = np.repeat(np.arange(len(scenes)), np.diff(start))
        moments = min(WORDS, max(1, (tracks.valid.shape[1] - 1) // SPAN))
        step = phase[group, None] + SPAN * np.arange(moments)
        row = np.flatnonzero(tracks.planned[box])
        sequences = tokenise(self.words, tracks, box[row], step[row], cut[group[row]], slips, random)
        state, there = self._states(box, step, row, sequences)
        begun = np.where(np.arange(moments) >= cut[group[row], None], cut[group[row], None], 0)
        shown = phase[group[row], None] + SPAN * begun
        age = (np.arange(moments) - begun) * SPAN * DT
        token, fresh, lanes = sequences.token, sequences.fresh, self.logs.lanes
        seen = seen_from(lanes, self.counts, tracks, scenes, scenes, state, there, token, fresh, age, shown)
        return seen, torch.from_numpy(sequences.target)

    def _states(
        self, box: NDArray[np.integer], step: NDArray[np.integer], row: NDArray[np.integer], sequences: Sequences
    ) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """(X, T, 4) x, y, heading, speed of all boxes, vehicles where they were told to be, and (X, T) whether they are there."""
        tracks, at = self.logs.tracks, np.minimum(step, self.logs.tracks.valid.shape[1] - 1)
        speed = np.hypot(*np.moveaxis(tracks.velocity[box[:, None], at], -1, 0))
        state = np.concatenate([logged(tracks, box[:, None], at), speed[..., None]], axis=-1)
        state[row] = np.concatenate([sequences.pose, sequences.speed[..., None]], axis=-1)
        return state, tracks.valid[box[:, None], at] & (step == at)


class SmartObjective(Objective):
    """The cross-entropy of the next token; held-out scenes are told from their first frame on, without slips."""

    chunk = 8

    def __init__(self, train: Examples, held_out: Examples, slips: Slips) -> None:
        super().__init__(train, held_out)
        self.slips = slips

    def draw(self, rows: int, generator: torch.Generator) -> tuple[Tensor, ...]:
        """A number (rows, 1) that the randomness of each scene hangs on."""
        return (torch.randint(2**31, (rows, 1), generator=generator),)

    def mean(
        self, model: nn.Module, examples: Examples, rows: NDArray[np.integer], device: torch.device, *drawn: Tensor
    ) -> Tensor:
        """Over the tokens of the scenes; what is drawn makes the first frame one of the first SPAN steps."""
        seen, target = self._told(examples, rows, drawn[0]) if drawn else examples.plain(rows)
        logit, _ = model(Seen(*(part.to(device) for part in seen)))
        target = target.to(device)
        labelled = target >= 0
        return functional.cross_entropy(logit[labelled], target[labelled], reduction="sum") / labelled.sum().clamp_min(1)

    def _told(self, examples: Examples, rows: NDArray[np.integer], drawn: Tensor) -> tuple[Seen, Tensor]:
        random = np.random.default_rng(drawn.cpu().flatten().tolist())
        phase, cut = random.integers(0, SPAN, len(rows)), random.integers(1, WORDS, len(rows))
        cut[random.random(len(rows)) >= self.slips.cut] = 0
        return examples.batch(rows, phase, cut, self.slips, random)
