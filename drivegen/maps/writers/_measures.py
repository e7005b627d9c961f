"""Lengths and angles, and what each measures."""

from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._owners import arm_role, is_close
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._places_along import give_to_part, leads_to_junction, lists_of_places
from drivegen.maps.writers._sentence import Sentence

_WIDEST_MEDIAN = 100.0
_NEAR_ISLAND = 5
_WIDEST_RING = 100.0
_PAIR = 2
_NEAR_THING = 7
_BENDS = ("curve", "s_curve", "hairpin")
_LEGS = frozenset(("straight", "straights", "legs", "tangents", "approaches", "arms"))
_CUES = ("radius", "diameter", "spacing", "offset", "later", "before", "start", "long", "auxiliary", "weaving", "median")


def read_lengths(s: Sentence, facts: Facts) -> None:
    """Lengths by role; the words beside a number tell what it measures."""
    listed = {i for places in lists_of_places(s) for i in places[1:]}
    for i in s.of_kind("length"):
        if i in s.used or i in s.aside:
            continue
        if i in listed:
            s.use(i, i, f"position {s.tokens[i].text}")
            continue
        metres, cue = s.tokens[i].amount[0], cue_of(s, i)
        name = _named(s, i, cue) if not leads_to_junction(s, i) else "gap"
        if name == "length" and _is_of_lanes(s, i) and facts.has("lane_drop", "lane_gain", "lane_change"):
            name = "position"
        if name in ("gap", "position") and give_to_part(s, facts, i, name, metres, cue):
            pass
        elif name == "gap":
            changes = facts.has("lane_drop", "lane_gain", "lane_change") or any(e.keeps for e in facts.events)
            changes = changes and not facts.junctions
            facts.lengths.setdefault("position" if changes else "spacing", metres)
        else:
            facts.whole |= name == "length" and "length" not in facts.lengths and _is_of_the_whole(s, i, cue)
            facts.lengths.setdefault(name, metres)
        shown = {"auxiliary": "auxiliary lane", "gap": "distance"}.get(name, name)
        s.use(i, i, f"{shown} {s.tokens[i].text}")
    alone = next((i for i in s.of_kind("number") if i not in s.used and s.tokens[i].number >= 20 and _cue_word(s, i)), None)
    if alone is not None:
        name = s.tokens[alone - 1 if s.tokens[alone - 1].kind in _CUES else alone - 2].kind
        facts.lengths.setdefault(name, s.tokens[alone].amount[0])
        s.use(alone, alone, f"{name} {s.tokens[alone].text} m")


def _is_of_lanes(s: Sentence, i: int) -> bool:
    """Whether lanes are there for so long: "four lanes for 500 m, after which the left one ends"."""
    return i > 1 and s.tokens[i - 1].text in ("for", "over") and s.tokens[i - 2].kind in ("lane", "each")


def _is_of_the_whole(s: Sentence, i: int, cue: int | None) -> bool:
    """Whether the words say that the whole road is so long: "a 300 m highway", "300 m long", "300 m in total"."""
    inside = any(
        p.kind == "road" and (p.first <= i < p.head or (p.head == i - 2 and s.tokens[i - 1].text == "of")) for p in s.phrases
    )
    return inside or cue is not None or any(s.word(j, "total") or s.word(j, "long") for j in (i - 1, i + 1))


def _cue_word(s: Sentence, i: int) -> bool:
    before = [t.kind for t in s.tokens[max(0, i - 2) : i]]
    return any(kind in ("radius", "diameter", "spacing") for kind in before)


def cue_of(s: Sentence, i: int) -> int | None:
    """The token that says what the length at i measures: right after it, else close before it."""
    for j in range(i + 1, min(len(s.tokens), i + 4)):
        token = s.tokens[j]
        if token.kind in _CUES:
            return j
        if not (
            token.kind in ("is", "small", "auxiliary")
            or (token.kind == "prep" and token.value in ("on", "of"))
            or token.text in ("long", "further")
        ):
            break
    for j in range(i - 1, max(-1, i - 5), -1):
        token = s.tokens[j]
        if token.kind in _CUES and not (token.kind in ("later", "before", "spacing") and _has_length(s, j, i)):
            return j
        if token.kind in ("length", "stop", "comma", "road", "place", "ramp", "speed", "verb", "number", "lane"):
            return None
    return None


