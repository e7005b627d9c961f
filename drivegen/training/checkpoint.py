"""Interrupted training on disk: one safetensors file, written whole, that holds everything the next step needs.

What the next step needs is the weights, their moving average (and the best one so far, where that is kept), Adam's
moments, the step number and the loss curve so far. No generator state is among it, because the loop derives every
random number from (seed, step).
"""

import dataclasses
import hashlib
import json
import sys
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file
from torch import Tensor, nn

from drivegen.core.errors import UnusableInput
from drivegen.store.files import whole
from drivegen.training.curve import LossRow

_STATE = "state"


@dataclass
class Progress:
    """How far training has come: optimiser steps done, the curve, and the sum of the losses since its last row."""

    step: int = 0
    since: int = 0
    loss_since: float = 0.0
    curve: list[LossRow] = field(default_factory=list)


def write(
    path: Path,
    model: nn.Module,
    average: nn.Module,
    optimiser: torch.optim.AdamW,
    progress: Progress,
    best: nn.Module | None = None,
) -> None:
    """Write the file whole: a kill leaves the old one or the new one."""
    nets = {"model": model, "average": average} | ({} if best is None else {"best": best})
    tensors = {f"{name}/{k}": v for name, net in nets.items() for k, v in net.state_dict().items()}
    for index, moments in optimiser.state_dict()["state"].items():
        tensors |= {f"adam/{index}/{k}": v for k, v in moments.items()}
    state = json.dumps(dataclasses.asdict(progress))  # Python writes floats so that they read back exactly
    with whole(path) as temporary:
        save_file({k: v.detach().cpu().contiguous().clone() for k, v in tensors.items()}, temporary, {_STATE: state})


def read(
    path: Path, model: nn.Module, average: nn.Module, optimiser: torch.optim.AdamW, best: nn.Module | None = None
) -> Progress:
    """Fill model, average, optimiser and best (if it is kept) from `path`; a fresh Progress where there is no file.

    Raises UnusableInput for a file that is damaged or belongs to another network.
    """
    if not path.exists():
        return Progress()
    try:
        with safe_open(path, framework="pt") as stored:
            tensors = {key: stored.get_tensor(key) for key in stored.keys()}  # noqa: SIM118 (no mapping)
            state = json.loads(stored.metadata()[_STATE])
        model.load_state_dict(_below("model/", tensors))
        average.load_state_dict(_below("average/", tensors))
        if best is not None:
            best.load_state_dict(_below("best/", tensors))
        _read_moments(optimiser, _below("adam/", tensors))
        curve = [LossRow(**row) for row in state.pop("curve")]
        return Progress(**state, curve=curve)
    except (SafetensorError, RuntimeError, KeyError, TypeError, ValueError) as error:
        raise UnusableInput(f"checkpoint {path} does not fit this training ({error}): remove it to start anew") from None


def name_of(inputs: object, files: Iterable[Path], code: str) -> str:
    """A name for an interrupted training, which changes with all that its weights depend on.

    `inputs` (settings, seed, ...) count by their `repr`, `files` by their bytes; `code` is a digest such as `source_digest`.
    """
    digest = hashlib.sha256(f"{inputs!r}\n{code}\n".encode())
    for path in files:
        digest.update(hashlib.sha256(path.read_bytes()).digest())
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


def _below(prefix: str, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
    return {key.removeprefix(prefix): value for key, value in tensors.items() if key.startswith(prefix)}


def _read_moments(optimiser: torch.optim.AdamW, moments: dict[str, Tensor]) -> None:
    state: dict[int, dict[str, Tensor]] = {}
    for key, value in moments.items():
        index, name = key.split("/")
        state.setdefault(int(index), {})[name] = value
    optimiser.load_state_dict({**optimiser.state_dict(), "state": state})
