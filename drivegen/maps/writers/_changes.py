"""Roads that narrow or widen, and how many lanes there are before and after."""

from drivegen.errors import UnusableInput
from drivegen.maps.spec import Side
from drivegen.maps.writers._facts import EventWords, Facts
from drivegen.maps.writers._sentence import Sentence

_SKIPPED = ("prep", "but", "det", "is", "that", "role", "verb", "unknown", "with", "turn")


def read_changes(s: Sentence, facts: Facts) -> None:
    """Lane drops and gains, by numbers or in words."""
    _read_from_to(s, facts)
    for i in s.verbs("narrow", "widen", "become", "lose", "gain", "merge"):
        if facts.from_lanes is None and not s.negated_at(i) and i not in s.used:
            _read_verb(s, facts, i)
    for i in s.verbs("narrow", "widen", "lose", "gain", "end"):
        if s.negated_at(i) or i in s.used:
            continue
        if not facts.has("lane_drop", "lane_gain", "lane_change"):
            _read_lane_verb(s, facts, i)
        else:
            _read_next_lane_verb(s, facts, i)
    for phrase in (p for p in s.said("extra") if p.head not in s.used):
        _read_extra(s, facts, phrase.head)


def lane_count(s: Sentence, start: int, end: int) -> int | None:
    """The first number of lanes from token `start` on, over small words."""
    for i in range(start, end):
        token = s.tokens[i]
        if token.kind == "number":
            return i
        if (token.kind not in _SKIPPED and token.kind != "lane") or (token.kind == "prep" and token.value == "on"):
            return None
    return None


def last_of_count(s: Sentence, i: int) -> int:
    """The last token of "three lanes" from its number on."""
    return next((item.last for item in s.lanes if item.first == i), i)


def is_lane_count(s: Sentence, i: int) -> bool:
    """Whether the number at i may be one of lanes: small, and not of something else that follows."""
    following = s.tokens[i + 1 : i + 2]
    bound = following and following[0].kind in ("road", "arm", "place", "ramp", "length", "spacing", "shape", "unknown")
    bound = bound and following[0].text not in ("over", "within", "about", "here", "there", "soon")
    return 0 <= s.tokens[i].amount[0] <= 12 and not bound


def _read_from_to(s: Sentence, facts: Facts) -> None:
    """From four to three lanes; 2 lanes to 3."""
    for i in s.of_kind("prep", "to"):
        after = lane_count(s, i + 1, min(len(s.tokens), i + 4))
        before = next((j for j in range(i - 1, max(-1, i - 4), -1) if s.tokens[j].kind == "number"), None)
        if after is None or before is None or not (is_lane_count(s, after) and s.tokens[before].number <= 12):
            continue
        between = s.tokens[before + 1 : i]
        beside = (*between, *s.tokens[after + 1 : after + 3], *s.tokens[max(0, before - 2) : before])
        lanes_said = any(t.kind in ("lane", "extra") or t.text.startswith("lane ") for t in beside) or _lane_follows(s, after)
        if s.tokens[before - 1].text.endswith("from"):  # "drops a lane on the right, going from five to four"
            lanes_said |= any(t.kind == "lane" for t in s.tokens[max(0, before - 10) : before])
        verbs = {t.value for t in between if t.kind == "verb"}
        joined = (verbs & {"merge", "join"} and _adjectival(s, after)) or "split" in verbs
        if all(t.kind in ("lane", "each", "verb", "but", "road") for t in between) and lanes_said and not joined:
            _change(s, facts, s.tokens[before].number, s.tokens[after].number, before, last_of_count(s, after))
            return


def _lane_follows(s: Sentence, i: int) -> bool:
    """Whether "lanes" is said at the end of several numbers: "from four to three and then to two lanes"."""
    rest = s.tokens[i + 1 : i + 7]
    end = next((j for j, t in enumerate(rest) if t.kind not in ("and", "seq", "prep", "number", "comma")), len(rest))
    return end < len(rest) and rest[end].kind == "lane"


def _read_verb(s: Sentence, facts: Facts, i: int) -> None:
    """It narrows to two; three lanes become four; 4 lanes merge into 3; gains a fourth lane."""
    verb = s.tokens[i].value
    after = lane_count(s, i + 1, min(len(s.tokens), i + 5))
    if verb == "gain" and (third := _ordinal_lane(s, i)) is not None:
        _change(s, facts, third - 1, third, i, i + 3)
        return
    if verb in ("lose", "gain") and not s.between(i, (after or i) + 1, "prep"):
        return
    if after is not None and any(t.kind == "prep" and t.value == "from" for t in s.tokens[i:after]):
        return
    if after is None or not is_lane_count(s, after) or (verb in ("lose", "gain", "merge") and _adjectival(s, after)):
        return
    if verb == "merge" and not (s.between(i, after, "prep") and _lane_or_end(s, after)):
        return
    earlier = [item for item in s.lanes if item.last < i and item.first not in s.used]
    bare = next((j for j in range(i - 1, max(-1, i - 4), -1) if s.tokens[j].kind == "number" and is_lane_count(s, j)), None)
    to = s.tokens[after].number
    if earlier:
        _change(s, facts, earlier[-1].count, to, earlier[-1].first, last_of_count(s, after))
    elif bare is not None:
        _change(s, facts, s.tokens[bare].number, to, bare, last_of_count(s, after))
    elif verb != "merge":
        facts.to_lanes = to
        facts.features["lane_change"] = i
        s.use(i, last_of_count(s, after), f"becomes {to} lane{'s' if to > 1 else ''}")


