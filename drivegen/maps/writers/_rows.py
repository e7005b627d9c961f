"""Which junction of a row is meant: "the first has lights, the second a stop sign", "the western one has four arms"."""

from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise

from drivegen.maps.writers._facts import Facts, JunctionWords
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._sentence import Sentence

_NEAR = 5
_SAID_OF_JUNCTIONS = ("control", "pocket")
_MOST = 13
_FEWEST_ARMS = 3
_JOINS_POCKETS = frozenset(("with", "is", "and", "det", "control", "number", "turn", "pocket"))
_JOINS_CONTROL = frozenset(("with", "neg", "det", "number", "role", "control", "prep", "each"))


def meant_of_a_row(s: Sentence, facts: Facts, phrase: Phrase) -> list[JunctionWords]:
    """The junctions that are named in the phrase, right behind it or shortly before it, none if it is said of all of them;
    counted ones are told apart from then on.
    """
    if not facts.junctions:
        return []
    if behind := _ordinals_behind(s, phrase):
        return _all_there(_numbered(s, facts, at, int(s.tokens[at].value)) for at in behind)
    told = (_ordinal_inside(s, phrase), _ordinal_of_subject(s, phrase), _ordinal_before(s, phrase))
    at = next((i for i in told if i is not None), None)
    if at is None:
        return []
    named = _all_there([_numbered(s, facts, at, int(s.tokens[at].value)), *_joined_before(s, facts, phrase)])
    if named and _are_excepted(s, phrase):
        named = [junction for junction in facts.junctions if all(junction is not one for one in named)]
    return named


def _all_there(named: Iterable[JunctionWords | None]) -> list[JunctionWords]:
    return [one for one in named if one is not None]


def _ordinals_behind(s: Sentence, phrase: Phrase) -> list[int]:
    """The ordinals of "lights at the first one only", "turn lanes at the first and the third"."""
    i, found = phrase.head + 1, list[int]()
    if phrase.kind not in _SAID_OF_JUNCTIONS or not (s.word(i, "but") or s.word(i, "prep")):
        return []
    while i < len(s.tokens) and s.tokens[i].kind in ("prep", "det", "but", "ordinal", *(("and",) if found else ())):
        found += [i] if s.word(i, "ordinal") else []
        i += 1
    follows = s.tokens[i].kind if i < len(s.tokens) else "stop"
    ends = ("comma", "stop", "place", "number", *_SAID_OF_JUNCTIONS)
    return found if follows in ends or s.word(i - 1, "but") else []


def _ordinal_inside(s: Sentence, phrase: Phrase) -> int | None:
    return next((i for i in range(phrase.first, phrase.head) if s.word(i, "ordinal")), None)


def _ordinal_of_subject(s: Sentence, phrase: Phrase) -> int | None:
    """That of "the second crossing is signalised": only "is" or "has" stands between."""
    place = s.last_before(phrase.head, "place") if phrase.kind in _SAID_OF_JUNCTIONS else None
    if place is None or "ordinal" not in place.words:
        return None
    between = s.tokens[place.head + 1 : phrase.head]
    said = bool(between) and all(t.kind in ("is", "with", "det", "but") for t in between)
    return _ordinal_inside(s, place) if said else None


def _ordinal_before(s: Sentence, phrase: Phrase) -> int | None:
    """That of "the second has lights"."""
    ordinal = s.last_before(phrase.head, "ordinal")
    if ordinal is None or phrase.head - ordinal.head > _NEAR or _speaks_of_others(s, ordinal.head, phrase.head):
        return None
    return ordinal.first


def _speaks_of_others(s: Sentence, first: int, last: int) -> bool:
    between = s.tokens[first + 1 : last]
    return any((t.kind == "det" and t.value == "another") or t.text in ("others", "rest", "remaining") for t in between)


def use_number_of_others(s: Sentence, phrase: Phrase) -> None:
    """Take the number in "the other two with stop signs": what is said of no junction of a row holds for those left."""
    i = phrase.first - 1
    while i > 0 and s.tokens[i].kind in ("with", "is", "verb", "place"):
        i -= 1
    if s.word(i, "number") and s.word(i - 1, "det") and s.tokens[i - 1].value == "another":
        s.used.add(i)


def _joined_before(s: Sentence, facts: Facts, phrase: Phrase) -> list[JunctionWords | None]:
    """The junctions named before the nearest ordinal and joined to it: "the first and the last with lights"."""
    ordinals = [p for p in s.said("ordinal") if p.head < phrase.head and phrase.head - p.head <= 2 * _NEAR]
    named = [_counted_from(s, facts, phrase, i) for i in range(1, _last_of_several(s, phrase) + 1)]
    for before, after in reversed(list(pairwise(ordinals))):
        joined = s.tokens[before.head + 1 : after.first]
        if not joined or any(t.kind not in ("and", "det", "comma") for t in joined):
            break
        named.append(_numbered(s, facts, before.first, int(before.value)))
    return named


def _last_of_several(s: Sentence, phrase: Phrase) -> int:
    """Two in "the first two have lights", "the last 2 are signalised"; 0 where a single one is named."""
    at = max((i for i in s.of_kind("ordinal", "0", "1") if i < phrase.head), default=None)
    if at is None or not s.word(at + 1, "number") or s.tokens[at + 1].number < 2 or phrase.head - at > _NEAR:
        return 0
    s.use(at, at + 1, f"junctions: {s.tokens[at].text} {s.tokens[at + 1].number}")
    return s.tokens[at + 1].number


