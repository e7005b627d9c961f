"""What published tables were made from and what they lack: the runs, their code, the versions of libraries."""

from collections.abc import Iterable, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from drivegen.store.results import run_id
from drivegen.warehouse.runs import METRICS, PIECES, read_codes

_PINNED = ("drivegen", "numpy", "torch", "libsumo", "numba")


def describe_runs(runs: Path, expected: Iterable[str], shown: Sequence[Path] = (METRICS,)) -> dict[str, Any]:
    """Hash and code of each run of `expected` (paths below `runs`), those that are missing, versions.

    A run is there if any of what is `shown` of it is: one that was stopped on the way has other results, too.
    Neither times nor paths of this machine, so the same runs give the same bytes.
    """
    names = list(expected)
    present = {name: runs / name for name in sorted(names) if any((runs / name / part).exists() for part in shown)}
    results = {name: [place / part for part in (METRICS, PIECES) if (place / part).is_dir()] for name, place in present.items()}
    return {
        "runs": {name: run_id({}, folders) for name, folders in results.items()},
        "code": read_codes(present),
        "runs_missing": [name for name in names if name not in present],
        "versions": {name: version(name) for name in _PINNED},
    }
