"""The corpus in another size, as scenarios to train and test on, in a workspace of its own: `python -m flows corpus driving`."""

import shutil
from pathlib import Path
from typing import Any

import yaml
from prefect import flow, get_run_logger

from flows import pipeline, workspace
from flows.rooms import placed

SIZES = Path("flows/sizes.yaml")
STAGES = ("corpus", "ingest")

_ROOM = Path(".drivegen/corpus")


@flow(name="corpus")
def corpus(size: str, real: Path) -> str:
    """Simulate and ingest a size; returns the folder of its scenarios. DVC's cache spares the simulation a second time."""
    room = _ROOM / size
    shutil.rmtree(room, ignore_errors=True)
    workspace.duplicate(Path(), room, overrides(size, real))
    for stage in STAGES:
        pipeline.reproduce(stage, get_run_logger().info, room)
    return str(room / "data/scenarios")


def overrides(size: str, real: Path) -> dict[str, Any]:
    """What differs from params.yaml in a size, by dotted names; `real` is the folder of real data.

    Raises KeyError, naming the sizes that there are, for another one.
    """
    sizes = yaml.safe_load(SIZES.read_text())
    if size not in sizes:
        raise KeyError(f"{SIZES} has no size {size!r}; there are {', '.join(sizes)}")
    folder = str(real.resolve()) if real.is_dir() else ""
    return {name: placed(value, folder) for name, value in sizes[size].items()}
