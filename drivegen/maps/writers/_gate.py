"""What the rules left over, and whether it forbids to draw: an honest no beats a wrong road.

A number of roads, lanes or junctions that no rule took would make another road than was asked for. Where much of a description
was left over and the described examples speak clearly of another kind of road, the rules have probably misread it.
"""

import re
from collections.abc import Mapping
from typing import Any

from drivegen.errors import UnusableInput
from drivegen.maps.writers import _likeness
from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._sentence import Sentence
from drivegen.maps.writers._small_words import NARRATIVE, SMALL_WORDS

LEAST_TAKEN = 0.5
"""Share of the words that speak of something below which the described examples are asked."""

_MOST_COUNTED = 8
_JOINING = ("join", "cross", "meet", "split", "end_at")
_COUNTED = frozenset(("lane", "arm", "road", "place", "ramp", "ring", "extra", "shape", "weaving", "control"))
_MEASURES = frozenset(("length", "angle", "size"))
_OVER = frozenset(("small", "unknown", "control", "one_way", "two_way", "surroundings", "role", "label", "prep"))
_NO_NAMES = frozenset(
    ("namely", "exactly", "precisely", "about", "roughly", "likewise", "also", "plus", "ie", "thus", "therefore")
)
_SILENT = frozenset(
    (
        "comma",
        "stop",
        "det",
        "is",
        "that",
        "prep",
        "and",
        "or",
        "with",
        "but",
        "neg",
        "each",
        "seq",
        "small",
        "bound",
        "driving",
        "noise",
    )
)


def refuse_lost_numbers(s: Sentence) -> None:
    """Raise UnusableInput at a number that counts or measures roads and that no rule took."""
    for i, token in enumerate(s.tokens):
        if i in s.used or i in s.aside or (token.kind == "number" and token.number == 1 and not _is_counted(s, i)):
            continue
        if token.kind in _MEASURES or (token.kind == "number" and (_counts_roads(s, i) or s.word(i + 1, "speed"))):
            last = min(i + 2, len(s.tokens))
            lost = " ".join(t.text for t in s.tokens[i:last]).strip(" ,.")
            raise UnusableInput(f"I do not understand {lost!r} here; please say it in other words", reason="not-understood")


def refuse_contradictions(s: Sentence, facts: Facts, road: Mapping[str, Any]) -> None:
    """Raise UnusableInput where roads are said to meet, or not to be there, and the road that was read has no junction or has.

    Who goes first, a side road, or roads that join and cross make no sense along a road that meets no other.
    """
    _refuse_denied_roads(s)
    _refuse_junction_within(s, facts)
    if road["kind"] not in ("corridor", "highway", "fork") or road.get("junctions"):
        return
    sides = [p.head for p in s.said("road") if p.role == "side" and s.tokens[p.head].text != "side"]  # "on one side"
    ramps = any(event["kind"].endswith("ramp") for event in road.get("events", ()))  # "a service road merges into the highway"
    told = [] if facts.has("fork") or ramps else sides
    if not road.get("events"):
        told += [p.head for p in s.said("control", "signals", "stop", "yield", "all_way_stop")]
    if not road.get("events") and road["kind"] == "corridor":
        told += [i for i in s.verbs(*_JOINING) if i not in s.used and not s.negated_at(i)]
        told = [i for i in told if not (s.tokens[i].kind == "verb" and (facts.has("cul_de_sac") or _links_straights(s, i)))]
    if told:
        words = s.tokens[min(told)].text
        raise UnusableInput(
            f"I do not understand where roads meet, though {words!r} says that they do; please say it in other words",
            reason="not-understood",
        )


def _refuse_junction_within(s: Sentence, facts: Facts) -> None:
    """Raise UnusableInput at one junction that has another, as "a roundabout with a crossing of six roads"."""
    for place in s.said("place") if len(facts.junctions) > 1 else ():
        before = s.last_before(place.first, "place")
        if s.word(place.first - 1, "with") and before is not None and not _are_apart(s, before, place):
            raise UnusableInput(
                f"I do not understand how {place.text!r} lies to {before.text!r}; please say it in other words",
                reason="not-understood",
            )


def _refuse_denied_roads(s: Sentence) -> None:
    """Raise UnusableInput at a map without roads, or a junction where none meet."""
    for phrase in s.denied("road"):
        if not phrase.words and s.tokens[phrase.head].text in ("road", "roads", "street", "streets"):
            raise UnusableInput(f"a map needs roads, and {phrase.text!r} are denied", reason="impossible-map")
    for phrase in s.denied("arm"):
        if s.tokens[phrase.head].text in ("arms", "legs", "approaches", "branches") and not phrase.words:
            raise UnusableInput(f"a junction needs roads, and {phrase.text!r} are denied", reason="impossible-map")