def _has_length(s: Sentence, j: int, i: int) -> bool:
    """Whether the cue at j already follows a length of its own."""
    return j > 0 and s.tokens[j - 1].kind == "length" and j - 1 != i


def _named(s: Sentence, i: int, cue: int | None) -> str:
    kind = s.tokens[cue].kind if cue is not None else ""
    if (thing := _of_ring(s, i, kind) or _own_thing(s, i, kind)) is not None:
        return thing
    if kind in ("", "diameter", "median") and s.tokens[i].amount[0] <= _WIDEST_MEDIAN and _is_of_median(s, i):
        return "median"
    if kind == "spacing" and s.tokens[cue or 0].text in ("away", "distance"):
        kind = "later" if s.tokens[cue or 0].text == "away" else "spacing"
    if kind == "long":
        return _what_is_long(s, i)
    if kind:
        return {"later": "gap", "before": "gap", "start": "position", "weaving": "auxiliary"}.get(kind, kind)
    before = s.tokens[i - 1] if i else None
    if before is not None and before.kind == "prep" and before.text in ("at", "after"):
        return "position" if before.text == "at" else "gap"
    if _is_inside(s, i, "auxiliary", "weaving"):
        return "auxiliary"
    return _what_is_long(s, i)


def _of_ring(s: Sentence, i: int, kind: str) -> str | None:
    """Whether the length is that of a ring or of its island: "a roundabout of 26 m", "a central island of 20 m"."""
    near = s.last_before(i, "central", "ring", "road", "arm", "place")
    if near is None or kind not in ("", "diameter") or i - near.head > _NEAR_ISLAND:
        return None
    if near.kind == "central":
        return "island"
    one = near.value == "roundabout" and (near.number or 1) == 1
    bare = s.word(i - 1, "comma") and (i + 1 == len(s.tokens) or s.word(i + 1, "comma")) and near.head == i - 2
    if one and bare and s.tokens[i].amount[0] <= _WIDEST_RING:
        return "diameter"  # "a roundabout, 70 m, two lanes"
    return "diameter" if one and near.head == i - 2 and s.tokens[i - 1].text == "of" and kind == "" else None


def _own_thing(s: Sentence, i: int, kind: str) -> str | None:
    """What else the length belongs to: a turn lane, the straights beside a bend, the ends of a grid's streets."""
    after = [t.text for t in s.tokens[i + 1 : i + 4]]
    if s.word(i + 1, "place") and after[0] == "blocks":
        return "spacing"
    inside = next((p for p in s.phrases if p.first <= i < p.head), None)
    before = s.last_before(i, "pocket", "road", "arm", "place", "ramp", "shape")
    close = before is not None and i - before.head <= _NEAR_THING and not s.between(before.head, i, "stop", "place", "road")
    if (inside is not None and inside.kind == "pocket") or (close and before is not None and before.kind == "pocket"):
        return "pocket" if not any(t == "apart" for t in after) else None
    if "more" in after[:1] and any(s.verbs("gain", "widen", "narrow", "lose")):
        return "rest"
    if kind not in ("radius", "diameter") and any(s.said("shape", *_BENDS)) and _is_of_straights(s, i):
        return "straights"
    return "beyond" if any(text.startswith("beyond") for text in after[:2]) and any(s.said("place", "grid")) else None


def _is_of_straights(s: Sentence, i: int) -> bool:
    """Whether the length is that of each straight beside a bend: "150 m straight on each side", "both legs 200 m long"."""
    if any(s.said("place")):
        return False
    after = [word for t in s.tokens[i + 1 : i + 4] for word in t.text.split()]
    j = i - 1
    while j >= 0 and s.tokens[j].kind in ("prep", "is", "each", "unknown", "with") and not _LEGS & set(s.tokens[j].text.split()):
        j -= 1
    legs = j >= 0 and bool(_LEGS & set(s.tokens[j].text.split()))
    if legs and s.word(j - 1, "number") and s.tokens[j - 1].number == _PAIR:
        s.used.add(j - 1)
    each = s.word(i + 1, "arm") or (j >= 0 and s.tokens[j].kind in ("arm", "each"))
    several = legs and (each or s.tokens[j].text.endswith("s") or s.word(j, "shape"))
    return "straight" in after or (several and not (s.word(j, "shape") and s.word(i + 1, "road")))


