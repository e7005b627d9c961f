"""DriveGen: endless, diverse, realistic traffic scenarios, and corner cases for a given driver without retraining.

Start reading at `core/scenario.py` (what a scenario is), then `traffic.py` (how one is made). The pipeline's table of
contents is `dvc.yaml` beside this package.
"""

import contextlib
import hashlib
import os
from pathlib import Path

from drivegen.core.errors import DriveGenError, MissingTool, UnusableInput
from drivegen.core.roadmap import LaneControl, LaneKind, RoadMap
from drivegen.core.scenario import Actors, Scenario, Trajectories, VehicleKind, Vehicles
from drivegen.core.signals import Signals, SignalState

__all__ = [
    "Actors",
    "DriveGenError",
    "LaneControl",
    "LaneKind",
    "MissingTool",
    "RoadMap",
    "Scenario",
    "SignalState",
    "Signals",
    "Trajectories",
    "UnusableInput",
    "VehicleKind",
    "Vehicles",
]


def _forget_compiled(package: Path) -> None:
    """Remove loops that Numba compiled of other code: it notices edits of a loop's own file, none of what that calls or reads."""
    files = sorted((str(file.relative_to(package)), file.stat()) for file in package.rglob("*.py"))
    code = hashlib.sha256(repr([(name, stat.st_mtime_ns, stat.st_size) for name, stat in files]).encode()).hexdigest()
    compiled = Path(os.environ.get("NUMBA_CACHE_DIR") or package)
    note = compiled / "__pycache__" / "compiled_of"
    if note.exists() and note.read_text() == code:
        return
    for index in compiled.rglob("*.nbi"):
        index.unlink(missing_ok=True)
    note.parent.mkdir(parents=True, exist_ok=True)
    note.write_text(code)


with contextlib.suppress(OSError):  # a folder that cannot be written has nothing that was compiled here
    _forget_compiled(Path(__file__).parent)