def _adjectival(s: Sentence, i: int) -> bool:
    return any(item.inside for item in s.lanes if item.first == i)


def _lane_or_end(s: Sentence, i: int) -> bool:
    return i + 1 >= len(s.tokens) or s.tokens[i + 1].kind in ("lane", "comma", "stop", "prep", "number")


def _ordinal_lane(s: Sentence, i: int) -> int | None:
    for token, following in zip(s.tokens[i + 1 : i + 4], s.tokens[i + 2 : i + 5], strict=False):
        if token.kind == "ordinal" and following.kind == "lane":
            return int(token.value)
    following_kinds = ("prep", "and", "comma", "later", "length", "stop")
    alone = i + 3 >= len(s.tokens) or s.tokens[i + 3].kind in following_kinds
    if alone and s.word(i + 1, "det") and s.word(i + 2, "ordinal") and int(s.tokens[i + 2].value) > 1:
        return int(s.tokens[i + 2].value)  # "gains a third after 400 m"
    return None


def _change(s: Sentence, facts: Facts, before: int, after: int, first: int, last: int) -> None:
    if before == after:
        raise UnusableInput(f"a road of {before} lanes cannot change to {after} lanes", reason="impossible-map")
    facts.from_lanes, facts.to_lanes = before, after
    facts.features["lane_drop" if after < before else "lane_gain"] = first
    read_later = {i for i in range(first, last) if s.tokens[i].kind in ("length", "speed") and i not in s.used}
    s.use(first, min(last, len(s.tokens) - 1), f"{before} lanes become {after}")
    s.used -= read_later  # "a three-lane road, 2 km long, narrowing to two"
    for item in s.lanes:
        if first <= item.first <= last:
            s.used.update(range(item.first, item.last + 1))


def _read_lane_verb(s: Sentence, facts: Facts, i: int) -> None:
    """The left lane ends; it loses a lane; a lane is added; it narrows."""
    verb = s.tokens[i].value
    added = next((p for p in s.phrases if p.first > i and p.head <= i + 5), None)
    if verb == "gain" and added is not None and added.kind in ("pocket", "noise", "auxiliary"):
        s.use(i, i, "")
        return
    lane = _lane_beside(s, i)
    own = [item for item in s.lanes if lane is not None and item.first <= lane <= item.last and item.last - item.first >= 1]
    counted = own[0].count if own else 1
    if verb in ("end", "lose", "gain"):
        single = lane is not None and _one_of_them(s, lane, i)
        if not single:
            return
    else:
        counted = 1
    kind = "lane_gain" if verb in ("widen", "gain") else "lane_drop"
    facts.features[kind] = i
    facts.events.append(EventWords(kind, i, counted if verb in ("lose", "gain") and counted <= 3 else 1, side_near(s, i)))
    first, last = (min(i, lane), max(i, lane)) if lane is not None else (i, i)
    between = {j for item in s.lanes if first < item.first < last for j in range(item.first, item.last + 1)} - s.used
    s.use(first, last, kind.replace("_", " "))
    s.used -= between  # "the left lane of a two-lane road ends"
    for item in own:
        s.used.update(range(item.first, item.last + 1))


def _read_next_lane_verb(s: Sentence, facts: Facts, i: int) -> None:
    """A second change: "the left lane ends 300 m later", "and is lost again after 400 m", "and then drops it"."""
    kind = "lane_gain" if s.tokens[i].value in ("widen", "gain") else "lane_drop"
    numbered = facts.from_lanes is not None or facts.to_lanes is not None
    if numbered and facts.has("lane_gain") and s.tokens[i].value == "lose" and facts.features["lane_gain"] < i:
        last = EventWords("lane_gain", facts.features["lane_gain"])  # "widens to three lanes for 500 m and then drops one"
    elif numbered or not facts.events:
        return
    else:
        last = facts.events[-1]
    apart = s.between(last.at, i + 4, "length", "later", "seq") or last.kind != kind
    lane = _lane_beside(s, i)
    if any(t.value == "another" for t in s.tokens[max(0, i - 3) : i + 3]):
        return  # read as a step
    if i in s.used or last.at > i or not apart or not last.kind.startswith("lane") or (lane in s.used and last.kind == kind):
        return
    its = lane is not None and _one_of_them(s, lane, i)
    back = last.kind == "lane_gain" and kind == "lane_drop" and s.tokens[i].value in ("lose", "end") and lane is None
    if not its and not back:
        return
    facts.features.setdefault(kind, i)
    at = _distance_between(s, last.at, i)
    facts.events.append(EventWords(kind, i, 1, side_near(s, i) if its else last.side, gap=s.tokens[at].amount[0] if at else None))
    s.use(i, i, kind.replace("_", " "))
    if lane is not None:
        s.use(lane, lane, "")
    if at is not None:
        s.use(at, at, f"{s.tokens[at].text} later")


