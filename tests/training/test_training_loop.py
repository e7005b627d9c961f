"""The training loop learns, resumes after a kill to the same bytes, and shares a batch between processes."""

import os
import random
import shutil
import signal
import socket
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import settings as examples
from hypothesis import strategies as st
from safetensors.torch import load_file, save_file
from torch import Tensor, nn

from drivegen.core.errors import UnusableInput
from drivegen.training import loop, weights
from drivegen.training.curve import LossRow, kept, plateau
from drivegen.training.loop import Settings, batch_rows, train
from drivegen.training.weights import SETTINGS as SETTINGS_FILE
from drivegen.training.weights import WEIGHTS, read_weights, write_weights

ROOT = Path(__file__).parents[2]
SETTINGS = Settings(
    steps=60,
    batch=32,
    learning_rate=1e-2,
    warmup=5,
    decay=True,
    weight_decay=1e-3,
    average=0.9,
    clip=1.0,
    bf16=False,
    report_every=20,
    checkpoint_every=7,
)


class NoisyCosine:
    """Learn cos(x) of noisy x: an objective that uses rows, noise and (through the network) dropout."""

    size = 100

    def __init__(self, pause: float = 0.0) -> None:
        self.x, self.pause = torch.linspace(-3, 3, self.size)[:, None], pause

    def draw(self, rows: int, generator: torch.Generator) -> tuple[Tensor, ...]:
        return (0.01 * torch.randn(rows, 1, generator=generator),)

    def loss(self, model: nn.Module, rows: Tensor, *drawn: Tensor) -> Tensor:
        time.sleep(self.pause)
        return (model(self.x[rows] + drawn[0]) - self.x[rows].cos()).square().mean()

    def validation(self, model: nn.Module) -> float:
        return float((model(self.x) - self.x.cos()).square().mean())


def net(dropout: float = 0.1) -> nn.Module:
    torch.manual_seed(3)
    return nn.Sequential(nn.Linear(1, 32), nn.SiLU(), nn.Dropout(dropout), nn.Linear(32, 1))


def run(out: Path, path: Path | None, pause: float = 0.0, dropout: float = 0.1) -> None:
    """What the subprocesses of these tests run: train and write the averaged weights."""
    model, curve = train(net(dropout), NoisyCosine(pause), SETTINGS, 5, path, lambda line: None)
    save_file(model.state_dict(), out)
    out.with_suffix(".curve").write_text(repr(curve))


def start(out: Path, path: str, pause: float = 0.0, dropout: float = 0.1, **environment: str) -> "subprocess.Popen[bytes]":
    code = f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r}); from pathlib import Path; "
    code += f"from test_training_loop import run; run(Path({str(out)!r}), {path}, {pause}, {dropout})"
    return subprocess.Popen([sys.executable, "-c", code], cwd=ROOT, env={**os.environ, "OMP_NUM_THREADS": "1", **environment})


class Level(nn.Module):
    """One number."""

    def __init__(self) -> None:
        super().__init__()
        self.level = nn.Parameter(torch.zeros(1))


class Fall:
    """The level is to fall, by a slope that is steep at first; Adam's steps tell only by how slopes change."""

    size = 4

    def __init__(self) -> None:
        self.slopes = iter([100.0, 1.0, 1.0, 1.0])

    def draw(self, rows: int, generator: torch.Generator) -> tuple[Tensor, ...]:
        return ()

    def loss(self, model: nn.Module, rows: Tensor, *drawn: Tensor) -> Tensor:
        return next(self.slopes) * next(model.parameters()).sum()

    def validation(self, model: nn.Module) -> float:
        return float("nan")


