"""Where along the road something lies, or how far from what comes before it."""

from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._sentence import Sentence

_EVENTS = ("ramp", "weaving", "extra")
_CLOSE = 4
_NO_PLACE = ("long", "total", "radius", "diameter", "spacing", "later")


def give_to_part(s: Sentence, facts: Facts, i: int, name: str, metres: float, cue: int | None) -> bool:
    """Note where a ramp or junction lies, or how far from the one before it; whether there is one."""
    start = s.clause(i)
    if (behind := _led_to(s, i)) is not None:
        behind.gap = metres
        return True
    if cue is not None and s.tokens[cue].kind == "later" and any(s.said("place", "staggered")):
        facts.lengths.setdefault("offset", metres)
        return True
    if _give_to_change(facts, i, start, metres):
        return True
    parts = [p for p in s.phrases if p.kind in (*_EVENTS, "place") and not p.negated]
    before = next((p for p in reversed(parts) if start <= p.head < i), None)
    after = next((p for p in parts if p.first > i and not s.between(i, p.first, "stop")), None)
    ordinal = next((p for p in s.said("ordinal") if start <= p.head < i and i - p.head <= _CLOSE), None)
    several = before is None and any((p.number or 1) > 1 for p in (*s.said("ramp"), *s.said("place")))
    if name == "position" and ordinal is not None and several:
        ordinal.position = metres  # "two crossings, the first 250 m after the start"
        return True
    if name == "position":
        return _give_position(s, facts, i, metres, before or s.last_before(i, *_EVENTS, "place") or after)
    if ordinal is not None and several and any((p.number or 1) > 1 for p in s.said("ramp")):
        ordinal.position, ordinal.gap = (metres, None) if ordinal.value == "1" else (None, metres)
        return True
    is_behind = s.tokens[i - 1].text == "after" and not s.tokens[i - 2].text.startswith("followed")
    if is_behind and (len(parts) < 2 or before is parts[0]):  # "an exit with one lane after 500 m"
        return _give_position(s, facts, i, metres, before or (parts[0] if len(parts) == 1 else None))
    part = before or after
    if is_behind and cue is None and part is not None and metres > (parts[0].position or metres):
        return _give_position(s, facts, i, metres, part)  # "an on-ramp after 300 m and an off-ramp after 1 km"
    return _give_gap(s, metres, before, after, parts, cue)


def leads_to_junction(s: Sentence, i: int) -> bool:
    """Whether the length at i is the way from one junction to the next."""
    return _led_to(s, i) is not None


def _led_to(s: Sentence, i: int) -> Phrase | None:
    """The junction that the length at i leads to from one before it: "go on for 350 m to a roundabout"."""
    place = s.next_after(i, "place")
    leads = place is not None and [t.value for t in s.tokens[i + 1 : place.first]] == ["to"]
    return place if leads and s.last_before(i, "place", same_sentence=False) is not None else None


def lists_of_places(s: Sentence) -> list[list[int]]:
    """Lengths that are told in a row behind "at": "at 300 m, 900 m and 1500 m", "at 200 m and at 400 m"."""
    found: list[list[int]] = []
    for i in s.of_kind("length"):
        j = i - 1
        while j > 0 and (s.tokens[j].kind in ("and", "comma") or s.tokens[j].text == "at"):
            j -= 1
        goes_on = found and found[-1][-1] == j and j < i - 1 and not any(s.word(i + 1, kind) for kind in _NO_PLACE)
        if goes_on:
            found[-1].append(i)
        elif s.tokens[i - 1].text == "at":
            found.append([i])
    return [places for places in found if len(places) > 1 and s.between(places[0], places[-1], "and")]


def listed_places(s: Sentence, phrase: Phrase) -> list[float]:
    """Positions [m] that are listed for what is spoken of in the plural: right behind it, or as many as were counted."""
    for places in lists_of_places(s):
        right_behind = s.tokens[phrase.head].text.endswith("s") and places[0] == phrase.head + 2
        near = places[0] > phrase.head and not s.between(phrase.head, places[0], "stop", "place")
        counted = near and phrase.number == len(places)
        amounts = [s.tokens[i].amount[0] for i in places]
        if (right_behind and phrase.number in (None, len(places))) or counted:
            return amounts if amounts == sorted(set(amounts)) else []
    return []


def _give_position(s: Sentence, facts: Facts, i: int, metres: float, part: Phrase | None) -> bool:
    """Note how far from the start of the road the part lies, or a side road that is spoken of after it."""
    side = s.last_before(i, "road")
    if side is not None and side.role == "side" and side.det != "the" and side.head >= s.clause(i):
        part = side
    if part is not None and part.kind == "extra":
        _place_change(facts, part.head, metres)
    elif part is not None:
        part.position = metres
    return part is not None


def _give_gap(
    s: Sentence, metres: float, before: Phrase | None, after: Phrase | None, parts: list[Phrase], cue: int | None
) -> bool:
    """Note how far a part lies from the one before it; the first one lies so far from the start of the road."""
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
