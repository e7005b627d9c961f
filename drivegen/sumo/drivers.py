"""Varied drivers and vehicles for simulated traffic: sizes by documented classes, car following by EIDM.

Every vehicle has SUMO's class `passenger`, so that each route drawn for cars is open to it; size, acceleration and
speed are what make it a truck, a bus or a cyclist at the right edge of a car lane. Lane changes are sublane ones
(SL2015) wherever lateral resolution is on: drivers keep beside the lane's middle, each in a way of his own, wander, overtake and
cut in. They look up every 0.2 to 0.5 s. Spreads are tuned on US-101 and Argoverse 2 Sensor (LOG.md).
"""

from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from drivegen.core.scenario import VehicleKind

SHARES = {
    VehicleKind.CAR: 0.82,
    VehicleKind.TRUCK: 0.08,
    VehicleKind.BUS: 0.04,
    VehicleKind.MOTORCYCLE: 0.03,
    VehicleKind.CYCLIST: 0.03,
}
"""Shares of kinds in the traffic: an urban mix, assumed."""

CYCLED = 15.0
"""Cyclists take no road with a limit above this [m/s]."""


@dataclass(frozen=True)
class _Body:
    """Mean and spread of length, width, height [m]; acceleration and comfortable deceleration [m/s2]; top speed [m/s]."""

    size: tuple[float, float, float]
    spread: tuple[float, float, float]
    acceleration: float
    deceleration: float
    top_speed: float


_BODIES: dict[VehicleKind, tuple[_Body, ...]] = {
    VehicleKind.CAR: (
        _Body((4.0, 1.74, 1.50), (0.20, 0.04, 0.05), 2.0, 2.6, 55.0),  # small cars (EU segments A and B)
        _Body((4.55, 1.82, 1.47), (0.18, 0.04, 0.04), 2.0, 2.6, 60.0),  # compact and middle class (C and D)
        _Body((4.70, 1.90, 1.68), (0.18, 0.04, 0.06), 1.9, 2.5, 55.0),  # SUVs
        _Body((5.40, 1.98, 2.20), (0.35, 0.05, 0.25), 1.6, 2.3, 45.0),  # vans
    ),
    VehicleKind.TRUCK: (_Body((8.2, 2.45, 3.20), (1.10, 0.06, 0.30), 1.1, 2.0, 25.0),),  # rigid lorries
    VehicleKind.BUS: (_Body((12.0, 2.55, 3.10), (0.30, 0.01, 0.10), 1.1, 1.9, 24.0),),  # solo city buses
    VehicleKind.MOTORCYCLE: (_Body((2.2, 0.82, 1.50), (0.10, 0.04, 0.06), 2.6, 2.8, 55.0),),
    VehicleKind.CYCLIST: (_Body((1.75, 0.62, 1.75), (0.05, 0.03, 0.07), 1.1, 2.2, 5.5),),
}


_SHAPES = {
    VehicleKind.CAR: "passenger",
    VehicleKind.TRUCK: "truck",
    VehicleKind.BUS: "bus",
    VehicleKind.MOTORCYCLE: "motorcycle",
    VehicleKind.CYCLIST: "bicycle",
}
"""SUMO's name for a vehicle's looks: `traffic` reads the kind from it."""


@dataclass(frozen=True)
class VehicleType:
    """One kind of vehicle with its driver: `name` begins with the kind, size is length, width, height [m]."""

    name: str
    kind: VehicleKind
    size: tuple[float, float, float]


def draw_types(count: int, random: np.random.Generator, parent: Element) -> list[VehicleType]:
    """Draw `count` types, kinds by SHARES, and write each as a <vType> below `parent`."""
    kinds = random.choice(list(SHARES), size=count, p=list(SHARES.values()))
    return [
        _draw_type(f"{VehicleKind(kind).name.lower()}-{i}", VehicleKind(kind), random, parent) for i, kind in enumerate(kinds)
    ]


def _draw_type(name: str, kind: VehicleKind, random: np.random.Generator, parent: Element) -> VehicleType:
    bodies = _BODIES[kind]
    body = bodies[int(random.integers(len(bodies)))]
    length, width, height = np.round(random.normal(body.size, body.spread).clip(0.8 * np.array(body.size)), 2).tolist()
    calm = random.uniform()  # one number makes a driver calm or brisk in every respect
    SubElement(
        parent,
        "vType",
        id=name,
        vClass="passenger",
        guiShape=_SHAPES[kind],
        length=f"{length:.2f}",
        width=f"{width:.2f}",
        height=f"{height:.2f}",
        carFollowModel="EIDM",
        actionStepLength=f"{0.1 * int(random.integers(2, 6)):.1f}",
        accel=f"{body.acceleration * (0.95 - 0.35 * calm):.3f}",
        decel=f"{body.deceleration * (0.95 - 0.35 * calm):.3f}",
        emergencyDecel="8.0",
        tau=f"{0.7 + 0.8 * calm + random.uniform(-0.1, 0.1):.3f}",
        minGap=f"{1.5 + 1.2 * calm + random.uniform(-0.2, 0.2):.3f}",
        maxSpeed=f"{body.top_speed:.2f}",
        speedFactor=f"{1.12 - 0.24 * calm + random.normal(0.0, 0.04):.3f}",
        speedDev="0",
        lcAssertive=f"{2.0 - 1.0 * calm:.3f}",
        lcSpeedGain=f"{random.uniform(2.0, 8.0) * (1.3 - 0.6 * calm):.3f}",
        lcKeepRight=f"{random.uniform(0.0, 0.5):.3f}",
        lcCooperative=f"{random.uniform(0.5, 1.0):.3f}",
        lcPushy=f"{0.4 * (1 - calm):.3f}",
        lcSigma="0.15",
        latAlignment="right" if kind == VehicleKind.CYCLIST else f"{random.normal(0.0, 0.55):.3f}",
        minGapLat="0.4",
        maxSpeedLat=f"{random.uniform(0.7, 1.2):.3f}",
    )
    return VehicleType(name, kind, (length, width, height))
