"""Roads and signals in a recording: surfaces as a mesh, markings as lines, signals as bars that change colour."""

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from drivegen.geometry import Floats, interpolate
from drivegen.recording import colours
from drivegen.roadmap import RoadMap
from drivegen.scenario import DT, Signals

_MOST_RIBS = 9
"""Cross-sections of a bent lane's surface; more would not be seen."""


def log_roads(recording: rr.RecordingStream, roads: RoadMap) -> None:
    """Everything of the map that does not move, below `world/roads`."""
    vertices, triangles, shade = _surface(roads)
    mesh = rr.Mesh3D(vertex_positions=vertices, triangle_indices=triangles, vertex_colors=shade)
    recording.log("world/roads/surface", mesh, static=True)
    drive = np.flatnonzero(roads.for_vehicles & ~roads.in_junction)
    edges = [flat(line) for lane in drive for line in (roads.left[int(lane)], roads.right[int(lane)])]
    _strips(recording, "world/roads/boundaries", edges, colours.MARKING, 0.08)
    across = [flat(roads.centreline[int(lane)]) for lane in np.flatnonzero(roads.in_junction)]
    _strips(recording, "world/roads/connections", across, colours.CONNECTION, 0.06)
    _strips(recording, "world/roads/drivable", [_closed(line) for line in roads.drivable.lines()], colours.KERB, 0.12)
    _strips(recording, "world/roads/crossings", [_closed(line) for line in roads.crossings.lines()], colours.CROSSING, 0.12)
    _strips(recording, "world/roads/stop_lines", [flat(line) for line in roads.stop_lines], colours.STOP_LINE, 0.2)


def log_signals(recording: rr.RecordingStream, roads: RoadMap, signals: Signals) -> None:
    """A bar across the entry of every guarded lane, coloured by its state; a row only where a state changes."""
    if len(signals) == 0:
        return
    bars = [flat(np.stack([roads.left[int(lane)][0], roads.right[int(lane)][0]]), 0.3) for lane in signals.lane]
    recording.log("world/signals", rr.LineStrips3D(bars, radii=0.3), static=True)
    changes = np.flatnonzero(np.any(np.diff(signals.state, axis=1, prepend=255) != 0, axis=0))
    shown = np.array(colours.SIGNAL, np.uint8)[signals.state[:, changes].T].reshape(-1, 4)
    columns = rr.LineStrips3D.columns(colors=shown).partition([len(signals)] * len(changes))
    recording.send_columns("world/signals", indexes=times(changes), columns=columns)


def times(steps: NDArray[np.integer]) -> list[rr.TimeColumn]:
    """Both time lines of a recording: seconds and steps."""
    return [rr.TimeColumn("time", duration=steps * DT), rr.TimeColumn("step", sequence=steps)]


def flat(points: Floats, height: float = 0.0) -> NDArray[np.float32]:
    """Points (P, 2) of the ground as (P, 3)."""
    return np.concatenate([points, np.full((len(points), 1), height)], axis=1).astype(np.float32)


def _closed(outline: Floats) -> NDArray[np.float32]:
    return flat(np.concatenate([outline, outline[:1]]))


def _strips(
    recording: rr.RecordingStream, path: str, lines: list[NDArray[np.float32]], colour: colours.Colour, radius: float
) -> None:
    if lines:
        recording.log(path, rr.LineStrips3D(lines, colors=[colour], radii=radius), static=True)


def _surface(roads: RoadMap) -> tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.uint8]]:
    """Lanes as ribbons between their edges: vertices (V, 3), triangles (F, 3), colours (V, 4); junctions lie lowest."""
    vertices: list[NDArray[np.float32]] = []
    triangles: list[NDArray[np.intp]] = []
    shades: list[NDArray[np.uint8]] = []
    count = 0
    for lane in range(len(roads)):
        ribs = min(_MOST_RIBS, max(len(roads.left[lane]), len(roads.right[lane])))
        along, rungs = np.linspace(0.0, 1.0, ribs), count + 2 * np.arange(ribs - 1)
        left, right = (interpolate(line, along * _length(line)) for line in (roads.left[lane], roads.right[lane]))
        height = -0.12 if roads.in_junction[lane] else -0.08
        triangles += [np.stack([rungs, rungs + 1, rungs + 2], axis=1), np.stack([rungs + 1, rungs + 3, rungs + 2], axis=1)]
        vertices.append(flat(np.stack([left, right], axis=1).reshape(-1, 2), height))
        shade = colours.ROAD if roads.for_vehicles[lane] else colours.BIKE_LANE
        shades.append(np.tile(np.array(shade, np.uint8), (2 * ribs, 1)))
        count += 2 * ribs
    return np.concatenate(vertices), np.concatenate(triangles).astype(np.uint32), np.concatenate(shades)


def _length(line: Floats) -> float:
    return float(np.hypot(*np.diff(line, axis=0).T).sum())
