"""One measured row, and the clock: CPU seconds of this process and its ended children, the best of several turns."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from drivegen.core.cpu import cpu_seconds


@dataclass(frozen=True)
class Row:
    """A measured figure beside its reference and its target.

    Attributes:
        name: what was measured, e.g. "raster 256x256".
        value, unit: e.g. 0.4 "ms" (smaller is better) or 9000 "trajectories per CPU-second" (larger is better).
        target: what is wanted, in the same unit; None for a figure that stands beside another one's target.
        smaller_is_better: whether the target is an upper bound.
        reference: the same by other means in the same run, None where there is nothing to compare with.
        reference_name: those means in words.
    """

    name: str
    value: float
    unit: str
    target: float | None
    smaller_is_better: bool
    reference: float | None = None
    reference_name: str = ""

    @property
    def passed(self) -> bool:
        """Whether the target, if any, is met."""
        if self.target is None:
            return True
        return self.value <= self.target if self.smaller_is_better else self.value >= self.target

    @property
    def ratio(self) -> float | None:
        """How many times better than the reference."""
        if self.reference is None:
            return None
        return self.reference / self.value if self.smaller_is_better else self.value / self.reference

    def as_json(self) -> dict[str, Any]:
        """The row as it is published."""
        names = ("name", "value", "unit", "reference", "reference_name", "ratio", "target")
        return {**{name: getattr(self, name) for name in names}, "pass": self.passed}


def best_cpu_seconds(work: Callable[[], Any], turns: int = 5) -> float:
    """CPU seconds of one call of `work`: the best of `turns`, after one call that pays for compilation and caches."""
    work()
    best = float("inf")
    for _ in range(turns):
        began = cpu_seconds()
        work()
        best = min(best, cpu_seconds() - began)
    return best
