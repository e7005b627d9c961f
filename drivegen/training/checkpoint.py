"""Interrupted training on disk: one safetensors file, written whole, that holds everything the next step needs.

That is networks, their moving averages and the best so far, Adam's moments, other tensors, and, as JSON, how far training is and
its curve. No generator state is among it, because training derives every random number from (seed, step).
"""

import hashlib
import json
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError
from safetensors.torch import load, save
from torch import Tensor, nn
from torch.optim import Optimizer

from drivegen.core.errors import UnusableInput
from drivegen.core.seal import BLANK, expect_seal, sealed
from drivegen.store.files import write_bytes
from drivegen.training.weights import metadata

Part = nn.Module | Optimizer | Tensor

_STATE = "state"


def write(path: Path, parts: Mapping[str, Part], state: Mapping[str, Any]) -> None:
    """Write the file whole, `state` as JSON: a kill leaves the old one or the new one."""
    tensors = {f"{name}/{key}": tensor for name, part in parts.items() for key, tensor in _tensors(part).items()}
    about = json.dumps({"checksum": BLANK, **state})  # floats are written so that they read back exactly
    content = save({k: v.detach().cpu().contiguous().clone() for k, v in tensors.items()}, {_STATE: about})
    write_bytes(path, sealed(content))


def read(path: Path, parts: Mapping[str, Part]) -> dict[str, Any] | None:
    """Fill `parts` from `path` and give back the state; None where there is no file.

    Raises UnusableInput for a file that is damaged or belongs to another training.
    """
    if not path.exists():
        return None
    raw = path.read_bytes()
    expect_seal(raw, f"checkpoint {path}", "remove it to start anew")
    try:
        tensors, state = load(raw), metadata(raw, _STATE)
        for name, part in parts.items():
            _fill(part, _below(f"{name}/", tensors))
    except (SafetensorError, RuntimeError, KeyError, TypeError, ValueError) as error:
        raise UnusableInput(f"checkpoint {path} does not fit this training ({error}): remove it to start anew") from None
    return state


def name_of(inputs: object, files: Iterable[Path], code: str) -> str:
    """A name for an interrupted training, which changes with all that its weights depend on.

    `inputs` (settings, seed, ...) count by their `repr`, `files` by their bytes; `code` is a digest such as `source_digest`.
    """
    digest = hashlib.sha256(f"{inputs!r}\n{code}\n".encode())
    for path in files:
        with path.open("rb") as file:
            digest.update(hashlib.file_digest(file, "sha256").digest())
    return digest.hexdigest()[:24]


def source_digest(*packages: str) -> str:
    """Hex digest of the source of all modules of `packages` that are loaded, that which `python -m` runs included.

    It depends neither on where the packages lie nor on the order in which their modules were loaded.
    """
    loaded = [module for name, module in list(sys.modules.items()) if name.split(".")[0] in {*packages, "__main__"}]
    specs = [spec for module in loaded if (spec := module.__spec__) is not None]
    sources = {spec.name: spec.origin for spec in specs if spec.has_location and spec.name.split(".")[0] in packages}
    digest = hashlib.sha256()
    for name, origin in sorted(sources.items()):
        digest.update(f"{name} {hashlib.sha256(Path(str(origin)).read_bytes()).hexdigest()}\n".encode())
    return digest.hexdigest()


def _tensors(part: Part) -> dict[str, Tensor]:
    if isinstance(part, Tensor):
        return {"tensor": part}
    if isinstance(part, nn.Module):
        return part.state_dict()
    moments = part.state_dict()["state"]
    return {f"{index}/{name}": tensor for index, of in moments.items() for name, tensor in of.items()}


@torch.no_grad()
def _fill(part: Part, tensors: dict[str, Tensor]) -> None:
    if isinstance(part, Tensor):
        part.copy_(tensors["tensor"])
    elif isinstance(part, nn.Module):
        part.load_state_dict(tensors)
    else:
        moments: dict[int, dict[str, Tensor]] = {}
        for key, value in tensors.items():
            index, name = key.split("/")
            moments.setdefault(int(index), {})[name] = value
        part.load_state_dict({**part.state_dict(), "state": moments})


def _below(prefix: str, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
    return {key.removeprefix(prefix): value for key, value in tensors.items() if key.startswith(prefix)}
