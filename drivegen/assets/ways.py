"""How far lanes lie apart for somebody who drives from one to another."""

import heapq
from collections import defaultdict
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from drivegen.geometry import Floats, arc_length
from drivegen.roadmap import RoadMap

REACH = 120.0
"""How far ahead vehicles matter to each other [m]."""


class Ways:
    """Driving distances on one map, without lane changes.

    Attributes:
        length: (L,) [m] of each lane. onward, back: the lanes that follow and precede each lane.
    """

    def __init__(self, road_map: RoadMap) -> None:
        self.length = np.array([arc_length(road_map.centreline[i].astype(np.float64))[-1] for i in range(len(road_map))])
        self.onward: dict[int, list[int]] = defaultdict(list)
        self.back: dict[int, list[int]] = defaultdict(list)
        for before, after in road_map.links.tolist():
            self.onward[before].append(after)
            self.back[after].append(before)
        self._after: dict[int, Floats] = {}
        self._before: dict[int, Floats] = {}

    def ahead(self, lane: int, along: float, lanes: NDArray[np.int32], alongs: NDArray[np.floating]) -> NDArray[np.float64]:
        """Driving distance (K,) [m] from one place to others ahead of it; inf where there is none within REACH or so."""
        if lane not in self._after:
            self._after[lane] = self._search(self.onward, lane)
        far = self._after[lane][lanes] + (self.length[lane] - along) + alongs
        return np.where((lanes == lane) & (alongs >= along), alongs - along, far)

    def behind(self, lane: int, along: float, lanes: NDArray[np.int32], alongs: NDArray[np.floating]) -> NDArray[np.float64]:
        """Driving distance (K,) [m] from other places to this one ahead of them; inf where there is none within REACH or so."""
        if lane not in self._before:
            self._before[lane] = self._search(self.back, lane)
        far = self._before[lane][lanes] + (self.length[lanes] - alongs) + along
        return np.where((lanes == lane) & (alongs <= along), along - alongs, far)

    def _search(self, following: Mapping[int, list[int]], lane: int) -> Floats:
        """(L,) [m] of the lanes between `lane` and every other one, both left out, within REACH; inf beyond."""
        found = np.full(len(self.length), np.inf)
        heap = [(0.0, after) for after in following.get(lane, [])]
        while heap:
            so_far, here = heapq.heappop(heap)
            if np.isfinite(found[here]) or so_far > REACH:
                continue
            found[here] = so_far
            for after in following.get(here, []):
                heapq.heappush(heap, (so_far + float(self.length[here]), after))
        return found
