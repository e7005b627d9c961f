"""The process that runs one libsumo simulation, started by `traffic.simulate`: nothing else imports this file.

libsumo crashes its process on malformed networks, keeps one simulation per process and holds the interpreter's lock,
so it lives alone. It is run by path, with the name of a folder that holds `run.json`, and imports nothing of ours.
"""

import json
import resource
import sys
import warnings
from pathlib import Path
from typing import Any

MEMORY = 6 * 1024**3


def main(folder: Path) -> None:
    """Simulate what `run.json` says; leaves tracks.parquet, types.json and lights.json in `folder`."""
    run: dict[str, Any] = json.loads((folder / "run.json").read_text())
    seconds = int(run["time_limit"]) + 1
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    warnings.filterwarnings("ignore", message="pyarrow .* might be incompatible with libsumo")
    import libsumo

    libsumo.start(["sumo", *run["arguments"]])
    lights: dict[str, list[tuple[int, str]]] = {name: [] for name in libsumo.trafficlight.getIDList()}
    for step in range(run["first"] + run["steps"]):
        libsumo.simulationStep()
        for name, changes in lights.items():
            state = libsumo.trafficlight.getRedYellowGreenState(name)
            if not changes or changes[-1][1] != state:
                changes.append((step, state))
    types = libsumo.vehicletype
    shown = {
        name: [types.getShapeClass(name), types.getLength(name), types.getWidth(name), types.getHeight(name)]
        for name in types.getIDList()
    }
    libsumo.close()
    (folder / "types.json").write_text(json.dumps(shown))
    (folder / "lights.json").write_text(json.dumps(lights))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
