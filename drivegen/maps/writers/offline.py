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
from drivegen.maps.writers._choices import Choices
from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._junctions import read_junctions
from drivegen.maps.writers._kinds import read_control, read_hand, read_highway, read_kinds, read_one_way
from drivegen.maps.writers._lanes import read_lanes
from drivegen.maps.writers._languages import in_english
from drivegen.maps.writers._measures import read_angles, read_lengths, read_speeds
from drivegen.maps.writers._ramps import read_ramps, read_side_streets
from drivegen.maps.writers._reading import Reading
from drivegen.maps.writers._roads import road
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
    r"clover ?leaf|(?:diamond |stack |spaghetti |trumpet )?interchanges?|over ?pass(?:es)?|under ?pass(?:es)?|fly ?overs?|"
    r"(?:rail(?:way|road)?|level|train|tram)(?: level)? crossings?|railways?|railroads?|parking (?:lots?|garages?|decks?)|"
    r"car parks?|toll (?:plazas?|booths?|stations?|gates?)|race ?tracks?|runways?|spiral\w*|helix|multi ?(?:storey|level)|"
    r"merge of \d+ \w+|y merge|(?:motorway|highway|freeway|autobahn) junctions?|"
    r"figure (?:of )?(?:8|eight)|draw ?bridges?|ferry|ferries|diverging diamond|jug ?handles?|turbo roundabouts?|rivers?"
)
_BESIDE_THE_POINT = (
    r"(?:pedestrian|zebra|foot|crosswalk|bicycle|cycle|animal|wildlife) ?crossings?|crosswalks?|(?:bus|bike|bicycle|cycle|"
    r"cycling|parking|tram) lanes?|bus stops?|(?:hard )?shoulders?|side ?walks?|pavements?"
)
_COUNTED = r"lanes?|ways?|arms?|legs?|roads?|streets?|exits?|branches|junctions?|crossings?|intersections?|roundabouts?|ramps?"
_SMALL_WORDS = frozenset(
    re.findall(
        r"\w+",
        """
        a an the of in on at to and or with for from by as is are be it its that this there has have where which who
        into onto each every all both only just please create generate make draw build give me us i we want would like
        need map scene scenario road network layout show simple typical basic standard normal ordinary about around
        approximately roughly some then one no not without two way through across over between after before near along
        up down when while their them they he she you your my our also very quite another same other first second last
        next end ends side sides here than more most less any s t design set use using but must can should followed row
        together come comes joined joining controlled control angle meeting linked connected connecting connects placed
        located
        """,
    )
)

# What is read first takes its words: lane numbers before the junctions that they belong to, ramps before bends.
_RULES = (
    *(read_hand, read_lanes, read_speeds, read_lengths, read_one_way, read_junctions, read_highway),
    *(read_ramps, read_side_streets, read_kinds, read_angles, read_control),
)


class Plugin:
    """The writer that needs no model, no key and no network."""

    description = "offline rules (no language model)"

    def __init__(self, model: "LanguageModel | None" = None) -> None:
        """See `MapWriter`: it asks none."""

    def write(self, text: str, seed: int, vehicle_words: Set[str] = frozenset()) -> Understanding:
        """See `MapWriter.write`."""
        reading = _read(text)
        facts = Facts()
        _refuse_the_unknown(reading)
        for read in _RULES:
            read(reading, facts)
        choices = Choices(reading.text, seed)
        fields = road(facts, choices)
        ignored = [w for w in reading.left_over() if w not in vehicle_words and w not in _SMALL_WORDS]
        understood = tuple((phrase, meaning) for phrase, meaning in reading.notes if meaning)
        if fields is not None:
            _refuse_lost_numbers(reading)
        if fields is None or _unsure(facts, understood, ignored):
            raise UnusableInput(
                f"no road that I know is described in {_quoted(text)}; I can draw {CAN_DRAW}", reason="not-understood"
            )
        try:
            spec = MapSpec.model_validate({"road": fields, "left_hand": facts.left_hand})
        except ValidationError as error:
            raise UnusableInput(f"this road cannot be drawn: {_first(error)}", reason="impossible-map") from None
        return Understanding(spec, understood, tuple(choices.assumed), tuple(dict.fromkeys(ignored)), self.description)


def _read(text: str) -> Reading:
    if len(text) > _LONGEST:
        raise UnusableInput(f"the description is longer than {_LONGEST} characters", reason="too-long")
    return Reading(in_english(text))


def _refuse_the_unknown(reading: Reading) -> None:
    """Stop at roads of kinds that are not drawn; set aside words that change no road."""
    for match in list(reading.all(_CANNOT)):
        if not reading.negated(match):
            raise UnusableInput(f"I cannot draw {match.group()!r}; I can draw {CAN_DRAW}", reason="not-understood")
        reading.take(match, f"no {match.group()}")
    if negative := reading.first(r"minus \d+"):
        raise UnusableInput(f"{negative.group()!r} makes no road: numbers must be positive", reason="impossible-map")
    for match in list(reading.all(_BESIDE_THE_POINT)):
        reading.set_aside(match)


def _refuse_lost_numbers(reading: Reading) -> None:
    """Stop at a number of roads or lanes that no rule took: leaving it out would draw another road than was asked for."""
    if match := reading.first(rf"(?:[2-9]|\d\d+) (?:\w+ )?(?:{_COUNTED})"):
        raise UnusableInput(f"I do not understand {match.group()!r} here; please say it in other words", reason="not-understood")


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
