"""Roundabouts: a one-way ring with a node for every road that meets it, declared as a roundabout."""

import numpy as np

from drivegen.layouts.compilers import _lines as lines
from drivegen.layouts.compilers.crossings import MAIN, add_arm
from drivegen.layouts.crossings import NO_TURN_LANES, RING_LANE, Roundabout
from drivegen.sumo.plain import Edge, Node, PlainNetwork, Point
from drivegen.sumo.plain import Roundabout as Ring

_STEP = np.radians(6.0)


def compile_roundabout(spec: Roundabout, plain: PlainNetwork) -> None:
    """Draw the roundabout around (0, 0)."""
    angles = [arm.angle for arm in spec.arms]
    places = add_ring(plain, "r", (0.0, 0.0), angles, spec.ring_lanes, spec.diameter, spec.ring_speed)
    for i, arm in enumerate(spec.arms):
        node, at = places[i]
        add_arm(plain, f"a{i}", arm, node, at, NO_TURN_LANES)


def add_ring(
    plain: PlainNetwork, name: str, centre: Point, angles: list[float], lanes: int, diameter: float, speed: float
) -> list[tuple[str, Point]]:
    """Draw a ring of outer `diameter` with a node at each of `angles` [degrees]; returns (node, its place) in that order."""
    radius = (diameter - lanes * RING_LANE) / 2
    order = sorted(range(len(angles)), key=lambda i: angles[i] % 360)
    places = []
    for i, angle in enumerate(angles):
        at = _on_circle(centre, radius, np.radians([angle % 360]))[0]
        places.append((f"{name}{i}", (float(at[0]), float(at[1]))))
        plain.nodes.append(Node(f"{name}{i}", *places[-1][1]))
    edges = []
    for i, j in zip(order, [*order[1:], order[0]], strict=True):
        start = np.radians(angles[i] % 360)
        sweep = (np.radians(angles[j] % 360) - start) % (2 * np.pi)
        around = start + np.linspace(0.0, sweep, max(3, int(np.ceil(sweep / _STEP)) + 1))
        shape = lines.points(_on_circle(centre, radius, around))
        edges.append(f"{name}{i}_{name}{j}")
        target = f"{name}{j}"
        edge = Edge(edges[-1], f"{name}{i}", target, lanes, speed, MAIN + 1, shape, spread="center", width=RING_LANE)
        plain.edges.append(edge)
    plain.roundabouts.append(Ring(tuple(f"{name}{i}" for i in order), tuple(edges)))
    return places


def _on_circle(centre: Point, radius: float, angle: lines.Line) -> lines.Line:
    return np.asarray(centre) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
