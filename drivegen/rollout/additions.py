"""The same additions for any generator: the vehicles of its futures combined anew, in a shared tempo, legal together.

K futures of a scene hold K trajectories of every vehicle. An addition chooses which of them goes into which future and changes
none, so it needs nothing of the model that made them, and what one vehicle may do stays what its model says:

* tempo: each vehicle's trajectories are reordered so that in one future all get far, or all do not: their ranks by distance
  driven, as if the road went on beyond its ends, follow a Gaussian copula (`goals.joint.tempos`). Every trajectory is used once,
  so mean errors stay what they are.
* checker: vehicle after vehicle, the target first, a trajectory that the checker turns down, alone or with those before it, is
  exchanged for the vehicle's own one of the nearest rank that is legal, or for its least illegal one.

DriveGen does the same with its goals, before it plans; there a new trajectory is drawn where this takes another of the K.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drivegen.checker.limits import Limits
from drivegen.checker.scene import SceneChecker
from drivegen.core import seeds
from drivegen.core.samples import Samples
from drivegen.core.scenario import DT, Scenario, Trajectories
from drivegen.goals.joint import tempos
from drivegen.rollout.scene import badness_of

CHECKER, TEMPO = "checker", "tempo"
VARIANTS: tuple[tuple[str, ...], ...] = ((), (TEMPO,), (CHECKER,), (CHECKER, TEMPO))
"""What is compared: as it is, with either addition, with both."""


def with_additions(
    scenario: Scenario, samples: Samples, limits: Limits, additions: Sequence[str], share: float, seed: int
) -> Samples:
    """K samples with `additions`, judged; they are those given where there are none.

    `share` of the variance of ranks is common to the vehicles of a future, as in `rollout.scene.RolloutSettings.tempo`.
    """
    count, vehicles = samples.motion.valid.shape[:2]
    rank = _distances(samples).argsort(axis=0, kind="stable").argsort(axis=0)
    chosen = np.repeat(np.arange(count)[:, None], vehicles, axis=1)
    if TEMPO in additions:
        chosen = _in_tempo(rank, tempos(seed, scenario.scenario_id, count), share, seeds.rng(seed, "own", scenario.scenario_id))
    checker = SceneChecker(scenario, limits)
    if CHECKER in additions:
        chosen = np.stack([_legal(checker, samples.motion, rank, own) for own in chosen])
    at = (chosen, np.arange(vehicles))
    violation, first = checker.check_samples(samples.motion[at])
    columns = {name: getattr(samples, name)[at] for name in ("goal", "natural", "used", "attempts", "dropped", "left_map")}
    return replace(samples, motion=samples.motion[at], violation=violation, first_violation=first, **columns)


def _distances(samples: Samples) -> NDArray[np.float64]:
    """(K, N) [m] that each vehicle drives; who leaves goes on at its last speed, as up to an exit the way is the same for all."""
    motion = samples.motion
    both = motion.valid[..., 1:] & motion.valid[..., :-1]
    step = np.linalg.norm(np.diff(motion.position, axis=-2), axis=-1)
    last = motion.last_valid()
    pace = np.take_along_axis(motion.speed, last[..., None], axis=-1)[..., 0]
    beyond = np.where(samples.left_map, pace * DT * (motion.steps - 1 - last), 0)
    return np.asarray(np.where(both, step, 0).sum(axis=-1, dtype=np.float64) + beyond)


def _in_tempo(rank: NDArray[np.intp], tempo: NDArray[np.float64], share: float, rng: np.random.Generator) -> NDArray[np.intp]:
    """Trajectories (K, N), each vehicle's permuted: the future of the highest tempo tends to have those of the highest rank."""
    score = np.sqrt(share) * tempo[:, None] + np.sqrt(1 - share) * rng.normal(size=rank.shape)
    order = score.argsort(axis=0, kind="stable").argsort(axis=0)
    return np.take_along_axis(rank.argsort(axis=0, kind="stable"), order, axis=0)


def _legal(checker: SceneChecker, motion: Trajectories, rank: NDArray[np.intp], own: NDArray[np.intp]) -> NDArray[np.intp]:
    """Trajectories (N,) of one future: those `own` (N,) where they are legal together, else others of the same vehicle."""
    committed, chosen = Trajectories.empty(len(own), motion.steps), own.copy()
    for n in range(len(own)):
        order = np.abs(rank[:, n] - rank[own[n], n]).argsort(kind="stable")
        for tried in (order[:1], order):  # most are legal at once
            violation, first = checker.check(n, motion[tried, n], committed, checker.size)
            if not violation.all():
                break
        legal = violation == 0
        chosen[n] = tried[legal.argmax() if legal.any() else badness_of(violation, first, motion.steps).argmin()]
        committed.put(n, motion[chosen[n], n])
    return chosen
