"""Phrases: a head noun with the words before it; negation and its scope.

"no three-lane one-way side streets" is one phrase: head "road" with role, lanes, direction, number, negated.
"""

from dataclasses import dataclass, field

from drivegen.maps.writers._quantities import Lanes
from drivegen.maps.writers._tokens import Token

HEADS = frozenset(
    (
        *("road", "place", "interchange", "ramp", "ring", "central", "arm", "pocket", "auxiliary", "weaving", "extra", "shape"),
        *("dead_end", "control", "divided", "noise"),
    )
)
_MODIFIERS = frozenset(
    (
        *(
            "number",
            "role",
            "label",
            "one_way",
            "two_way",
            "surroundings",
            "small",
            "bend_size",
            "det",
            "ordinal",
            "many",
            "turn",
        ),
        *("control", "lane", "each", "arm", "speed", "speed_word", "divided", "bound", "row", "total", "length", "angle"),
        *("unknown", "road", "long"),
    )
)
_HOLDS_LANES = ("road", "ramp", "ring", "place")
_ENDS_NEGATION = ("stop", "but", "with", "that", "verb", "seq")


@dataclass
class Phrase:
    """Something that is spoken of.

    Attributes:
        kind, value: of its head. first, head: places of its first token and its head.
        number: how many, None unsaid. det: "the", "a", "another" or "". words: kinds and values of its modifiers.
        arms: roads that meet at a place, if its own words say so. The rest is attached later.
    """

    kind: str
    value: str
    first: int
    head: int
    text: str
    number: int | None = None
    det: str = ""
    negated: bool = False
    words: dict[str, str] = field(default_factory=dict)
    arms: int | None = None
    lanes: int | None = None
    speed: float | None = None
    length: float | None = None
    position: float | None = None
    gap: float | None = None

    @property
    def role(self) -> str:
        """Main or side road, "" unsaid."""
        return self.words.get("role", "")


def phrases(tokens: list[Token], lanes: list[Lanes]) -> list[Phrase]:
    """All phrases, in order; numbers of lanes inside a phrase are marked and belong to it."""
    lane_at = {i: item for item in lanes for i in range(item.first, item.last + 1)}
    found: list[Phrase] = []
    start = 0
    for i, token in enumerate(tokens):
        if token.kind in HEADS and not _is_modifier(tokens, i):
            found.append(_phrase(tokens, start, i, lane_at, found))
            start = i + 1
        elif token.kind not in _MODIFIERS or token.text == ",":
            if alone := _headless(tokens, start, i, found):
                found.append(alone)
            start = i + 1
    if alone := _headless(tokens, start, len(tokens), found):
        found.append(alone)
    found.sort(key=lambda p: p.head)
    _negate(tokens, found)
    return found


def _is_modifier(tokens: list[Token], i: int) -> bool:
    """Whether the head at i only describes the noun after it: "4-arm junction", "signalised T", "five-road roundabout"."""
    token = tokens[i]
    nouns = {"arm": ("place",), "control": ("place",), "road": ("place", "ramp"), "divided": ("road",)}.get(token.kind)
    if nouns is None:
        return False
    j = i + 1
    while j < len(tokens) and (
        tokens[j].kind in ("control", "small", "role", "surroundings", "arm", "unknown", "divided")
        or (tokens[j].kind == "number" and tokens[j + 1 : j + 2] and tokens[j + 1].kind == "arm")  # "signalised 4-way crossings"
    ):
        if tokens[j].kind == "unknown" and token.kind != "arm":
            return False
        j += 1
    if j >= len(tokens) or tokens[j].kind not in nouns:
        return False
    if token.kind == "road" and tokens[j].kind == "place":
        return not token.text.endswith("s") and i > 0 and tokens[i - 1].kind in ("number", "surroundings", "role", "unknown")
    if token.kind == "road":
        return token.value in ("highway", "") and not token.text.endswith("s") and j == i + 1
    return token.kind != "arm" or not token.text.endswith("s")


def _phrase(tokens: list[Token], start: int, head: int, lane_at: dict[int, Lanes], before: list[Phrase]) -> Phrase:
    first = _first(tokens, start, head, lane_at, before)
    token = tokens[head]
    phrase = Phrase(token.kind, token.value, first, head, "")
    for i in range(first, head):
        _modify(phrase, tokens, i, lane_at)
    if token.kind == "road":
        _classify(phrase)
    phrase.text = " ".join(t.text for t in tokens[first : head + 1])
    return phrase


def _first(tokens: list[Token], start: int, head: int, lane_at: dict[int, Lanes], before: list[Phrase]) -> int:
    """Where a phrase begins: not before a number of lanes that belongs to what stands ahead of it."""
    first = start
    for i in range(start, head):
        lanes = lane_at.get(i)
        if lanes is None or i != lanes.last:
            continue
        follows_a_head = lanes.first > 0 and before and before[-1].head == lanes.first - 1 and before[-1].kind in _HOLDS_LANES
        plural = tokens[lanes.last].text.endswith("lanes") or tokens[lanes.last].kind in ("each", "total")
        if lanes.count > 1 and tokens[head].kind == "road" and any(t.text == "lane" for t in tokens[lanes.first : i + 1]):
            continue  # "a four-lane-per-direction expressway"
        if (
            lanes.last == head - 1
            and tokens[head].kind == "road"
            and tokens[lanes.last].kind == "each"
            and tokens[lanes.first + 1].text == "lane"
        ):
            continue  # "a single-lane-per-direction road"
        if tokens[head].kind not in _HOLDS_LANES or (plural and (follows_a_head or tokens[lanes.last].kind != "lane")):
            first = i + 1
    while first < head and tokens[first].kind in ("unknown", "each", "total", "length", "speed", "long", "speed_word", "angle"):
        first += 1
    return first


