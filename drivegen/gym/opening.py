"""What `make` of an environment is given, made into what it needs."""

from collections.abc import Sequence
from pathlib import Path

from drivegen.core.settings import read_params
from drivegen.drivers.shared.conditions import Settings, Traffic
from drivegen.drivers.shared.environment import Environment
from drivegen.gym.folders import SCENES, read_traffic

SECTION = "environment"


def opened(
    scenarios: str | Path | Sequence[Traffic], rows: int, settings: Settings | None, of: str | Path | None, device: str
) -> Environment:
    """Episodes in the scenarios of a folder, or in those given, as `settings` say or, without them, params.yaml."""
    settings = settings or read_params(SECTION, Settings)
    traffic = read_traffic(Path(scenarios), Path(of or SCENES)) if isinstance(scenarios, str | Path) else scenarios
    return Environment(traffic, rows, settings, device)
