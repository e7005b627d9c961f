"""The protocol of a map writer: words in, a map out, with an account of what was understood."""

from collections.abc import Set
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from drivegen.maps.examine import WrittenNetwork
from drivegen.maps.spec import MapSpec

if TYPE_CHECKING:
    from drivegen.lm.model import LanguageModel


@dataclass(frozen=True)
class Understanding:
    """What a writer made of a description.

    Attributes:
        spec: the map: a typed specification or, from a writer of XML, the network itself.
        understood: phrases of the description and what each was taken to mean.
        assumed: what the description leaves open and the writer chose.
        ignored: words that were not understood and change nothing.
        writer: who wrote it, as it stands in tables: not always whom one asked.
        repairs: how often it went back to its writer with what was wrong.
    """

    spec: MapSpec | WrittenNetwork
    understood: tuple[tuple[str, str], ...]
    assumed: tuple[str, ...]
    ignored: tuple[str, ...]
    writer: str
    repairs: int = 0


class MapWriter(Protocol):
    """Turns descriptions into specifications. `Plugin(model)` makes one; a writer that asks no language model ignores it."""

    @property
    def description(self) -> str:
        """Who writes, as it stands in tables, e.g. "offline rules (no language model)"."""

    def __init__(self, model: "LanguageModel | None" = None) -> None: ...

    def write(self, text: str, seed: int, vehicle_words: Set[str] = frozenset()) -> Understanding:
        """The map that `text` describes; `vehicle_words` were understood by whoever reads vehicles, so are not ignored.

        The same text and seed give the same specification. Raises UnusableInput, saying what can be asked for, where
        the text describes no road, an impossible one, or one that this writer is not sure about.
        """
