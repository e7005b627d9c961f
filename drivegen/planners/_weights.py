"""A trained planner as a folder: `settings.json` and `weights.safetensors`; nothing in it can run."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load_file, save_file

from drivegen.errors import MissingTool, UnusableInput
from drivegen.store.files import whole, write_json

SETTINGS, WEIGHTS = "settings.json", "weights.safetensors"


def write_weights(folder: Path, planner: str, settings: Mapping[str, Any], tensors: Mapping[str, NDArray[Any]]) -> None:
    """Write both files whole, the settings last: a folder with settings is complete."""
    with whole(folder / WEIGHTS) as temporary:
        save_file({name: np.ascontiguousarray(tensor) for name, tensor in sorted(tensors.items())}, temporary)
    write_json(folder / SETTINGS, {"planner": planner, "settings": settings})


def read_weights(folder: Path, planner: str) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Settings and tensors of a trained `planner`.

    Raises MissingTool where the folder holds no weights, UnusableInput where they are damaged or another planner's.
    """
    if not (folder / SETTINGS).exists():
        raise MissingTool(f"{folder} holds no trained planner: run `make run` first")
    try:
        about = json.loads((folder / SETTINGS).read_text())
        if about["planner"] != planner:
            raise UnusableInput(f"{folder} holds planner {about['planner']!r}, not {planner!r}")
        return dict(about["settings"]), load_file(folder / WEIGHTS)
    except (SafetensorError, OSError, ValueError, KeyError, TypeError) as error:
        raise UnusableInput(f"{folder} holds a damaged planner ({error}): train it again") from None
