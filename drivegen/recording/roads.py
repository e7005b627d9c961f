"""Roads and signals in a recording: surfaces as a mesh, markings as lines, signals as bars that change colour.

Only what is near enough to the traffic to be looked at is drawn (`surroundings`): a town's map is larger than its traffic.
"""

from collections.abc import Sequence

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from drivegen.core.crop import Cropper
from drivegen.core.geometry import Floats, arc_length, interpolate
from drivegen.core.roadmap import RoadMap
from drivegen.core.scenario import DT, Scenario, Trajectories
from drivegen.core.signals import Signals
from drivegen.recording import colours
from drivegen.recording.lines import closed, flat, thinned

SIGHT = 50.0
"""Roads are drawn where they come this near to a vehicle [m] ..."""

_LOOK = 1.0
"""... at some time; it is looked every second [s] ..."""

_CELL = 10.0
"""... and places in one square of this side [m] count once."""

_MOST_RIBS = 9
"""Cross-sections of a bent lane's surface; more would not be seen."""

_RIB = 0.3
"""A surface, which has the colour of the one next to it, may differ so much from its edges [m]."""


def surroundings(scenario: Scenario, motions: Sequence[Trajectories]) -> tuple[RoadMap, Signals]:
    """The roads near any vehicle of `motions` (N, T) each, and their signals; the whole map where none is near."""
    every = round(_LOOK / DT)
    places = np.concatenate([motion.position[:, ::every][motion.valid[:, ::every]] for motion in motions])
    cells = np.unique(np.round(places / _CELL), axis=0) * _CELL
    roads, lanes = Cropper(scenario.map).around(cells, SIGHT)
    return (roads, scenario.signals.on_lanes(lanes)) if len(lanes) else (scenario.map, scenario.signals)


def log_roads(recording: rr.RecordingStream, roads: RoadMap) -> None:
    """Everything of the map that does not move, below `world/roads`."""
    vertices, triangles, shade = _surface(roads)
    mesh = rr.Mesh3D(vertex_positions=vertices, triangle_indices=triangles, vertex_colors=shade)
    recording.log("world/roads/surface", mesh, static=True)
    drive = np.flatnonzero(roads.for_vehicles & ~roads.in_junction)
    edges = [line for lane in drive for line in (roads.left[int(lane)], roads.right[int(lane)])]
    _strips(recording, "world/roads/boundaries", edges, colours.MARKING, 0.08)
    across = [roads.centreline[int(lane)] for lane in np.flatnonzero(roads.in_junction)]
    _strips(recording, "world/roads/connections", across, colours.CONNECTION, 0.06)
    _strips(recording, "world/roads/drivable", [closed(line) for line in roads.drivable.lines()], colours.KERB, 0.12)
    _strips(recording, "world/roads/crossings", [closed(line) for line in roads.crossings.lines()], colours.CROSSING, 0.12)
    _strips(recording, "world/roads/stop_lines", list(roads.stop_lines), colours.STOP_LINE, 0.2)


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


def _strips(recording: rr.RecordingStream, path: str, lines: Sequence[Floats], colour: colours.Colour, radius: float) -> None:
    if lines:
        strips = [flat(thinned(line)) for line in lines]
        recording.log(path, rr.LineStrips3D(strips, colors=[colour], radii=radius), static=True)


def _surface(roads: RoadMap) -> tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.uint8]]:
    """Lanes as ribbons between their edges: vertices (V, 3), triangles (F, 3), colours (V, 4); junctions lie lowest."""
    vertices: list[NDArray[np.float32]] = []
    triangles: list[NDArray[np.intp]] = []
    shades: list[NDArray[np.uint8]] = []
    count = 0
    for lane in range(len(roads)):
        edges = roads.left[lane], roads.right[lane]
        ribs = min(_MOST_RIBS, max(len(thinned(line, _RIB)) for line in edges))
        along, rungs = np.linspace(0.0, 1.0, ribs), count + 2 * np.arange(ribs - 1)
        left, right = (interpolate(line, along * float(arc_length(line)[-1])) for line in edges)
        height = -0.12 if roads.in_junction[lane] else -0.08
        triangles += [np.stack([rungs, rungs + 1, rungs + 2], axis=1), np.stack([rungs + 1, rungs + 3, rungs + 2], axis=1)]
        vertices.append(flat(np.stack([left, right], axis=1).reshape(-1, 2), height))
        shade = colours.ROAD if roads.for_vehicles[lane] else colours.BIKE_LANE
        shades.append(np.tile(np.array(shade, np.uint8), (2 * ribs, 1)))
        count += 2 * ribs
    return np.concatenate(vertices), np.concatenate(triangles).astype(np.uint32), np.concatenate(shades)
