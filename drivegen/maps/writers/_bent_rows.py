"""Junctions along a road that bends: where they lie against its bends, and on which side their roads join."""

from drivegen.errors import UnusableInput
from drivegen.maps.spec_alignment import Alignment
from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._sentence import Sentence

BENDS = ("curve", "s_curve", "hairpin")

_ROOM = 60.0
"""Between a bend and a junction that is not said to lie in it [m], and behind it up to the road's end."""

_NEAR = 6
_BEFORE, _BEHIND = ("before", "ahead"), ("after", "behind", "beyond", "past", "later")
_LINKS = frozenset(
    (
        "prep",
        "det",
        "before",
        "later",
        "seq",
        "and",
        "small",
        "unknown",
        "comma",
        "number",
        "bend_size",
        "turn",
        "road",
        "right_angle",
        "angle",
    )
)
_INSIDE = frozenset(("on", "in", "at", "within", "inside", "along", "through", "of", "halfway", "middle", "apex", "around"))


def read_junctions_at_bends(s: Sentence, facts: Facts) -> None:
    """Whether junctions lie before a bend, in it or behind it, and how far from it: "a side road 100 m after the bend"."""
    bends = list(s.said("shape", *BENDS))
    joins = sorted((p for p in s.phrases if _is_junction(p)), key=lambda p: p.first)
    if not bends or not joins:
        return
    _read_distance(s, facts, bends, joins)
    for bend in bends if not facts.at_bend else ():
        join = min(joins, key=lambda p: abs(p.head - bend.head))
        first, last = sorted((bend, join), key=lambda p: p.head)
        between = s.tokens[first.head + 1 : last.first]
        words = {word for t in (*between, *s.tokens[last.first : last.head]) for word in t.text.split()}
        facts.at_bend = facts.at_bend or _place(words, join is first, _stands_in(s, bend, join))
    facts.at_bend = facts.at_bend or ("in" if len(joins) > 1 or (joins[0].number or 1) > 1 else "behind")
    if any({"inside", "inner"} & set(t.text.split()) for join in joins for t in s.tokens[join.head + 1 : join.head + _NEAR]):
        facts.side_turn = "inside"
    for i in s.of_kind("turn"):
        near = _owner(s, i)
        if near is not None and _is_junction(near):
            facts.side_turn = facts.side_turn or ("left" if s.tokens[i].value == "left" else "right")
            s.use(i, i, f"side road to the {s.tokens[i].value}")
            facts.side_turns.add(i)


def _is_junction(phrase: Phrase) -> bool:
    return not phrase.negated and (
        phrase.kind == "place" or (phrase.kind == "road" and phrase.role == "side") or phrase.kind == "dead_end"
    )


def _read_distance(s: Sentence, facts: Facts, bends: list[Phrase], joins: list[Phrase]) -> None:
    for i in s.of_kind("length"):
        if i in s.used or i in s.aside or s.word(i + 1, "radius") or s.word(i - 1, "radius"):
            continue
        bend = next((p for p in bends if p.first > i and all(t.kind in _LINKS for t in s.tokens[i + 1 : p.first])), None)
        word = s.tokens[i + 1].text.split()[0] if i + 1 < len(s.tokens) else ""
        if bend is not None and word in (*_BEFORE, *_BEHIND):
            before_it = any(join.head < i for join in joins)
            later = word == "later"  # "a crossing, 150 m later the road bends"
            facts.at_bend = "before" if word in _BEFORE or (later and before_it) else "behind"
        elif _is_behind_bend(s, i, bends, joins):
            facts.at_bend = "behind"
        elif word in (*_BEFORE, *_BEHIND) and _bends_near_junction(s, i, bends, joins):
            facts.at_bend = "behind" if word in _BEFORE else "before"
        else:
            continue
        facts.lengths["from_bend"] = s.tokens[i].amount[0]
        s.use(i, i, f"{s.tokens[i].text} {facts.at_bend} the bend")
        return


