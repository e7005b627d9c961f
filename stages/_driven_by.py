"""What a driver drives by beside its code and its settings: the weights of one that has learned."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any


def weights_of(settings: Mapping[str, Any]) -> list[Path]:
    """The folder of weights that the settings of a driver name, an input of its runs; nothing of one that learns nothing."""
    return [Path(settings["weights"])] if "weights" in settings else []
