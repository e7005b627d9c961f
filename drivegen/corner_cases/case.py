"""A corner case: one scene in which a driver collided, with all that is needed to drive it again and to judge it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import TARGET, Scenario, Trajectories
from drivegen.world.outcome import CollisionKind


@dataclass(frozen=True)
class Case:
    """One collision of a driver, with the traffic that led to it. Vehicle 0 is the target.

    Attributes:
        scenario: map, vehicles with their first frame, context actors, signals. Several cases may share one.
        traffic: (N, T) how everybody was to move; the target's row gives its path and first state only.
        attacker: the vehicle whose motion was exchanged, one of them where two were, 0 where none was (logged traffic).
        driven: (T,) the target as it was driven, valid until the collision.
        step: of the collision. partner: who was hit, as in `DrivingOutcome`. kind: who hit whom. at_fault: nuPlan's verdict.
        impact_speed: [m/s] of the two relative to one another.
        violation: Violation flags of the scene, with the target left out of others' duties after its time to react; 0 is legal.
        odds: the attacker's natural odds of its goal, of two attackers the product; NaN where the method knows no goals.
        queries: runs of the driver that were spent on the scene up to this one, itself included.
        driver, method: who drove, who found it.
    """

    scenario: Scenario
    traffic: Trajectories
    attacker: int
    driven: Trajectories
    step: int
    partner: int
    kind: CollisionKind
    at_fault: bool
    impact_speed: float
    violation: int
    odds: float
    queries: int
    driver: str
    method: str

    @property
    def scenario_id(self) -> str:
        """The scenario's."""
        return self.scenario.scenario_id

    @property
    def other(self) -> tuple[Trajectories, NDArray[np.float32]]:
        """Motion (T,) and size (3,) [m] of the one that was hit."""
        count, people = len(self.scenario.vehicles), self.scenario.context
        if self.partner < count:
            return self.traffic[self.partner], self.scenario.vehicles.size[self.partner]
        return people.motion[self.partner - count], people.size[self.partner - count]

    @property
    def motion(self) -> Trajectories:
        """(N, T) everybody's, the target as it was driven: valid until the collision."""
        return Trajectories.joined([self.driven.until(self.traffic.steps)[np.newaxis], self.traffic[TARGET + 1 :]])

    @property
    def deaf(self) -> int:
        """The vehicle that does not react where all but the attacker do: the one that was hit where there is no attacker."""
        return self.attacker or self.partner

    @property
    def legal(self) -> bool:
        """Whether nobody in it breaks a rule of the checker."""
        return self.violation == 0
