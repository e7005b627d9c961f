"""What the stages measured, read from their folders: results (JSON) and training curves (CSV)."""

from pathlib import Path
from typing import Any

import orjson

from drivegen.core.errors import UnusableInput
from drivegen.report.evidence import Curve
from drivegen.warehouse.runs import read_curve


def read_results(folder: Path) -> dict[str, Any]:
    """Contents of all JSON files below `folder`, by path without suffix; none where there is no such folder.

    Raises UnusableInput, naming the file, for one that is not JSON.
    """
    return {_name(folder, file): _read_json(file) for file in sorted(folder.rglob("*.json"))}


def read_curves(folder: Path) -> tuple[Curve, ...]:
    """All training curves below `folder`, titled by path without suffix; none where there is no such folder."""
    return tuple(Curve(_name(folder, file), read_curve(file)) for file in sorted(folder.rglob("*.csv")))


def _name(folder: Path, file: Path) -> str:
    return file.relative_to(folder).with_suffix("").as_posix()


def _read_json(file: Path) -> Any:
    try:
        return orjson.loads(file.read_bytes())
    except orjson.JSONDecodeError as error:
        raise UnusableInput(f"{file} is not JSON: remove it and run its stage again", reason="truncated") from error
