"""Benchmarks, one file a part: each has `rows()`, which yields measured `Row`s in CPU seconds of this process.

A value and its reference are measured in the same run on the same input, so their ratio means something on any machine.
"""

import importlib
import pkgutil
from collections.abc import Iterator

from drivegen.bench._row import Row
from drivegen.errors import UnusableInput

__all__ = ["Row", "measure", "parts"]


def parts() -> list[str]:
    """Names of the benchmark files, sorted; files that begin with `_` are none."""
    return sorted(module.name for module in pkgutil.iter_modules(__path__) if not module.name.startswith("_"))


def measure(only: str = "") -> Iterator[Row]:
    """The rows of all parts, or of the part `only`. Raises UnusableInput for a name that is no part."""
    if only and only not in parts():
        raise UnusableInput(f"no benchmark is called {only!r}: choose one of {', '.join(parts())}")
    for name in [only] if only else parts():
        yield from importlib.import_module(f"drivegen.bench.{name}").rows()
