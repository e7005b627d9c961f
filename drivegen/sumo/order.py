"""Which way across a junction goes before which, as the `response` of a SUMO junction's <request> rows says.

https://sumo.dlr.de/docs/Networks/SUMO_Road_Networks.html#requests: the rows number the ways across, by the lanes of `incLanes`
that they come from and then as the file lists them. Those on foot are the last ones, or have no number (onto a walking area);
`response` has a digit for each, the first one last.
"""

from collections import defaultdict
from collections.abc import Iterator
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from drivegen.sumo.net_lanes import NetLanes, whole_number


def yields_to(root: Element, lanes: NetLanes, waits: NDArray[np.bool_], place: str) -> NDArray[np.int32]:
    """Rows (Q, 2) of `RoadMap.yields_to`, for the lanes (L,) that wait by a sign.

    Where SUMO cuts a way in two both halves have its order: that which the other way meets is asked. All-way stops have no order,
    nor have two ways that wait for each other, as where lanes merge like a zipper.
    """
    ways: dict[str, list[str]] = defaultdict(list)
    for element in root.iterfind("connection"):
        if via := element.get("via"):
            ways[f"{element.get('from')}_{element.get('fromLane')}"].append(via)
    rows: set[tuple[int, int]] = set()
    for junction in root.iterfind("junction"):
        if junction.get("type") == "allway_stop":
            continue
        parts = [_parts(via, ways, lanes) for lane in junction.get("incLanes", "").split() for via in ways.get(lane, ())]
        order = {pair for pair in _responses(junction, place) if max(pair) < len(parts)}
        for own, other in order - {pair[::-1] for pair in order}:
            rows |= {(a, b) for a in parts[own] if waits[a] for b in parts[other]}
    return np.array(sorted(rows), np.int32).reshape(-1, 2)


def _parts(via: str, ways: dict[str, list[str]], lanes: NetLanes) -> list[int]:
    """The internal lanes of the way that begins with lane `via`, as far as we have them."""
    parts: list[int] = []
    while via in lanes.number and lanes.number[via] not in parts:
        parts.append(lanes.number[via])
        via = ways.get(via, [""])[0]
    return parts


def _responses(junction: Element, place: str) -> Iterator[tuple[int, int]]:
    """Pairs of connections of which the first waits for the second."""
    for request in junction.iterfind("request"):
        own = whole_number(request, "index", place)
        for other, digit in enumerate(reversed(request.get("response", ""))):
            if digit == "1":
                yield own, other
