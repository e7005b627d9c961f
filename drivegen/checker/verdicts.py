"""The legal checker's verdicts on samples that somebody else made, with the calibrated limits of the folder of models.

Who leaves the map is decided here, too: for every method before it is judged, so that whatever reads samples sees one rule.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import orjson
from numpy.typing import NDArray

from drivegen.checker.limits import Limits
from drivegen.checker.scene import SceneChecker
from drivegen.core.errors import MissingTool
from drivegen.core.samples import Samples, Violation
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.core.seal import BLANK, expect_seal, sealed
from drivegen.roads.leaving import STAYS, Exits, left_from
from drivegen.store.files import as_json, write_bytes

SEAL = "checksum"
"""The name in the file of what is no limit."""


def read_limits(models: Path) -> Limits:
    """The checker's limits of a folder of models, `models/limits.json`; raises as `read_limits_file`."""
    return read_limits_file(models / "limits.json")


def read_limits_file(path: Path) -> Limits:
    """The checker's limits as `write_limits_file` wrote them.

    Raises MissingTool where the file is absent, UnusableInput where it is broken or changed.
    """
    if not path.exists():
        raise MissingTool(f"{path} is not there: `make run` calibrates it and trains the models beside it")
    raw = path.read_bytes()
    expect_seal(raw, path, "remove it and `make run` again")
    return Limits.from_json({name: value for name, value in orjson.loads(raw).items() if name != SEAL}, str(path))


def write_limits_file(path: Path, limits: Limits) -> None:
    """JSON, written whole, with a checksum of itself."""
    write_bytes(path, sealed(as_json(limits.to_json() | {SEAL: BLANK})))


def judged(scenario: Scenario, samples: Samples, limits: Limits) -> Samples:
    """The samples, ended where vehicles leave the map, with verdicts; both partners of a collision are charged."""
    left = Exits.of(scenario.map).crossings(samples.motion, scenario.vehicles.size[:, 0])
    motion = left_from(samples.motion, left)
    violation, first = SceneChecker(scenario, limits).check_samples(motion)
    return replace(samples, motion=motion, violation=violation, first_violation=first, left_map=left != STAYS)


class SingleJudge:
    """The rules that need no other vehicle, for single trajectories of many scenarios; a scenario's checker is made once."""

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._checkers: dict[str, SceneChecker] = {}

    def __call__(
        self,
        scenarios: Sequence[Scenario],
        scenario: NDArray[np.integer],
        vehicle: NDArray[np.integer],
        motion: Trajectories,
    ) -> dict[str, NDArray[np.bool_]]:
        """Verdicts (B,) `off_road` and `illegal` (any rule, being off the road included) on motion (B, T).

        `scenario` (B,) counts through `scenarios`, `vehicle` (B,) through the vehicles of each. Steps after a scenario's last are
        not judged.
        """
        violation = np.zeros(len(scenario), np.uint16)
        for number in np.unique(scenario).tolist():
            rows = np.flatnonzero(scenario == number)
            one = scenarios[number]
            violation[rows] = self._checker(one).alone(vehicle[rows], motion[rows].until(one.steps)).violation
        return {"off_road": (violation & int(Violation.OFF_ROAD)) > 0, "illegal": violation > 0}

    def _checker(self, scenario: Scenario) -> SceneChecker:
        if scenario.scenario_id not in self._checkers:
            self._checkers[scenario.scenario_id] = SceneChecker(scenario, self._limits)
        return self._checkers[scenario.scenario_id]
