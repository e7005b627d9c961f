"""Single lanes that end or begin: "the left lane ends", "it loses a lane", "a climbing lane"."""

from drivegen.maps.spec_values import Side
from drivegen.maps.writers._facts import EventWords, Facts
from drivegen.maps.writers._sentence import Sentence

_BESIDE = ("beside", "alongside", "the", "to", "along")


def read_lane_verb(s: Sentence, facts: Facts, i: int) -> None:
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
        single = (lane is not None and _one_of_them(s, lane, i)) or _stands_for_lane(s, i)
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


def is_of_auxiliary(s: Sentence, i: int) -> bool:
    """Whether it is a ramp's lane that ends or begins: "an acceleration lane, running beside the three lanes, ends"."""
    beside = s.last_before(i, "auxiliary", "road", "extra")
    if (
        s.tokens[i].value not in ("end", "gain", "lose")
        or beside is None
        or beside.kind != "auxiliary"
        or beside.value == "weave"
    ):
        return False
    of_others = [item for item in s.lanes if beside.head < item.first < i and s.tokens[item.first - 1].text in _BESIDE]
    own = [t for j, t in enumerate(s.tokens[beside.head + 1 : i], beside.head + 1) if t.kind in ("lane", "verb")]
    if any(t.kind == "lane" for t in own) and not of_others:
        return False
    s.use(i, i, "")
    for item in of_others:
        s.used.update(range(item.first, item.last + 1))
    for j in range(i + 1, min(len(s.tokens), i + 5)):  # "is added as a fifth lane"
        if s.word(j, "ordinal") and s.word(j + 1, "lane"):
            s.use(j, j + 1, "")
    return True


def _stands_for_lane(s: Sentence, i: int) -> bool:
    """Whether a side is the subject of the verb: "three lanes, the right one ends"."""
    j = i - 2 if s.word(i - 1, "number") and s.tokens[i - 1].text == "1" else i - 1
    if any(s.said("extra")):
        return False  # "the left lane ends, 400 m later the right one too": read as a step
    return s.word(j, "turn") and s.word(j - 1, "det") and s.tokens[i].value == "end" and any(x.last < j for x in s.lanes)


def read_next_lane_verb(s: Sentence, facts: Facts, i: int) -> None:
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
    lane = None if numbered and lane in s.used else lane  # "from two to three lanes, and dropped again"
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
    event = EventWords(kind, i, 1, side_near(s, i) if its else last.side)
    if at is not None and at > i and s.tokens[at - 1].text == "at":
        event.position = s.tokens[at].amount[0]  # "gets a third lane at 700 m, loses it again at 1400 m"
    elif at is not None:
        event.gap = s.tokens[at].amount[0]
    facts.events.append(event)
    s.use(i, i, kind.replace("_", " "))
    if lane is not None:
        s.use(lane, lane, "")
    if at is not None:
        s.use(at, at, f"{s.tokens[at].text} {'later' if event.gap else 'from the start'}")


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


def read_extra(s: Sentence, facts: Facts, i: int) -> None:
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
