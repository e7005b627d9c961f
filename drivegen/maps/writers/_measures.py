"""Speeds, lengths, angles and what each belongs to."""

from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._owners import holds_for_all_of_a_ring, is_close, owner, role
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._sentence import Sentence

_KMH = 1 / 3.6
_LEAST_BARE_SPEED = 10
_MOST_BARE_SPEED = 130
_WIDEST_MEDIAN = 100.0
_NEAR_ISLAND = 5
_CUES = ("radius", "diameter", "spacing", "offset", "later", "before", "start", "long", "auxiliary", "weaving", "median")
_EVENTS = ("ramp", "weaving", "extra")


def read_speeds(s: Sentence, facts: Facts) -> None:
    """Speed limits, with or without a unit; the speeds of cars are left to whoever reads vehicles."""
    for i, token in enumerate(s.tokens):
        if i in s.used:
            continue
        if token.kind == "speed" and not _is_driven(s, i):
            _give_speed(s, facts, i, token.amount[0], f"{_shown(token.text)}")
        elif token.kind == "number" and token.amount[0] >= _LEAST_BARE_SPEED and _is_bare_speed(s, facts, i):
            _give_speed(s, facts, i, token.amount[0] * _KMH, f"{token.amount[0]:g} km/h")


def _shown(text: str) -> str:
    return text.replace("kmh", "km/h").replace("mps", "m/s")


def _clause(s: Sentence, i: int) -> int:
    """Where the clause of token i begins."""
    while i > 0 and s.tokens[i - 1].kind not in ("stop", "comma", "and", "but"):
        i -= 1
    return i


def _is_driven(s: Sentence, i: int) -> bool:
    clause = s.tokens[_clause(s, i) : i]
    return any(t.kind == "driving" for t in clause) and not any(t.kind == "speed_word" for t in clause)


def _is_bare_speed(s: Sentence, facts: Facts, i: int) -> bool:
    following = s.tokens[i + 1] if i + 1 < len(s.tokens) else None
    if following is not None and following.kind == "speed_word":
        return True
    if following is not None and following.kind in ("lane", "arm", "place", "road", "driving"):
        return False
    if any(t.kind == "speed_word" for t in s.tokens[_clause(s, i) : i]):
        return True
    return (bool(facts.speeds) and s.governed(i) is not None) or (not facts.speeds and _stands_alone(s, i))


def _stands_alone(s: Sentence, i: int) -> bool:
    """Whether a round number that is left by itself can only be a limit: "two lanes each way, 90"."""
    ends = i + 1 == len(s.tokens) or s.tokens[i + 1].kind in ("comma", "stop")
    begins = i > 0 and s.tokens[i - 1].kind in ("comma", "stop", "each")
    return ends and begins and s.tokens[i].number % 10 == 0 and 20 <= s.tokens[i].number <= _MOST_BARE_SPEED


def _give_speed(s: Sentence, facts: Facts, i: int, speed: float, shown: str) -> None:
    who = "main" if holds_for_all_of_a_ring(s, i) else _speed_role(s, facts, i)
    phrase = owner(s, i, i, "ramp")
    if who == "ramp" and phrase is not None and phrase.speed is None:
        phrase.speed = speed
    if (who or "main") == "main" and "main" in facts.speeds and _names_the_road_again(s, facts, i):
        facts.speeds["ramp"] = facts.speeds.pop("main")  # the earlier one was said of the ramp
        s.notes[:] = [(at, words, f"{m} on the ramp" if m.startswith("speed limit") else m) for at, words, m in s.notes]
    facts.speeds.setdefault(who or "main", speed)
    if holds_for_all_of_a_ring(s, i):
        facts.speeds.setdefault("ring", speed)
    first = i
    while (first > 0 and s.tokens[first - 1].kind in ("speed_word", "is")) or (
        first > 0 and s.tokens[first - 1].text in ("of", "at", "to")
    ):
        first -= 1
    last = i + 1 if s.word(i + 1, "speed_word") else i
    s.use(first, last, f"speed limit {shown}" + (f" on the {who}" if who and who != "main" else ""))


