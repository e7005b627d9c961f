"""A trained model as a folder: `settings.json` and `weights.safetensors`; nothing in it can run.

The weights hold a checksum of themselves and of the settings, so a changed bit of either is an error.
"""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load, save

from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.seal import BLANK, expect_seal, sealed
from drivegen.store.files import as_json, write_bytes

SETTINGS, WEIGHTS = "settings.json", "weights.safetensors"

_ABOUT = "drivegen"
_AGAIN = "train it again, or copy it again from where it was"


def write_weights(folder: Path, kind: str, name: str, settings: Mapping[str, Any], tensors: Mapping[str, NDArray[Any]]) -> None:
    """Write both files whole, the settings last: a folder with settings is complete. `kind` is "planner", "generator", ...

    Raises UnusableInput where a weight is not finite.
    """
    check_finite(tensors, f"the trained {kind} {name!r}")
    about = as_json({kind: name, "settings": settings})
    beside = json.dumps({"checksum": BLANK, SETTINGS: _digest(about)})  # one entry: safetensors writes several in any order
    written = save({key: np.ascontiguousarray(tensor) for key, tensor in sorted(tensors.items())}, {_ABOUT: beside})
    for file, content in ((WEIGHTS, sealed(written)), (SETTINGS, about)):
        write_bytes(folder / file, content)


def read_weights(folder: Path, kind: str, name: str) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Settings and tensors of the trained `kind` called `name`.

    Raises MissingTool where the folder holds no weights, UnusableInput where they are damaged, not finite, or another model's.
    """
    if not (folder / SETTINGS).exists():
        raise MissingTool(f"{folder} holds no trained {kind}: run `make run` first")
    try:
        text, raw = (folder / SETTINGS).read_bytes(), (folder / WEIGHTS).read_bytes()
        about = json.loads(text)
        if about[kind] != name:
            raise UnusableInput(f"{folder} holds {kind} {about[kind]!r}, not {name!r}")
        expect_seal(raw, folder / WEIGHTS, _AGAIN)
        if metadata(raw, _ABOUT)[SETTINGS] != _digest(text):
            raise UnusableInput(f"{folder / SETTINGS} is not what these weights were trained with: {_AGAIN}", reason="damaged")
        settings, tensors = dict(about["settings"]), load(raw)
    except (SafetensorError, OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise UnusableInput(f"{folder} holds a damaged {kind} ({error}): {_AGAIN}", reason="damaged") from None
    check_finite(tensors, str(folder / WEIGHTS))
    return settings, tensors


def metadata(raw: bytes, name: str) -> dict[str, Any]:
    """The JSON of that name beside the tensors: safetensors begin with the length of a JSON header, 8 bytes."""
    header = json.loads(raw[8 : 8 + int.from_bytes(raw[:8], "little")])
    values: dict[str, Any] = json.loads(header["__metadata__"][name])
    return values


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


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
