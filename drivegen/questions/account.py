"""Whom to ask a model about, what its ranking is worth as odds, and the account of both."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray


def odds(ranked: Sequence[NDArray[np.intp]], usual: NDArray[np.float32], decay: float, trust: float) -> NDArray[np.float32]:
    """Probabilities (C,) from a ranking of places: a declared mixture, not what the model believes, which it never said.

    The share `trust` goes to the ranked ones, each `decay` times the one before and within each to its candidates, which are
    what `ranked` holds, as `usual` (C,) has them; the rest goes as `usual`.
    """
    weights = decay ** np.arange(len(ranked), dtype=np.float64)
    weights /= weights.sum()
    odds_of_model = np.zeros(len(usual))
    for weight, members in zip(weights.tolist(), ranked, strict=True):
        within = usual[members].astype(np.float64)
        odds_of_model[members] = weight * (within / within.sum() if within.any() else 1 / len(members))
    mixed = trust * odds_of_model + (1 - trust) * usual.astype(np.float64)
    return np.asarray(mixed / mixed.sum(), np.float32)


def worth_asking(
    usual: Sequence[NDArray[np.float32]], exclusive: NDArray[np.bool_], of: Sequence[int], share: float, lot: float
) -> NDArray[np.intp]:
    """The `share` of the vehicles `of`, in order, about which the usual odds know least or whose goals matter most to others.

    Uncertainty is entropy over that of a uniform choice; stake is the expected number of others whose goals exclude the
    vehicle's own, `exclusive` (Q, Q), at most 1. What is left of a whole number of vehicles is settled by `lot` in [0, 1).
    """
    counts = [len(p) for p in usual]
    p = np.concatenate(usual).astype(np.float64)
    own = np.repeat(np.arange(len(usual)), counts)
    stake = np.bincount(own, p * (exclusive @ p), len(usual))
    entropy = -np.bincount(own, p * np.log(np.maximum(p, 1e-12)), len(usual))
    doubt = entropy / np.log(np.maximum(counts, 2))
    able = np.array(of, np.intp)
    worth = (doubt + np.minimum(stake, 1.0))[able]
    return np.sort(able[np.argsort(-worth, kind="stable")[: int(share * len(able) + lot)]])


@dataclass
class Account:
    """What became of the vehicles that were to be ranked.

    Attributes:
        vehicles: all. asked: those that the model ranked. unasked: those that it was not to be asked about.
        fallback: reasons why the usual odds stand in for an answer. chosen: how often each number was ranked first.
        expected: how often it would have been by lot. place: sum of (number + 0.5) / candidates over first choices.
    """

    vehicles: int = 0
    asked: int = 0
    unasked: int = 0
    fallback: Counter[str] = field(default_factory=Counter)
    chosen: Counter[int] = field(default_factory=Counter)
    expected: dict[int, float] = field(default_factory=dict)
    place: float = 0.0

    def note(self, number: int, count: int) -> None:
        """The model ranked `number` of `count` first."""
        self.asked += 1
        self.chosen[number] += 1
        self.place += (number + 0.5) / count
        for k in range(count):
            self.expected[k] = self.expected.get(k, 0.0) + 1 / count

    def table(self) -> dict[str, Any]:
        """For JSON. `label_bias` is how far along its numbers the first choice is on average, less the half that chance gives."""
        table: dict[str, Any] = {
            "vehicles": self.vehicles,
            "asked": self.asked,
            "unasked": self.unasked,
            "fallback": dict(sorted(self.fallback.items())),
        }
        if self.asked:
            shares = {str(k): {"chosen": self.chosen[k], "by_lot": round(e, 3)} for k, e in sorted(self.expected.items())}
            table["label_bias"] = self.place / self.asked - 0.5
            table["label_bias_by_chance"] = float(1 / np.sqrt(12 * self.asked))
            table["numbers"] = shares
        return table