def _bends_near_junction(s: Sentence, i: int, bends: list[Phrase], joins: list[Phrase]) -> bool:
    """Whether the length at i says where a road bends: "the road bends to the left 100 m after the junction"."""
    join = next((p for p in joins if p.first > i and all(t.kind in _LINKS for t in s.tokens[i + 1 : p.first])), None)
    before = max((p for p in (*bends, *joins) if p.head < i), key=lambda p: p.head, default=None)
    return join is not None and before is not None and any(before is p for p in bends)


def _is_behind_bend(s: Sentence, i: int, bends: list[Phrase], joins: list[Phrase]) -> bool:
    """Whether the length at i leads from a bend to a junction: "a bend and, 200 m further on, a crossing"."""
    word = s.tokens[i + 1].kind if i + 1 < len(s.tokens) else ""
    join = next((p for p in joins if p.first > i), None)
    before = max((p.head for p in (*bends, *joins) if p.head < i), default=-1)
    after_bend = any(p.head == before for p in bends) and join is not None and not s.between(i, join.first, "stop", "length")
    return after_bend and (word == "later" or s.tokens[i - 1].text in ("after", "another"))


def _place(words: set[str], junction_first: bool, stands_in: bool) -> str:
    """Before the bend, in it or behind it, by the words between the two."""
    if words & set(_BEFORE):
        return "before" if junction_first else "behind"
    if words & set(_BEHIND) or "then" in words or "followed" in words:
        return "behind" if junction_first and words & set(_BEHIND) else "before" if junction_first else "behind"
    return "in" if stands_in else ""


def _stands_in(s: Sentence, bend: Phrase, join: Phrase) -> bool:
    """Whether the junction is said to lie in the bend: "a crossing on a curve", "a curve with a side road at its apex"."""
    if join.head < bend.head:
        words = [word for t in s.tokens[join.head + 1 : bend.first] for word in t.text.split()]
        return bool(_INSIDE & set(words[-4:]))
    words = [word for t in s.tokens[join.head + 1 : join.head + 8] for word in t.text.split()]
    return bool({"apex", "halfway", "middle", "outside", "inside", "bend", "curve", "midway"} & set(words))


def _owner(s: Sentence, i: int) -> Phrase | None:
    """What the side at token i is said of: the phrase around it, else the last one before it."""
    around = next((p for p in s.phrases if p.first <= i <= p.head and (p.kind == "shape" or _is_junction(p))), None)
    before = [p for p in s.phrases if p.head < i and (p.kind == "shape" or _is_junction(p))]
    return around or (before[-1] if before else None)


def placed_at_bend(facts: Facts, line: dict[str, object], between: float, start: float | None) -> tuple[dict[str, object], float]:
    """The line of a road, made longer where it must be, and where on it the first of junctions lies that take `between` [m].

    `start` is that place where it was said. Raises UnusableInput where they do not fit into the length that was said.
    """
    if start is not None:
        return line, start
    told = Alignment.model_validate(line)
    distance = facts.lengths.get("from_bend", _ROOM)
    need = distance + between + _ROOM if facts.at_bend != "in" else max(told.straight, between / 2)
    if told.straight < need and "length" not in facts.lengths:
        line = {**line, "length": told.length + (need - told.straight) * told.straights}
        told = Alignment.model_validate(line)
    begin, end = told.spans[0][0], told.spans[-1][1]
    first = {"before": begin - distance - between, "behind": end + distance}.get(facts.at_bend, (begin + end - between) / 2)
    if first < _ROOM / 2 or first + between > told.length - _ROOM / 2:
        raise UnusableInput("the road is too short for its bends and junctions", reason="impossible-map")
    return line, first


def side_at_bend(line: dict[str, object], told: str) -> str:
    """The side of a road at a bend: as told, else the outer one, where there is most room."""
    to_the_left = sum(Alignment.model_validate(line).turns) >= 0
    if told in ("left", "right"):
        return told
    return "left" if to_the_left == (told == "inside") else "right"