def test_steps_are_clipped_warm_up_and_decay_and_the_average_soon_forgets_where_it_began() -> None:
    shape = replace(SETTINGS, steps=4, batch=2, learning_rate=0.1, warmup=2, weight_decay=0.0, clip=1.0, average=0.2)
    model = Level()
    averaged, _ = train(model, Fall(), shape, 5, None, lambda line: None)
    rates = [0.1 * warm * (0.5 + 0.5 * np.cos(np.pi * k / 4)) for k, warm in enumerate((0.5, 1, 1, 1))]
    assert model.level.item() == pytest.approx(-sum(rates), rel=1e-4)
    mean = 0.0
    for level, decay in zip(-np.cumsum(rates), (1 / 10, 2 / 11, 0.2, 0.2), strict=True):
        mean = decay * mean + (1 - decay) * level
    assert averaged.level.item() == pytest.approx(mean, rel=1e-4)
    held = Level()
    train(held, Fall(), replace(shape, decay=False), 5, None, lambda line: None)
    assert held.level.item() == pytest.approx(-0.35, rel=1e-4)


def test_training_lowers_the_loss_and_reports_a_curve() -> None:
    _, curve = train(net(0.0), NoisyCosine(), replace(SETTINGS, steps=200), 5, None, lambda line: None)
    assert [row.step for row in curve] == list(range(20, 201, 20))
    assert curve[-1].validation < 0.2 * curve[0].validation


@pytest.mark.parametrize(
    ("errors", "expected"),
    [
        ((9, 8, 5, 4.0, 4.1, 3.97), True),  # 0.75 % less in the last third: no gain
        ((9, 8, 5, 4.0, 4.1, 3.9), False),
        ((9, 8, 5, 4.0, 5.0, 6.0), True),  # it gets worse
        ((9, 8, 5, 4.0, float("nan"), 3.9), None),
        ((9, 4.0, 3.0), None),  # a last third of one row
        ((), None),
    ],
)
def test_a_plateau_is_a_last_third_without_gain(errors: tuple[float, ...], expected: bool | None) -> None:
    rows = [LossRow(100 * n, 0.0, 0.0, error) for n, error in enumerate(errors, 1)]
    assert plateau(rows) is expected


def test_a_probe_is_asked_of_the_averaged_network_at_every_row_and_changes_nothing() -> None:
    asked: list[float] = []

    def probe(averaged: nn.Module) -> float:
        assert not averaged.training
        asked.append(NoisyCosine().validation(averaged))
        return asked[-1]

    watched, rows = train(net(), NoisyCosine(), SETTINGS, 5, None, lambda line: None, probe=probe)
    alone, plain = train(net(), NoisyCosine(), SETTINGS, 5, None, lambda line: None)
    assert [row.error for row in rows] == asked == [row.validation for row in rows]
    assert np.isnan([row.error for row in plain]).all()
    for mine, theirs in zip(watched.parameters(), alone.parameters(), strict=True):
        assert torch.equal(mine, theirs)


def test_training_killed_at_a_random_step_resumes_to_the_same_bytes(tmp_path: Path) -> None:
    run(tmp_path / "whole.safetensors", None)
    checkpoint = tmp_path / "checkpoint.safetensors"
    killed = start(tmp_path / "resumed.safetensors", f"Path({str(checkpoint)!r})", pause=0.02)
    patience = time.monotonic() + 60
    while not checkpoint.exists() and time.monotonic() < patience:
        time.sleep(0.01)
    time.sleep(random.uniform(0.0, 0.5))
    killed.send_signal(signal.SIGKILL)
    assert killed.wait() == -signal.SIGKILL
    assert not (tmp_path / "resumed.safetensors").exists()
    run(tmp_path / "resumed.safetensors", checkpoint)
    for suffix in (".safetensors", ".curve"):
        assert (tmp_path / f"resumed{suffix}").read_bytes() == (tmp_path / f"whole{suffix}").read_bytes()


class Rising(NoisyCosine):
    """Every look at the validation examples finds a higher loss, but for the second one."""

    def __init__(self) -> None:
        super().__init__()
        self.looks = 0

    def validation(self, model: nn.Module) -> float:
        self.looks += 1
        return -1.0 if self.looks == 2 else float(self.looks)


