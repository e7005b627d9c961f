"""One training loop for every network here: plain torch, seeded, resumable, on one device or several (torchrun).

AdamW with linear warm-up and cosine decay, an exponential moving average of the weights (which is what is kept),
clipped gradients, budgets in optimiser steps. Everything random is a function of (seed, step): the order of the
examples, the noise of the loss, dropout. So training that was killed goes on from its checkpoint to the same bytes, and
with W processes each takes its W-th part of the very batch that one process would have taken.
"""

import copy
import math
import os
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any, Generic, Protocol, Self, TypeVar

import numpy as np
import torch
import torch.distributed as dist
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn.parallel import DistributedDataParallel
from torch.optim.swa_utils import get_ema_multi_avg_fn

from drivegen.core import seeds
from drivegen.core.errors import UnusableInput
from drivegen.core.settings import Count, Index, NotNegative, Positive, Share
from drivegen.training import checkpoint
from drivegen.training.curve import LossRow, kept

Net = TypeVar("Net", bound=nn.Module)

LATE = {"cpu": 1, "cuda": 32}
"""Steps after which their losses are read: a GPU works on while the next batches are made."""


@dataclass(frozen=True)
class Settings:
    """How to train.

    Attributes:
        steps: optimiser steps, the whole budget. batch: examples per step, over all processes together.
        learning_rate: the highest; reached after `warmup` steps, then a cosine down to zero, or held if not `decay`.
        weight_decay: AdamW's. average: decay of the moving average of the weights, 0 for none.
        clip: highest norm of the gradient. bf16: autocast of the forward pass to bfloat16.
        report_every: steps between rows of the loss curve. checkpoint_every: steps between checkpoints.
    """

    steps: Count
    batch: Count
    learning_rate: Positive
    warmup: Index
    decay: bool
    weight_decay: NotNegative
    average: Share
    clip: Positive
    bf16: bool
    report_every: Count
    checkpoint_every: Count


class Objective(Protocol):
    """What is minimised over `size` examples, as the mean over the rows of a batch."""

    size: int

    def draw(self, rows: int, generator: torch.Generator) -> tuple[Tensor, ...]:
        """The random numbers of a batch of `rows` examples: tensors on the CPU with `rows` as first dimension."""

    def loss(self, model: nn.Module, rows: Tensor, *drawn: Tensor) -> Tensor:
        """Mean loss (scalar) over the examples `rows` (b,) with their random numbers."""

    def validation(self, model: nn.Module) -> float:
        """Loss on the validation examples, the same noise at each call; NaN if there are none."""


def device() -> torch.device:
    """This process's GPU if there is one, else the CPU."""
    if not torch.cuda.is_available():
        return torch.device("cpu")
    return torch.device("cuda", int(os.environ.get("LOCAL_RANK", "0")))


def train(
    model: Net,
    objective: Objective,
    settings: Settings,
    seed: int,
    path: Path | None,
    report: Callable[[str], None],
    keep_best: bool = False,
    probe: Callable[[Net], float] | None = None,
) -> tuple[Net, list[LossRow]]:
    """Train `model`, already on its device; returns the averaged copy and the loss curve.

    With `keep_best` the copy is that of the row `curve.kept`, else the last one.
    `probe` is asked for each row's `error` of the averaged network, in evaluation mode.

    With `path`, progress is kept there every `checkpoint_every` steps and taken up from there; the file of a training
    that ended well is left to the caller to remove. Raises UnusableInput where there is nothing to learn from, and as soon as
    the loss is not finite.
    """
    if objective.size == 0:
        raise UnusableInput("there is no example to learn from", reason="no-examples")
    torch.set_num_threads(1)  # sums depend on the number of threads
    torch.backends.cudnn.deterministic = True  # and on the kernels of convolutions, which a GPU else chooses as it likes
    run = _Run(model, objective, settings, seed, keep_best)
    if path is not None:
        run.progress = Progress.of(checkpoint.read(path, run.parts))
    if run.progress.step:
        report(f"going on from step {run.progress.step}")
    while run.progress.step < settings.steps:
        run.step()
        done = run.progress.step
        if done % settings.report_every == 0 or done == settings.steps:
            row = run.close_row(probe)
            report(f"step {done}/{settings.steps} loss {row.train:.4f} validation {row.validation:.4f}")
        if path is not None and run.rank == 0 and done % settings.checkpoint_every == 0:
            run.count()
            checkpoint.write(path, run.parts, asdict(run.progress))
    return run.averaged if run.best is None else run.best, run.progress.curve


@dataclass
class Progress:
    """How far training has come: optimiser steps done, the curve, and the sum of the losses since its last row."""

    step: int = 0
    since: int = 0
    loss_since: float = 0.0
    curve: list[LossRow] = field(default_factory=list)

    @classmethod
    def of(cls, state: dict[str, Any] | None) -> Self:
        """What `asdict` made of it; none yet where that is None."""
        if state is None:
            return cls()
        return cls(state["step"], state["since"], state["loss_since"], [LossRow(**row) for row in state["curve"]])


