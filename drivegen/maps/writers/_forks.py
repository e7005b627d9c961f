"""Roads that split into two, and the lanes of their branches."""

from drivegen.maps.writers._changes import is_lane_count
from drivegen.maps.writers._facts import Facts
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
        for phrase in (*s.said("arm"), *s.said("road")):
            if phrase.number == _TWO and phrase.head > i:
                s.used.update(j for j in range(phrase.first, phrase.head) if s.word(j, "number"))
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
    if named := lanes_of_named(s):
        for side, j in named.items():
            s.use(j, max([item.last for item in s.lanes if item.first == j] or [j]), f"{s.tokens[j].number} on the {side} branch")
        facts.branches = (s.tokens[named["left"]].number, s.tokens[named["right"]].number)
    elif set(turns) == {"left", "right"}:
        counts = {side: _count_beside(s, j) for side, j in turns.items()}
        if counts["left"] and counts["right"]:
            facts.branches = (counts["left"], counts["right"])
    each = [item for item in s.lanes if item.first > i and (item.per == "each" or _of_two_roads(s, i, item))]
    told = set(turns) == {"left", "right"} or any(item.last < i and item.count >= each[0].count for item in s.lanes if each)
    if facts.branches is None and each and (told or _of_two_roads(s, i, each[0])):
        facts.branches = (each[0].count, each[0].count)
        s.use(each[0].first, each[0].last, f"{each[0].count} lanes on each branch")
    both = _two_numbers(s, i)
    if facts.branches is None and len(both) == 2 and s.between(both[0], both[1], "and"):
        facts.branches = (s.tokens[both[0]].number, s.tokens[both[1]].number)
        s.use(both[0], both[1], f"{facts.branches[0]} lanes to the left, {facts.branches[1]} to the right")
        for item in s.lanes:
            if item.first in both:
                s.used.update(range(item.first, item.last + 1))


def _two_numbers(s: Sentence, i: int) -> list[int]:
    """Two numbers after the verb at i, as "three and two lanes", or those into which one is divided."""
    both = [j for j in range(i + 1, min(len(s.tokens), i + 8)) if s.tokens[j].kind == "number"]
    further = [j for j in range(i + 1, min(len(s.tokens), i + 13)) if s.tokens[j].kind == "number"][:3]
    if len(further) == 3 and s.between(further[1], further[2], "and") and not s.between(further[0], further[2], "stop"):
        both = further
    if len(further) == 2 and s.between(further[0], further[1], "and") and all(_is_lanes(s, j) for j in further):
        both = further
    if len(both) == 3 and s.tokens[both[0]].number == sum(s.tokens[j].number for j in both[1:]):
        both = both[1:]  # "four lanes become two and two"
    return _into_two(s) or both


def _into_two(s: Sentence) -> list[int]:
    """The last two numbers of "four lanes into two and two"."""
    for i in s.of_kind("prep", "to"):
        numbers = [j for j in (i - 2, i - 1, i + 1, i + 3) if s.word(j, "number")]
        if len(numbers) == _TWO + 1 and s.word(i + 2, "and") and any(item.first == numbers[0] for item in s.lanes):
            return numbers[1:]
    return []


def lanes_of_named(s: Sentence) -> dict[str, int]:
    """Where the lanes of the "left" and the "right branch" stand, before both names or behind both; {} where they do not."""
    named = {s.tokens[j].value: j for j in s.of_kind("turn") if s.word(j + 1, "arm") or s.word(j + 1, "road")}
    for j in s.of_kind("ordinal"):  # "and the right one two"
        side = next((side for side in ("left", "right") if side in s.tokens[j].text.split()), None)
        if side is not None and named:
            named.setdefault(side, j - 1)
    if set(named) != {"left", "right"}:
        return {}
    first = min(named.values())
    before = first > 0 and s.tokens[first - 1].kind in ("lane", "number")
    places = {side: _number_before(s, j) if before else _number_behind(s, j + 1) for side, j in named.items()}
    told = {side: i for side, i in places.items() if i is not None}
    return told if len(told) == _TWO else {}


def _number_before(s: Sentence, j: int) -> int | None:
    i = j - 2 if s.word(j - 1, "lane") else j - 1
    return i if s.word(i, "number") else None


def _number_behind(s: Sentence, j: int) -> int | None:
    i = j + 1
    while i < len(s.tokens) and s.tokens[i].kind in ("with", "is", "but", "prep", "comma", "det", "verb"):
        i += 1
    return i if s.word(i, "number") and is_lane_count(s, i) else None


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
