"""Argoverse 2 vector maps (`log_map_archive_*.json`) to and from `RoadMap`.

Official keys are those of av2's `map/{lane_segment,drivable_area,pedestrian_crossing}.py`. Sensor maps have no
centrelines: the midline of the boundaries stands in, as in av2. Keys of our own, ignored by av2 and read back here:
`origin`, `dangling_links`, `stop_lines`, and per lane `speed_limit` [m/s], `control`, `cut` and `yields_to`. Official maps are
cut-outs of a city: every end without a link is taken for cut.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import chain
from operator import itemgetter
from typing import Any

import numpy as np
import orjson
from numpy.typing import NDArray

from drivegen.av2.schema import CROSSABLE_MARKS
from drivegen.core import safe_json
from drivegen.core.errors import UnusableInput, naming
from drivegen.core.geometry import Floats, Polylines, arc_length, interpolate
from drivegen.core.recorded_log import FARTHEST
from drivegen.core.roadmap import NO_LANE, LaneControl, LaneKind, RoadMap, open_ends

MIDLINE_SPACING = 2.0
"""Distance between points of a midline [m], about that of the official centrelines."""

HIGHEST_LIMIT = 1000.0
"""No limit is higher [m/s]."""

DECIMALS = 4
"""Decimals of written coordinates [0.1 mm]: finer than float32 a few hundred metres from the origin."""

_xy = itemgetter("x", "y")
_KINDS = {kind.name: kind.value for kind in LaneKind}
_UNSOUND = (KeyError, TypeError, ValueError, AttributeError, IndexError, OverflowError)
_CONTROLS = {control.name: control.value for control in LaneControl}


def read_map(raw: bytes, place: str) -> RoadMap:
    """The map in a local frame at its own centre, rounded to whole metres (or at its `origin`, if it has that key).

    Args:
        raw: the JSON file's bytes.
        place: the file's name for error sentences.

    Raises UnusableInput, reason `bad-map` or `no-lanes`, or `too-large`, naming `place` and what is wrong.
    """
    tree = safe_json.parse(raw, place, "bad-map")
    if not isinstance(tree, dict) or not isinstance(tree.get("lane_segments"), dict):
        raise UnusableInput(f"{place} is no Argoverse 2 map: it has no `lane_segments`", reason="bad-map")
    if not tree["lane_segments"]:
        raise UnusableInput(f"{place}: the map has no lanes", reason="no-lanes")
    try:
        road_map = _build(tree)
    except _UNSOUND as error:
        what = f"key {error} is missing or unknown" if isinstance(error, KeyError) else str(error)
        raise UnusableInput(f"{place} is no sound Argoverse 2 map{_at_fault(tree)}: {what}", reason="bad-map") from None
    with naming(place):
        road_map.validate()
    return road_map


def _at_fault(tree: Mapping[str, Any]) -> str:
    """In words, the first lane that is unsound by itself; whom it yields to is no question of one lane."""
    for name, lane in tree["lane_segments"].items():
        try:
            _build({"lane_segments": {name: {**lane, "yields_to": ()} if isinstance(lane, dict) else lane}})
        except _UNSOUND:
            return f", see lane {name}"
    return ""


def _build(tree: Mapping[str, Any]) -> RoadMap:
    lanes = list(tree["lane_segments"].values())
    lane_id = [lane["id"] for lane in lanes]
    index = {number: i for i, number in enumerate(lane_id)}
    left, right = _lines(map(itemgetter("left_lane_boundary"), lanes)), _lines(map(itemgetter("right_lane_boundary"), lanes))
    centre = _centrelines(lanes, left, right)
    origin = np.array(tree["origin"], np.float64) if "origin" in tree else _middle(centre[0])
    if origin.shape != (2,) or not np.isfinite(origin).all():
        raise ValueError("its origin is not a finite point")
    kind = np.array([_KINDS[lane["lane_type"]] for lane in lanes], np.uint8)
    links, dangling = _links(lanes, index)
    dangling += (unseen := int(tree.get("dangling_links", 0)))
    if not 0 <= unseen <= dangling < 2**31:
        raise ValueError(f"it cannot have {unseen} `dangling_links`")
    neighbour, same_direction, may_change = _neighbours(lanes, index, centre, kind)
    stops = list(tree.get("stop_lines", {}).values())
    ends = _lines(map(itemgetter("line"), stops))[0].reshape(-1, 2, 2)
    return RoadMap(
        origin=origin,
        lane_id=np.array(lane_id, np.int64),
        kind=kind,
        centreline=_local(centre, origin).distinct(),
        left=_local(left, origin).distinct(),
        right=_local(right, origin).distinct(),
        speed_limit=_limits(lanes),
        in_junction=np.array([lane["is_intersection"] for lane in lanes], np.bool_),
        control=np.array([_CONTROLS[lane.get("control", "UNKNOWN")] for lane in lanes], np.uint8),
        links=links,
        yields_to=_yields_to(lanes, index),
        neighbour=neighbour,
        same_direction=same_direction,
        may_change=may_change,
        cut=_cut(lanes, links),
        drivable=_local(_outlines(tree.get("drivable_areas", {}).values()), origin),
        crossings=_local(_crossings(tree.get("pedestrian_crossings", {}).values()), origin),
        stop_lines=(ends - origin).astype(np.float32),
        stop_lane=np.array([index[stop["lane"]] for stop in stops], np.int32),
        dangling=dangling,
    )


Lines = tuple[NDArray[np.float64], NDArray[np.int32]]
"""Points (P, 2) in city coordinates and start rows (L + 1,), as in `Polylines` but in full precision."""


def _lines(lines: Iterable[Sequence[Mapping[str, float]]]) -> Lines:
    """All points of many lines of `{"x", "y", "z"}`, height left out; one pass, no array per line."""
    lines = list(lines)
    start = np.zeros(len(lines) + 1, np.int32)
    np.cumsum([len(line) for line in lines], out=start[1:])
    values = chain.from_iterable(map(_xy, chain.from_iterable(lines)))
    return np.fromiter(values, np.float64, 2 * int(start[-1])).reshape(-1, 2), start


def _local(lines: Lines, origin: NDArray[np.float64]) -> Polylines:
    points = lines[0] - origin
    if np.abs(points).max(initial=0) > FARTHEST:
        raise ValueError(f"it has points more than {FARTHEST / 1000:g} km from its middle")
    return Polylines(points.astype(np.float32), lines[1])


def _middle(points: NDArray[np.float64]) -> NDArray[np.float64]:
    if not len(points):
        raise ValueError("its lanes have no points")
    middle: NDArray[np.float64] = np.round((points.min(0) + points.max(0)) / 2)
    return middle


def _centrelines(lanes: Sequence[Mapping[str, Any]], left: Lines, right: Lines) -> Lines:
    centrelines = [lane.get("centerline") or () for lane in lanes]
    lines = _lines(centrelines)
    if all(len(line) >= 2 for line in centrelines):
        return lines
    lines_of_lanes = [
        _line(lines, i) if len(centrelines[i]) >= 2 else _midline(_line(left, i), _line(right, i)) for i in range(len(lanes))
    ]
    start = np.cumsum([0, *map(len, lines_of_lanes)]).astype(np.int32)
    return np.concatenate(lines_of_lanes), start


def _line(lines: Lines, i: int) -> NDArray[np.float64]:
    points, start = lines
    return points[start[i] : start[i + 1]]


def _midline(left: Floats, right: Floats) -> Floats:
    """The line halfway between both boundaries at equal shares of their lengths, as in av2."""
    lengths = [float(arc_length(line)[-1]) for line in (left, right)]
    share = np.linspace(0.0, 1.0, max(2, int(np.ceil(max(lengths) / MIDLINE_SPACING)) + 1))
    return (interpolate(left, share * lengths[0]) + interpolate(right, share * lengths[1])) / 2


def _links(lanes: Sequence[Mapping[str, Any]], index: Mapping[int, int]) -> tuple[NDArray[np.int32], int]:
    """Links (E, 2), sorted and unique, and the number of those that name a lane the map does not hold."""
    pairs = [(i, index.get(other, NO_LANE)) for i, lane in enumerate(lanes) for other in lane["successors"]]
    pairs += [(index.get(other, NO_LANE), i) for i, lane in enumerate(lanes) for other in lane["predecessors"]]
    held = sorted({pair for pair in pairs if NO_LANE not in pair})
    return np.array(held, np.int32).reshape(-1, 2), sum(NO_LANE in pair for pair in pairs)


def _limits(lanes: Sequence[Mapping[str, Any]]) -> NDArray[np.float32]:
    """(L,) [m/s], NaN where there is none."""
    limits = np.array([lane.get("speed_limit") for lane in lanes], np.float64)  # None becomes NaN
    if (limits > HIGHEST_LIMIT).any():
        raise ValueError(f"a speed limit is {np.nanmax(limits):g} m/s")
    return limits.astype(np.float32)


def _yields_to(lanes: Sequence[Mapping[str, Any]], index: Mapping[int, int]) -> NDArray[np.int32]:
    pairs = {(i, index[other]) for i, lane in enumerate(lanes) for other in lane.get("yields_to", ())}
    return np.array(sorted(pairs), np.int32).reshape(-1, 2)


def _neighbours(
    lanes: Sequence[Mapping[str, Any]], index: Mapping[int, int], centre: Lines, kind: NDArray[np.uint8]
) -> tuple[NDArray[np.int32], NDArray[np.bool_], NDArray[np.bool_]]:
    """Neighbours, whether they run the same way (by geometry: the file does not say), whether one may change (L, 2)."""
    beside = chain.from_iterable(map(itemgetter("left_neighbor_id", "right_neighbor_id"), lanes))
    neighbour = np.array([index.get(other, NO_LANE) for other in beside], np.int32).reshape(-1, 2)
    marks = chain.from_iterable(map(itemgetter("left_lane_mark_type", "right_lane_mark_type"), lanes))
    crossable = np.array([mark in CROSSABLE_MARKS for mark in marks], np.bool_).reshape(-1, 2)
    points, start = centre
    along = points[start[1:] - 1] - points[start[:-1]]
    same_direction = (neighbour != NO_LANE) & ((along[:, None] * along[neighbour]).sum(-1) > 0)
    for_bikes = kind == LaneKind.BIKE
    may_change = same_direction & crossable & (for_bikes[:, None] == for_bikes[neighbour])
    return neighbour, same_direction, may_change


def _cut(lanes: Sequence[Mapping[str, Any]], links: NDArray[np.int32]) -> NDArray[np.bool_]:
    """(L, 2) as the file says of each lane, all ends without a link where it does not say."""
    unsaid = open_ends(links, len(lanes)).tolist()
    cut = [lane.get("cut", ends) for lane, ends in zip(lanes, unsaid, strict=True)]
    if not all(isinstance(ends, list) and [type(end) for end in ends] == [bool, bool] for ends in cut):
        raise ValueError("`cut` of a lane is not a pair of true and false")
    return np.array(cut, np.bool_).reshape(-1, 2)


def _outlines(areas: Iterable[Mapping[str, Any]]) -> Lines:
    """Closed outlines without the repeated first point that some files have."""
    outlines = [area["area_boundary"] for area in areas]
    return _lines([line[:-1] if len(line) > 3 and _xy(line[0]) == _xy(line[-1]) else line for line in outlines])


def _crossings(crossings: Iterable[Mapping[str, Any]]) -> Lines:
    """Four corners each: along one edge and back along the other, whichever way the edges point."""
    edges = [edge for crossing in crossings for edge in (crossing["edge1"], crossing["edge2"])]
    corner = _lines([(edge[0], edge[-1]) for edge in edges])[0].reshape(-1, 2, 2, 2)  # crossing, edge, end, xy
    along = corner[:, :, 1] - corner[:, :, 0]
    same_way = (along[:, 0] * along[:, 1]).sum(-1) >= 0
    back = np.where(same_way[:, None, None], corner[:, 1, ::-1], corner[:, 1])
    points = np.concatenate([corner[:, 0], back], axis=1).reshape(-1, 2)
    return points, np.arange(0, len(points) + 1, 4, dtype=np.int32)


def write_map(road_map: RoadMap) -> bytes:
    """The official JSON in source coordinates, rounded to 0.1 mm, with our own keys; same map, same bytes."""
    successors, predecessors = _by_lane(road_map, road_map.links)
    first, _ = _by_lane(road_map, road_map.yields_to)
    centre, left, right = (_points(lines, road_map.origin) for lines in (road_map.centreline, road_map.left, road_map.right))
    lanes: dict[str, Any] = {}
    for i, number in enumerate(road_map.lane_id.tolist()):
        beside = [None if n == NO_LANE else int(road_map.lane_id[n]) for n in road_map.neighbour[i]]
        marks = [_mark(road_map, i, side) for side in (0, 1)]
        limit = float(road_map.speed_limit[i])
        lanes[str(number)] = {
            "centerline": centre[i],
            "id": number,
            "is_intersection": bool(road_map.in_junction[i]),
            "lane_type": LaneKind(int(road_map.kind[i])).name,
            "left_lane_boundary": left[i],
            "left_lane_mark_type": marks[0],
            "left_neighbor_id": beside[0],
            "predecessors": predecessors[i],
            "right_lane_boundary": right[i],
            "right_lane_mark_type": marks[1],
            "right_neighbor_id": beside[1],
            "successors": successors[i],
            "control": LaneControl(int(road_map.control[i])).name,
            "cut": road_map.cut[i].tolist(),
            "yields_to": first[i],
            "speed_limit": None if np.isnan(limit) else limit,
        }
    return orjson.dumps(
        {"lane_segments": lanes, "origin": road_map.origin.tolist(), "dangling_links": road_map.dangling, **_areas(road_map)}
    )


def _areas(road_map: RoadMap) -> dict[str, Any]:
    drivable, crossings = _points(road_map.drivable, road_map.origin), _points(road_map.crossings, road_map.origin)
    stops = _points(Polylines.of(list(road_map.stop_lines)), road_map.origin)
    guarded = road_map.lane_id[road_map.stop_lane].tolist()
    return {
        "drivable_areas": {str(i): {"area_boundary": line, "id": i} for i, line in enumerate(drivable)},
        "pedestrian_crossings": {str(i): {"edge1": [a, b], "edge2": [d, c], "id": i} for i, (a, b, c, d) in enumerate(crossings)},
        "stop_lines": {str(i): {"lane": lane, "line": line} for i, (lane, line) in enumerate(zip(guarded, stops, strict=True))},
    }


def _points(lines: Polylines, origin: NDArray[np.float64]) -> list[list[dict[str, float]]]:
    xy = np.round(lines.points.astype(np.float64) + origin, DECIMALS).tolist()
    points = [{"x": x, "y": y, "z": 0.0} for x, y in xy]
    return [points[a:b] for a, b in zip(lines.start[:-1].tolist(), lines.start[1:].tolist(), strict=True)]


def _by_lane(road_map: RoadMap, pairs: NDArray[np.int32]) -> tuple[list[list[int]], list[list[int]]]:
    """Ids of the lanes that stand second, first in the `pairs` (E, 2) of each lane: by links its successors, predecessors."""
    successors: list[list[int]] = [[] for _ in range(len(road_map))]
    predecessors: list[list[int]] = [[] for _ in range(len(road_map))]
    for before, after in pairs.tolist():
        successors[before].append(int(road_map.lane_id[after]))
        predecessors[after].append(int(road_map.lane_id[before]))
    return successors, predecessors


def _mark(road_map: RoadMap, lane: int, side: int) -> str:
    """A lane mark that says the same as `may_change`; our maps keep no others."""
    if road_map.may_change[lane, side]:
        return "DASHED_WHITE"
    if road_map.neighbour[lane, side] != NO_LANE and not road_map.same_direction[lane, side]:
        return "DOUBLE_SOLID_YELLOW"
    return "SOLID_WHITE"