def test_the_best_weights_are_kept_also_across_a_resumption(tmp_path: Path) -> None:
    second = replace(SETTINGS, steps=40, decay=False)
    wanted, _ = train(net(), NoisyCosine(), second, 5, None, lambda line: None)
    path = tmp_path / "c.safetensors"
    constant = replace(SETTINGS, decay=False, checkpoint_every=50)
    best, curve = train(net(), Rising(), constant, 5, path, lambda line: None, keep_best=True)
    again, _ = train(net(), Rising(), constant, 5, path, lambda line: None, keep_best=True)
    assert [row.validation for row in curve] == [1.0, -1.0, 3.0]
    for model in (best, again):
        assert all(torch.equal(a, b) for a, b in zip(model.state_dict().values(), wanted.state_dict().values(), strict=True))


def test_where_an_error_is_asked_for_it_chooses_the_weights_and_not_the_loss() -> None:
    errors = iter([3.0, 1.0, 2.0, 1.0])
    constant = replace(SETTINGS, steps=80, decay=False)
    best, curve = train(net(), NoisyCosine(), constant, 5, None, lambda line: None, keep_best=True, probe=lambda _: next(errors))
    wanted, _ = train(net(), NoisyCosine(), replace(constant, steps=40), 5, None, lambda line: None)
    assert kept(curve) is curve[1]
    assert all(torch.equal(a, b) for a, b in zip(best.state_dict().values(), wanted.state_dict().values(), strict=True))


def test_the_last_weights_are_kept_where_nothing_tells_which_are_best() -> None:
    rows = [LossRow(10, 1.0, float("nan")), LossRow(20, 1.0, float("nan"))]
    assert kept(rows) is rows[-1]


def test_two_processes_get_equal_weights_that_agree_with_one(tmp_path: Path) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    group = {"WORLD_SIZE": "2", "MASTER_ADDR": "127.0.0.1", "MASTER_PORT": str(port)}
    ranks = [start(tmp_path / f"{r}.safetensors", "None", dropout=0.0, RANK=str(r), **group) for r in range(2)]
    assert [rank.wait(timeout=120) for rank in ranks] == [0, 0]
    run(tmp_path / "one.safetensors", None, dropout=0.0)
    one, first, second = (load_file(tmp_path / f"{name}.safetensors") for name in ("one", "0", "1"))
    for key, value in one.items():
        assert torch.equal(first[key], second[key])
        torch.testing.assert_close(first[key], value, rtol=1e-4, atol=1e-5)


def test_a_network_on_the_cpu_is_trained_by_processes_that_talk_on_the_cpu_whatever_gpu_there_is(monkeypatch) -> None:
    def join(backend: str) -> None:
        raise RuntimeError(backend)

    monkeypatch.setenv("WORLD_SIZE", "2")
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    monkeypatch.setattr(torch.distributed, "init_process_group", join)
    with pytest.raises(RuntimeError, match="gloo"):
        train(net(), NoisyCosine(), SETTINGS, 5, None, lambda line: None)


def test_a_damaged_checkpoint_is_named(tmp_path: Path) -> None:
    (tmp_path / "c.safetensors").write_bytes(b"half a file")
    with pytest.raises(UnusableInput, match=r"c\.safetensors.*remove it"):
        train(net(), NoisyCosine(), SETTINGS, 5, tmp_path / "c.safetensors", lambda line: None)


def test_a_checkpoint_of_another_network_is_refused(tmp_path: Path) -> None:
    run(tmp_path / "out.safetensors", tmp_path / "c.safetensors")
    other = nn.Sequential(nn.Linear(1, 8), nn.Linear(8, 1))
    with pytest.raises(UnusableInput, match="does not fit"):
        train(other, NoisyCosine(), SETTINGS, 5, tmp_path / "c.safetensors", lambda line: None)


def test_every_epoch_sees_every_example_once() -> None:
    rows = torch.cat([batch_rows(100, 32, 1, step) for step in range(25)])
    assert len(rows) == 800
    for epoch in range(8):
        assert sorted(rows[100 * epoch :][:100].tolist()) == list(range(100))


def test_a_batch_larger_than_the_examples_repeats_them() -> None:
    assert len(batch_rows(3, 10, 1, 0)) == 10


class Diverging(NoisyCosine):
    """A loss that is no number from the fourth step on."""

    steps = 0

    def loss(self, model: nn.Module, rows: Tensor, *drawn: Tensor) -> Tensor:
        self.steps += 1
        return super().loss(model, rows, *drawn) * (float("nan") if self.steps > 3 else 1.0)


