"""Let SUMO's own car-following drive a target along its path through replayed traffic, in a process of its own.

The network of a run is the path: one lane, in pieces of one speed limit each, written as a SUMO network directly. Others
are moved by hand to where the record has them (moveToXY), on the lane or beside it; SUMO finds the leader and the speed.
"""

import json
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import arc_length
from drivegen.core.scenario import DT
from drivegen.sumo import child, closed_loop_process

_PROGRAM = Path(closed_loop_process.__file__)  # run, never called; imported so that whoever follows imports finds it
_SECONDS_PER_RUN = 20.0


@dataclass(frozen=True)
class ClosedLoopRun:
    """One target, the path that it follows, and M others over T steps.

    Attributes:
        line: (P, 2) float64 [m] the path, long enough on both sides of the target.
        limit: (P,) float64 [m/s] speed limit on the segment after each point.
        start: distance of the target's front along `line` at step 0 [m].
        speed: of the target at step 0 [m/s]. target_size: (2,) length, width [m].
        front: (T, M, 2) [m] middles of the others' front bumpers. heading: (T, M) [rad]. valid: (T, M) bool.
        size: (M, 2) length, width [m].
    """

    line: NDArray[np.float64]
    limit: NDArray[np.float64]
    start: float
    speed: float
    target_size: NDArray[np.float32]
    front: NDArray[np.float64]
    heading: NDArray[np.float64]
    valid: NDArray[np.bool_]
    size: NDArray[np.float32]


def drive(
    runs: Sequence[ClosedLoopRun], vehicle_type: Mapping[str, str]
) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Distance (T,) of each target's front along its line [m] and its speed (T,) [m/s].

    `vehicle_type` are attributes of the vType that drives the targets. Raises SimulationFailed whatever SUMO does.
    """
    with tempfile.TemporaryDirectory(prefix="drivegen-sumo-") as name:
        folder = Path(name)
        attributes = " ".join(f"{key}={quoteattr(value)}" for key, value in vehicle_type.items())
        types = f'<additional><vType id="driver" {attributes}/><vType id="other" minGap="0"/></additional>'
        (folder / "types.add.xml").write_text(types)
        edges = [_write(folder, i, run) for i, run in enumerate(runs)]
        limit = _SECONDS_PER_RUN * len(runs)
        task = {"edges": edges, "time_limit": limit, "arguments": _arguments(folder)}
        (folder / "runs.json").write_text(json.dumps(task))
        child.simulate(_PROGRAM, folder, limit)
        results = [np.load(folder / f"result-{i}.npz") for i in range(len(runs))]
        return [(result["along"], result["speed"]) for result in results]


def _write(folder: Path, i: int, run: ClosedLoopRun) -> dict[str, float]:
    """The files of one run; returns the edges with the distance at which each begins."""
    network, edges = path_network(run.line, run.limit)
    (folder / f"net-{i}.net.xml").write_text(network)
    along = arc_length(run.line)
    place = int(np.clip(np.searchsorted(along, run.start, side="right") - 1, 0, len(along) - 2))
    step = run.line[place + 1] - run.line[place]
    here = run.line[place] + step * (run.start - along[place]) / (along[place + 1] - along[place])
    np.savez(
        folder / f"run-{i}.npz",
        front=run.front,
        angle=_compass(run.heading),
        valid=run.valid,
        size=run.size,
        start=run.start,
        speed=run.speed,
        target_size=run.target_size,
        target_front=here,
        target_angle=_compass(np.arctan2(step[1], step[0])),
    )
    return edges


def _compass(heading: NDArray[np.float64]) -> NDArray[np.float64]:
    """SUMO's angle: degrees clockwise from north."""
    return (90.0 - np.degrees(heading)) % 360.0


def path_network(line: NDArray[np.float64], limit: NDArray[np.float64]) -> tuple[str, dict[str, float]]:
    """A SUMO network with one lane along `line` (P, 2), cut where `limit` (P,) changes; and where each edge begins [m]."""
    along = arc_length(line)
    cuts = [0, *(np.flatnonzero(np.diff(limit[:-1])) + 1).tolist(), len(line) - 1]
    low, high = line.min(axis=0), line.max(axis=0)
    box = f"{low[0]:.2f},{low[1]:.2f},{high[0]:.2f},{high[1]:.2f}"
    rows = [f'<location netOffset="0.00,0.00" convBoundary="{box}" origBoundary="{box}" projParameter="!"/>']
    for k, (a, b) in enumerate(pairwise(cuts)):
        shape = " ".join(f"{x:.3f},{y:.3f}" for x, y in line[a : b + 1])
        lane = f'<lane id="e{k}_0" index="0" speed="{limit[a]:.3f}" length="{along[b] - along[a]:.3f}" shape="{shape}"/>'
        rows.append(f'<edge id="e{k}" from="n{k}" to="n{k + 1}" priority="1">{lane}</edge>')
    for k, point in enumerate(cuts):
        kind = "dead_end" if k in (0, len(cuts) - 1) else "unregulated"
        into = f"e{k - 1}_0" if k else ""
        at = f'x="{line[point, 0]:.3f}" y="{line[point, 1]:.3f}"'
        rows.append(f'<junction id="n{k}" type="{kind}" {at} incLanes="{into}" intLanes="" shape=""/>')
    rows += [f'<connection from="e{k}" to="e{k + 1}" fromLane="0" toLane="0" dir="s" state="M"/>' for k in range(len(cuts) - 2)]
    edges = {f"e{k}": float(along[a]) for k, a in enumerate(cuts[:-1])}
    return '<net version="1.20" limitTurnSpeed="-1">' + "".join(rows) + "</net>", edges


def _arguments(folder: Path) -> list[str]:
    options = {
        "-a": str(folder / "types.add.xml"),
        "--step-length": str(DT),
        "--collision.action": "none",
        "--time-to-teleport": "-1",
        "--default.speeddev": "0",
        "--no-step-log": "true",
        "--no-warnings": "true",
        "--xml-validation": "never",
        "--xml-validation.net": "never",
    }
    return [word for pair in options.items() for word in pair]
