"""How much maps differ: windows of one size out of made and real road maps, described by the same few numbers.

Every map is seen as a `RoadMap`, so that SUMO's, Argoverse 2's and our own are measured by one ruler.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from drivegen.core.crop import Cropper
from drivegen.core.geometry import arc_length, line_heading, resample
from drivegen.core.roadmap import NO_LANE, RoadMap

FEATURES = ("lanes", "arms", "curvature", "length", "connectivity")
"""Most lanes side by side in one direction; roads that meet at the largest junction, 0 without; degrees turned per 100 m
outside junctions; kilometres of lane outside junctions; ways on per lane that goes on."""

_SPACING = 4.0
_TOUCH = 5.0
"""Ways across that come this close belong to one junction [m]."""

_SAME_ROAD = 25.0
"""Lanes that leave a junction within this angle are one road [degrees]."""


def windows(road_map: RoadMap, count: int, radius: float, rng: np.random.Generator) -> list[dict[str, float]]:
    """`FEATURES` of `count` windows of `radius` [m] around places drawn on vehicle lanes, every metre of lane alike."""
    lanes = np.flatnonzero(road_map.for_vehicles & ~road_map.in_junction).tolist()
    if not lanes:
        return []
    points = np.concatenate([resample(road_map.centreline[i], _SPACING) for i in lanes])
    cropper = Cropper(road_map)
    rows = []
    for i in rng.integers(len(points), size=count).tolist():
        inside = int((np.hypot(*(points - points[i]).T) <= radius).sum())
        rows.append({**described(cropper.around(points[i : i + 1], radius)[0]), "length": inside * _SPACING / 1000})
    return rows


def described(window: RoadMap) -> dict[str, float]:
    """`FEATURES` of a map as a whole."""
    roads = np.flatnonzero(window.for_vehicles & ~window.in_junction).tolist()
    lengths = np.array([arc_length(window.centreline[i])[-1] for i in roads])
    turned = np.array([_turned(window.centreline[i]) for i in roads])
    goes_on = np.unique(window.links[:, 0])
    return {
        "lanes": float(max((_abreast(window, i) for i in roads), default=0)),
        "arms": float(max(junction_arms(window), default=0)),
        "curvature": float(turned.sum() / max(lengths.sum(), 1.0) * 100),
        "length": float(lengths.sum() / 1000),
        "connectivity": len(window.links) / max(1, len(goes_on)),
    }


def summary(windows: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Mean, standard deviation and the middle 80 % of every feature over the windows of one source."""
    means: dict[str, float] = {"windows": len(windows)}
    for name in FEATURES:
        values = np.array([one[name] for one in windows])
        low, high = np.percentile(values, (10, 90))
        means |= {name: float(values.mean()), f"{name}.low": float(low), f"{name}.high": float(high)}
        means[f"{name} spread"] = float(values.std())
    return {name: round(value, 4) for name, value in means.items()}


def junction_arms(window: RoadMap) -> list[int]:
    """Roads that meet at each junction of three or more."""
    ways = np.flatnonzero(window.in_junction & window.for_vehicles)
    arms = []
    for cluster in _clusters([resample(window.centreline[i], _SPACING) for i in ways.tolist()]):
        inside = ways[cluster]
        before = window.links[np.isin(window.links[:, 1], inside), 0]
        after = window.links[np.isin(window.links[:, 0], inside), 1]
        out = [line_heading(window.centreline[i])[0] for i in set(after.tolist()) if not window.in_junction[i]]
        into = [line_heading(window.centreline[i])[-1] + math.pi for i in set(before.tolist()) if not window.in_junction[i]]
        arms.append(_roads(np.degrees(np.array([*out, *into]))))
    return sorted((count for count in arms if count >= 3), reverse=True)


def _abreast(window: RoadMap, lane: int) -> int:
    """Lanes side by side that run the same way as `lane`, itself included."""
    seen = {int(lane)}
    for side in (0, 1):
        here = int(lane)
        while window.same_direction[here, side] and (there := int(window.neighbour[here, side])) not in {NO_LANE, *seen}:
            if window.kind[there] == window.kind[lane]:
                seen.add(there)
            else:
                break
            here = there
    return len(seen)


def _turned(line: NDArray[np.float32]) -> float:
    """Degrees that a line turns, left and right added; steps of a few metres, so that noise does not count."""
    heading = line_heading(resample(line, 2 * _SPACING))[:-1]
    return float(np.degrees(np.abs((np.diff(heading) + np.pi) % (2 * np.pi) - np.pi).sum()))


def _clusters(lines: list[NDArray[np.float32]]) -> list[NDArray[np.intp]]:
    """Indices of lines that touch one another, directly or through others."""
    if not lines:
        return []
    owner = np.repeat(np.arange(len(lines)), [len(line) for line in lines])
    points = np.concatenate(lines).astype(np.float64)
    group = np.arange(len(lines))
    for i, line in enumerate(lines):
        near = np.hypot(*(points[:, None] - line[None].astype(np.float64)).T).min(axis=0) < _TOUCH
        joined = np.isin(group, group[owner[near]])
        group[joined] = group[i]
    return [np.flatnonzero(group == g) for g in np.unique(group)]


def _roads(angles: NDArray[np.float64]) -> int:
    """How many roads leave in these directions [degrees]."""
    if not len(angles):
        return 0
    around = np.sort(angles % 360)
    gaps = np.diff(around, append=around[:1] + 360)
    return max(1, int((gaps >= _SAME_ROAD).sum()))
