"""What published tables were made from and what they lack: the runs, their code, the versions of libraries."""

from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path
from typing import Any

from drivegen.store.results import run_id
from drivegen.warehouse.runs import METRICS, read_codes

_PINNED = ("drivegen", "numpy", "torch", "libsumo", "numba")


def describe_runs(runs: Path, expected: Iterable[str]) -> dict[str, Any]:
    """Hash and code of each run of `expected` (paths below `runs`), those that are missing, versions.

    Neither times nor paths of this machine, so the same runs give the same bytes.
    """
    names = list(expected)
    present = {name: runs / name for name in sorted(names) if (runs / name / METRICS).is_dir()}
    return {
        "runs": {name: run_id({}, [place / METRICS]) for name, place in present.items()},
        "code": read_codes(present),
        "runs_missing": [name for name in names if name not in present],
        "versions": {name: version(name) for name in _PINNED},
    }