def _counted_from(s: Sentence, facts: Facts, phrase: Phrase, i: int) -> JunctionWords | None:
    """The i-th junction from the start, or from the end where "the last two" are named."""
    at = max(j for j in s.of_kind("ordinal", "0", "1") if j < phrase.head)
    number = i if s.tokens[at].value == "1" else len(facts.junctions) + 1 - i
    return facts.junctions[number - 1] if 1 <= number <= len(facts.junctions) else None


def _are_excepted(s: Sentence, phrase: Phrase) -> bool:
    """Whether the phrase is said of all but the junction that is named: "all except the last one have lights"."""
    ordinal = max((i for i in s.of_kind("ordinal") if i < phrase.head), default=0)
    before = s.tokens[max(0, ordinal - _NEAR) : ordinal]
    whole = [t.kind == "total" or t.text in ("all", "every", "each") or t.kind == "each" for t in before]
    return any(whole) and any(t.kind == "but" and t.text not in ("just", "only") for t in before[whole.index(True) :])


def read_arms_of_a_row(s: Sentence, facts: Facts) -> None:
    """Arms of single junctions of a row; "the eastern one three" leaves the word out."""
    if not any(junction.count > 1 for junction in facts.junctions) and len(facts.junctions) < 2:
        return
    places = [i for i in s.of_kind("ordinal") if not s.word(i + 1, "lane")]
    for i, end in pairwise([*places, len(s.tokens)]):
        number = next(
            (j for j in range(i + 1, min(end, i + 6)) if s.word(j, "number") and s.tokens[j].number >= _FEWEST_ARMS), None
        )
        if number is None or number in s.used or not (_counts_arms(s, number) or _left_out(s, number, places)):
            continue
        one = _numbered(s, facts, i, int(s.tokens[i].value))
        if one is not None:
            one.arms = s.tokens[number].number
            s.use(number, number + 1 if _counts_arms(s, number) else number, f"{one.arms} roads meet")


def read_positions_of_a_row(s: Sentence, facts: Facts) -> None:
    """Places of the junctions of a row along its road: "the first 250 m after the start, the second at 550 m"."""
    if not any(junction.count > 1 for junction in facts.junctions):
        return
    for phrase in s.said("ordinal"):
        one = _numbered(s, facts, phrase.head, int(phrase.value)) if phrase.position else None
        if one is not None:
            one.position = phrase.position


def read_control_of_each(s: Sentence, facts: Facts) -> None:
    """Control said right behind each junction: "a crossing with lights, 150 m later a T without lights".

    Said behind one junction only, it is left to hold for all, unless another one has its own.
    """
    behind = [(junction, phrase) for junction in facts.junctions if (phrase := _said_behind(s, junction)) is not None]
    told = {"no " * phrase.negated + phrase.value for _, phrase in behind}
    own = any(junction.control for junction in facts.junctions)
    if len(facts.junctions) < 2 or not behind or not (own or len(told) > 1):
        return
    for junction, phrase in behind:
        if phrase.negated and phrase.value != "signals":
            continue
        junction.control = "unsignalled" if phrase.negated else phrase.value
        s.use(phrase.first, phrase.head, f"{'no ' * phrase.negated}{phrase.value.replace('_', ' ')} at this junction")


def pockets_of_a_row(s: Sentence, facts: Facts, phrase: Phrase) -> list[JunctionWords]:
    """The junctions of a row that alone have the turn lanes: those that are named, or the one behind which they are said."""
    if len(facts.junctions) < 2 and not any(junction.count > 1 for junction in facts.junctions):
        return []
    if named := meant_of_a_row(s, facts, phrase):
        return named
    place = s.last_before(phrase.head, "place")
    between = s.tokens[place.head + 1 : phrase.head] if place is not None else []
    if not between or any(t.kind not in _JOINS_POCKETS for t in between):
        return []
    return [junction for junction in facts.junctions if place is not None and junction.at == place.first and junction.count == 1]


def _said_behind(s: Sentence, junction: JunctionWords) -> Phrase | None:
    place = next((p for p in s.phrases if p.first == junction.at and p.kind == "place"), None)
    if place is None or junction.control or junction.form == "roundabout":
        return None
    control = next((p for p in s.phrases if p.head > place.head and p.kind == "control" and p.value != "signs"), None)
    between = s.tokens[place.head + 1 : control.head] if control is not None else []
    joined = bool(between) and between[0].kind in ("with", "neg", "prep") and len(between) <= _NEAR
    return control if joined and all(t.kind in _JOINS_CONTROL for t in between) else None


def _counts_arms(s: Sentence, number: int) -> bool:
    return s.word(number + 1, "arm") or (s.word(number + 1, "ramp") and s.tokens[number + 1].value.endswith("_or_arm"))


def _left_out(s: Sentence, number: int, places: list[int]) -> bool:
    """Whether the number stands alone, after arms that were counted for another junction."""
    ends = number + 1 >= len(s.tokens) or s.tokens[number + 1].kind in ("stop", "comma", "and")
    return ends and any(s.word(j, "number") and _counts_arms(s, j) and j > places[0] for j in range(number))


def _numbered(s: Sentence, facts: Facts, at: int, number: int) -> JunctionWords | None:
    if len(facts.junctions) == 1 and facts.junctions[0].count > 1:
        one = facts.junctions[0]
        facts.junctions[:] = [replace(one, count=1) for _ in range(min(one.count, _MOST))]
    number = {0: len(facts.junctions), -1: (len(facts.junctions) + 1) // 2}.get(number, number)  # the last, the middle one
    if number > len(facts.junctions):
        return None
    s.use(at, at, f"junction {number}")
    return facts.junctions[number - 1]
