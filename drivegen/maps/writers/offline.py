"""Offline rules (no language model): a rule parser for descriptions in English, and word by word in German and
Chinese.

It answers only when it is sure: a description of a kind it knows, consistent, within bounds, and most of whose words it
understood. Else it stops and says what it can draw.
"""

import re
from collections.abc import Set
from typing import TYPE_CHECKING

from pydantic import ValidationError

from drivegen.errors import UnusableInput
from drivegen.maps.spec import MapSpec
from drivegen.maps.writers._changes import read_branches, read_changes, read_joining_roads
from drivegen.maps.writers._choices import Choices
from drivegen.maps.writers._events import read_ramps
from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._general import note_roads, read_control, read_hand, read_pockets, read_roads, read_shapes
from drivegen.maps.writers._junctions import read_junctions
from drivegen.maps.writers._lanes import read_lanes
from drivegen.maps.writers._languages import in_english
from drivegen.maps.writers._layouts import read_interchange
from drivegen.maps.writers._measures import read_angles, read_lengths, read_speeds
from drivegen.maps.writers._reading import normalise
from drivegen.maps.writers._relations import read_relations
from drivegen.maps.writers._roads import road
from drivegen.maps.writers._sentence import Sentence
from drivegen.maps.writers.base import Understanding

if TYPE_CHECKING:
    from drivegen.lm.model import LanguageModel

CAN_DRAW = (
    "crossings of 3 to 8 roads (T, Y, staggered, one-way), roundabouts, several of these in a row, street grids, straight "
    "and curved roads, S-curves, hairpins, dead ends, streets with side streets, highways with on-ramps, off-ramps, weaving "
    "sections, lane drops and gains, forks; with lanes, speed limits, lengths, angles, traffic lights, stop, yield, turn lanes"
)
"""What this writer says it can do when it does not understand."""

_LONGEST = 2000
_CANNOT = (
    r"clover ?leaf|(?:stack|spaghetti|trumpet|spui|ddi|turbine|windmill)(?: interchanges?)?|diverging diamond|"
    r"single point(?: urban)? interchange|tunnels?|viaducts?|"
    r"(?:rail(?:way|road)?|level|train|tram)(?: level)? crossings?|railways?|railroads?|parking (?:lots?|garages?|decks?)|"
    r"car parks?|toll (?:plazas?|booths?|stations?|gates?)|race ?tracks?|runways?|spiral\w*|helix|multi ?(?:storey|level)|"
    r"(?:motorway|highway|freeway|autobahn) junctions?|"
    r"figure (?:of )?(?:8|eight)|draw ?bridges?|ferry|ferries|jug ?handles?|turbo roundabouts?|rivers?|michigan left\w*"
)
_COUNTED = frozenset(("lane", "arm", "road", "place", "ramp"))
_SMALL_WORDS = frozenset(
    re.findall(
        r"\w+",
        """
        a an the of in on at to and or with for from by as is are be it its that this there has have where which who
        into onto each every all both only just please create generate make draw build give me us i we want would like
        need map scene scenario road network layout show simple typical basic standard normal ordinary about around
        approximately roughly some then one no not without two way through across over between after before near along
        up down when while their them they he she you your my our also very quite another same other first second last
        next end ends side sides here than more most less any s t d setting design set use using but must can should followed row
        together come comes joined joining controlled control angle meeting linked connected connecting connects placed
        located goes go runs running going traffic style real really kind sort thing place situated version picture
        """,
    )
)

# Each rule takes what it understands, so that later ones leave it: changes of lanes before numbers of lanes.
_RULES = (
    *(
        read_hand,
        read_branches,
        read_joining_roads,
        read_changes,
        read_lanes,
        read_speeds,
        read_lengths,
        read_angles,
        read_roads,
        read_interchange,
    ),
    *(read_junctions, read_relations, read_ramps, read_shapes, read_pockets, read_control, note_roads),
)


