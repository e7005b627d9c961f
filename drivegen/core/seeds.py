"""One seed in, independent streams out: a stream depends on words, never on order, process or thread.

>>> int(rng(7, "rollout", "scenario-3").integers(1000)) == int(rng(7, "rollout", "scenario-3").integers(1000))
True
"""

import hashlib

import numpy as np

LARGEST = 2**63 - 1
"""Of a seed: larger ones do not fit the rows of tables."""


def derive(seed: int, *words: str | int) -> int:
    """A 63-bit seed for the stream named by `words`; independent of PYTHONHASHSEED."""
    text = "\x1f".join([str(seed), *map(str, words)])
    raw = text.encode(errors="surrogateescape")  # words from a command line may be bytes that are no UTF-8
    return int.from_bytes(hashlib.sha256(raw).digest()[:8], "big") >> 1


def rng(seed: int, *words: str | int) -> np.random.Generator:
    """The random generator of the stream named by `words`."""
    return np.random.default_rng(derive(seed, *words))
