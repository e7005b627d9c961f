"""Junctions: roundabouts, T and Y junctions, crossings, and how many roads meet at them."""

import re
from dataclasses import replace

from drivegen.errors import UnusableInput
from drivegen.maps.writers._arms import read_arms
from drivegen.maps.writers._control import one_for_all
from drivegen.maps.writers._facts import Facts, JunctionWords
from drivegen.maps.writers._layouts import read_grid
from drivegen.maps.writers._mentions import mentioned
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._places_along import listed_places
from drivegen.maps.writers._rows import meant_of_a_row, read_arms_of_a_row, read_positions_of_a_row
from drivegen.maps.writers._sentence import Sentence

_NAMES = {"t": "T-junction", "y": "Y-junction", "crossing": "crossing", "roundabout": "roundabout"}
_FEWEST = 3
_MIDDLE = frozenset(("middle", "halfway", "midway", "midpoint", "centre", "center", "half"))


def read_junctions(s: Sentence, facts: Facts) -> None:
    """Find all junctions, in the order of the text."""
    read_grid(s, facts)
    for phrase in s.phrases:
        if phrase.kind == "place" and phrase.head not in s.used:
            _read_place(s, facts, phrase)
    if len(facts.junctions) == 1 and facts.junctions[0].count == 1 and any(s.said("central")):
        facts.junctions[0].form = "roundabout"  # only rings have an island in the middle
        facts.lengths.pop("length", None)
    if any(junction.form == "roundabout" for junction in facts.junctions):
        for phrase in (*s.said("ring"), *s.said("central")):
            s.use(phrase.head, phrase.head, "")
    elif (ring := next(s.said("ring"), None)) and _stands_for_roundabout(s, ring):
        facts.junctions.append(JunctionWords("roundabout", ring.first, ring.arms))
        s.use(ring.head, ring.head, "roundabout")
    _put_between(s, facts)
    _read_ways_that_stop(s, facts)
    read_positions_of_a_row(s, facts)
    read_arms_of_a_row(s, facts)
    read_arms(s, facts)
    _refuse_crossroads_of_three(s, facts)
    _read_counted_signals(s, facts)


def _refuse_crossroads_of_three(s: Sentence, facts: Facts) -> None:
    """Raise UnusableInput at "crossroads with three arms"."""
    crossroads = {p.first for p in s.said("place", "crossing") if "crossroads" in p.text}
    if any(j.at in crossroads and j.arms == _FEWEST and not j.shape for j in facts.junctions):
        raise UnusableInput("crossroads have four arms, not three", reason="impossible-map")


def _put_between(s: Sentence, facts: Facts) -> None:
    """The order of "a roundabout between two T-junctions", "between two crossings there is a T-junction"."""
    counts = [j.count for j in facts.junctions]
    if counts not in ([1, 2], [2, 1]):
        return
    outer, inner = sorted(facts.junctions, key=lambda j: -j.count)
    before = next((i for i in range(outer.at - 1, -1, -1) if s.tokens[i].text == "between"), None)
    if before is None or s.between(before, outer.at, "place", "comma"):
        return
    if counts == [2, 1] and "spacing" in facts.lengths:
        facts.lengths["spacing"] /= 2  # said of the outer two
    facts.junctions[:] = [replace(outer, count=1), inner, replace(outer, count=1)]


def _stands_for_roundabout(s: Sentence, ring: Phrase) -> bool:
    return ring.text.endswith(("circle", "circles")) or any(
        p.number and p.number >= _FEWEST for p in (*s.said("arm"), *s.said("road"))
    )


def _read_place(s: Sentence, facts: Facts, phrase: Phrase) -> None:
    name = _NAMES.get(phrase.value, phrase.value)
    if phrase.negated:
        s.use(phrase.first, phrase.head, f"no {name}s")
        return
    if phrase.value == "staggered":
        facts.features.setdefault("staggered", phrase.first)
        first = phrase.text.split()[0]
        facts.turn = "right" if first == "right" else "left" if first == "left" else facts.turn
        facts.control = facts.control or one_for_all(phrase)
        s.use(phrase.first, phrase.head, "staggered junction")
        return
    of_lanes = {j for item in s.lanes for j in range(item.first, item.last + 1)}
    if any(s.word(j, "number") and j in s.used and j not in of_lanes for j in range(phrase.first, phrase.head)):
        phrase.number = None  # "splits in two like the letter Y"
    _use_words(s, phrase)
    arms = phrase.arms or _ways(s, phrase)
    if _is_of_a_row(s, facts, phrase, arms):
        return
    same = mentioned(s, facts, phrase)
    if same is not None:
        same.arms = same.arms or arms
        same.control = same.control or _own_control(phrase)
        same.middle |= _lies_in_the_middle(s, phrase)
        if phrase.value in ("t", "y") and not same.shape and same.form == "crossing":
            same.shape, same.arms = phrase.value, same.arms or _FEWEST
        s.use(phrase.head, phrase.head, name)
        return
    shape = phrase.value if phrase.value in ("t", "y") else ""
    form = "roundabout" if phrase.value == "roundabout" else "crossing"
    count = phrase.number or 1
    if phrase.arms is None and arms is not None:
        count = 1
    junction = JunctionWords(
        form,
        phrase.first,
        arms or (_FEWEST if shape else None),
        shape,
        count,
        _own_control(phrase),
        gap=phrase.gap,
        position=phrase.position,
    )
    following = s.tokens[phrase.head + 1 : phrase.head + 2]
    if following and following[0].kind == "turn":
        junction.side = "left" if following[0].value == "left" else "right"
    junction.middle = junction.position is None and _lies_in_the_middle(s, phrase)
    places = listed_places(s, phrase)
    facts.junctions += [replace(junction, count=1, position=metres) for metres in places] or [junction]
    s.use(phrase.first if phrase.number else phrase.head, phrase.head, name if count == 1 else f"{count} {name}s")


