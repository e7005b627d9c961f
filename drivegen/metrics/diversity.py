"""Diversity of a set of scenarios, and its ratio to the real set (paper, "Scenario Quality Evaluation").

D(S1, S2) = sum_i sum_j d(tau_i, tau_j), d(tau_1, tau_2) = sum_t ||s_t^1 - s_t^2||^2, every vehicle's trajectory in the
frame of its own first position and heading; the set is split into random pairs and D is averaged over them.

What the paper leaves open is fixed here, and stated wherever the number is:

* the state is the position [m];
* `||.||^2` is read both ways: the squared distance [m^2], and the plain distance [m];
* a term counts where both vehicles are valid at that step, and generated motion takes its log's mask, so that the ratio
  compares sums over the same terms;
* one split of S scenes has only S // 2 pairs, so several seeded splits are averaged; the real and the generated set
  are split alike.

The squared form needs no pairs of vehicles: with a scene's sums over its vehicles n_t = sum 1, p_t = sum s, q_t = sum |s|^2,
D(S1, S2) = sum_t n_t^1 q_t^2 + q_t^1 n_t^2 - 2 p_t^1 . p_t^2.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import to_vehicle_frame
from drivegen.core.intervals import Draws, Interval, percentiles
from drivegen.core.scenario import Trajectories

Pairs = NDArray[np.intp]

PAIRS = 4096
"""Pairs that are compared at once."""

WEIGHTS = 2**22
"""Weights of pairs in draws that are in memory at once, or 64 draws' where these are more."""


@dataclass(frozen=True)
class OwnFrames:
    """Motion of S scenes, each vehicle in its own initial frame, padded to N vehicles and T steps; made when asked for.

    `frames[s]` are positions (N, T, 2) float32 [m], zero where not valid, and valid (N, T) of a scene.
    """

    scenes: Sequence[Trajectories]
    vehicles: int
    steps: int

    def __len__(self) -> int:
        return len(self.scenes)

    def __getitem__(self, number: int) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        scene = self.scenes[number]
        rows = np.arange(len(scene.valid))
        first = np.argmax(scene.valid, axis=1)
        moved = to_vehicle_frame(scene.position, scene.position[rows, first], scene.heading[rows, first])
        position = np.zeros((self.vehicles, self.steps, 2), np.float32)
        valid = np.zeros((self.vehicles, self.steps), np.bool_)
        position[: len(rows), : scene.steps] = np.where(scene.valid[..., None], moved, 0)
        valid[: len(rows), : scene.steps] = scene.valid
        return position, valid


def own_frames(scenes: Sequence[Trajectories]) -> OwnFrames:
    """Of scenes of Trajectories (N_i, T_i), moved into each vehicle's frame at its first valid step."""
    shapes = np.array([scene.valid.shape for scene in scenes])
    return OwnFrames(scenes, *shapes.max(axis=0).tolist())


def random_pairs(scenes: int, splits: int, rng: np.random.Generator) -> Pairs:
    """(splits * (scenes // 2), 2) scene numbers: each split pairs every scene with one other (an odd one stays out)."""
    half = scenes // 2
    orders = [rng.permutation(scenes)[: 2 * half].reshape(half, 2) for _ in range(splits)]
    return np.concatenate(orders) if orders else np.zeros((0, 2), np.intp)


def squared_differences(frames: OwnFrames, pairs: Pairs) -> NDArray[np.float64]:
    """D (P,) [m^2] of each pair with the squared norm."""
    count, square = np.zeros((2, len(frames), frames.steps))
    total = np.zeros((len(frames), frames.steps, 2))
    for s in range(len(frames)):
        position, valid = frames[s][0].astype(np.float64), frames[s][1]
        count[s], total[s], square[s] = valid.sum(axis=0), position.sum(axis=0), (position**2).sum(axis=(0, 2))
    out = np.zeros(len(pairs))
    for low in range(0, len(pairs), PAIRS):
        a, b = pairs[low : low + PAIRS].T
        cross = np.einsum("ptd,ptd->p", total[a], total[b])
        same = np.einsum("pt,pt->p", count[a], square[b]) + np.einsum("pt,pt->p", square[a], count[b])
        out[low : low + PAIRS] = same - 2 * cross
    return out


def plain_differences(frames: OwnFrames, pairs: Pairs) -> NDArray[np.float64]:
    """D (P,) [m] of each pair with the plain norm; N x N x T distances a pair."""
    out = np.zeros(len(pairs))
    for p, pair in enumerate(pairs.tolist()):
        (one, seen), (other, there) = (frames[s] for s in pair)
        gap = one[:, None] - other[None]
        distance = np.sqrt(gap[..., 0] ** 2 + gap[..., 1] ** 2)
        out[p] = distance.sum(where=seen[:, None] & there[None], dtype=np.float64)
    return out


def ratio(
    generated: NDArray[np.float64],
    real: NDArray[np.float64],
    pairs: Pairs,
    recordings: Sequence[str],
    draws: int,
    rng: np.random.Generator,
) -> Interval:
    """Mean difference of the generated set over that of the real one, both (P,) on the same pairs.

    The interval resamples the `recordings` of scenes, one name a scene, not pairs, because pairs of several splits share scenes:
    in a draw that holds scene i c_i times, pair (i, j) weighs c_i c_j.
    """
    if len(pairs) == 0 or real.sum() == 0:
        return Interval(np.nan, np.nan, np.nan)
    drawn_recordings = Draws.of(recordings, draws, rng)
    times, (one, other) = drawn_recordings.times, drawn_recordings.number[pairs.T]
    above, below = np.zeros((2, len(times)))
    rows = max(WEIGHTS // len(pairs) // 64, 1) * 64
    for part in (slice(low, low + rows) for low in range(0, len(times), rows)):
        weight = times[part][:, one] * times[part][:, other]
        above[part], below[part] = weight @ generated, weight @ real
    drawn = above[below > 0] / below[below > 0]
    low, high = percentiles(drawn)
    return Interval(float(generated.sum() / real.sum()), low, high)
