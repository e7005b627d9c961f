"""Roads that become one: "two motorways merge into one", "a two-lane and a three-lane road merge into a five-lane one"."""

from itertools import combinations

from drivegen.maps.writers._changes import last_of_count
from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._sentence import Sentence


def read_joining_roads(s: Sentence, facts: Facts) -> None:
    """Two roads that become one: "two motorways merge into one"."""
    if any(s.said("place")):
        return
    if _read_sum(s, facts) or _read_two_become(s, facts):
        return
    for phrase in (*s.said("road"), *s.said("ramp")):
        verb = _becomes_one(s, phrase)
        merges = (
            verb is not None
            or _ramps_become_one(s, phrase)
            or any(t.kind == "verb" and t.value == "merge" for t in s.tokens[max(0, phrase.first - 2) : phrase.first])
        )
        if phrase.number != 2 or not merges or phrase.role:
            continue
        facts.features.update({"fork": phrase.first, "joining": phrase.first})
        one = next((p for p in s.said("road") if p.first > phrase.head), None)
        end = verb if verb is not None else one.first if one is not None else len(s.tokens)
        inner = [item for item in s.lanes if phrase.head < item.first and item.last < end]
        later = [item for item in s.lanes if item.first >= end and item.per != "each"]
        told = phrase.lanes or (inner[0].count if inner else later[0].count if len(later) > 1 else None)
        each = told or 2
        for item in (*inner[:1], *later):
            s.use(item.first, item.last, f"{item.count} lanes")
        facts.branches = (each, each)
        facts.lanes["main"] = one.lanes if one is not None and one.lanes else later[-1].count if later else 2 * each
        last = one.head if one is not None else phrase.head
        for i in range(phrase.head + 1, min(phrase.head + 5, len(s.tokens))):
            last = max(last, i) if s.tokens[i].kind == "number" else last
        measures = {i for i in range(phrase.first, last) if s.tokens[i].amount and s.tokens[i].kind != "number"} - s.used
        s.use(phrase.first, last, "2 roads become 1")
        s.used -= measures  # "two roads of 300 m join into a single one"
        return


def _read_sum(s: Sentence, facts: Facts) -> bool:
    """Lanes of two roads that add up to those of one: "a two-lane and a three-lane freeway merge into a five-lane one"."""
    verbs = [i for i in s.verbs("merge", "join", "become", "meet") if not s.negated_at(i)]
    if not any(s.tokens[i].value in ("merge", "join", "meet") for i in verbs) or any(s.said("ramp")):
        return False
    places = [i for i in s.of_kind("number") if _may_be_lanes(s, i)]
    for a, b, one in combinations(places, 3):
        left, right, both = (s.tokens[i].number for i in (a, b, one))
        if (
            left + right != both
            or _another_verb(s, a, b)
            or not (s.between(b, one, "verb", "prep") or s.tokens[one - 1].text == "=")
        ):
            continue
        facts.features.update({"fork": a, "joining": a})
        facts.branches = (left, right)
        facts.lanes["main"] = both
        s.use(a, last_of_count(s, one), f"2 roads of {left} and {right} lanes become 1 of {both}")
        for phrase in s.said("road"):
            if phrase.number == 2:
                s.use(phrase.first, phrase.head, "")
        for i in verbs:
            s.use(i, i, "")
        return True
    return False


def _read_two_become(s: Sentence, facts: Facts) -> bool:
    """Lanes of two roads side by side that become fewer: "two lanes and two lanes become three lanes"."""
    for a, b, one in zip(s.lanes, s.lanes[1:], s.lanes[2:], strict=False):
        joined = [t.kind for t in s.tokens[a.last + 1 : b.first]] == ["and"]
        verbs = [t.value for t in s.tokens[b.last + 1 : one.first] if t.kind == "verb"]
        fits = max(a.count, b.count) <= one.count <= a.count + b.count
        if joined and verbs and verbs[0] in ("become", "merge", "join") and fits and not any(x.per for x in (a, b, one)):
            facts.features.update({"fork": a.first, "joining": a.first})
            facts.branches, facts.lanes["main"] = (a.count, b.count), one.count
            s.use(a.first, one.last, f"2 roads of {a.count} and {b.count} lanes become 1 of {one.count}")
            for i in s.verbs("merge"):
                s.use(i, i, "")
            return True
    return False


def _another_verb(s: Sentence, a: int, b: int) -> bool:
    """Whether the lanes at a and b are not those of two roads beside each other, or of one that merges with the other."""
    if s.between(a, b, "prep") and any(t.kind == "prep" and t.value == "to" for t in s.tokens[a:b]):
        return s.between(a, b, "verb")
    return any(t.kind == "verb" and t.value not in ("merge", "join", "meet") for t in s.tokens[a:b])


def _may_be_lanes(s: Sentence, i: int) -> bool:
    if not 1 <= s.tokens[i].amount[0] <= 8 or s.tokens[i].amount[0] % 1:
        return False
    return any(item.first == i for item in s.lanes) or not (s.word(i + 1, "road") or s.word(i + 1, "with"))


def _ramps_become_one(s: Sentence, phrase: Phrase) -> bool:
    """ "Two ramps merge into one road": the verb is part of the ramps' name."""
    after = s.tokens[phrase.head + 1 : phrase.head + 3]
    return phrase.kind == "ramp" and "merg" in s.tokens[phrase.head].text and [t.kind for t in after] == ["prep", "number"]


def _becomes_one(s: Sentence, phrase: Phrase) -> int | None:
    """The verb by which the roads merge, or come together "into one", "to form a single road"."""
    i = next((i for i in s.verbs() if i > phrase.head), None)
    if i is None or i > phrase.head + 8 or s.between(phrase.head, i, "stop", "place", "road"):
        return None
    if phrase.kind == "ramp" and phrase.value != "" and not _into_one(s, i):
        return None  # "two on-ramps merge onto a freeway"
    if s.tokens[i].value in ("merge", "become"):
        apart = any(t.kind not in ("with", "number", "lane", "each", "of") for t in s.tokens[phrase.head + 1 : i])
        return i if not (apart and s.between(phrase.head, i, "comma", "with")) or i <= phrase.head + 2 else None
    after = s.tokens[i + 1 : i + 5]
    into = any(t.kind == "prep" and t.value == "to" for t in after)
    one = any((t.kind == "number" and t.number == 1) or t.text in ("single", "common") for t in after)
    if any(t.kind == "verb" and t.value == "become" for t in after):
        return i if s.tokens[i].value in ("meet", "join", "merge") else None
    return i if s.tokens[i].value in ("meet", "join") and one and (into or s.tokens[i].text.endswith("into")) else None


def _into_one(s: Sentence, i: int) -> bool:
    after = s.tokens[i + 1 : i + 4]
    return any((t.kind == "number" and t.number == 1) or t.text in ("single", "common") for t in after)
