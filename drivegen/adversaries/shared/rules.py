"""What an exchanged track may do: everything that is physically possible, or only what the legal checker lets pass."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from drivegen.checker.limits import Limits
from drivegen.checker.scene import SceneChecker
from drivegen.core.samples import Violation
from drivegen.core.scenario import TARGET, Scenario, Trajectories
from drivegen.rollout.scene import steps_to_avoid_target

PHYSICAL = (
    Violation.COLLISION | Violation.COLLISION_WITH_CONTEXT | Violation.ACCELERATION | Violation.CURVATURE | Violation.NOT_FINITE
)
"""Rules that bodies keep, whatever the law says."""

RULES = {"physical": int(PHYSICAL), "legal": 0xFFFF}
"""The rules that hold, by what is allowed."""


@dataclass(frozen=True)
class Judge:
    """The checker of one scene, whose traffic stands.

    Attributes:
        traffic: (N, T). target_steps: (N,) for how long each avoids the target; its driver reacts after that.
    """

    checker: SceneChecker
    traffic: Trajectories
    target_steps: NDArray[np.int64]

    @classmethod
    def of(cls, scenario: Scenario, traffic: Trajectories, limits: Limits, reaction_steps: int) -> Self:
        """Others avoid the target's plan for `reaction_steps`, those that come up from behind always."""
        return cls(SceneChecker(scenario, limits), traffic, steps_to_avoid_target(scenario, reaction_steps))

    def alone_and_among(self, vehicle: NDArray[np.integer], motion: Trajectories) -> NDArray[np.uint16]:
        """(E,) Violation flags of tracks (E, T) of the vehicles (E,), each exchanged by itself."""
        flags, motion = np.zeros(len(vehicle), np.uint16), motion.until(self.traffic.steps)
        alone = self.checker.alone(vehicle, motion)
        for n in np.unique(vehicle).tolist():
            rows = np.flatnonzero(vehicle == n)
            among = self.checker.among_committed(n, motion[rows], self._others(n), self.checker.size, alone[rows])
            flags[rows] = among.violation
        return flags

    def whole(self, variants: Sequence[Trajectories]) -> NDArray[np.uint16]:
        """(V,) flags of everybody but the target in whole variants (N, T), none of whom has duties towards the target."""
        if not variants:
            return np.zeros(0, np.uint16)
        stacked = Trajectories.joined([motion[np.newaxis] for motion in variants])
        violation, _ = self.checker.check_samples(stacked, ignore_target=True)
        return np.asarray(np.bitwise_or.reduce(violation[:, TARGET + 1 :], axis=1), np.uint16)

    def exchanged(self, vehicle: NDArray[np.integer], motion: Trajectories) -> Trajectories:
        """The traffic (N, T) with other tracks (E, T) of the vehicles (E,)."""
        changed = self.traffic.copy()
        changed.put(vehicle, motion.until(changed.steps))
        return changed

    def _others(self, vehicle: int) -> Trajectories:
        valid = self.traffic.valid.copy()
        valid[vehicle] = False
        valid[TARGET, self.target_steps[vehicle] :] = False
        return replace(self.traffic, valid=valid)