def _is_of_median(s: Sentence, i: int) -> bool:
    """Whether the length is the width of what divides the carriageways: "10 m median", "a median of 12 m", "12 m wide strip"."""
    near = [j for j in range(max(0, i - 4), min(len(s.tokens), i + 4)) if s.tokens[j].kind in ("divided", "median")]
    between = [t for j in near for t in s.tokens[min(i, j) + 1 : max(i, j)]]
    return bool(near) and all(t.kind in ("diameter", "is", "det", "small", "unknown", "prep", "with") for t in between)


def _is_inside(s: Sentence, i: int, *kinds: str) -> bool:
    return any(p.kind in kinds and p.first <= i < p.head for p in s.phrases) or (
        i + 1 < len(s.tokens) and s.tokens[i + 1].kind in kinds
    )


def _spoken_of(s: Sentence, i: int) -> Phrase | None:
    """The last thing with a length that is spoken of before token i; of "the acceleration lane of the entrance", the lane."""
    before = s.last_before(i, "auxiliary", "weaving", "road", "arm", "ramp", "place", "shape", "dead_end", "divided")
    of_it = before is not None and before.kind == "ramp" and before.first > 0 and s.tokens[before.first - 1].text == "of"
    if before is not None and of_it:
        return s.last_before(before.first, "auxiliary", "weaving") or before
    return before


def _what_is_long(s: Sentence, i: int) -> str:
    """Which thing a plain length belongs to: an acceleration lane, side roads, arms, or the road itself."""
    road = next((p for p in s.phrases if p.kind == "road" and p.first <= i < p.head), None)
    if road is not None and any(t.value == "meet" for t in s.tokens[max(0, road.first - 2) : road.first]):
        return "spacing"  # "linked by a 120 m road"
    if s.word(i - 1, "total") or s.word(i + 1, "total"):
        return "length"
    after = next((p for p in s.phrases if i < p.head <= i + 4), None) if s.word(i + 1, "long") else None
    if after is not None and after.kind in ("auxiliary", "weaving", "arm"):  # "a 250 m long deceleration lane"
        return "side" if after.kind == "arm" else "auxiliary"
    before = _spoken_of(s, i)
    near = s.tokens[i - 1].text if i else ""
    if any(s.said("weaving")) and (near in ("within", "over") or not any(s.said("road"))):
        return "auxiliary"  # "weaving between two ramps over 350 m"
    merging = near in ("within", "over") and any("merge" in (t.value, *t.text.split()) for t in s.tokens[max(0, i - 4) : i])
    if _is_inside(s, i, "auxiliary", "weaving") or (merging and any(s.said("ramp"))):
        return "auxiliary"
    if before is None or s.governed(i) is not None:
        return "length"
    beside = i - before.head <= 4 or not s.between(before.head, i, "comma", "stop", "and", "verb", "road")
    if before.kind in ("auxiliary", "weaving") and beside:
        return "auxiliary"
    if before.kind == "arm" and arm_role(s, before) == "main":
        return "length"
    if (before.kind == "road" and before.role == "side") or before.kind in ("arm", "dead_end"):
        return "side" if is_close(s, before, i) else "length"
    return "length"


def read_angles(s: Sentence, facts: Facts) -> None:
    """One angle: of a bend, a fork or a skew crossing."""
    for i in s.of_kind("angle"):
        if i in s.used:
            continue
        branches = s.next_after(i, "arm", "road")  # "50 degrees between its two branches"
        if (
            branches is not None
            and branches.number == _PAIR
            and [t.text for t in s.tokens[i + 1 : branches.first]] == ["between"]
        ):
            s.used.update(range(branches.first, branches.head))
        two = s.last_before(i, "arm", "road")  # "its two upper branches are 60 degrees apart"
        if two is not None and any(t.text == "apart" for t in s.tokens[i : i + 2]) and two.head + 4 > i:
            numbers = [j for j in range(two.first - 2, two.head) if s.word(j, "number") and s.tokens[j].number == _PAIR]
            s.used.update(numbers)
        facts.angle = s.tokens[i].amount[0] if facts.angle is None else facts.angle
        s.use(i, i, f"angle {s.tokens[i].amount[0]:g} degrees")
    for i in s.of_kind("right_angle"):
        facts.angle = 90.0 if facts.angle is None else facts.angle
        s.use(i, i, "angle 90 degrees")
