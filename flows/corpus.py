"""The corpus in another size, as scenarios to train and test on, in a workspace of its own: `python -m flows corpus driving`."""

from pathlib import Path
from typing import Any

from prefect import flow

from flows import FlowFailed, workspace
from flows.bring_up import bring_up, by_a_sentence
from flows.rooms import placed

SIZES = Path("flows/sizes.yaml")
STAGES = ("corpus", "ingest")

_ROOM = Path(".drivegen/corpus")


@flow(name="corpus")
@by_a_sentence
def corpus(size: str, real: Path) -> str:
    """Simulate and ingest a size; returns the folder of its scenarios. DVC's cache spares the simulation a second time."""
    room, params = _ROOM / size, overrides(size, real)
    with workspace.alone(f"corpus-{size}"):
        workspace.renew(Path(), room, params)
        for stage in STAGES:
            bring_up(stage, room)
    return str(room / "data/scenarios")


def overrides(size: str, real: Path) -> dict[str, Any]:
    """What differs from params.yaml in a size, by dotted names; `real` is the folder of real data.

    Raises FlowFailed, naming the sizes that there are, for another one.
    """
    sizes = workspace.read_yaml(SIZES)
    if size not in sizes:
        raise FlowFailed(f"{SIZES} has no size {size!r}; there are {', '.join(sizes)}")
    folder = str(real.resolve()) if real.is_dir() else ""
    return {name: placed(value, folder) for name, value in sizes[size].items()}
