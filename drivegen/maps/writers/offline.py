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
from drivegen.maps.writers._bends import read_arcs, read_straights
from drivegen.maps.writers._bent_rows import read_junctions_at_bends
from drivegen.maps.writers._changes import read_changes
from drivegen.maps.writers._choices import Choices
from drivegen.maps.writers._events import read_ramps
from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._fork_lengths import read_fork_lengths
from drivegen.maps.writers._forks import read_branches
from drivegen.maps.writers._gate import refuse_contradictions, refuse_lost_numbers, refuse_misread
from drivegen.maps.writers._general import note_roads, read_control, read_hand, read_pockets, read_roads, read_shapes
from drivegen.maps.writers._impossible import refuse_impossible
from drivegen.maps.writers._joining import read_joining_roads
from drivegen.maps.writers._junctions import read_junctions
from drivegen.maps.writers._kept import refuse_unkept
from drivegen.maps.writers._lanes import read_lanes
from drivegen.maps.writers._languages import in_english
from drivegen.maps.writers._layouts import read_interchange
from drivegen.maps.writers._likeness import MARGIN, NONE, TYPICAL, kind_of, nearest
from drivegen.maps.writers._measures import read_angles, read_lengths
from drivegen.maps.writers._reading import normalise
from drivegen.maps.writers._relations import read_relations
from drivegen.maps.writers._rewording import reworded, without_names
from drivegen.maps.writers._roads import Road, road
from drivegen.maps.writers._sentence import Sentence
from drivegen.maps.writers._series import read_how_often, read_upstream
from drivegen.maps.writers._small_words import NARRATIVE, SMALL_WORDS
from drivegen.maps.writers._speeds import read_speeds
from drivegen.maps.writers._steps import read_steps
from drivegen.maps.writers._stretches import read_stretches
from drivegen.maps.writers.base import Understanding

if TYPE_CHECKING:
    from drivegen.lm.model import LanguageModel

CAN_DRAW = (
    "crossings of 3 to 8 roads (T, Y, staggered, one-way), roundabouts, several of these in a row, street grids, straight "
    "and curved roads, S-curves, hairpins, dead ends, streets with side streets, highways with on-ramps, off-ramps, weaving "
    "sections, lane drops and gains, forks, interchanges (diamond, cloverleaf, trumpet, loop ramps); with lanes, speed "
    "limits, lengths, angles, traffic lights, stop, yield, turn lanes"
)
"""What this writer says it can do when it does not understand."""

