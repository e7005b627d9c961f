"""Who is parked at the first frame, when nothing but that frame is known."""

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import Vehicles
from drivegen.roads.graph import LaneGraph

STANDING = 0.5
"""Slower than this [m/s] a vehicle stands: trackers let parked ones creep (up to 0.2 m/s in Argoverse 2)."""

BESIDE = 2.0
"""Farther than this from the middle of every lane [m], a vehicle is beside them: more than half of any usual lane's width."""


def parked(graph: LaneGraph, vehicles: Vehicles) -> NDArray[np.bool_]:
    """(N,) whether each vehicle stands beside all lanes for motor vehicles, whichever way they lead, or where there are none."""
    return np.asarray((vehicles.speed < STANDING) & (graph.distance_to_lanes(vehicles.position) > BESIDE))
