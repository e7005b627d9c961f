"""The latent space of a flow: whitened principal components of groups of spline coefficients, and drawing from it."""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from drivegen.planners.shared.flow import FlowNet
from drivegen.store.columns import mapped
from drivegen.training import loop

CHUNK = {"cpu": 256, "cuda": 8192}
"""Requests that go through the network at once, always: sums differ between batch sizes."""

ROWS = 2**16
"""Rows of coefficients that are looked at at once."""

Basis = dict[str, NDArray[np.float64]]
"""`<group>_mean` (C,), `<group>_components` (K, C) and `<group>_scale` (K,) of every group, in the groups' order."""


def principal(coefficients: NDArray[np.float64], count: int, name: str) -> Basis:
    """Mean, the first `count` principal components of coefficients (E, C), and their standard deviations."""
    mean = coefficients.mean(axis=0)
    parts = (coefficients[low : low + ROWS] - mean for low in range(0, len(coefficients), ROWS))
    value, vector = np.linalg.eigh(sum(part.T @ part for part in parts) * np.true_divide(1, len(coefficients) - 1))
    components = vector[:, ::-1][:, :count].T
    components = components * np.sign(components[np.arange(count), np.abs(components).argmax(axis=1)])[:, None]
    scale = np.sqrt(np.maximum(value[::-1][:count], 1e-10))
    return {f"{name}_mean": mean, f"{name}_components": np.ascontiguousarray(components), f"{name}_scale": scale}


def whitened(coefficients: Mapping[str, NDArray[np.float64]], basis: Basis, folder: Path | None = None) -> Tensor:
    """Latents (E, Z) of the groups' coefficients (E, C), side by side; mapped from a file of `folder` where one is named."""
    count, size = len(next(iter(coefficients.values()))), sum(len(basis[f"{name}_scale"]) for name in coefficients)
    latents = mapped(folder, (count, size), np.float32)
    for low in range(0, count, ROWS):
        part, column = slice(low, low + ROWS), 0
        for name, fitted in coefficients.items():
            own = (fitted[part] - basis[f"{name}_mean"]) @ basis[f"{name}_components"].T / basis[f"{name}_scale"]
            latents[part, column : column + own.shape[1]] = own
            column += own.shape[1]
    return torch.from_numpy(latents)


def importance(names: tuple[str, ...], basis: Basis) -> Tensor:
    """Weight (Z,) of each latent in the loss: the root of its scale, so that what moves a vehicle most counts most."""
    parts = [np.sqrt(basis[f"{name}_scale"] / basis[f"{name}_scale"].max()) for name in names]
    weight = np.concatenate(parts)
    return torch.from_numpy(np.asarray(weight / weight.mean(), np.float32))


def expanded(latents: NDArray[np.float32], basis: Basis, name: str, table: NDArray[np.float64]) -> NDArray[np.float32]:
    """Curves (B, U) of a group's latents (B, K) through `table` (U, C); summed one by one: no row depends on another."""
    components = (basis[f"{name}_scale"][:, None] * basis[f"{name}_components"] @ table.T).astype(np.float32)
    curves = np.tile((table @ basis[f"{name}_mean"]).astype(np.float32), (len(latents), 1))
    for k, component in enumerate(components):
        curves += latents[:, k, None] * component
    return curves


def draw(net: FlowNet, inputs: NDArray[np.float32], noise: NDArray[np.float32], steps: int) -> NDArray[np.float32]:
    """Latents (B, Z) from features (B, F) and noise (B, Z), see `in_chunks`."""
    return in_chunks(net, lambda features, z: net.sample(features, z, steps), inputs, noise)


def in_chunks(net: FlowNet, function: Callable[..., Tensor], *inputs: NDArray[np.float32]) -> NDArray[np.float32]:
    """(B, R) what `function` of `net` makes of inputs (B, ...), on this process's device, in chunks of one size.

    The last chunk is filled up with zeros. Bytes agree between batches on one device, not between devices.
    """
    torch.set_num_threads(1)
    device = loop.device()
    net.to(device)
    chunk, parts = CHUNK[device.type], []
    padded = [torch.zeros(chunk, a.shape[1]) for a in inputs]
    with torch.inference_mode():
        for low in range(0, max(len(inputs[0]), 1), chunk):
            count = min(chunk, len(inputs[0]) - low)
            for buffer, array in zip(padded, inputs, strict=True):
                buffer[:count] = torch.from_numpy(array[low : low + count])
                buffer[count:] = 0
            parts.append(function(*(buffer.to(device) for buffer in padded))[:count].cpu().numpy())
    return np.concatenate(parts)
