"""Roads that split into two or become one, and the lanes of their branches."""

from itertools import combinations

from drivegen.maps.writers._changes import last_of_count
from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._quantities import Lanes
from drivegen.maps.writers._sentence import Sentence

_TWO = 2


def read_branches(s: Sentence, facts: Facts) -> None:
    """Roads that split, with the lanes of their branches: "two go left and one right"."""
    one_way = [i for i in s.of_kind("one_way") if not s.negated_at(i)]
    branching = [i for i in s.verbs("join") if len(one_way) > 1 and s.tokens[i].text.startswith(("branch", "peel"))]
    for i in (*s.verbs("split"), *branching):
        if s.negated_at(i):
            s.use(i, i, "no fork")
            continue
        if facts.has("fork") and s.word(i - 1, "det"):
            s.use(i, i, "")  # "before and after the split"
            continue
        facts.features.setdefault("fork", i)
        s.use(i, i, "road that splits into two")
        subject = s.last_before(i, "road")
        if subject is not None and subject.text.endswith("carriageway"):
            facts.features.setdefault("carriageway", i)
        _read_branch_lanes(s, facts, i)
        s.used |= {p.first for p in s.said("arm") if p.number == _TWO and p.head > i and p.text.endswith("branches")}
        for j in range(i + 1, min(len(s.tokens), i + 4)):
            if s.tokens[j].kind == "number" and s.tokens[j].number == 2:
                s.use(j, j, "")


def _read_branch_lanes(s: Sentence, facts: Facts, i: int) -> None:
    """Lanes of the branches after the verb at i: "two left, one right", "two lanes each", "into two and two"."""
    sides = {
        t.value: j for j, t in enumerate(s.tokens) if t.kind == "pocket" and t.text.startswith("lane") and s.word(j - 1, "number")
    }
    if set(sides) == {"left", "right"}:  # "two lanes to the left and one lane to the right"
        facts.branches = (s.tokens[sides["left"] - 1].number, s.tokens[sides["right"] - 1].number)
        for side, j in sides.items():
            s.use(j - 1, j, f"{s.tokens[j - 1].number} to the {side}")
        return
    apiece = next((item for item in s.lanes if item.first > i and item.per == "each" and _of_branches(s, i, item)), None)
    if apiece is not None:
        facts.branches = (apiece.count, apiece.count)
        s.use(apiece.first, apiece.last, f"{apiece.count} lanes on each branch")
    else:
        _read_other_branch_lanes(s, facts, i)


def _read_other_branch_lanes(s: Sentence, facts: Facts, i: int) -> None:
    """Lanes told by sides, "each", or as two numbers."""
    turns = {t.value: j for j, t in enumerate(s.tokens) if t.kind == "turn"}
    if set(turns) == {"left", "right"}:
        counts = {side: _count_beside(s, j) for side, j in turns.items()}
        if counts["left"] and counts["right"]:
            facts.branches = (counts["left"], counts["right"])
    each = [item for item in s.lanes if item.first > i and (item.per == "each" or _of_two_roads(s, i, item))]
    told = set(turns) == {"left", "right"} or any(item.last < i and item.count >= each[0].count for item in s.lanes if each)
    if facts.branches is None and each and (told or _of_two_roads(s, i, each[0])):
        facts.branches = (each[0].count, each[0].count)
        s.use(each[0].first, each[0].last, f"{each[0].count} lanes on each branch")
    both = [j for j in range(i + 1, min(len(s.tokens), i + 8)) if s.tokens[j].kind == "number"]
    further = [j for j in range(i + 1, min(len(s.tokens), i + 13)) if s.tokens[j].kind == "number"][:3]
    if len(further) == 3 and s.between(further[1], further[2], "and") and not s.between(further[0], further[2], "stop"):
        both = further
    if len(further) == 2 and s.between(further[0], further[1], "and") and all(_is_lanes(s, j) for j in further):
        both = further
    if len(both) == 3 and s.tokens[both[0]].number == sum(s.tokens[j].number for j in both[1:]):
        both = both[1:]  # "four lanes become two and two"
    if facts.branches is None and len(both) == 2 and s.between(both[0], both[1], "and"):
        facts.branches = (s.tokens[both[0]].number, s.tokens[both[1]].number)
        s.use(both[0], both[1], f"{facts.branches[0]} lanes to the left, {facts.branches[1]} to the right")
        for item in s.lanes:
            if item.first in both:
                s.used.update(range(item.first, item.last + 1))


def _of_branches(s: Sentence, i: int, item: Lanes) -> bool:
    """Whether the lanes are said right behind the two branches: "splits into two branches with two lanes apiece"."""
    before = s.last_before(item.first, "arm", "road")
    return before is not None and before.first > i and before.number == _TWO and item.first - before.head <= _TWO


def _is_lanes(s: Sentence, j: int) -> bool:
    return any(item.first == j for item in s.lanes)


def _of_two_roads(s: Sentence, i: int, item: Lanes) -> bool:
    """Whether the lanes are those of the two roads that the verb at i leads to: "splits into two three-lane carriageways"."""
    two = next((p for p in s.said("road") if p.first > i and p.number == 2), None)
    if two is None:
        return False
    return two.first <= item.first < two.head or (s.governed(two.head) is None and two.head + 2 == item.first)


def read_joining_roads(s: Sentence, facts: Facts) -> None:
    """Two roads that become one: "two motorways merge into one"."""
    if any(s.said("place")):
        return
    if _read_sum(s, facts):
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
        s.use(phrase.first, last, "2 roads become 1")
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


def _is_named_first(s: Sentence) -> bool:
    """Whether branches are named before their lanes: "left branch one lane, right branch two"."""
    turn = next(s.of_kind("turn"))
    return all(item.first > turn for item in s.lanes) and (s.word(turn + 1, "role") or s.word(turn + 1, "with"))


def _count_beside(s: Sentence, turn: int) -> int:
    following = [j for j in range(turn + 1, min(len(s.tokens), turn + 4)) if s.tokens[j].kind == "number"]
    backwards = range(turn, max(-1, turn - 6), -1)
    for j in following[:1] if following and _is_named_first(s) else backwards:
        token = s.tokens[j]
        if token.kind in ("stop", "verb") and j != turn and token.value == "split":
            return 0
        if token.kind == "number" and token.number <= 4:
            s.use(j, turn, f"{token.number} to the {s.tokens[turn].value}")
            for item in s.lanes:
                if item.first <= j <= item.last:
                    s.used.update(range(item.first, item.last + 1))
            return token.number
    return 0
