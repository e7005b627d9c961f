"""Lanes that end or begin one after another."""

from drivegen.maps.writers._changes import is_lane_count, lane_count, last_of_count
from drivegen.maps.writers._facts import EventWords, Facts
from drivegen.maps.writers._lane_ends import side_near
from drivegen.maps.writers._sentence import Sentence


def read_steps(s: Sentence, facts: Facts) -> None:
    """One lane after another: "the left lane ends, 400 m later another one", "from four lanes to three and then to two"."""
    kind = "lane_gain" if facts.has("lane_gain") else "lane_drop"
    if not facts.has("lane_drop", "lane_gain"):
        return
    first = facts.features[kind]
    for i in s.of_kind("det", "another"):
        if i < first or (s.between(first, i, "stop") and s.tokens[i - 1].kind == "stop" and not _length_near(s, i)):
            continue
        rest = s.tokens[i + 1 : i + 3]
        if rest and not (
            rest[0].kind in ("lane", "extra", "stop", "comma", "length", "later", "prep", "and")
            or rest[0].value in ("end", "lose", "gain")
            or (s.word(i - 1, "verb") and s.tokens[i - 1].value in ("lose", "gain"))
        ):
            continue
        _add_step(s, facts, kind, i, 1)
    for i in s.of_kind("turn"):
        if i > first and _the_other_one(s, i):
            _add_step(s, facts, kind, i, 1)
    for i in s.of_kind("ordinal"):  # "gains a third lane and, 400 m later, a fourth"
        to = (facts.to_lanes or 9) + sum(e.lanes or 1 for e in facts.events)
        if kind == "lane_gain" and i > first and i not in s.used and int(s.tokens[i].value) == to + 1:
            _add_step(s, facts, kind, i, 1)
    _read_first_and_then(s, facts, kind)
    _read_further_numbers(s, facts, kind)


def _read_first_and_then(s: Sentence, facts: Facts, kind: str) -> None:
    """Numbers that explain the verb: "it broadens: two lanes, then three"."""
    seq = next(s.of_kind("seq"), None)
    before = [item for item in s.lanes if seq is not None and item.last < seq]
    after = lane_count(s, seq + 1, min(len(s.tokens), seq + 2)) if seq is not None else None
    if facts.from_lanes is not None or facts.to_lanes is not None or not before or after is None or len(facts.events) != 1:
        return
    change = s.tokens[after].number - before[-1].count
    if is_lane_count(s, after) and change * (1 if kind == "lane_gain" else -1) > 0:
        facts.from_lanes, facts.to_lanes = before[-1].count, s.tokens[after].number
        facts.events.clear()
        s.use(before[-1].first, last_of_count(s, after), f"{before[-1].count} lanes become {facts.to_lanes}")


def _read_further_numbers(s: Sentence, facts: Facts, kind: str) -> None:
    """The numbers after the second: "from four lanes to three and then to two"."""
    if facts.to_lanes is None or facts.from_lanes is None:
        return
    sign = 1 if kind == "lane_gain" else -1
    for i in sorted([*s.of_kind("prep", "to"), *s.of_kind("seq"), *s.of_kind("later"), *s.verbs("become", "narrow", "widen")]):
        after = lane_count(s, i + 1, min(len(s.tokens), i + 4))
        if after is None or after in s.used or i < facts.features[kind] or not is_lane_count(s, after):
            continue
        signs = {"lane_gain": 1, "lane_drop": -1}
        here = facts.to_lanes + sum(signs.get(e.kind, 0) * (e.lanes or 1) for e in facts.events)
        step = (s.tokens[after].number - here) * sign
        back = s.tokens[i].value in ("narrow", "widen") or s.tokens[i].text.startswith("back")
        if step > 0 or (step < 0 and back):  # "and 400 m later narrows back to two"
            _use_again(s, max((j for j in s.used if j < i), default=0), i, here)
            facts.features.setdefault("lane_gain" if step * sign > 0 else "lane_drop", i)
            _add_step(s, facts, "lane_gain" if step * sign > 0 else "lane_drop", i, abs(step))
            s.use(i, last_of_count(s, after), f"becomes {s.tokens[after].number} lanes")


def _use_again(s: Sentence, since: int, i: int, lanes: int) -> None:
    """Take the lanes that are named again before a step at i: "and then, 300 m on, from three to two"."""
    for j in range(since + 1, i):
        if s.tokens[j].kind == "number" and s.tokens[j].number == lanes:
            s.use(j, last_of_count(s, j), "")


def _the_other_one(s: Sentence, i: int) -> bool:
    """Whether the turn at i is of a second lane: "and later the right one too"."""
    before = s.tokens[max(0, i - 3) : i]
    goes_on = i + 2 < len(s.tokens) and s.tokens[i + 2].kind not in ("length", "later", "comma", "stop")
    lane = s.word(i + 1, "lane") and not goes_on and i not in s.used  # "and then its right lane 350 m further"
    return (lane or (s.word(i + 1, "number") and s.tokens[i + 1].number == 1)) and any(
        t.kind in ("and", "seq", "later", "length") for t in before
    )


def _length_near(s: Sentence, i: int) -> int | None:
    before, after = range(i - 1, max(-1, i - 5), -1), range(i + 1, min(len(s.tokens), i + 4))
    near = (*after, *before) if s.word(i + 1, "prep") or s.word(i + 1, "later") else (*before, *after)
    if s.tokens[i].kind == "prep" or s.tokens[i].value == "become":  # "and then, 300 m on, from three to two"
        near = (*range(i - 1, max(-1, i - 9), -1), *range(i + 1, min(len(s.tokens), i + 6)))
    said = [j for j in near if s.tokens[j].kind == "length" and j not in s.used]
    behind = [j for j in said if j > i and s.tokens[j - 1].kind in ("prep", "later") and not s.between(i, j, "and", "comma")]
    return next(iter(behind or said), None)


def _add_step(s: Sentence, facts: Facts, kind: str, i: int, lanes: int) -> None:
    """One more change of lanes at token i; where the numbers were of all changes together, the first one is less."""
    if facts.to_lanes is not None and facts.from_lanes is not None and s.tokens[i].kind == "det":
        if abs(facts.to_lanes - facts.from_lanes) <= lanes:
            return
        facts.to_lanes += lanes if kind == "lane_drop" else -lanes
    at = _length_near(s, i)
    metres = s.tokens[at].amount[0] if at is not None else None
    fixed = at is not None and s.tokens[at - 1].text == "at"
    side = side_near(s, i) if s.tokens[i].kind != "turn" else "left" if s.tokens[i].value == "left" else "right"
    facts.events.append(EventWords(kind, i, lanes, side, position=metres if fixed else None, gap=None if fixed else metres))
    if at is not None:
        s.use(at, at, f"{s.tokens[at].text} later")
    s.phrases[:] = [p for p in s.phrases if (p.first, p.head) != (i, i)]  # "another one" is a lane here, no road
    for item in s.lanes:
        if facts.from_lanes is not None and facts.features[kind] < item.first < i and item.count == 1 and not item.per:
            s.used.update(range(item.first, item.last + 1))
    s.use(i, i, kind.replace("_", " "))