def _links_straights(s: Sentence, i: int) -> bool:
    """Whether the verb at i joins the parts of one road: "hairpins linked by straights of 80 m"."""
    return any(p.first <= i + 2 and p.head > i for p in s.said("shape", "straight"))


def _are_apart(s: Sentence, before: Phrase, place: Phrase) -> bool:
    """Whether two junctions are told apart: counted, listed, or one so far behind the other; "a ring with a crossing" is not."""
    counted = (
        s.word(place.head + 1, "length") or (before.number or 1) > 1 or (place.number or 1) > 1 or place.value == before.value
    )
    return counted or s.between(before.head, place.first, "and", "seq", "later", "length", "spacing", "stop", "ordinal")


def _is_counted(s: Sentence, i: int) -> bool:
    """Whether the "1" at i counts what meets: "a roundabout with one arm", "a crossing of one road"."""
    if s.word(i + 1, "road") and s.word(i - 1, "prep") and s.tokens[i - 1].value == "of" and s.word(i - 2, "place"):
        return True
    return s.word(i + 1, "arm") and s.tokens[i + 1].text in ("arm", "leg", "branch", "spoke")


def _counts_roads(s: Sentence, i: int) -> bool:
    """Whether the number at i counts what roads are made of, or stands where a number of them was asked for."""
    if [t.text for t in s.tokens[i + 1 : i + 3]] in (["of", "them"], ["of", "these"]) and s.word(i + 3, "verb"):
        return True
    if s.word(i - 1, "det") and s.tokens[i - 1].value == "another" and (s.word(i + 1, "with") or s.word(i + 1, "is")):
        return True  # "the other two have four arms"
    if s.word(i - 1, "det") and s.tokens[i - 1].value == "the" and not s.word(i + 1, "lane"):
        following = s.tokens[i + 1].kind if i + 1 < len(s.tokens) else "stop"
        if following in ("comma", "stop", "verb", "is", "and"):
            return False  # "a lane that connects the two"
    if i + 1 < len(s.tokens) and s.tokens[i + 1].text in ("row", "rows", "column", "columns"):
        return True
    for j in range(i + 1, min(i + 4, len(s.tokens))):
        if s.tokens[j].kind in _COUNTED:
            return True
        if s.tokens[j].kind not in _OVER:
            return s.tokens[j].kind in ("comma", "stop", "and") and j == i + 1 and _is_bare(s, i)
    return i + 1 == len(s.tokens) and _is_bare(s, i)


def _is_bare(s: Sentence, i: int) -> bool:
    """Whether the number names nothing: in "unit 2", "question 12" or "exit 14" it does."""
    if i and s.tokens[i].number > _MOST_COUNTED and s.tokens[i - 1].kind in ("ramp", "place", "road"):
        return s.tokens[i - 1].text.endswith("s")
    if s.word(i - 2, "det") and s.tokens[i - 2].value == "the" and s.word(i - 1, "unknown"):
        return True  # "the bar three"
    if i and s.tokens[i - 1].text in _NO_NAMES:
        return True
    return i == 0 or s.tokens[i - 1].kind != "unknown" or not re.fullmatch(r"[a-z]+", s.tokens[i - 1].text)


def taken(s: Sentence) -> float:
    """Share of the words that speak of something which changed the road."""
    speaking = [i for i in range(len(s.tokens)) if i in s.used or not _is_silent(s, i)]
    return sum(i in s.used for i in speaking) / max(1, len(speaking))


def _is_silent(s: Sentence, i: int) -> bool:
    kind, text = s.tokens[i].kind, s.tokens[i].text
    if s.tokens[i].kind == "number":
        return s.word(i + 1, "driving") or s.word(i + 1, "noise")
    return kind in _SILENT or (kind == "unknown" and (text in SMALL_WORDS or text in NARRATIVE or not re.search(r"\w", text)))


def refuse_misread(s: Sentence, text: str, kind: str) -> None:
    """Raise UnusableInput where much was left over and the described examples say clearly that it is another kind of road."""
    if taken(s) >= LEAST_TAKEN:
        return
    near = _likeness.nearest(text)
    if near.kind != kind and near.margin >= _likeness.MARGIN:
        left = ", ".join(repr(t.text) for i, t in enumerate(s.tokens) if i not in s.used and not _is_silent(s, i))
        raise UnusableInput(
            f"I am not sure of this road, because I do not understand {left}; please say it in other words",
            reason="not-understood",
        )