class _Run(Generic[Net]):
    """One training under way."""

    def __init__(self, model: Net, objective: Objective, settings: Settings, seed: int, keep_best: bool) -> None:
        self.objective, self.settings, self.seed = objective, settings, seed
        self.device = next(model.parameters()).device
        self.rank, self.world = _join(self.device)
        if settings.batch % self.world:
            raise UnusableInput(f"a batch of {settings.batch} cannot be shared by {self.world} processes")
        self.model = model
        self.parallel: nn.Module = DistributedDataParallel(model) if self.world > 1 else model
        self.averaged = copy.deepcopy(model)
        self.averaged.requires_grad_(False)
        self.best = copy.deepcopy(self.averaged) if keep_best else None
        self.optimiser = torch.optim.AdamW(
            model.parameters(), lr=settings.learning_rate, weight_decay=settings.weight_decay, foreach=True
        )
        self.progress = Progress()
        self._uncounted: list[Tensor] = []

    @property
    def parts(self) -> dict[str, checkpoint.Part]:
        """What the next step depends on, beside the progress."""
        best = {} if self.best is None else {"best": self.best}
        return {"model": self.model, "average": self.averaged, "adam": self.optimiser, **best}

    def step(self) -> None:
        """One optimiser step."""
        settings, done = self.settings, self.progress.step
        for group in self.optimiser.param_groups:
            group["lr"] = settings.learning_rate * _rate(settings, done)
        rows = batch_rows(self.objective.size, settings.batch, self.seed, done)
        generator = torch.Generator().manual_seed(seeds.derive(self.seed, "noise", done))
        noise = self.objective.draw(len(rows), generator)
        mine = slice(self.rank * len(rows) // self.world, (self.rank + 1) * len(rows) // self.world)
        torch.manual_seed(seeds.derive(self.seed, "dropout", done, self.rank))
        self.model.train()
        with self._autocast():
            loss = self.objective.loss(self.parallel, rows[mine].to(self.device), *(d[mine].to(self.device) for d in noise))
        self.optimiser.zero_grad(set_to_none=True)
        loss.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(self.model.parameters(), settings.clip)
        self.optimiser.step()
        self._average()
        self._uncounted.append(self._mean(loss.detach()))
        self.progress.step += 1
        if len(self._uncounted) == LATE[self.device.type]:
            self.count()

    def count(self) -> None:
        """Add up the losses of the last steps."""
        losses = torch.stack(self._uncounted).cpu().tolist() if self._uncounted else []
        for step, loss in enumerate(losses, self.progress.step - len(losses) + 1):
            self.progress.loss_since += self._finite(loss, step)
        self.progress.since += len(losses)
        self._uncounted = []

    def close_row(self, probe: Callable[[Net], float] | None) -> LossRow:
        """Add the row of the loss curve that ends at this step."""
        self.count()
        progress = self.progress
        self.averaged.eval()
        with torch.no_grad():
            validation = self.objective.validation(self.averaged)
        error = float("nan") if probe is None else probe(self.averaged)
        row = LossRow(progress.step, progress.loss_since / progress.since, validation, error)
        progress.curve.append(row)
        if self.best is not None and kept(progress.curve) is row:
            self.best.load_state_dict(self.averaged.state_dict())
        progress.since, progress.loss_since = 0, 0.0
        return row

    def _average(self) -> None:
        """Move the average towards the weights; early on faster, so that it forgets where it started."""
        decay = min(self.settings.average, (1 + self.progress.step) / (10 + self.progress.step))
        move = get_ema_multi_avg_fn(decay)  # type: ignore[no-untyped-call]
        move(list(self.averaged.parameters()), [p.detach() for p in self.model.parameters()], self.progress.step)
        for mine, theirs in zip(self.averaged.buffers(), self.model.buffers(), strict=True):
            mine.copy_(theirs)

    def _autocast(self) -> torch.autocast | nullcontext[None]:
        return torch.autocast(self.device.type, torch.bfloat16) if self.settings.bf16 else nullcontext()

    def _finite(self, loss: float, step: int) -> float:
        if not math.isfinite(loss):
            when, rate = f"step {step} of {self.settings.steps}", f"{self.settings.learning_rate:g}"
            raise UnusableInput(
                f"training stopped: the loss is {loss} at {when}; lower learning_rate ({rate}) or raise warmup",
                reason="not-finite",
            )
        return loss

    def _mean(self, loss: Tensor) -> Tensor:
        if self.world > 1:
            dist.all_reduce(loss)
        return loss / self.world


def batch_rows(size: int, batch: int, seed: int, step: int) -> Tensor:
    """Example numbers (batch,) of one step: the endless chain of shuffled epochs, cut into batches."""
    first = step * batch
    epochs = range(first // size, (first + batch - 1) // size + 1)
    begin, parts = first - epochs[0] * size, [_order(size, seed, epoch) for epoch in epochs]
    chain = [part[max(begin - k * size, 0) : begin - k * size + batch] for k, part in enumerate(parts)]
    return torch.from_numpy(np.concatenate(chain).astype(np.int64))


@lru_cache(maxsize=2)
def _order(size: int, seed: int, epoch: int) -> NDArray[np.integer]:
    """Example numbers (size,) of one epoch; kept, as the next batch asks for it again, in as few bytes as will do."""
    kind = np.int32 if size < 2**31 else np.int64
    return seeds.rng(seed, "order", epoch).permutation(np.arange(size, dtype=kind))


def _rate(settings: Settings, done: int) -> float:
    """Share of the highest learning rate."""
    warm = min(1.0, (done + 1) / max(settings.warmup, 1))
    return warm * (0.5 + 0.5 * float(np.cos(np.pi * done / settings.steps)) if settings.decay else 1.0)


def _join(device: torch.device) -> tuple[int, int]:
    """Rank and number of processes; joins torchrun's group if this process, which trains on `device`, was started by it."""
    world = int(os.environ.get("WORLD_SIZE", "1"))
    if world > 1 and not dist.is_initialized():
        dist.init_process_group("nccl" if device.type == "cuda" else "gloo")
    return (dist.get_rank(), world) if world > 1 else (0, 1)
