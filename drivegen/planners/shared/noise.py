"""Gaussian noise by counter: number k of seed s is a function of (s, k) alone, so it never depends on the batch."""

import numpy as np
from numpy.typing import NDArray

GOLDEN = np.uint64(0x9E3779B97F4A7C15)
"""The step of splitmix64 from one state to the next."""


def normals(seed: NDArray[np.int64], count: int, stream: int = 0) -> NDArray[np.float32]:
    """(B, count) independent standard normals, row b from seed[b]; count must be even. Streams are independent, too.

    splitmix64 (Steele, Lea, Flood 2014) at positions 1..2 * count of each seed's stream, then Box and Muller's transform.
    """
    with np.errstate(over="ignore"):
        key = mixed(mixed(seed.astype(np.uint64)) + np.uint64(stream))
        state = key[:, None] + GOLDEN * np.arange(1, count + 1, dtype=np.uint64)
    uniform = (mixed(state) >> np.uint64(11)).astype(np.float64) * 2.0**-53
    radius = np.sqrt(-2.0 * np.log1p(-uniform[:, : count // 2]))
    angle = 2.0 * np.pi * uniform[:, count // 2 :]
    return np.concatenate([radius * np.cos(angle), radius * np.sin(angle)], axis=1).astype(np.float32)


def mixed(z: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """splitmix64's finaliser: the number that belongs to each state; states that differ in one bit have unlike numbers."""
    with np.errstate(over="ignore"):
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))