_LONGEST = 2000
_CANNOT = (
    r"(?:stack|spaghetti|spui|ddi|turbine|windmill)(?: interchanges?)?|diverging diamond|"
    r"single point(?: urban)? interchange|tunnels?|viaducts?|"
    r"(?:rail(?:way|road)?|level|train|tram)(?: level)? crossings?|railways?|railroads?|parking (?:lots?|garages?|decks?)|"
    r"car parks?|toll (?:plazas?|booths?|stations?|gates?)|race ?tracks?|runways?|spiral\w*|helix|multi ?(?:storey|level)|"
    r"(?:motorway|highway|freeway|autobahn) junctions?|"
    r"figure (?:of )?(?:8|eight)|draw ?bridges?|ferry|ferries|jug ?handles?|turbo roundabouts?|rivers?|michigan left\w*"
)
_DENIED_QUESTION = re.compile(r"[^.?!;]*\?\s*(?:no|nope)\b[,.:;!]*", re.IGNORECASE)
_DENIED_BEFORE = re.compile(
    r"\b(?:no|not|without|never|neither|nor|outside|beyond|far from|away from|omit\w*|ignor\w+|neglect\w*|leav\w+ out|except)"
    r"(?: an?| any| the| all)?(?: \w+,?(?: and| or))? $"
)
_DENIED_BEHIND = re.compile(
    r" ?,? (?:(?:and|or) \w+ )?(?:(?:is|are|being|to be|may be|can be) )?"
    r"(?:omitted|left out|ignored|neglected|excluded|out of scope|aside|absent|"
    r"not (?:modelled|included|drawn|needed|wanted|part))\b"
)
# Each rule takes what it understands, so that later ones leave it: changes of lanes before numbers of lanes.
_RULES = (
    *(
        read_hand,
        read_branches,
        read_joining_roads,
        read_fork_lengths,
        read_stretches,
        read_upstream,
        read_changes,
        read_how_often,
        read_steps,
        read_lanes,
        read_speeds,
        read_junctions_at_bends,
        read_arcs,
        read_straights,
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
        sentence, facts = _understood(_read(text))
        choices = Choices(sentence.text, seed)
        fields = road(facts, choices)
        understood, written_by = sentence.understood(), self.description
        ignored = _ignored(sentence, vehicle_words)
        if fields is not None:
            refuse_lost_numbers(sentence)
        if fields is None or _unsure(facts, understood, ignored):
            fields, like = _like_an_example(text, fields, facts, choices, bool(sentence.phrases or sentence.lanes))
            understood, written_by = (*understood, like), f"{self.description}, by likeness to a described example"
        else:
            refuse_contradictions(sentence, facts, fields)
            refuse_misread(sentence, text, kind_of(fields))
        try:
            spec = MapSpec.model_validate({"road": fields, "left_hand": facts.left_hand})
        except ValidationError as error:
            raise UnusableInput(f"this road cannot be drawn: {_first(error)}", reason="impossible-map") from None
        ignored += refuse_unkept(sentence, spec, choices.waived)
        return Understanding(spec, understood, tuple(choices.assumed), tuple(dict.fromkeys(ignored)), written_by)


def _understood(sentence: Sentence) -> tuple[Sentence, Facts]:
    facts = Facts()
    for read in _RULES:
        read(sentence, facts)
    return sentence, facts


def _like_an_example(
    text: str, fields: Road | None, facts: Facts, choices: Choices, spoken: bool
) -> tuple[Road, tuple[str, str]]:
    """The road where the rules have none or are not sure: of the kind of the nearest described example, with the numbers that
    the rules did read. Raises UnusableInput where nothing of roads was `spoken`, no kind is nearest by the
    measured margin, or it is not the one of the rules.
    """
    near = nearest(text)
    agreed = fields is None or kind_of(fields) == near.kind
    if not spoken or near.kind == NONE or near.margin < MARGIN or near.kind not in TYPICAL or not agreed:
        raise UnusableInput(
            f"no road that I know is described in {_quoted(text)}; I can draw {CAN_DRAW}", reason="not-understood"
        )
    meaning = f"{near.kind.replace('_', ' ')}, because it is most like {_quoted(near.text)} (margin {near.margin:.2f})"
    if fields is None:
        _, typical = _understood(Sentence(normalise(TYPICAL[near.kind])))
        for name in ("lanes", "other_lanes", "speeds", "lengths", "control", "unsignalled", "left_hand", "surroundings", "turn"):
            setattr(typical, name, getattr(facts, name))
        fields = road(typical, choices)
    assert fields is not None  # every typical description is understood by the rules: see the tests
    return fields, (_quoted(text), meaning)


def _read(text: str) -> Sentence:
    if len(text) > _LONGEST:
        raise UnusableInput(f"the description is longer than {_LONGEST} characters", reason="too-long")
    if re.search(r"</?\w+[^<>]*>", text):
        raise UnusableInput(f"markup is no description of a road; I can draw {CAN_DRAW}", reason="not-understood")
    text = _DENIED_QUESTION.sub(" ", text)
    plain = reworded(normalise(in_english(without_names(text))))
    for match in re.finditer(rf"(?<!\w)(?:{_CANNOT})(?!\w)", plain):
        if not (_DENIED_BEFORE.search(plain[: match.start()]) or _DENIED_BEHIND.match(plain[match.end() :])):
            raise UnusableInput(f"I cannot draw {match.group()!r}; I can draw {CAN_DRAW}", reason="not-understood")
    refuse_impossible(plain)
    return Sentence(plain)


def _ignored(sentence: Sentence, vehicle_words: Set[str]) -> list[str]:
    """The words that changed nothing and are no small words."""
    words = [
        word
        for i, token in enumerate(sentence.tokens)
        if i not in sentence.used and token.kind in ("unknown", "noise", "driving", "number", "length", "speed", "angle", "size")
        for word in token.text.split()
    ]
    return [word for word in words if word not in vehicle_words and word not in SMALL_WORDS and re.search(r"\w", word)]


def _unsure(facts: Facts, understood: tuple[tuple[str, str], ...], ignored: list[str]) -> bool:
    """Whether so much was left over that what was understood may be chance."""
    ignored = [word for word in ignored if word not in NARRATIVE]
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