class Plugin:
    """The writer that needs no model, no key and no network."""

    description = "offline rules (no language model)"

    def __init__(self, model: "LanguageModel | None" = None) -> None:
        """See `MapWriter`: it asks none."""

    def write(self, text: str, seed: int, vehicle_words: Set[str] = frozenset()) -> Understanding:
        """See `MapWriter.write`."""
        sentence = _read(text)
        facts = Facts()
        for read in _RULES:
            read(sentence, facts)
        choices = Choices(sentence.text, seed)
        fields = road(facts, choices)
        ignored = _ignored(sentence, vehicle_words)
        understood = sentence.understood()
        if fields is not None:
            _refuse_lost_numbers(sentence)
        if fields is None or _unsure(facts, understood, ignored):
            raise UnusableInput(
                f"no road that I know is described in {_quoted(text)}; I can draw {CAN_DRAW}", reason="not-understood"
            )
        try:
            spec = MapSpec.model_validate({"road": fields, "left_hand": facts.left_hand})
        except ValidationError as error:
            raise UnusableInput(f"this road cannot be drawn: {_first(error)}", reason="impossible-map") from None
        return Understanding(spec, understood, tuple(choices.assumed), tuple(dict.fromkeys(ignored)), self.description)


def _read(text: str) -> Sentence:
    if len(text) > _LONGEST:
        raise UnusableInput(f"the description is longer than {_LONGEST} characters", reason="too-long")
    plain = normalise(in_english(text))
    for match in re.finditer(rf"(?<!\w)(?:{_CANNOT})(?!\w)", plain):
        if not re.search(r"\b(?:no|not|without|never)(?: an?| any)? $", plain[: match.start()]):
            raise UnusableInput(f"I cannot draw {match.group()!r}; I can draw {CAN_DRAW}", reason="not-understood")
    if negative := re.search(r"minus \d+", plain):
        raise UnusableInput(f"{negative.group()!r} makes no road: numbers must be positive", reason="impossible-map")
    return Sentence(plain)


def _ignored(sentence: Sentence, vehicle_words: Set[str]) -> list[str]:
    """The words that changed nothing and are no small words."""
    words = [
        word
        for i, token in enumerate(sentence.tokens)
        if i not in sentence.used and token.kind in ("unknown", "noise", "driving", "number", "length", "speed", "angle", "size")
        for word in token.text.split()
    ]
    return [word for word in words if word not in vehicle_words and word not in _SMALL_WORDS and re.search(r"\w", word)]


def _refuse_lost_numbers(sentence: Sentence) -> None:
    """Stop at a number of roads or lanes that no rule took: leaving it out would draw another road than was asked for."""
    for i in sentence.of_kind("number"):
        if i in sentence.used or sentence.tokens[i].number == 1:
            continue
        for j in range(i + 1, min(i + 3, len(sentence.tokens))):
            if sentence.tokens[j].kind in _COUNTED:
                phrase = " ".join(t.text for t in sentence.tokens[i : j + 1])
                raise UnusableInput(f"I do not understand {phrase!r} here; please say it in other words", reason="not-understood")
            if sentence.tokens[j].kind != "unknown":
                break


def _unsure(facts: Facts, understood: tuple[tuple[str, str], ...], ignored: list[str]) -> bool:
    """Whether so much was left over that what was understood may be chance."""
    if not understood and facts.has("road"):
        return len(ignored) > 1
    return len(ignored) > 3 + 2 * len(understood)


def _quoted(text: str) -> str:
    shown = re.sub(r"\s+", " ", text).strip()
    return repr(shown if len(shown) <= 60 else f"{shown[:57]}...")


def _first(error: ValidationError) -> str:
    """The first complaint of a specification, without pydantic's words around it."""
    detail = error.errors(include_url=False, include_input=True)[0]
    place = [str(part) for part in detail["loc"] if not isinstance(part, int)][2:]
    message = detail["msg"].removeprefix("Value error, ").replace("Input should be", "must be").replace("Tuple should have", "")
    name = " ".join(place).replace("_", " ")
    shown = f" (asked: {detail['input']})" if isinstance(detail["input"], int | float) else ""
    return f"{name} {message}{shown}".strip()
