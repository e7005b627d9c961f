"""The protocol of a simulator: let a driver steer the target of many scenarios through traffic.

The target follows its path (`world/paths.py`) with the driver's speed. A run ends for the target at its first collision, or where
it leaves the map.
"""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import Scenario, Trajectories
from drivegen.drivers.base import Driver
from drivegen.world.outcome import DrivingOutcome
from drivegen.world.paths import TargetPaths


class Simulator(Protocol):
    """A way to run a driver in closed loop.

    Attributes:
        name: the plugin's name, as it stands in tables.
    """

    name: str

    def run(
        self,
        driver: Driver,
        scenarios: Sequence[Scenario],
        traffic: Sequence[Trajectories],
        paths: TargetPaths | None = None,
        attacker: NDArray[np.integer] | None = None,
    ) -> DrivingOutcome:
        """Drive the target of every scenario through `traffic`.

        Args:
            driver: who steers.
            scenarios: S scenarios; map, vehicles and context are used, the log is not.
            traffic: S motions (N, T), logged or generated. The target's own row gives its path and first state only.
            paths: S paths to follow instead of those of the traffic.
            attacker: (S,) the vehicle that does not react where others do, 0 for none; all where it is not given.

        Raises UnusableInput for a target that is not there at step 0 or a driver that this simulator can't run.
        """
