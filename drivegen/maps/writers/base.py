"""The protocol of a map writer: words in, a map out, with an account of what was understood."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from drivegen.layouts.spec import MapSpec
from drivegen.maps.examine import WrittenNetwork

if TYPE_CHECKING:
    from drivegen.lm.model import LanguageModel
    from drivegen.lm.prompt import Prompt

Contradictions = Callable[[str, MapSpec], list[str]]
"""What of a text a specification contradicts, as sentences."""


ROUNDS = 3
"""Rounds of repair by a language model at most."""


@dataclass(frozen=True)
class Understanding:
    """What a writer made of a description.

    Attributes:
        spec: the map: a typed specification or, from a writer of XML, the network itself.
        writer: who wrote it, as it stands in tables.
        understood: phrases of the description and what each was taken to mean.
        assumed: what the description leaves open and the writer chose.
        ignored: words that change nothing.
        sentences: the specification said back, where its writer speaks.
        repairs: how often it went back to its writer with what was wrong.
        contradictions: what of the description the specification contradicts even so.
    """

    spec: MapSpec | WrittenNetwork
    writer: str
    understood: tuple[tuple[str, str], ...] = ()
    assumed: tuple[str, ...] = ()
    ignored: tuple[str, ...] = ()
    sentences: tuple[str, ...] = ()
    repairs: int = 0
    contradictions: tuple[str, ...] = ()


class MapWriter(Protocol):
    """Turns descriptions into specifications."""

    @property
    def description(self) -> str:
        """Who writes, as it stands in tables, e.g. "phrase table (no language model)"."""

    def write(self, text: str, seed: int) -> Understanding:
        """The map that `text` describes.

        The same text and seed give the same specification. Raises UnusableInput, saying what can be asked for, where
        the text describes no road, an impossible one, or one that this writer is not sure about.
        """


class AskingMapWriter(MapWriter, Protocol):
    """A map writer that asks a language model: `Plugin(model, contradictions)`; it is held to what `contradictions` finds."""

    def __init__(self, model: "LanguageModel | None" = None, contradictions: Contradictions | None = None) -> None: ...

    def first_questions(self, texts: Iterable[str]) -> "list[Prompt[Any]]":
        """What is asked about descriptions at first."""