def _modify(phrase: Phrase, tokens: list[Token], i: int, lane_at: dict[int, Lanes]) -> None:
    token = tokens[i]
    if lanes := lane_at.get(i):
        lanes.inside = True
        if i == lanes.first:
            phrase.lanes = lanes.count
        return
    if token.kind == "number":
        if i + 1 < len(tokens) and tokens[i + 1].kind in ("arm", "road") and i + 1 < phrase.head:
            phrase.arms = token.number
        else:
            phrase.number = token.number
    elif token.kind == "many":
        phrase.number = int(token.value)
    elif token.kind == "det":
        phrase.det = token.value
        if token.value in ("the", "a"):
            phrase.number = None  # "in 2024 the city rebuilt this junction" counts none
    elif token.kind in ("speed", "length"):
        setattr(phrase, token.kind, token.amount[0])
    elif token.kind == "road":
        phrase.words["class"] = token.value or phrase.words.get("class", "")
    else:
        phrase.words[token.kind] = token.value or token.text


def _classify(phrase: Phrase) -> None:
    """Roles and kinds that the noun itself says: "arterial", "side street", "one-way"."""
    if phrase.value in ("main", "side"):
        phrase.words.setdefault("role", phrase.value)
    elif phrase.value == "one_way":
        phrase.words["one_way"] = "one_way"
    elif phrase.value in ("rural", "residential"):
        phrase.words["surroundings"] = phrase.value
    elif phrase.value:
        phrase.words["class"] = phrase.value
    if phrase.number == 1 and phrase.det == "the":
        phrase.number = None


def _headless(tokens: list[Token], start: int, end: int, before: list[Phrase]) -> Phrase | None:
    """A road that is named by its role or direction alone ("major: 70 km/h", "the other one"), an ordinal ("the second")."""
    found: Phrase | None = None
    for i in range(start, end):
        token = tokens[i]
        if token.kind in ("role", "label") and found is None:
            found = Phrase("road", "", i, i, token.text, words={token.kind: token.value})
        elif token.kind == "det" and token.value == "another" and found is None and not _of_a_lane(tokens, i):
            verb = tokens[i + 1].value if i + 1 < len(tokens) and tokens[i + 1].kind == "verb" else ""
            ramp = {"leave": "off", "join": "on", "merge": "on"}.get(verb) if any(p.kind == "ramp" for p in before) else None
            alike = _alike(tokens, i, before) if ramp is None else None
            kind, value = ("ramp", ramp) if ramp else alike or ("road", "")
            found = Phrase(kind, value, i, i, token.text, det="another")  # "another one leaves"
            if alike and kind == "road":
                found.words["role"] = "side"
        elif token.kind == "ordinal" and found is None and before:
            found = Phrase("ordinal", token.value, i, i, token.text)
        elif token.kind == "one_way" and found is not None:
            found.words["one_way"] = "one_way"
    return found


def _alike(tokens: list[Token], i: int, before: list[Phrase]) -> tuple[str, str] | None:
    """What the "another" at i is one of: "a T-junction on the left and another on the right", "an exit, and one after 900 m"."""
    things = [p for p in before if p.kind in ("place", "ramp", "road", "dead_end")]
    listed = i > 0 and tokens[i - 1].kind == "and" and i + 1 < len(tokens) and tokens[i + 1].kind in ("turn", "prep")
    counted = ("place", "ramp") if not things or things[-1].role != "side" else ("road",)
    one = bool(things) and listed and things[-1].kind in counted and things[-1].value not in ("grid", "staggered")
    return (things[-1].kind, things[-1].value) if one and not things[-1].negated else None


def _of_a_lane(tokens: list[Token], i: int) -> bool:
    """Whether "another" ends what is said, or a lane follows: "and 400 m later another"."""
    following = tokens[i + 1].kind if i + 1 < len(tokens) else "stop"
    return tokens[i].text.startswith("another") and following in ("comma", "stop", "lane", "length", "later")


def _negate(tokens: list[Token], found: list[Phrase]) -> None:
    """Mark what "no", "without", "instead of" deny: the next phrase, and those joined to it by "or" and "nor"."""
    for i, token in enumerate(tokens):
        if token.kind != "neg":
            continue
        # "none of them with lights": what stands right behind the negation does not end it.
        reach = i + 2 if i + 1 < len(tokens) and tokens[i + 1].kind == "with" else i + 1
        begin, before_it = reach, ""
        for phrase in (p for p in found if p.head > i):
            between = tokens[reach : phrase.head]
            of_it = reach > begin and before_it == "place" and phrase.kind == "control" and [t.kind for t in between] == ["with"]
            if any(t.kind in _ENDS_NEGATION for t in between) and not of_it:
                break  # but "no junctions with lights" denies both
            if reach > begin and not of_it and not _goes_on(tokens, reach, phrase.head):
                break
            if len(between) > 5:
                break
            phrase.negated = True
            reach, before_it = phrase.head + 1, phrase.kind


def _goes_on(tokens: list[Token], reach: int, head: int) -> bool:
    between = tokens[reach:head]
    if any(t.kind == "or" or t.kind == "neg" for t in between):
        return True
    if any(t.kind == "and" for t in between):
        return not any(t.kind == "det" for t in between) and not any(t.kind == "number" for t in between)
    if any(t.kind == "comma" for t in between):
        rest = tokens[head + 1 : head + 4]
        return any(t.kind == "or" for t in rest) and not any(t.kind == "det" for t in between)
    return not between