def _names_the_road_again(s: Sentence, facts: Facts, i: int) -> bool:
    """Whether the speed at i stands right behind a highway, and one before it behind words on a ramp."""
    highway = next((p for p in s.said("road") if p.head == i - 1 and p.words.get("class") == "highway"), None)
    ramp = next((p for p in s.said("ramp") if p.head < i), None)
    return highway is not None and ramp is not None and "ramp" not in facts.speeds


def _speed_role(s: Sentence, facts: Facts, i: int) -> str:
    inside = next((p for p in s.phrases if p.first <= i < p.head and p.kind in ("road", "ramp", "ring", "place")), None)
    governed = s.governed(i)
    if governed is None and s.word(i + 1, "speed_word"):
        governed = s.governed(i + 1)
    if governed is not None and ((governed.det == "" and (governed.number or 0) > 1) or _all(s, governed)):
        return "main"
    beside = next((p for p in s.said("road") if p.first == p.head == i + 1 and p.role), None)  # "60 km/h main, 40 minor"
    phrase = inside or governed or beside
    if phrase is not None:
        return role(s, phrase)
    before = s.last_before(i, "road", "ramp", "ring", "place")
    if before is None or before.kind == "place" or (before.value.endswith("_or_arm") and any(s.said("place"))):
        return "main"
    who = role(s, before)
    if who in ("ramp", "side", "ring") and not is_close(s, before, i) and "main" not in facts.speeds:
        return "main"
    if who == "side" and not before.role and not is_close(s, before, i):
        return "main"
    return who


def _all(s: Sentence, phrase: Phrase) -> bool:
    near = s.tokens[max(0, phrase.first - 1) : phrase.head + 1]
    return any(t.text in ("all", "both", "each", "every") for t in near)


def read_lengths(s: Sentence, facts: Facts) -> None:
    """Lengths by role; the words beside a number tell what it measures."""
    for i in s.of_kind("length"):
        if i in s.used:
            continue
        if _goes_on_a_list(s, i):
            s.use(i, i, f"position {s.tokens[i].text}")
            continue
        metres, cue = s.tokens[i].amount[0], _cue(s, i)
        name = _named(s, i, cue)
        if name in ("gap", "position") and _give_to_part(s, facts, i, name, metres, cue):
            pass
        elif name == "gap":
            changes = facts.has("lane_drop", "lane_gain", "lane_change") and not facts.junctions
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


def _goes_on_a_list(s: Sentence, i: int) -> bool:
    """Whether the length at i is one more place: "at 300 m, 900 m and 1500 m"."""
    j = i
    while j >= 2 and s.tokens[j - 1].kind in ("and", "comma") and s.tokens[j - 2].kind == "length":
        j -= 2
    return j < i and s.tokens[j - 1].text == "at" and s.word(j - 2, "ramp")


def _is_of_the_whole(s: Sentence, i: int, cue: int | None) -> bool:
    """Whether the words say that the whole road is so long: "a 300 m highway", "300 m long", "300 m in total"."""
    inside = any(
        p.kind == "road" and (p.first <= i < p.head or (p.head == i - 2 and s.tokens[i - 1].text == "of")) for p in s.phrases
    )
    return inside or cue is not None or any(s.word(j, "total") or s.word(j, "long") for j in (i - 1, i + 1))


def _cue_word(s: Sentence, i: int) -> bool:
    before = [t.kind for t in s.tokens[max(0, i - 2) : i]]
    return any(kind in ("radius", "diameter", "spacing") for kind in before)


def _cue(s: Sentence, i: int) -> int | None:
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
    near = s.last_before(i, "central", "ring", "road", "arm", "place")
    if kind in ("", "diameter") and near is not None and near.kind == "central" and i - near.head <= _NEAR_ISLAND:
        return "island"
    if s.word(i + 1, "place") and s.tokens[i + 1].text == "blocks":
        return "spacing"
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


def _is_of_median(s: Sentence, i: int) -> bool:
    """Whether the length is the width of what divides the carriageways: "10 m median", "a median of 12 m", "12 m wide strip"."""
    near = [j for j in range(max(0, i - 4), min(len(s.tokens), i + 4)) if s.tokens[j].kind in ("divided", "median")]
    between = [t for j in near for t in s.tokens[min(i, j) + 1 : max(i, j)]]
    return bool(near) and all(t.kind in ("diameter", "is", "det", "small", "unknown", "prep", "with") for t in between)


