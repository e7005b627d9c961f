"""The protocol of a data set: list scenes, read one. `Plugin(root)` opens the data set below a folder."""

from pathlib import Path
from typing import Protocol

from drivegen.core.errors import UnusableInput
from drivegen.core.recorded_log import RecordedLog
from drivegen.core.scenario import SPLITS


def expect_splits(root: Path, what: str, parts: str) -> None:
    """Raise UnusableInput unless `root` has the folder of a split of `what`, each with such `parts`."""
    if not any((root / split).is_dir() for split in SPLITS):
        raise UnusableInput(f"{root} holds no {what}: it needs train/, val/ or test/ with {parts}")


def id_of(scene: str) -> str:
    """The scenario's id of a scene, which is its name without the colons: it names folders."""
    return scene.replace(":", "-")


class Dataset(Protocol):
    """Recordings below one folder.

    Attributes:
        description: the data set in words, as it stands in every table.
    """

    description: str

    def __init__(self, root: Path) -> None:
        """Raises UnusableInput, naming the folder and the expected layout, where `root` holds no such data set."""

    def scenes(self, split: str) -> list[str]:
        """Names of the scenes of "train", "val" or "test", sorted; empty if the split is absent."""

    def read(self, split: str, scene: str) -> RecordedLog:
        """One recording, its id `id_of(scene)`. Raises UnusableInput with a countable reason where the file cannot be used."""

    def files(self, split: str, scene: str) -> tuple[Path, ...]:
        """The files that a scene is read from: when their bytes change, what was made from it is made again."""
