"""The data sets that scenarios are made from: the folder of each, and how its recordings become scenarios."""

import hashlib
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from pathlib import Path

import orjson

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.datasets.base import Dataset
from drivegen.ingest.selection import Settings

CODE = (
    "core/*.py",
    "ingest/*.py",
    "av2/*.py",
    "commonroad/*.py",
    "datasets/*.py",
    "store/lists.py",
    "store/scenarios.py",
)
"""What decides how a recording becomes a row; when it changes, all shards are made again."""


@dataclass(frozen=True)
class Sources:
    """Data sets by name.

    Attributes:
        folders: of each data set. selection: how recordings become scenarios.
        horizons: the horizon of some data sets [steps], in place of the selection's.
    """

    folders: dict[str, Path]
    selection: Settings
    horizons: dict[str, int]

    def open(self, name: str) -> Dataset:
        """A data set; opened once in a process. Raises UnusableInput where its folder holds no such data."""
        return open_dataset(name, self.folders[name])

    def settings(self, name: str) -> Settings:
        """How recordings of this data set become scenarios."""
        return replace(self.selection, horizon=self.horizons.get(name, self.selection.horizon))

    def files(self, item: str) -> tuple[Path, ...]:
        """The files of `<data set>/<its split>/<scene>`; none where they are not there, for reading it says what is missing."""
        data, split, scene = self.scene(item)
        try:
            return data.files(split, scene)
        except UnusableInput:
            return ()

    def scene(self, item: str) -> tuple[Dataset, str, str]:
        """The opened data set, its split and the scene that `<data set>/<its split>/<scene>` names."""
        name, split, scene = item.split("/", 2)
        return self.open(name), split, scene

    def digest(self) -> str:
        """Hash of what decides, besides the files, how items become rows: settings and code."""
        total = hashlib.sha256(orjson.dumps([asdict(self.selection), self.horizons], option=orjson.OPT_SORT_KEYS))
        for path in sorted(code_files()):
            total.update(path.read_bytes())
        return total.hexdigest()


@lru_cache
def open_dataset(name: str, folder: Path) -> Dataset:
    """The data set `name` in `folder`, opened once in a process."""
    opened: Dataset = plugins.load("datasets", name)(folder)
    return opened


def code_files() -> Iterator[Path]:
    """The files of `CODE`."""
    package = Path(__file__).parents[1]
    return (path for pattern in CODE for path in package.glob(pattern))
