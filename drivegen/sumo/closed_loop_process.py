"""The process in which SUMO drives targets through replayed traffic, started by `closed_loop.drive`; nobody calls it.

libsumo keeps one simulation per process and can crash it, so it lives alone. It is run by path, with the name of a folder
that holds `runs.json` and per run a network and arrays, and imports nothing of ours.
"""

import json
import resource
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np

MEMORY = 6 * 1024**3
EXACTLY = 2
"""`keepRoute` of moveToXY: put the vehicle exactly there, on a lane or beside it."""


def main(folder: Path) -> None:
    """Play all runs one after the other; leaves result-<i>.npz with along (T,) and speed (T,) of each target."""
    task: dict[str, Any] = json.loads((folder / "runs.json").read_text())
    seconds = int(task["time_limit"]) + 1
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    warnings.filterwarnings("ignore", message="pyarrow .* might be incompatible with libsumo")
    import libsumo

    for i, edges in enumerate(task["edges"]):
        libsumo.start(["sumo", "-n", str(folder / f"net-{i}.net.xml"), *task["arguments"]])
        along, speed = _play(libsumo, np.load(folder / f"run-{i}.npz"), edges)
        libsumo.close()
        np.savez(folder / f"result-{i}.npz", along=along, speed=speed)


def _play(libsumo: Any, run: Any, edges: dict[str, float]) -> tuple[Any, Any]:
    """One run: everybody is put in place at step 0, then the target is let go and the others are moved by hand."""
    front, angle, valid, size = run["front"], run["angle"], run["valid"], run["size"]
    vehicle = libsumo.vehicle
    libsumo.route.add("way", list(edges))
    steps = valid.shape[0]
    along, speed = np.zeros(steps), np.zeros(steps)
    along[0], speed[0] = run["start"], run["speed"]
    vehicle.add("target", "way", typeID="driver", departPos="0")
    vehicle.setLength("target", float(run["target_size"][0]))
    vehicle.setWidth("target", float(run["target_size"][1]))
    vehicle.setLaneChangeMode("target", 0)
    vehicle.moveToXY("target", "", -1, *run["target_front"].tolist(), angle=float(run["target_angle"]), keepRoute=EXACTLY)
    there: dict[int, str] = {}
    for t in range(steps):
        for m in range(valid.shape[1]):
            _place(vehicle, there, m, t, front[t, m], angle[t, m], valid[t, m], size[m])
        libsumo.simulationStep()
        if t == 0:
            vehicle.setPreviousSpeed("target", float(run["speed"]), 0.0)
        else:
            along[t] = edges[vehicle.getRoadID("target")] + vehicle.getLanePosition("target")
            speed[t] = vehicle.getSpeed("target")
    return along, speed


def _place(vehicle: Any, there: dict[int, str], m: int, t: int, front: Any, angle: Any, valid: Any, size: Any) -> None:
    """Move vehicle m to where it is at step t; let it appear and vanish as the record has it."""
    if not valid:
        if m in there:
            vehicle.remove(there.pop(m))
        return
    if m not in there:
        there[m] = f"{m}-{t}"
        vehicle.add(there[m], "way", typeID="other", departPos="0")
        vehicle.setLength(there[m], float(size[0]))
        vehicle.setWidth(there[m], float(size[1]))
    vehicle.moveToXY(there[m], "", -1, *front.tolist(), angle=float(angle), keepRoute=EXACTLY)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