def test_a_loss_that_is_not_finite_stops_the_training_with_one_sentence(tmp_path):
    with pytest.raises(UnusableInput, match=r"the loss is nan at step 4 of 60; lower learning_rate \(0.01\)"):
        train(net(), Diverging(), SETTINGS, 1, tmp_path / "kept.safetensors", lambda _: None)
    assert not (tmp_path / "kept.safetensors").exists()


def test_losses_that_are_read_late_are_the_same_losses(tmp_path, monkeypatch):
    _, at_once = train(net(), NoisyCosine(), SETTINGS, 5, tmp_path / "at-once.safetensors", lambda line: None)
    monkeypatch.setitem(loop.LATE, "cpu", 9)  # neither rows nor checkpoints come every nine steps
    _, late = train(net(), NoisyCosine(), SETTINGS, 5, tmp_path / "late.safetensors", lambda line: None)
    assert [row.train for row in late] == [row.train for row in at_once]
    assert (tmp_path / "late.safetensors").read_bytes() == (tmp_path / "at-once.safetensors").read_bytes()
    with pytest.raises(UnusableInput, match="the loss is nan at step 4 of 60"):
        train(net(), Diverging(), SETTINGS, 5, tmp_path / "kept.safetensors", lambda line: None)
    assert not (tmp_path / "kept.safetensors").exists()


def test_weights_that_are_not_finite_are_neither_written_nor_read(tmp_path, monkeypatch):
    good = {"a": np.zeros(3, np.float32)}
    write_weights(tmp_path / "good", "planner", "p", {}, good)
    with pytest.raises(UnusableInput, match="a has a number that is not finite"):
        write_weights(tmp_path / "bad", "planner", "p", {}, {"a": np.array([0, np.nan], np.float32)})
    assert not (tmp_path / "bad").exists()
    monkeypatch.setattr(weights, "check_finite", lambda *_: None)
    write_weights(tmp_path / "bad", "planner", "p", {}, {"a": np.array([1, np.inf], np.float32)})
    monkeypatch.undo()
    with pytest.raises(UnusableInput, match=r"weights\.safetensors: a has a number that is not finite: train it again"):
        read_weights(tmp_path / "bad", "planner", "p")


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    folder = tmp_path_factory.mktemp("good")
    tensors = {"a": np.arange(6, dtype=np.float32), "b": np.ones((2, 2), np.float32)}
    write_weights(folder, "planner", "p", {"width": 6, "temperature": 1.25}, tensors)
    return folder


def test_the_same_weights_are_the_same_bytes_and_come_back(good, tmp_path):
    settings, tensors = read_weights(good, "planner", "p")
    write_weights(tmp_path, "planner", "p", settings, tensors)
    assert settings == {"width": 6, "temperature": 1.25}
    assert tensors["a"].tolist() == list(range(6))
    for file in (SETTINGS_FILE, WEIGHTS):
        assert (tmp_path / file).read_bytes() == (good / file).read_bytes()


def test_settings_without_end_are_refused(good, tmp_path):
    shutil.copytree(good, tmp_path / "deep")
    (tmp_path / "deep" / SETTINGS_FILE).write_text("[" * 100_000)
    with pytest.raises(UnusableInput, match="deep holds a damaged planner"):
        read_weights(tmp_path / "deep", "planner", "p")


@given(file=st.sampled_from([SETTINGS_FILE, WEIGHTS]), place=st.floats(0, 1, exclude_max=True), bit=st.integers(0, 7))
@examples(max_examples=100, deadline=None)
def test_no_flipped_bit_of_weights_or_their_settings_is_taken(good, file, place, bit):
    flipped = good.with_name("flipped")
    shutil.copytree(good, flipped, dirs_exist_ok=True)
    raw = bytearray((good / file).read_bytes())
    raw[int(place * len(raw))] ^= 1 << bit
    (flipped / file).write_bytes(raw)
    with pytest.raises(UnusableInput, match="flipped"):
        read_weights(flipped, "planner", "p")
