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
from drivegen.core.intervals import Interval, percentiles, resamplings
from drivegen.core.scenario import Trajectories

Pairs = NDArray[np.intp]


@dataclass(frozen=True)
class OwnFrames:
    """Motion of S scenes, each vehicle in its own initial frame, padded to N vehicles and T steps.

    Attributes:
        position: (S, N, T, 2) float32 [m], zero where not valid.
        valid: (S, N, T) bool.
    """

    position: NDArray[np.float32]
    valid: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.valid)


def own_frames(scenes: list[Trajectories]) -> OwnFrames:
    """Scenes of Trajectories (N_i, T_i), moved into each vehicle's frame at its first valid step and padded."""
    vehicles = max(scene.valid.shape[0] for scene in scenes)
    steps = max(scene.steps for scene in scenes)
    position = np.zeros((len(scenes), vehicles, steps, 2), np.float32)
    valid = np.zeros((len(scenes), vehicles, steps), np.bool_)
    for s, scene in enumerate(scenes):
        rows = np.arange(len(scene.valid))
        first = np.argmax(scene.valid, axis=1)
        moved = to_vehicle_frame(scene.position, scene.position[rows, first], scene.heading[rows, first])
        position[s, : len(rows), : scene.steps] = np.where(scene.valid[..., None], moved, 0)
        valid[s, : len(rows), : scene.steps] = scene.valid
    return OwnFrames(position, valid)


def random_pairs(scenes: int, splits: int, rng: np.random.Generator) -> Pairs:
    """(splits * (scenes // 2), 2) scene numbers: each split pairs every scene with one other (an odd one stays out)."""
    half = scenes // 2
    orders = [rng.permutation(scenes)[: 2 * half].reshape(half, 2) for _ in range(splits)]
    return np.concatenate(orders) if orders else np.zeros((0, 2), np.intp)


def squared_differences(frames: OwnFrames, pairs: Pairs) -> NDArray[np.float64]:
    """D (P,) [m^2] of each pair with the squared norm."""
    position = frames.position.astype(np.float64)
    count = frames.valid.sum(axis=1).astype(np.float64)
    total = position.sum(axis=1)
    square = (position**2).sum(axis=(1, 3))
    a, b = pairs.T
    cross: NDArray[np.float64] = np.einsum("ptd,ptd->p", total[a], total[b])
    same: NDArray[np.float64] = np.einsum("pt,pt->p", count[a], square[b]) + np.einsum("pt,pt->p", square[a], count[b])
    return same - 2 * cross


def plain_differences(frames: OwnFrames, pairs: Pairs) -> NDArray[np.float64]:
    """D (P,) [m] of each pair with the plain norm; N x N x T distances a pair."""
    out = np.zeros(len(pairs))
    for p, (a, b) in enumerate(pairs):
        gap = frames.position[a][:, None] - frames.position[b][None]
        distance = np.sqrt(gap[..., 0] ** 2 + gap[..., 1] ** 2)
        out[p] = distance.sum(where=frames.valid[a][:, None] & frames.valid[b][None], dtype=np.float64)
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
    times = resamplings(recordings, draws, rng)
    weight = times[:, pairs[:, 0]] * times[:, pairs[:, 1]]
    below = weight @ real
    drawn = (weight @ generated)[below > 0] / below[below > 0]
    low, high = percentiles(drawn)
    return Interval(float(generated.sum() / real.sum()), low, high)
