"""The numbers that the legal checker judges by, and the rules that they belong to.

Every rule measures one *severity* per trajectory (the worst moment of it) and is broken where that exceeds its limit,
so a limit can be read off logs as a quantile (`calibration.py`).
"""

from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.samples import Violation
from drivegen.core.settings import NotNegative, build


@dataclass(frozen=True)
class Limits:
    """Limits of the legal checker, one per rule.

    Attributes:
        overlap: depth by which boxes of two vehicles may overlap, because measured boxes do [m].
        overlap_context: the same for a vehicle and a pedestrian, cyclist or motorcyclist [m].
        off_road: distance by which a corner may stay outside the drivable area for three looks in a row (`road.STRIDE`) [m].
        wrong_way: time for which a vehicle may face or move against every lane under it, outside junctions [s].
        oncoming_lanes: time for which a front corner may be on lanes that all lead against the vehicle (`road.OVER_THE_LINE`),
            outside junctions, once it has not been there [s].
        speed: absolute speed [m/s].
        over_limit: speed above the lane's limit, where it has one [m/s].
        acceleration, braking: along the direction of travel, both positive [m/s2].
        lateral_acceleration: across it, either side [m/s2].
        velocity_error: difference between the stated velocity and that of the positions [m/s].
        jump: distance between where one step leads and where the stated velocity leads in it [m].
        velocity_step: how much the stated velocity changes from one step to the next, in any direction [m/s].
        curvature: of the path, while faster than `dynamics.STEERING_SPEED` [1/m].
        side_slip: speed across the vehicle's own heading, or against it [m/s].
        spin: how much faster the heading turns, from one step to the next, than a car that steers as sharply as it can on the way
            of this step (`dynamics.TIGHTEST`) [rad/s].
        red_grace: how long a signal may have been red when a vehicle enters [s].
        stop_speed: lowest speed on the last metres before a stop line [m/s].
        yield_gap: time that must pass between leaving a conflict point and a vehicle with priority reaching it [s]; below zero
            where logs overlap there.
    """

    overlap: NotNegative
    overlap_context: NotNegative
    off_road: NotNegative
    wrong_way: NotNegative
    oncoming_lanes: NotNegative
    speed: NotNegative
    over_limit: NotNegative
    acceleration: NotNegative
    braking: NotNegative
    lateral_acceleration: NotNegative
    velocity_error: NotNegative
    jump: NotNegative
    velocity_step: NotNegative
    curvature: NotNegative
    side_slip: NotNegative
    spin: NotNegative
    red_grace: NotNegative
    stop_speed: NotNegative
    yield_gap: float

    def severities(self) -> NDArray[np.float64]:
        """(R,) the largest severity that is allowed, in the order of RULES; the yield gap negated: less is worse."""
        values = np.array([*(getattr(self, name) for name in LIMITED), ALL_FINITE], np.float64)
        values[YIELD_GAP] = -values[YIELD_GAP]
        return values

    @classmethod
    def from_severities(cls, values: NDArray[np.floating]) -> "Limits":
        """The inverse of `severities`."""
        signed = [float(v) for v in values[: len(LIMITED)]]
        signed[YIELD_GAP] = -signed[YIELD_GAP]
        return cls(**dict(zip(LIMITED, signed, strict=True)))

    def to_json(self) -> dict[str, float]:
        """A plain mapping, for `store.files.write_json`."""
        return asdict(self)

    @classmethod
    def from_json(cls, values: Any, place: str) -> "Limits":
        """Limits from a parsed JSON file; raises UnusableInput naming `place` and the key at fault."""
        if not isinstance(values, dict) or set(values) != set(LIMITED):
            raise UnusableInput(f"{place} does not hold the limits {', '.join(LIMITED)}: run the calibrate stage again")
        return build(cls, values, place)


LIMITED = tuple(f.name for f in fields(Limits))
"""The rules that have a limit."""

RULES = (*LIMITED, "not_finite")
"""Names of the rules; their order is that of every (.., R) array of severities. The last one says that a number of the
trajectory is not finite: 1 where one is not, and no log can move its limit."""

ALL_FINITE = 0.0
"""The limit of the last rule."""

(
    OVERLAP,
    OVERLAP_CONTEXT,
    OFF_ROAD,
    WRONG_WAY,
    ONCOMING_LANES,
    SPEED,
    OVER_LIMIT,
    ACCELERATION,
    BRAKING,
    LATERAL_ACCELERATION,
    VELOCITY_ERROR,
    JUMP,
    VELOCITY_STEP,
    CURVATURE,
    SIDE_SLIP,
    SPIN,
    RED_GRACE,
    STOP_SPEED,
    YIELD_GAP,
    NOT_FINITE,
) = range(len(RULES))

FLAGS = (
    Violation.COLLISION,
    Violation.COLLISION_WITH_CONTEXT,
    Violation.OFF_ROAD,
    Violation.WRONG_WAY,
    Violation.WRONG_WAY,
    Violation.SPEED,
    Violation.SPEED,
    Violation.ACCELERATION,
    Violation.ACCELERATION,
    Violation.ACCELERATION,
    Violation.ACCELERATION,
    Violation.ACCELERATION,
    Violation.ACCELERATION,
    Violation.CURVATURE,
    Violation.CURVATURE,
    Violation.CURVATURE,
    Violation.RED_LIGHT,
    Violation.STOP_OR_YIELD,
    Violation.STOP_OR_YIELD,
    Violation.NOT_FINITE,
)
"""(R,) the flag that each rule sets."""

NEVER = -float("inf")
"""Severity where a rule had nothing to judge."""
