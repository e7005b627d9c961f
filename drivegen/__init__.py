"""DriveGen: endless, diverse, realistic traffic scenarios, and corner cases for a given driver without retraining.

Start reading at `core/scenario.py` (what a scenario is), then `traffic.py` (how one is made). The pipeline's table of
contents is `dvc.yaml` beside this package.
"""

from drivegen.core.compiled import keep_compiled
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

keep_compiled()