def _lies_in_the_middle(s: Sentence, phrase: Phrase) -> bool:
    """Whether the junction is said to be in the middle of its road, right behind it or, "halfway along", right before it."""
    behind = [word for t in s.tokens[phrase.head + 1 : phrase.head + 5] for word in t.text.split()]
    before = [word for t in s.tokens[max(0, phrase.first - 5) : phrase.first] for word in t.text.split()]
    return bool(_MIDDLE & {*behind, *before}) and not s.between(phrase.first - 5, phrase.head + 5, "shape", "ordinal")


def _read_ways_that_stop(s: Sentence, facts: Facts) -> None:
    """Five roads meet at "a five-way stop"."""
    for phrase in s.said("control", "all_way_stop"):
        all_roads = re.match(r"all (\d) ", phrase.text)
        if all_roads and facts.junctions and (facts.junctions[0].arms or int(all_roads[1])) != int(all_roads[1]):
            raise UnusableInput(
                f"{phrase.text!r} cannot be said of a junction of {facts.junctions[0].arms} roads", reason="impossible-map"
            )
        ways = re.match(r"(?:an? )?(\d) way", phrase.text)
        if ways and not facts.junctions:
            facts.junctions.append(JunctionWords("crossing", phrase.first, int(ways[1]), control="all_way_stop"))
        elif ways and len(facts.junctions) == 1 and facts.junctions[0].arms is None:
            facts.junctions[0].arms = int(ways[1])


def _is_of_a_row(s: Sentence, facts: Facts, phrase: Phrase, arms: int | None) -> bool:
    """Say of a junction of a row what it is, if the phrase does: "the first is a T, the second a roundabout"."""
    by_ordinal = "ordinal" in phrase.words or s.word(phrase.first - 2, "ordinal")  # "the middle one is a roundabout"
    told_apart = len(facts.junctions) > 1 and (phrase.det == "the" or by_ordinal)
    row = told_apart or any(junction.count > 1 for junction in facts.junctions)
    if not row or (phrase.number or 1) > 1:
        return False
    named = meant_of_a_row(s, facts, phrase)
    if len(named) != 1:
        return False
    one = named[0]
    one.at = phrase.first
    one.form = "roundabout" if phrase.value == "roundabout" else one.form
    one.shape = phrase.value if phrase.value in ("t", "y") else one.shape
    one.arms = arms or (_FEWEST if one.shape else one.arms)
    one.control = _own_control(phrase) or one.control
    s.use(phrase.head, phrase.head, _NAMES.get(phrase.value, phrase.value))
    return True


def _use_words(s: Sentence, phrase: Phrase) -> None:
    for i in range(phrase.first, phrase.head):
        if s.tokens[i].kind in ("control", "number", "arm", "many"):
            s.used.add(i)
        if s.tokens[i].kind == "road" and s.word(i - 1, "number"):
            s.used.update((i - 1, i))


def _ways(s: Sentence, phrase: Phrase) -> int | None:
    """Four in "four-way intersection" where the phrase begins after the number."""
    before = s.tokens[max(0, phrase.first - 2) : phrase.first]
    if len(before) == 2 and before[0].kind == "number" and before[1].kind in ("arm", "two_way"):
        s.used.update((phrase.first - 2, phrase.first - 1))
        return before[0].number
    return None


def _own_control(phrase: Phrase) -> str | None:
    return phrase.words.get("control")


def _read_counted_signals(s: Sentence, facts: Facts) -> None:
    """Lights that are counted are junctions: "three traffic lights every 200 m"."""
    for phrase in s.said("control", "signals"):
        if (phrase.number or 0) >= 2 and not facts.junctions and not facts.has("grid"):
            facts.junctions.append(JunctionWords("crossing", phrase.first, None, "", phrase.number or 2, "signals"))
            s.use(phrase.first, phrase.head, f"{phrase.number} signalised crossings")
