"""Collisions of a driver that were pictured: for each a picture (PNG), words (TXT) and where its traffic lies (JSON).

They lie in `<round>/collisions/<number>.*` below the folder of corner cases.
"""

from dataclasses import asdict, dataclass
from pathlib import Path

import orjson

from drivegen.core.errors import UnusableInput
from drivegen.core.settings import build
from drivegen.store.files import write_bytes, write_json

FOLDER = "collisions"


@dataclass(frozen=True)
class Where:
    """A collision's place in its round: `shard` is the file of its scenario, `step` that of the impact."""

    scenario_id: str
    shard: str
    sample: int
    partner: int
    step: int


@dataclass(frozen=True)
class Pictured:
    """A pictured collision: `path` without suffix, what the picture shows in `words`."""

    path: Path
    where: Where
    words: str

    @property
    def name(self) -> str:
        """E.g. "corner-2-0": the first picture of round 2."""
        return f"corner-{self.path.parent.parent.name}-{self.path.name}"

    @property
    def title(self) -> str:
        """The same for a reader."""
        return f"Round {self.path.parent.parent.name}, collision {int(self.path.name) + 1}"


def write_pictured(path: Path, png: bytes, words: str, where: Where) -> None:
    """`path`.png, `path`.txt and `path`.json."""
    write_bytes(path.with_suffix(".png"), png)
    write_bytes(path.with_suffix(".txt"), words.encode())
    write_json(path.with_suffix(".json"), asdict(where))


def read_pictured(corner: Path) -> list[Pictured]:
    """All that the rounds below `corner` hold, the last round first; none where there is no such folder.

    A folder whose name is no number, such as a copy of a round, is none.

    Raises UnusableInput, naming the file, for one that does not say where its traffic lies.
    """
    rounds = [folder for folder in corner.glob(f"*/{FOLDER}") if folder.parent.name.isdecimal()]
    rounds.sort(key=lambda folder: int(folder.parent.name), reverse=True)
    return [_pictured(file) for folder in rounds for file in sorted(folder.glob("*.json"), key=lambda file: int(file.stem))]


def _pictured(file: Path) -> Pictured:
    try:
        where = build(Where, orjson.loads(file.read_bytes()), str(file))
    except orjson.JSONDecodeError as error:
        raise UnusableInput(f"{file} is not JSON: remove its round and run the corner stage again", reason="truncated") from error
    return Pictured(file.with_suffix(""), where, file.with_suffix(".txt").read_text(encoding="utf-8"))
