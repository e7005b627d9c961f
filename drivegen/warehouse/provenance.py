"""What published tables were made from and what they lack: the runs, their code, the versions of libraries."""

from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path
from typing import Any

from drivegen.store.results import run_id
from drivegen.warehouse.runs import METRICS, PIECES, read_codes

_PINNED = ("drivegen", "numpy", "torch", "libsumo", "numba")


def describe_runs(runs: Path, expected: Iterable[str]) -> dict[str, Any]:
    """Hash and code of each run of `expected` (paths below `runs`), those that are missing, versions.

    Neither times nor paths of this machine, so the same runs give the same bytes.
    """
    names = list(expected)
    results = {name: [folder for part in (METRICS, PIECES) if (folder := runs / name / part).is_dir()] for name in sorted(names)}
    present = {name: runs / name for name, folders in results.items() if folders}
    return {
        "runs": {name: run_id({}, results[name]) for name in present},
        "code": read_codes(present),
        "runs_missing": [name for name in names if name not in present],
        "versions": {name: version(name) for name in _PINNED},
    }
