"""Generated traffic: K futures of one scenario, with the goals they were given and the checker's verdicts."""

from dataclasses import dataclass
from enum import IntFlag

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import Trajectories

NO_GOAL = -1


class Violation(IntFlag):
    """What the legal checker found; a trajectory is legal iff it is NONE."""

    NONE = 0
    COLLISION = 1
    COLLISION_WITH_CONTEXT = 2
    OFF_ROAD = 4
    WRONG_WAY = 8
    SPEED = 16
    ACCELERATION = 32
    CURVATURE = 64
    RED_LIGHT = 128
    STOP_OR_YIELD = 256
    NOT_FINITE = 512


@dataclass(frozen=True)
class Samples:
    """K generated futures of one scenario of N vehicles.

    Attributes:
        scenario_id: the scenario they belong to.
        method: who made them, e.g. "drivegen" or "constant_velocity".
        motion: Trajectories (K, N, T); valid False for a vehicle that this sample leaves out, and once one has left the map.
        violation: (K, N) uint16 Violation flags of the trajectory as it stands here.
        first_violation: (K, N) int16 first step at which it is illegal, -1 if legal.
        goal: (K, N) int32 index of the candidate that was followed, NO_GOAL where the method has no goals.
        natural: (K, N) float32 the selector's own probability of that goal (NaN without goals).
        used: (K, N) float32 the probability with which it was drawn (differs from `natural` in corner cases).
        attempts: (K, N) uint8 trajectories planned until this one was taken.
        dropped: (K, N) bool left out because nothing legal was found (shipped scenarios only).
        left_map: (K, N) bool drove out by an exit of the map before the end (`roads.leaving`).
    """

    scenario_id: str
    method: str
    motion: Trajectories
    violation: NDArray[np.uint16]
    first_violation: NDArray[np.int16]
    goal: NDArray[np.int32]
    natural: NDArray[np.float32]
    used: NDArray[np.float32]
    attempts: NDArray[np.uint8]
    dropped: NDArray[np.bool_]
    left_map: NDArray[np.bool_]

    @property
    def legal(self) -> NDArray[np.bool_]:
        """(K, N)."""
        return np.equal(self.violation, 0)

    @classmethod
    def without_goals(cls, scenario_id: str, method: str, motion: Trajectories) -> "Samples":
        """Samples of a method that knows no goals, not yet checked, nor who leaves the map."""
        shape = motion.valid.shape[:2]
        return cls(
            scenario_id,
            method,
            motion,
            np.zeros(shape, np.uint16),
            np.full(shape, -1, np.int16),
            np.full(shape, NO_GOAL, np.int32),
            np.full(shape, np.nan, np.float32),
            np.full(shape, np.nan, np.float32),
            np.ones(shape, np.uint8),
            np.zeros(shape, np.bool_),
            np.zeros(shape, np.bool_),
        )
