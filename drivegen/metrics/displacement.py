"""Displacement errors of generated traffic against the log: the paper's sADE and sFDE, with masks.

One sample of a scene is a joint future of all its vehicles ("world" in av2). Its sADE is the mean over scored vehicles
of the mean distance over their scored steps; its sFDE the mean over scored vehicles of the distance at the last one.

* Scored steps are those the log observed, from `FIRST_SCORED` on: step 0 is given to every method, its error is 0 for
  all, and av2 too is handed future steps only.
* Scored vehicles have at least one scored step. None is ever left out because a method failed on it.
* Who has left the map while the log is still there stands at its exit (`standing_at_exit`); where the log has left, nothing is
  scored. The other scores of this package take motion from the same function.
* On tracks without gaps the numbers equal av2's `compute_world_ade` and `compute_world_fde` (motion_forecasting/eval/
  metrics.py) over steps 1..T-1.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import Trajectories

FIRST_SCORED = 1
"""First step that counts; the one before it is the initial state."""


@dataclass(frozen=True)
class QualitySummary:
    """The four statistics of one scene over its K samples [m] (paper, "Scenario Quality Evaluation")."""

    min_sade: float
    min_sfde: float
    mean_sade: float
    mean_sfde: float


def scored_steps(log: Trajectories) -> NDArray[np.bool_]:
    """(N, T) where errors count: observed in the log, after the initial state."""
    scored = log.valid.copy()
    scored[:, :FIRST_SCORED] = False
    return scored


def standing_at_exit(samples: Trajectories, log: Trajectories) -> Trajectories:
    """Samples (K, N, T) as they are scored against the log (N, T): who has left the map stands where it was seen last.

    Raises UnusableInput where shapes differ, and where a sample lacks a step that the log has and did not leave before
    ("left-out"): an average over the remaining vehicles would flatter the method.
    """
    if samples.valid.shape[1:] != log.valid.shape:
        raise UnusableInput(f"samples {samples.valid.shape} and log {log.valid.shape} differ in shape", reason="bad-samples")
    seen = np.asarray(samples.valid.any(-1))
    gone = seen[..., None] & (np.arange(samples.steps) > samples.last_valid()[..., None])
    if not (samples.valid | gone)[:, scored_steps(log)].all():
        raise UnusableInput("a sample leaves out vehicles or steps that the log has", reason="left-out")
    return samples.standing_after_end() if gone.any() else samples


def scene_errors(samples: Trajectories, log: Trajectories) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """sADE (K,) and sFDE (K,) [m] of samples (K, N, T) against the log (N, T).

    Raises UnusableInput as `standing_at_exit` does, and where nothing can be scored ("nothing-to-score").
    """
    samples = standing_at_exit(samples, log)
    scored = scored_steps(log)
    vehicles = scored.any(axis=1)
    if not vehicles.any():
        raise UnusableInput("the log has no step after the first frame to be scored", reason="nothing-to-score")
    gap = np.where(scored[..., None], samples.position - log.position, np.float32(0))
    distance = np.sqrt(gap[..., 0] ** 2 + gap[..., 1] ** 2, dtype=np.float32)
    steps = np.maximum(scored.sum(axis=1), 1)
    sade = (distance.sum(axis=-1, dtype=np.float64) / steps)[:, vehicles].mean(axis=1)
    last = scored.shape[1] - 1 - np.argmax(scored[:, ::-1], axis=1)
    sfde = distance[:, np.arange(len(last)), last][:, vehicles].mean(axis=1, dtype=np.float64)
    return sade, sfde


def summarise(sade: NDArray[np.float64], sfde: NDArray[np.float64]) -> QualitySummary:
    """Minimum and mean over the K samples; each minimum is taken on its own, as av2 and the paper do."""
    return QualitySummary(float(sade.min()), float(sfde.min()), float(sade.mean()), float(sfde.mean()))
