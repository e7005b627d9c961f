"""SUMO as the simulator: libsumo's own car-following drives the target, in a process of its own.

For drivers that SUMO can play (`SumoDriver`); the driver's `act` is not called. The target keeps to its path, which is the
network's only lane, so others count for it as SUMO sees them on that lane. Collisions are found by our own box test, as in
every simulator: SUMO's are gaps along lanes.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import Floats, interpolate, line_heading, unit
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.drivers.base import Driver, RuleDriver, SumoDriver
from drivegen.sumo.closed_loop import ClosedLoopRun, drive
from drivegen.world.contact import outcome
from drivegen.world.observation import PATH_SPACING
from drivegen.world.outcome import DrivingOutcome
from drivegen.world.paths import TargetPaths, target_paths
from drivegen.world.replay import Replay, replay

LEAD_IN = 200.0
"""The lane begins this far before the target [m], so that those behind it are on it too ..."""

LEAD_OUT = 1000.0
"""... and goes on this far beyond its path [m]: nobody arrives."""


class Plugin:
    """Closed loop in libsumo."""

    name = "sumo"

    def run(
        self,
        driver: Driver,
        scenarios: Sequence[Scenario],
        traffic: Sequence[Trajectories],
        paths: TargetPaths | None = None,
        attacker: NDArray[np.integer] | None = None,
    ) -> DrivingOutcome:
        """See `base.Simulator.run`; everybody is replayed, the attacker as well."""
        del attacker
        if not isinstance(driver, SumoDriver):
            raise UnusableInput(f"SUMO has no model of the driver {driver.name}: use the batch simulator")
        if isinstance(driver, RuleDriver) and driver.sees_rules:
            raise UnusableInput(f"on the target's lane SUMO sees no rules for the driver {driver.name}: use the batch simulator")
        paths = paths if paths is not None else target_paths(scenarios, traffic)
        others = replay(scenarios, traffic, paths, len(scenarios))
        runs = [_run(others, paths, s, driver.desired_speed) for s in range(len(scenarios))]
        motion = Trajectories.empty(len(scenarios), max(moves.steps for moves in traffic))
        for s, (front, speed) in enumerate(drive(runs, driver.vehicle_type())):
            _fill(motion[s], runs[s], front, speed, others, s)
        return outcome(motion, others, scenarios)


def _run(others: Replay, paths: TargetPaths, s: int, desired_speed: float) -> ClosedLoopRun:
    steps = int(others.steps[s])
    line, limit = _lane(paths, s, desired_speed)
    heading = others.heading[s, :steps].astype(np.float64)
    half = (0.5 * others.size[s, :, 0]).astype(np.float64)[:, None]
    return ClosedLoopRun(
        line=line,
        limit=limit,
        start=LEAD_IN + 0.5 * float(others.target_size[s, 0]),
        speed=float(others.target_speed[s]),
        target_size=others.target_size[s],
        front=others.position[s, :steps].astype(np.float64) + half * unit(heading),
        heading=heading,
        valid=others.valid[s, :steps],
        size=others.size[s],
    )


def _lane(paths: TargetPaths, s: int, desired_speed: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The path with straight lead-in and lead-out, and the speed limit after each of its points."""
    rows = slice(0, int(paths.length[s] / PATH_SPACING) + 1)
    line = paths.point[s, rows].astype(np.float64)
    first, last = unit(line_heading(line)[[0, -1]])
    limit = paths.speed_limit[s, rows].astype(np.float64)
    limit = np.where(np.isnan(limit), desired_speed, limit)
    whole = np.concatenate([line[:1] - LEAD_IN * first, line, line[-1:] + LEAD_OUT * last])
    return whole.astype(np.float64), np.concatenate([limit[:1], limit, limit[-1:]])


def _fill(motion: Trajectories, run: ClosedLoopRun, front: Floats, speed: Floats, others: Replay, s: int) -> None:
    """Write one target's centre positions; it is half a length behind its front on the same line."""
    steps = len(front)
    centre = front - 0.5 * float(run.target_size[0])
    motion.position[:steps] = interpolate(run.line, centre)
    ahead = interpolate(run.line, centre + 0.5 * PATH_SPACING) - interpolate(run.line, centre - 0.5 * PATH_SPACING)
    motion.heading[:steps] = np.arctan2(ahead[:, 1], ahead[:, 0])
    motion.position[0], motion.heading[0] = others.target_position[s], others.target_heading[s]
    motion.velocity[:steps] = speed[:, None] * unit(motion.heading[:steps].astype(np.float64))
    motion.valid[:steps] = True
