"""Whether the road that was built keeps what was said of it.

The rules take facts from the words one by one, and a fact that is said twice is kept once. Here the words are read a second
time, fact by fact, and each is looked up in what was built. One that isn't there is contradicted by another, or was
misunderstood: both are reasons not to draw."""

from collections.abc import Callable, Collection, Iterator

from drivegen.errors import UnusableInput
from drivegen.maps.spec import MapSpec
from drivegen.maps.writers._built import Built, built
from drivegen.maps.writers._measures import cue_of
from drivegen.maps.writers._owners import is_close
from drivegen.maps.writers._quantities import Lanes
from drivegen.maps.writers._said import (
    OTHERS,
    Said,
    said_branches,
    said_control,
    said_numbers,
    said_others,
    said_places,
    said_ramps,
    said_shapes,
    said_turns,
    said_ways,
)
from drivegen.maps.writers._sentence import Sentence
from drivegen.maps.writers._small_words import SMALL_WORDS

_NEAR = 0.03
_SUBJECT = 3
_ENDS = ("comma", "stop", "and", "but")
_ROAD_WORDS = ("verb", "lane", "total", "radius", "diameter", "offset", "median", "speed_word")
_AT_ALL = ("at", "whatsoever")
_NEIGHBOURS = frozenset(("adjacent", "neighbour", "neighbours", "neighbor", "neighbors", "neighbouring", "neighboring"))


def refuse_unkept(s: Sentence, spec: MapSpec, waived: Collection[float] = ()) -> list[str]:
    """Raise UnusableInput at a fact that the road doesn't have; `waived` are lengths [m] that it needn't.

    Lengths of what hardly changes the road are returned instead, in the words of the description.
    """
    found = built(spec)
    said = [fact for read in _READERS for fact in read(s, found)]
    said = [fact for fact in said if not (fact.what.startswith("length") and s.tokens[fact.first].amount[0] in waived)]
    dropped: list[str] = []
    for fact in said:
        if fact.kept:
            continue
        if fact.what.startswith("length") and _is_aside(s, fact.first):
            dropped.append(_words(s, fact))
            continue
        rivals = [other for other in said if other.what == fact.what and other.kept and _words(s, other) != _words(s, fact)]
        if rivals:
            raise UnusableInput(
                f"{_words(s, rivals[0])!r} and {_words(s, fact)!r} cannot both hold for one road", reason="impossible-map"
            )
        raise UnusableInput(
            f"the road that I understand does not keep {_words(s, fact)!r}; please say it in other words", reason="not-understood"
        )
    return dropped


def _is_aside(s: Sentence, i: int) -> bool:
    """Whether the length at i is that of a leg or side road, or how far off something is ("the school is 120 m away")."""
    start, end = s.clause(i), next((j for j in range(i, len(s.tokens)) if s.tokens[j].kind in _ENDS), len(s.tokens))
    of_roads = any(start <= p.head < end for p in s.phrases) or any(_says_of_road(s, j) for j in range(start, end))
    if any(t.kind in ("total", "long") for t in s.tokens[start:end] if t.text not in ("away", "off")):
        of_roads = True  # "whole length 1 km"
    remark = [t for t in s.tokens[start:end] if t.kind == "unknown" and t.text not in SMALL_WORDS]
    if remark and not of_roads:
        return True
    before = s.last_before(i, "arm", "road", "place", "ramp", "shape", "auxiliary", "ring", "central")
    leg = before is not None and (before.kind == "arm" or before.role == "side") and is_close(s, before, i)
    cue = cue_of(s, i)
    return leg and (cue is None or s.tokens[cue].kind == "long")


def _says_of_road(s: Sentence, j: int) -> bool:
    """Whether token j speaks of a road without naming it; "from its end" does not."""
    return s.tokens[j].kind in _ROAD_WORDS and not (s.word(j, "verb") and s.word(j - 1, "det"))


def _thing(s: Sentence, i: int) -> str:
    """What the measure at i is said of, as far as that is needed to tell whether two measures are of the same."""
    cue, before = cue_of(s, i), s.last_before(i, "road", "arm", "place", "ramp", "shape")
    return f"{s.tokens[cue].kind if cue is not None else ''} {before.first if before is not None else ''}"