def _is_inside(s: Sentence, i: int, *kinds: str) -> bool:
    return any(p.kind in kinds and p.first <= i < p.head for p in s.phrases) or (
        i + 1 < len(s.tokens) and s.tokens[i + 1].kind in kinds
    )


def _what_is_long(s: Sentence, i: int) -> str:
    """Which thing a plain length belongs to: an acceleration lane, side roads, arms, or the road itself."""
    road = next((p for p in s.phrases if p.kind == "road" and p.first <= i < p.head), None)
    if road is not None and any(t.value == "meet" for t in s.tokens[max(0, road.first - 2) : road.first]):
        return "spacing"  # "linked by a 120 m road"
    before = s.last_before(i, "auxiliary", "weaving", "road", "arm", "ramp", "place", "shape", "dead_end", "divided")
    near = s.tokens[i - 1].text if i else ""
    if any(s.said("weaving")) and (near in ("within", "over") or not any(s.said("road"))):
        return "auxiliary"  # "weaving between two ramps over 350 m"
    if _is_inside(s, i, "auxiliary", "weaving"):
        return "auxiliary"
    if before is None or s.governed(i) is not None:
        return "length"
    if before.kind in ("auxiliary", "weaving") and len(s.tokens[before.head + 1 : i]) <= 3:
        return "auxiliary"
    if (before.kind == "road" and before.role == "side") or before.kind in ("arm", "dead_end"):
        return "side" if is_close(s, before, i) else "length"
    return "length"


def _give_to_part(s: Sentence, facts: Facts, i: int, name: str, metres: float, cue: int | None) -> bool:
    """Note where a ramp or junction lies, or how far from the one before it; whether there is one."""
    kinds = (*_EVENTS, "place")
    start = _clause(s, i)
    if _give_to_change(facts, i, start, metres):
        return True
    before = next((p for p in reversed(s.phrases) if start <= p.head < i and p.kind in kinds and not p.negated), None)
    after = next(
        (p for p in s.phrases if p.first > i and p.kind in kinds and not p.negated and not s.between(i, p.first, "stop")), None
    )
    if name == "position":
        part = before or s.last_before(i, *kinds) or after
        side = s.last_before(i, "road")
        if side is not None and side.role == "side" and side.det != "the" and side.head >= start:
            part = side
        if part is not None and part.kind == "extra":
            _place_change(facts, part.head, metres)
        elif part is not None:
            part.position = metres
        return part is not None
    parts = [p for p in s.phrases if p.kind in kinds and not p.negated]
    is_before = cue is not None and s.tokens[cue].kind == "before"
    part = after if is_before or before is None or before is parts[0] else before
    part = part or before
    if part is None:
        return False
    if part is parts[0] and not is_before:
        part.position = metres
    else:
        part.gap = metres
    return True


def _give_to_change(facts: Facts, i: int, start: int, metres: float) -> bool:
    """Note where lanes end or begin, if that is said before the length in its clause; whether it is."""
    changes = [event for event in facts.events if start <= event.at < i and event.kind.startswith("lane")]
    numbered = facts.from_lanes is not None and any(start <= facts.features.get(k, -1) < i for k in ("lane_drop", "lane_gain"))
    if not changes and not numbered:
        return False
    if any(changes[-1:]) and changes[-1] is not facts.events[0] and changes[-1].gap is None and changes[-1].position is None:
        changes[-1].gap = metres
    else:
        _place_change(facts, changes[0].at if changes else -1, metres)
    return True


def _place_change(facts: Facts, at: int, metres: float) -> None:
    """The first change of lanes, or the one at a token, lies so far from the start of the road."""
    event = next((event for event in facts.events if event.at == at and event.position is None), None)
    if event is not None and event.gap is None:
        event.position = metres
    elif event is None:
        facts.lengths.setdefault("position", metres)


def read_angles(s: Sentence, facts: Facts) -> None:
    """One angle: of a bend, a fork or a skew crossing."""
    for i in s.of_kind("angle"):
        facts.angle = s.tokens[i].amount[0] if facts.angle is None else facts.angle
        s.use(i, i, f"angle {s.tokens[i].amount[0]:g} degrees")
    for i in s.of_kind("right_angle"):
        facts.angle = 90.0 if facts.angle is None else facts.angle
        s.use(i, i, "angle 90 degrees")
