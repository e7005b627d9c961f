"""The legal checker's verdicts on samples that somebody else made, with the calibrated limits of the folder of models."""

from dataclasses import replace
from pathlib import Path

import orjson

from drivegen.checker.limits import Limits
from drivegen.checker.scene import SceneChecker
from drivegen.errors import MissingTool, UnusableInput
from drivegen.samples import Samples
from drivegen.scenario import Scenario


def read_limits(models: Path) -> Limits:
    """The checker's limits, `models/limits.json`; raises MissingTool where it is absent, UnusableInput where it is broken."""
    path = models / "limits.json"
    if not path.exists():
        raise MissingTool(f"{path} is not there: `make run` calibrates it and trains the models beside it")
    try:
        values = orjson.loads(path.read_bytes())
    except orjson.JSONDecodeError:
        raise UnusableInput(f"{path} is not JSON: remove it and `make run` again") from None
    return Limits.from_json(values, str(path))


def judged(scenario: Scenario, samples: Samples, limits: Limits) -> Samples:
    """The samples with the checker's verdicts on them as they stand, both partners of a collision charged."""
    violation, first = SceneChecker(scenario, limits).check_samples(samples.motion)
    return replace(samples, violation=violation, first_violation=first)