def _distance_between(s: Sentence, since: int, i: int) -> int | None:
    """The length from one change to the next at i: "300 m later", "for 500 m", but not where the first one lies."""
    near = [j for j in range(since, min(len(s.tokens), i + 5)) if s.tokens[j].kind == "length" and j not in s.used]
    near = [j for j in near if j > i or not (s.tokens[j - 1].kind == "prep" and s.tokens[j - 1].text in ("after", "at"))]
    return next((j for j in near if s.word(j + 1, "later")), next(iter(near), None))


def _lane_beside(s: Sentence, i: int) -> int | None:
    """The lane that ends or begins: beside the verb, or before it with its road between ("the right lane of the road ends")."""
    if s.tokens[i].value in ("lose", "gain"):  # "with four lanes, loses one lane"
        for j in range(i + 1, min(len(s.tokens), i + 4)):
            if s.tokens[j].text in ("lane", "lanes"):
                return j
            if s.tokens[j].kind not in ("det", "number", "turn", "small", "ordinal"):
                break
    counted = {j for item in s.lanes if item.per for j in range(item.first, item.last + 1)}  # "one lane each way"
    near = (*range(i - 1, max(-1, i - 5), -1), *range(i + 1, min(len(s.tokens), i + 5)))
    near = tuple(j for j in near if j not in counted)
    beside: int | None = next((j for j in near if s.tokens[j].text in ("lane", "lanes") and not _of_a_road(s, j)), None)
    if beside is not None:
        return beside
    for j in range(i - 1, max(-1, i - 9), -1):
        if s.tokens[j].text == "lane" and s.word(j + 1, "prep"):
            return j
    return None


def _of_a_road(s: Sentence, j: int) -> bool:
    return any(p.kind == "road" and p.first <= j < p.head for p in s.phrases)


def _one_of_them(s: Sentence, lane: int, verb: int) -> bool:
    """Whether lane and verb belong together: the lane is the verb's subject or object, and not the road's number of lanes."""
    first, last = min(lane, verb), max(lane, verb)
    between = s.tokens[first + 1 : last]
    if lane < verb and s.word(lane + 1, "prep") and s.tokens[lane + 1].value == "of":
        between = []
    if any(t.kind in ("stop", "road", "place", "ramp", "verb") or t.text == "," for t in between):
        return False
    if verb < lane:
        return True
    before = s.tokens[lane - 1] if lane else None
    return (
        before is None
        or before.kind in ("det", "turn", "role", "unknown", "small", "ordinal", "comma")
        or (before.kind == "number" and before.number == 1)
    )


def side_near(s: Sentence, i: int) -> Side:
    """The side that is said within a few words of token i."""
    near = s.tokens[max(0, i - 5) : i + 5]
    return "left" if any(t.kind == "turn" and t.value == "left" for t in near) else "right"


def _read_extra(s: Sentence, facts: Facts, i: int) -> None:
    kinds = {p.value.split("_")[0] for p in s.said("ramp")}
    if {"on", "off"} <= kinds and s.tokens[i].value == "":  # one lane from the entrance to the exit
        facts.features.setdefault("weaving", i)
        s.use(i, i, "lane from the on-ramp to the off-ramp")
        if s.word(i - 1, "number") or s.word(i - 1, "det"):
            s.use(i - 1, i - 1, "")
    elif not facts.has("lane_drop", "lane_gain", "lane_change"):
        kind = "lane_drop" if s.tokens[i].value == "drop" or _ends(s, i) else "lane_gain"
        facts.features[kind] = i
        facts.events.append(EventWords(kind, i, 1, side_near(s, i)))
        s.use(i, i, kind.replace("_", " "))
    elif s.tokens[i].value == "drop" and facts.from_lanes is None and facts.to_lanes is None and facts.events:
        at = _distance_between(s, facts.events[-1].at, i)
        another = s.word(i - 1, "det") and s.tokens[i - 1].value == "another"  # read as a step
        if at is not None and not another and facts.events[-1].kind == "lane_drop" and facts.events[-1].at < i:
            facts.events.append(EventWords("lane_drop", i, 1, side_near(s, i), gap=s.tokens[at].amount[0]))
            s.use(at, at, f"{s.tokens[at].text} later")
        s.use(i, i, "lane drop")
    else:
        s.use(i, i, "")


def _ends(s: Sentence, i: int) -> bool:
    return any(t.kind == "verb" and t.value in ("end", "lose") for t in s.tokens[i + 1 : i + 4])
