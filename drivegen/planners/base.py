"""The protocol of a planner: learn from logs, then fill in motion between initial states and goals, in batches."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

ROUTE_SPACING = 1.0
"""Distance between points of a route line [m]."""


@dataclass(frozen=True)
class PlanRequests:
    """B trajectories that are wanted, from many scenarios at once.

    Requests refer to routes and to vehicles by index, so ten samples of one vehicle share one context.

    Attributes:
        scenario: (B,) int32 which scenario of the batch. vehicle: (B,) int32 which vehicle of it.
        position: (B, 2) float32 [m], heading: (B,) [rad], speed: (B,) [m/s], size: (B, 3) [m]: the state at step 0.
        goal_position: (B, 2), goal_heading: (B,), goal_speed: (B,): the state at the last step; met exactly.
        route: (B,) int32 row of `route_line`, or -1 where no route fits (parking, leaving the map).
        route_line: (R, P, 2) float32 [m] points every ROUTE_SPACING, the line starts abreast of its vehicle (s = 0).
        route_length: (R,) float32 [m] valid length of each line; points beyond repeat the last.
        route_speed_limit: (R, P) float32 [m/s], NaN unknown.
        goal_s, goal_d: (B,) float32 [m] the goal along and left of its route.
        leader_gap: (B,) float32 [m] bumper to bumper to the next vehicle ahead on the route at step 0, inf if none.
        leader_speed: (B,) float32 [m/s], 0 where there is none.
        stop_s: (B,) float32 [m] distance along the route to the next red or yellow signal at step 0, inf if none.
        seed: (B,) int64; a result depends on its request and this number alone, never on its neighbours in the batch.
    """

    scenario: NDArray[np.int32]
    vehicle: NDArray[np.int32]
    position: NDArray[np.float32]
    heading: NDArray[np.float32]
    speed: NDArray[np.float32]
    size: NDArray[np.float32]
    goal_position: NDArray[np.float32]
    goal_heading: NDArray[np.float32]
    goal_speed: NDArray[np.float32]
    route: NDArray[np.int32]
    route_line: NDArray[np.float32]
    route_length: NDArray[np.float32]
    route_speed_limit: NDArray[np.float32]
    goal_s: NDArray[np.float32]
    goal_d: NDArray[np.float32]
    leader_gap: NDArray[np.float32]
    leader_speed: NDArray[np.float32]
    stop_s: NDArray[np.float32]
    seed: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.seed)
