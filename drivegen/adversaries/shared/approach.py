"""How near planned tracks come to a target as it drove, in the frame of its path, and how long before that it could have seen it.

A driver brakes for who is in its way, so what counts beside the gap is the *warning*: for how long the other has been on the
target's way, ahead of it, when they are nearest.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.core.geometry import Floats
from drivegen.core.scenario import DT, FIRST_SECOND, TARGET, Trajectories
from drivegen.corner_cases.trials import Trials
from drivegen.world.replay import progress, project

MARGIN = 0.2
"""Who keeps less than this [m] beside the target's way is on it."""


@dataclass(frozen=True)
class Approaches:
    """Nearest approaches of E tracks, after the first second.

    Attributes:
        gap: (E,) float32 [m] between the boxes along or across the path, whichever is more; inf if never both there.
        warning: (E,) float32 [s].
        behind: (E,) bool, the other's middle is behind the target's rear then.
        contact: (E,) int16 first step at which the boxes overlap, -1 for never.
    """

    gap: NDArray[np.float32]
    warning: NDArray[np.float32]
    behind: NDArray[np.bool_]
    contact: NDArray[np.int16]

    def cost(self, caution: float, behind: float) -> NDArray[np.float32]:
        """(E,) [m] the gap, more where there is much warning: `caution` [m/s] for each second, `behind` [m] for who is behind."""
        return np.asarray(self.gap + np.float32(caution) * self.warning + np.float32(behind) * self.behind, np.float32)


def approaches(
    trials: Trials,
    driven: Trajectories,
    scene: NDArray[np.integer],
    vehicle: NDArray[np.integer],
    motion: Trajectories,
    run: NDArray[np.integer] | None = None,
) -> Approaches:
    """Of tracks (E, T) of the vehicles (E,) of scenes (E,) to targets as they were `driven` (R, T), `DrivingOutcome.to_the_end`.

    `run` (E,) says to which of these each track comes near; where it is not given, `driven` are those of all scenes. Nobody
    comes near a target that is gone.
    """
    run, count = scene if run is None else run, len(scene)
    gap, warning = np.full(count, np.inf, np.float32), np.zeros(count, np.float32)
    behind, contact = np.zeros(count, np.bool_), np.full(count, -1, np.int16)
    for s in np.unique(scene).tolist():
        mine, line, sizes = np.flatnonzero(scene == s), trials.path(s), trials.scenarios[s].vehicles.size[:, :2]
        runs, own_run = np.unique(run[mine], return_inverse=True)
        target, target_size = driven[runs], np.repeat(sizes[TARGET : TARGET + 1], len(runs), axis=0)
        own = _frame(line, progress(target, target.steps).T, target, target_size, True)[:, 0, own_run]
        found = _frame(line, own, motion[mine], sizes[vehicle[mine]], False)
        there = np.ascontiguousarray((motion.valid[mine] & driven.valid[run[mine], : motion.steps]).T)
        gap[mine], warning[mine], behind[mine], contact[mine] = _nearest(np.ascontiguousarray(own), sizes[TARGET], found, there)
    return Approaches(gap, warning, behind, contact)


def _frame(
    line: Floats, expected: NDArray[np.float32], motion: Trajectories, size: NDArray[np.float32], throughout: bool
) -> NDArray[np.float32]:
    """(T, 6, E) see `Observation`: the target is `expected` (T, E) [m] along its path; `throughout`: invalid steps count, too."""
    frame = np.zeros((motion.steps, 6, len(size)), np.float32)
    valid = np.ones_like(motion.valid) if throughout else motion.valid
    arrays = (motion.position, motion.heading, motion.velocity, valid)
    seen = (np.ascontiguousarray(array.swapaxes(0, 1)) for array in arrays)
    project(line, np.ascontiguousarray(expected), *seen, np.ascontiguousarray(size), frame)
    return frame


@njit(cache=True)
def _nearest(own, size, frame, valid):  # type: ignore[no-untyped-def]
    """gap, warning, behind, contact (E,) of boxes `frame` (T, 6, E) to a target at `own` (T, E) along its path."""
    count = valid.shape[1]
    gap, warning = np.full(count, np.inf, np.float32), np.zeros(count, np.float32)
    behind, contact = np.zeros(count, np.bool_), np.full(count, -1, np.int16)
    for e in range(count):
        since = 0
        for t in range(valid.shape[0]):
            if not valid[t, e]:
                since = 0
                continue
            ahead = frame[t, 0, e] - own[t, e]
            across = abs(frame[t, 1, e]) - frame[t, 3, e] - 0.5 * size[1]
            along = abs(ahead) - frame[t, 2, e] - 0.5 * size[0]
            apart = max(along, across, 0.0)
            if apart == 0 and contact[e] < 0:
                contact[e] = t
            if t > FIRST_SECOND and apart < gap[e]:
                gap[e], warning[e], behind[e] = apart, since * DT, ahead < -0.5 * size[0]
            since = since + 1 if across < MARGIN and ahead > 0 else 0
    return gap, warning, behind, contact
