"""The map writer that asks no language model: what `read.py` reads, as map writers give it."""

from typing import TYPE_CHECKING

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.maps.writers.base import AskingMapWriter, MapWriter, Understanding
from drivegen.words.facts import contradictions
from drivegen.words.read import READER, read
from drivegen.words.saying import sentences

if TYPE_CHECKING:
    from drivegen.lm.model import LanguageModel

OFFLINE = "offline"
"""The name of this writer in settings."""


class Writer:
    """See `MapWriter`: words by the phrase table."""

    description = READER

    def write(self, text: str, seed: int) -> Understanding:
        """See `MapWriter.write`. Traffic in the text is read, and left to whoever generates it."""
        words = read(text, seed)
        if words.road is None:
            raise UnusableInput(
                f"no road is described, only traffic\ntry: A road with two-way traffic. {' '.join(words.sentences())}",
                reason="not-understood",
            )
        return Understanding(words.road, self.description, sentences=tuple(sentences(words.road)))


def writer_called(name: str, model: "LanguageModel | None" = None) -> MapWriter:
    """The writer of a name: "offline", or a file in drivegen/maps/writers that asks `model`."""
    return Writer() if name == OFFLINE else asking_writer(name, model)


def asking_writer(name: str, model: "LanguageModel | None") -> AskingMapWriter:
    """The writer in a file of drivegen/maps/writers, held to what the phrase table reads in the text."""
    writer: AskingMapWriter = plugins.load("maps.writers", name)(model, contradictions)
    return writer
