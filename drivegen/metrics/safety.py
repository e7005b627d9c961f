"""How often generated traffic collides, leaves the road or breaks a rule, from the checker's verdicts.

Rates are over all K samples and all N vehicles that the sample was to hold: a vehicle that was left out counts as
illegal, so that dropping it never improves a rate.

`box_rates` are taken without the checker and its tolerances, with boxes of several sizes: where sizes are assumed, as in
Argoverse 2's forecasting logs, a collision rate is only as good as they are.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.samples import Samples, Violation
from drivegen.metrics.surroundings import Boxes, centres_meet, overlapping_at_first, touching

COLLISIONS = Violation.COLLISION | Violation.COLLISION_WITH_CONTEXT


@dataclass(frozen=True)
class SafetyRates:
    """Shares in [0, 1] over the samples of one scene.

    Attributes:
        collision_per_vehicle: of (sample, vehicle) that touch another vehicle or a context actor.
        collision_per_scene: of samples with at least one such vehicle.
        off_road_per_vehicle, off_road_per_scene: the same for leaving the drivable area.
        illegal_per_vehicle, illegal_per_scene: the same for any violation, or left out.
        dropped_per_vehicle: of (sample, vehicle) that were left out.
        left_map_per_vehicle: of (sample, vehicle) that drove out by an exit of the map before the end: nothing illegal.
    """

    collision_per_vehicle: float
    collision_per_scene: float
    off_road_per_vehicle: float
    off_road_per_scene: float
    illegal_per_vehicle: float
    illegal_per_scene: float
    dropped_per_vehicle: float
    left_map_per_vehicle: float


def safety_rates(samples: Samples) -> SafetyRates:
    """Rates of one scene, from `violation` (K, N) and `dropped` (K, N)."""
    collides, leaves, illegal = _flags(samples)
    return SafetyRates(
        float(collides.mean()),
        float(collides.any(axis=1).mean()),
        float(leaves.mean()),
        float(leaves.any(axis=1).mean()),
        float(illegal.mean()),
        float(illegal.any(axis=1).mean()),
        float(samples.dropped.mean()),
        float(samples.left_map.mean()),
    )


def sample_rates(samples: Samples) -> dict[str, NDArray[np.float64]]:
    """The shares of vehicles of `safety_rates` for each sample, (K,) by name."""
    names = ("collision_per_vehicle", "off_road_per_vehicle", "illegal_per_vehicle")
    return {name: flag.mean(axis=1) for name, flag in zip(names, _flags(samples), strict=True)}


def _flags(samples: Samples) -> tuple[NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_]]:
    """(K, N) who touches another one, who leaves the road, who is illegal or left out."""
    collides = (samples.violation & int(COLLISIONS)) > 0
    leaves = (samples.violation & int(Violation.OFF_ROAD)) > 0
    return collides, leaves, ~samples.legal | samples.dropped


def violation_shares(samples: Samples) -> dict[str, float]:
    """Share of (sample, vehicle) per kind of violation, by its lower-case name."""
    kinds = (kind for kind in Violation if kind is not Violation.NONE)
    return {str(kind.name).lower(): float(np.mean((samples.violation & int(kind)) > 0)) for kind in kinds}


def box_rates(boxes: Boxes, vehicles: int, scales: Sequence[float]) -> dict[str, float]:
    """Shares of (sample, vehicle) in which boxes touch; `boxes` are K samples and, last, the log.

    `boxes_90_collision` scales all boxes by 0.9, and so on; pairs that overlap at their first common step count only once they
    have come apart. `boxes_overlap_initial` is the share of vehicles that are given overlapping (at full size),
    `boxes_centres_meet` av2's measure: centres nearer than a metre.
    """
    rates: dict[str, float] = {}
    hits = touching(boxes, vehicles, np.array(scales))[:, :-1]
    for scale, hit in zip(scales, hits, strict=True):
        rates[f"boxes_{round(100 * scale)}_collision"] = float(hit.mean())
    rates["boxes_overlap_initial"] = float(overlapping_at_first(boxes, vehicles).mean())
    rates["boxes_centres_meet"] = float(centres_meet(boxes, vehicles)[:-1].mean())
    return rates
