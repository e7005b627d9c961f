"""What `make` and `reset` of an environment are given, made into what it needs."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.core.settings import read_params
from drivegen.drivers.shared.conditions import Settings, Traffic
from drivegen.drivers.shared.environment import Environment
from drivegen.gym.folders import SCENES, read_traffic

SECTION = "environment"


def opened(
    scenarios: str | Path | Sequence[Traffic], rows: int, settings: Settings | None, of: str | Path | None, device: str
) -> Environment:
    """Episodes in the scenarios of a folder, or in those given, as `settings` say or, without them, params.yaml."""
    if not isinstance(rows, int | np.integer) or rows < 1:
        raise UnusableInput(f"num_envs is {rows!r}: give a whole number from 1 on")
    if not isinstance(settings, Settings | None):
        raise UnusableInput(
            f"settings are a {type(settings).__name__}: give Settings, as replace(read_params('environment', Settings))"
        )
    settings = settings or read_params(SECTION, Settings)
    if _kind_of(device) == "cuda" and not torch.cuda.is_available():
        raise UnusableInput(f"device is {device!r}, and PyTorch finds no GPU here: leave it out")
    traffic = read_traffic(Path(scenarios), Path(of or SCENES)) if isinstance(scenarios, str | Path) else scenarios
    traffic = list(traffic) if isinstance(traffic, Iterable) else [traffic]
    if not all(map(_is_traffic, traffic)):
        raise UnusableInput("scenarios to drive in are pairs of a scenario and motion of its vehicles, or a folder")
    return Environment(traffic, rows, settings, device)


def _kind_of(device: str) -> str:
    try:
        return torch.device(device).type
    except RuntimeError:
        raise UnusableInput(f"device is {device!r}, which PyTorch does not know: cpu or cuda") from None


def _is_traffic(pair: Any) -> bool:
    """Whether it is a scenario and, beside it, motion of as many vehicles."""
    whole = isinstance(pair, tuple | list) and [type(one) for one in pair] == [Scenario, Trajectories]
    return whole and len(pair[0].vehicles) == len(pair[1].valid)


def begun(environment: Environment, count: int, options: Mapping[str, Any] | None, random: np.random.Generator) -> Tensor:
    """(count,) scenes drawn by `random`, or those with the number, or one for each, `options["scenario"]` of the playable ones.

    Raises UnusableInput for other numbers and other options, rather than leave unsaid that they do nothing.
    """
    options = options or {}
    if others := sorted(set(options) - {"scenario"}):
        raise UnusableInput(f"options {others} are not known: `scenario` is, the number of a playable scenario")
    if "scenario" not in options:
        return environment.draw_scenes(count, random)
    said, last = options["scenario"], len(environment.playable) - 1
    asked = np.array(said, object)
    if asked.shape not in ((), (count,)):
        raise UnusableInput(f"options['scenario'] is {said!r}: give one number, or a list of {count}, one for each environment")
    if not all(isinstance(one, int | np.integer) and not isinstance(one, bool) and 0 <= one <= last for one in asked.flat):
        raise UnusableInput(f"options['scenario'] is {said!r}: the playable scenarios have the numbers 0 to {last}, give one")
    number = torch.from_numpy(np.broadcast_to(asked, count).astype(np.int64))
    return environment.playable[number.to(environment.playable.device)]
