"""Benchmarks, one file a part: each has `rows()`, which yields measured `Row`s in CPU seconds of this process.

A value and its reference are measured in the same run on the same input, so their ratio means something on any machine.
"""

import importlib
import pkgutil
from collections.abc import Iterator
from types import ModuleType

from drivegen.bench._row import Row
from drivegen.core.errors import UnusableInput

__all__ = ["Row", "measure", "parts", "unmeasured"]


def parts() -> list[str]:
    """Names of the benchmark files, sorted; files that begin with `_` are none."""
    return sorted(module.name for module in pkgutil.iter_modules(__path__) if not module.name.startswith("_"))


def measure(only: str = "") -> Iterator[Row]:
    """The rows of all parts whose needs are met, or of the part `only`. Raises UnusableInput for a name that is no part."""
    if only and only not in parts():
        raise UnusableInput(f"no benchmark is called {only!r}: choose one of {', '.join(parts())}")
    for name in [only] if only else parts():
        part = importlib.import_module(f"drivegen.bench.{name}")
        if only or not _missing(part):
            yield from part.rows()


def unmeasured() -> list[str]:
    """A sentence for each part that needs what `make run` has not made yet."""
    named = [(name, _missing(importlib.import_module(f"drivegen.bench.{name}"))) for name in parts()]
    return [f"{name}: not measured, it needs {', '.join(missing)}: `make run` makes them" for name, missing in named if missing]


def _missing(part: ModuleType) -> list[str]:
    return [str(path) for path in getattr(part, "NEEDS", ()) if not path.exists()]
