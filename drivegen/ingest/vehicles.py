"""Which vehicles of a recording a scenario has, and how large their boxes are: decided by the first frame alone."""

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import boxes_overlap
from drivegen.core.recorded_log import RecordedLog
from drivegen.core.scenario import SizeSource, VehicleKind

PLANNED_KINDS = (VehicleKind.CAR, VehicleKind.TRUCK, VehicleKind.BUS)
"""Kinds that are planned; all others are context."""

ASSUMED_SIZE = {
    VehicleKind.CAR: (4.63, 1.97, 1.74),
    VehicleKind.TRUCK: (6.93, 2.51, 2.84),
    VehicleKind.BUS: (10.5, 2.94, 3.47),
    VehicleKind.MOTORCYCLE: (2.11, 0.77, 1.47),
    VehicleKind.CYCLIST: (1.70, 0.60, 1.28),
    VehicleKind.PEDESTRIAN: (0.73, 0.67, 1.77),
}
"""Length, width, height [m] where a data set has no boxes (Argoverse 2 Motion Forecasting): mean boxes of nuScenes'
classes, as the anchors of Zhu et al., "Class-balanced grouping and sampling", 2019, and OpenPCDet have them. The medians
of the regular vehicles in two Argoverse 2 Sensor logs are 4.35 x 1.96 x 1.62 and 4.16 x 1.82 x 1.70: somewhat smaller."""

PARKED_SPEED = 0.5
"""A vehicle that is no faster at the first frame [m/s] stands."""


def boxes_of(log: RecordedLog) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """Boxes (M, 3) without gaps, and where they come from (M,): flat recordings measure length and width, which is enough."""
    assumed = np.array([ASSUMED_SIZE[VehicleKind(int(kind))] for kind in log.kind], np.float32).reshape(-1, 3)
    unknown = np.any(np.isnan(log.size[:, :2]), axis=-1)
    source = np.where(unknown, SizeSource.ASSUMED, SizeSource.MEASURED).astype(np.uint8)
    return np.where(unknown[:, None] | np.isnan(log.size), assumed, log.size), source


def choose(
    log: RecordedLog,
    target: int,
    size: NDArray[np.float32],
    source: NDArray[np.uint8],
    most: int,
    smallest_shrink: float,
    notes: dict[str, str],
) -> NDArray[np.intp]:
    """The target, then the nearest vehicles at step 0 that can stand beside those already chosen.

    Overlaps that the recording's first frame already has are resolved in this order: the assumed boxes of standing
    vehicles shrink together, as little as needed, to `smallest_shrink` at most; else the farther vehicle is dropped. At `most`
    so many are chosen. `size`, `source` and `notes` are updated.
    """
    position, present = log.motion.position[:, 0], log.motion.valid[:, 0]
    candidate = present & np.isin(log.kind, PLANNED_KINDS)
    candidate[target] = False
    far = np.hypot(*(position - position[target]).T)
    order = np.flatnonzero(candidate)
    order = order[np.argsort(far[order], kind="stable")]
    parked = (source == SizeSource.ASSUMED) & (log.motion.speed[:, 0] < PARKED_SPEED)
    chosen, full_size, counts = [target], size.copy(), {"overlaps": 0, "shrunk": 0, "dropped_overlapping": 0}
    for vehicle in order.tolist():
        if len(chosen) == most:
            break
        touched = _touched(log, vehicle, np.array(chosen), size)
        counts["overlaps"] += len(touched)
        if len(touched):
            group = np.append(touched, vehicle)
            factor = _shrink(log, vehicle, touched, full_size, smallest_shrink) if parked[group].all() else None
            if factor is None:
                counts["dropped_overlapping"] += 1
                continue
            size[group, :2] = np.minimum(size[group, :2], factor * full_size[group, :2])
            source[group] = SizeSource.SHRUNK
            counts["shrunk"] += len(group)
        chosen.append(vehicle)
    notes.update({name: str(count) for name, count in counts.items() if count})
    return np.array(chosen)


def _touched(log: RecordedLog, vehicle: int, others: NDArray[np.intp], size: NDArray[np.float32]) -> NDArray[np.intp]:
    """Those of `others` whose box overlaps the vehicle's at step 0."""
    position, heading = log.motion.position[:, 0], log.motion.heading[:, 0]
    overlap = boxes_overlap(
        position[vehicle], heading[vehicle], size[vehicle, :2], position[others], heading[others], size[others, :2]
    )
    return others[overlap]


def _shrink(
    log: RecordedLog, vehicle: int, touched: NDArray[np.intp], size: NDArray[np.float32], smallest: float
) -> float | None:
    """The largest factor, in steps of 0.02, by which all these boxes clear one another; None if none is large enough."""
    for factor in np.arange(0.98, smallest - 1e-9, -0.02):
        if not len(_touched(log, vehicle, touched, size * np.float32(factor))):
            return float(factor)
    return None
