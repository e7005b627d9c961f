"""Numbers of lanes along a road: before and behind a place, and in how many steps they change."""

from drivegen.maps.writers._changes import is_lane_count
from drivegen.maps.writers._facts import EventWords, Facts
from drivegen.maps.writers._places_along import lists_of_places
from drivegen.maps.writers._quantities import Lanes
from drivegen.maps.writers._sentence import Sentence

_MOST_AT_A_RAMP = 3


def read_upstream(s: Sentence, facts: Facts) -> None:
    """ "Three lanes upstream, four downstream", "two before the ramp, three after it": a change, at a ramp if one is named."""
    for i in s.of_kind("remain"):  # "two lanes carry on": what is left of more that were named
        left = next((item for item in s.lanes if item.last == i - 1 and item.first not in s.used), None)
        if left is not None and any(item.count > left.count for item in s.lanes):
            s.use(left.first, i, f"{left.count} lanes remain")
    if _read_weaving(s, facts) or facts.from_lanes is not None:
        return
    before, after = (_count_at(s, next(s.of_kind(kind), None)) for kind in ("before", "later"))
    if before is None:
        before, after = _one_then_another(s, facts)
    if before is None or after is None or before.first == after.first or before.count == after.count:
        return
    ramps = [p for p in s.said("ramp") if p.value in ("on", "off", "on_or_arm", "off_or_arm") and not p.negated]
    change = after.count - before.count
    kinds = {p.value.split("_")[0] for p in ramps}
    meaning = f"{before.count} lanes become {after.count}"
    if len(kinds) == 1 and abs(change) <= _MOST_AT_A_RAMP and (change > 0) == (kinds == {"on"}):
        kind = f"{kinds.pop()}_ramp"
        facts.events.append(EventWords(kind, ramps[0].head, abs(change), keeps=True))
        facts.lanes["main"] = before.count
        for phrase in (*ramps, *s.said("ramp", "")):
            s.use(phrase.head, phrase.head, "")
    elif kinds:
        return
    else:
        facts.from_lanes, facts.to_lanes = before.count, after.count
        facts.features["lane_gain" if change > 0 else "lane_drop"] = min(before.first, after.first)
    s.use(before.first, before.last, "")
    s.use(after.first, after.last, meaning)
    for i in (
        *s.verbs("gain", "lose", "widen", "narrow", "end", "become", "merge", "join"),
        *s.of_kind("keeps"),
        *s.of_kind("extra"),
    ):
        s.use(i, i, "")


def _one_then_another(s: Sentence, facts: Facts) -> tuple[Lanes | None, Lanes | None]:
    """ "Three lanes for 500 m, afterwards only two lanes": numbers of one road, the second right behind "then"."""
    if any(s.said("place")) or any(s.said("ramp")) or len(list(s.said("road"))) > 1:
        return None, None
    for i in sorted([*s.of_kind("seq"), *s.of_kind("later")]):
        at = next((j for j in range(i + 1, min(i + 4, len(s.tokens))) if s.tokens[j].kind not in ("but", "with", "is")), i)
        after = next((item for item in s.lanes if item.first == at and not item.inside), None)
        if after is None and s.word(at, "number") and is_lane_count(s, at) and _alone(s, at):
            after = Lanes(s.tokens[at].number, at, at)
        before = next((item for item in reversed(s.lanes) if item.last < i), None)
        if after is None or before is None or s.between(before.last, i, "verb", "road"):
            continue
        for j in range(before.last + 1, i):  # "for 500 m": where the change lies
            if s.tokens[j].kind == "length" and s.tokens[j - 1].text in ("for", "over", "after", "first"):
                facts.lengths["position"] = s.tokens[j].amount[0]
                s.use(j - 1, j, f"position {s.tokens[j].text}")
        return before, after
    return None, None


def _alone(s: Sentence, i: int) -> bool:
    return i + 1 == len(s.tokens) or s.tokens[i + 1].kind in ("comma", "stop", "and", "seq")


def _read_weaving(s: Sentence, facts: Facts) -> bool:
    """ "Five lanes in the weaving section, four before and after it": the smaller number is that of the road."""
    counts = [item for item in s.lanes if not item.inside and not item.value]
    ramps = {p.value.split("_")[0] for p in s.said("ramp")}
    if not (any(s.said("weaving")) or {"on", "off"} <= ramps) or len(counts) != 2 or abs(counts[0].count - counts[1].count) != 1:
        return False
    facts.lanes["main"] = min(item.count for item in counts)
    facts.features.setdefault("weaving", counts[0].first)
    for item in counts:
        s.use(item.first, item.last, f"{item.count} lanes")
    return True


def _count_at(s: Sentence, place: int | None) -> Lanes | None:
    """The number of lanes said at a place, before or behind its word: "three lanes upstream", "upstream three lanes"."""
    if place is None:
        return None
    beside = [item for item in s.lanes if not item.inside and not _apart(s, min(item.last, place), max(item.first, place))]
    if beside:
        return min(beside, key=lambda item: (min(abs(item.last - place), abs(item.first - place)), item.first))
    for i in (place - 1, place + 1):  # "three lanes before, four after"
        if s.word(i, "number") and 1 <= s.tokens[i].number <= 8 and s.lanes:
            return Lanes(s.tokens[i].number, i, i)
    return None


def _apart(s: Sentence, first: int, last: int) -> bool:
    between = s.tokens[first + 1 : last]
    return any(t.kind not in ("is", "det", "unknown", "each", "with", "prep") for t in between) or len(between) > 3


def read_how_often(s: Sentence, facts: Facts) -> None:
    """In how many steps: "in two steps", "one lane at a time"."""
    if facts.from_lanes is None or facts.to_lanes is None or any(event.kind.startswith("lane") for event in facts.events):
        return
    change = abs(facts.to_lanes - facts.from_lanes)
    for places in lists_of_places(s):
        if 1 < len(places) <= change and not any(s.said("ramp")):
            facts.steps, facts.step_places = len(places), [s.tokens[i].amount[0] for i in places]
            s.use(places[0], places[-1], f"{facts.steps} steps")
    for i in s.of_kind("steps"):
        if s.tokens[i].value == "each":
            facts.steps = change
        elif s.word(i - 1, "number") and 1 < s.tokens[i - 1].number <= change:
            facts.steps = s.tokens[i - 1].number
        if facts.steps > 1:
            s.use(i - 1 if s.word(i - 1, "number") else i, i, f"{facts.steps} steps")
            for item in s.lanes:
                if item.first > i and item.count * facts.steps == change:
                    s.use(item.first, item.last, "")
