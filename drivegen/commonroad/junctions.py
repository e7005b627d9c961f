"""Which lanes are ways across a junction: as 2020a's intersections say, else where lanes cross."""

from collections.abc import Sequence
from typing import Protocol
from xml.etree.ElementTree import Element  # the type only: parsing is safe_xml's

import numpy as np
from numpy.typing import NDArray

from drivegen.commonroad.values import references
from drivegen.core.geometry import Polylines

TURNS = {"successorsRight": "right", "successorsStraight": "straight", "successorsLeft": "left"}
"""An intersection's groups of ways, and the word that a traffic light calls their direction by."""


class Typed(Protocol):
    """What a lanelet has: its types."""

    @property
    def types(self) -> frozenset[str]:
        """The lanelet's types."""


def ways(root: Element, place: str) -> dict[int, str]:
    """Turn of each lanelet that an intersection lists: "left", "straight" or "right", by the lanelet's id."""
    return {
        name: word
        for incoming in root.iterfind("intersection/incoming")
        for tag, word in TURNS.items()
        for name in references(incoming, tag, place)
    }


def named(root: Element, lanes: Sequence[Typed], index: dict[int, int], place: str) -> NDArray[np.bool_] | None:
    """(L,) lanes that the file puts into an intersection; None where it says nothing of intersections."""
    inside = np.array(["intersection" in one.types for one in lanes])
    listed = ways(root, place)
    for name in listed:
        if name in index:
            inside[index[name]] = True
    return inside if listed or inside.any() else None


def crossing(centreline: Polylines, links: NDArray[np.int32]) -> NDArray[np.bool_]:
    """(L,) lanes whose centreline crosses that of a lane that neither leads to it nor begins or ends with it, and the
    lanes that begin or end with one of those."""
    count = len(centreline)
    after, before = np.zeros((2, count, count), np.bool_)
    after[links[:, 0], links[:, 1]] = True
    before[links[:, 1], links[:, 0]] = True
    together = _share(after) | _share(before)
    lines = centreline.lines()
    low, high = np.array([line.min(0) for line in lines]), np.array([line.max(0) for line in lines])
    near = ((low[:, None] <= high) & (low <= high[:, None])).all(-1)
    pairs = np.argwhere(np.triu(near & ~after & ~before & ~together, 1))
    crosses = np.zeros(count, np.bool_)
    for i, j in pairs.tolist():
        if not (crosses[i] and crosses[j]) and _cross(lines[i], lines[j]):
            crosses[i] = crosses[j] = True
    beside = crosses | (together & crosses).any(-1)
    return np.asarray(beside)


def _share(linked: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(L, L) pairs of lanes that are linked to one and the same lane."""
    numbers = linked.astype(np.float32)
    return np.asarray(numbers @ numbers.T > 0)


def _cross(one: NDArray[np.float32], other: NDArray[np.float32]) -> bool:
    """Whether two polylines cross within a segment of both."""
    a, b = one[:-1, None].astype(np.float64), one[1:, None].astype(np.float64)
    c, d = other[None, :-1].astype(np.float64), other[None, 1:].astype(np.float64)
    return bool(((_side(a, b, c) * _side(a, b, d) < 0) & (_side(c, d, a) * _side(c, d, b) < 0)).any())


def _side(a: NDArray[np.float64], b: NDArray[np.float64], point: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray((b - a)[..., 0] * (point - a)[..., 1] - (b - a)[..., 1] * (point - a)[..., 0])
