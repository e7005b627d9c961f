"""A trained model as a folder: `settings.json` and `weights.safetensors`; nothing in it can run."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load_file, save_file

from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.store.files import whole, write_json

SETTINGS, WEIGHTS = "settings.json", "weights.safetensors"


def write_weights(folder: Path, kind: str, name: str, settings: Mapping[str, Any], tensors: Mapping[str, NDArray[Any]]) -> None:
    """Write both files whole, the settings last: a folder with settings is complete. `kind` is "planner", "generator", ...

    Raises UnusableInput where a weight is not finite.
    """
    check_finite(tensors, f"the trained {kind} {name!r}")
    with whole(folder / WEIGHTS) as temporary:
        save_file({key: np.ascontiguousarray(tensor) for key, tensor in sorted(tensors.items())}, temporary)
    write_json(folder / SETTINGS, {kind: name, "settings": settings})


def read_weights(folder: Path, kind: str, name: str) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Settings and tensors of the trained `kind` called `name`.

    Raises MissingTool where the folder holds no weights, UnusableInput where they are damaged, not finite, or another model's.
    """
    if not (folder / SETTINGS).exists():
        raise MissingTool(f"{folder} holds no trained {kind}: run `make run` first")
    try:
        about = json.loads((folder / SETTINGS).read_text())
        if about[kind] != name:
            raise UnusableInput(f"{folder} holds {kind} {about[kind]!r}, not {name!r}")
        settings, tensors = dict(about["settings"]), load_file(folder / WEIGHTS)
    except (SafetensorError, OSError, ValueError, KeyError, TypeError) as error:
        raise UnusableInput(f"{folder} holds a damaged {kind} ({error}): train it again") from None
    check_finite(tensors, str(folder / WEIGHTS))
    return settings, tensors


def check_finite(tensors: Mapping[str, NDArray[Any]], place: str) -> None:
    """Raise UnusableInput, naming `place` and the tensor, where a number of a tensor is not finite."""
    for name, tensor in tensors.items():
        if not np.isfinite(tensor).all():
            raise UnusableInput(f"{place}: {name} has a number that is not finite: train it again", reason="not-finite")


def fill(net: torch.nn.Module, tensors: Mapping[str, NDArray[Any]], folder: Path) -> None:
    """Give `net` the weights that were read from `folder`. Raises UnusableInput where they are those of another network."""
    try:
        net.load_state_dict({key: torch.from_numpy(tensor) for key, tensor in tensors.items()})
    except RuntimeError as error:
        raise UnusableInput(f"{folder}: weights do not fit the settings ({error}): train it again") from None
