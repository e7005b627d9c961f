"""What `make` of an environment is given, made into what it needs; spaces of observations and actions."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from gymnasium.spaces import Box

from drivegen.core.settings import read_params
from drivegen.drivers.shared.features import COUNT, LIMIT
from drivegen.gym.episodes import Episodes
from drivegen.gym.folders import SCENES, Traffic, read_traffic
from drivegen.gym.settings import MOTIONS, Settings

SECTION = "environment"

OBSERVATION = Box(-LIMIT, LIMIT, (COUNT,), np.float32)
"""See `drivers.shared.features` for each number and its unit."""


def opened(
    scenarios: str | Path | Sequence[Traffic], rows: int, settings: Settings | None, of: str | Path | None, device: str
) -> Episodes:
    """Episodes in the scenarios of a folder, or in those given, as `settings` say or, without them, params.yaml."""
    settings = settings or read_params(SECTION, Settings)
    traffic = read_traffic(Path(scenarios), Path(of or SCENES)) if isinstance(scenarios, str | Path) else scenarios
    return Episodes(traffic, rows, settings, device)


def actions(settings: Settings) -> Box:
    """Numbers in [-1, 1]; see `episodes` for their units."""
    return Box(-1.0, 1.0, (MOTIONS[settings.motion],), np.float32)