def _words(s: Sentence, fact: Said) -> str:
    first = fact.first - 1 if s.word(fact.first - 1, "neg") else fact.first
    return " ".join(t.text for t in s.tokens[first : fact.last + 1]).strip(" ,.")


def _is_near(value: float, values: Collection[float]) -> bool:
    return any(abs(value - other) <= _NEAR * max(value, other) for other in values)


def _measures(s: Sentence, found: Built) -> Iterator[Said]:
    """Speeds, lengths and angles that some rule took."""
    for i, token in enumerate(s.tokens):
        if i not in s.used or not token.amount:
            continue
        amount = token.amount[0]
        if token.kind == "speed":
            yield Said("speed", i, i, _is_near(amount, found.speeds))
        elif token.kind == "length":
            yield Said(f"length {_thing(s, i)}", i, i, _is_near(amount, _lengths_meant(s, i, found)))
        elif token.kind == "angle":
            kept = _is_near(amount, {a for b in found.angles for a in (b, 180.0 - b, 360.0 - b)})
            if found.gaps and any(t.text in _NEIGHBOURS for t in s.tokens[max(0, i - 9) : i + 9]):
                kept = all(_is_near(amount, (gap,)) for gap in found.gaps)
            yield Said(f"angle {_thing(s, i)}", i, i, kept)


def _lengths_meant(s: Sentence, i: int, found: Built) -> set[float]:
    """Lengths among which the one at i must be, by what it was taken to mean."""
    meaning = next((meaning for at, words, meaning in s.notes if at == i and words == s.tokens[i].text), "")
    if meaning.startswith("position") and found.positions:
        return found.positions
    if meaning.startswith("distance") and found.positions:
        return found.positions | found.distances
    if meaning.startswith("length") and found.positions:
        return found.lengths
    return found.lengths | found.between


def _lanes(s: Sentence, found: Built) -> Iterator[Said]:
    for item in s.lanes:
        if item.first in s.used:
            yield Said("lanes", item.first, item.last, item.count in _possible(item, found))
    for i in s.of_kind("lane", "", "ring"):
        ends = i + 1 == len(s.tokens) or s.tokens[i + 1].kind in ("comma", "stop", "each") or s.tokens[i + 1].text in _AT_ALL
        if ends and s.tokens[i].text.endswith("lanes") and any(s.word(j, "neg") for j in (i - 1, i - 2)):
            yield Said("lanes", i, i, s.negated_at(i) and s.word(i - 2, "neg") and s.tokens[i - 1].text in OTHERS)


def _possible(item: Lanes, found: Built) -> set[int]:
    if item.per in ("each", "arms", "all"):
        return found.lanes
    if item.per == "total":
        return found.totals
    return found.lanes | found.changes | found.totals


def _changes(s: Sentence, found: Built) -> Iterator[Said]:
    """Roads that narrow and widen."""
    less = found.counts["lane_drop"] + found.counts["off_ramp"] + found.counts["fork"] + found.counts["on_ramp"]
    more = found.counts["lane_gain"] + found.counts["on_ramp"] + found.counts["fork"]
    for i in s.verbs("narrow", "widen", "gain", "lose"):
        subject = s.last_before(i, "road", "shape")
        of_road = subject is not None and i - subject.head <= _SUBJECT and s.tokens[i].value in ("narrow", "widen")
        of_lanes = of_road or any(t.kind == "lane" for t in s.tokens[i + 1 : i + 4])
        if of_lanes and not s.negated_at(i):
            yield Said("lanes", i, i, (less if s.tokens[i].value in ("narrow", "lose") else more) > 0)
    for i in s.verbs("end"):
        if s.word(i - 1, "lane") and i in s.used and not s.negated_at(i):
            yield Said("lanes", i - 1, i, less > 0)
    for phrase in s.said("extra", "drop", "gain"):
        yield Said("lanes", phrase.first, phrase.head, (less if phrase.value == "drop" else more) > 0)


_READERS: tuple[Callable[[Sentence, Built], Iterator[Said]], ...] = (
    *(said_places, said_ramps, said_numbers, said_control, said_shapes, said_turns, said_ways),
    *(_changes, _lanes, _measures, said_others, said_branches),
)
