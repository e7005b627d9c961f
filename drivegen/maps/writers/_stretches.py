"""Numbers of lanes told stretch by stretch: "three lanes for the first 1000 m, then two lanes for another 800 m"."""

from itertools import pairwise

from drivegen.maps.writers._changes import is_lane_count, last_of_count
from drivegen.maps.writers._facts import EventWords, Facts
from drivegen.maps.writers._lane_ends import side_near
from drivegen.maps.writers._sentence import Sentence

_OVER = frozenset(("for", "over", "along", "across", "during"))
_FURTHER = frozenset(
    ("further", "next", "following", "remaining", "last", "final", "another", "first", "initial", "other", "rest")
)
_FILLS = frozenset(("det", "ordinal", "seq", "unknown", "small", "number", "but"))
_TWO = 2
_BENDS = ("curve", "s_curve", "hairpin")


def read_stretches(s: Sentence, facts: Facts) -> None:
    """Lanes of the stretches of one road; the road is as long as they are together, if the last one's length is said."""
    counts, lengths = _told_in_turn(s)
    if not counts:
        return
    lanes, metres = [s.tokens[i].number for i in counts], [s.tokens[i].amount[0] for i in lengths]
    facts.from_lanes, facts.to_lanes = lanes[0], lanes[1]
    facts.lengths["position"] = metres[0]
    facts.features["lane_gain" if lanes[1] > lanes[0] else "lane_drop"] = counts[1]
    for k, (before, after) in enumerate(pairwise(lanes[1:]), 1):
        kind = "lane_gain" if after > before else "lane_drop"
        facts.features.setdefault(kind, counts[k + 1])
        event = EventWords(kind, counts[k + 1], abs(after - before), side_near(s, counts[k + 1]), position=sum(metres[: k + 1]))
        facts.events.append(event)
    if len(metres) == len(lanes):
        facts.lengths["length"], facts.whole = sum(metres), True
    for i, number in zip(counts, lanes, strict=True):
        s.use(i, last_of_count(s, i), f"{number} lanes")
    for i in lengths:
        s.use(i, i, f"over {s.tokens[i].text}")
    for i in range(counts[0], max(*counts, *lengths)):
        if s.tokens[i].kind in ("verb", "number") and i not in s.used:
            s.use(i, i, "")


def _told_in_turn(s: Sentence) -> tuple[list[int], list[int]]:
    """Where numbers of lanes and lengths of stretches stand, if they follow one another in turn; else nothing."""
    elsewhere = any(s.said("place")) or any(s.said("ramp")) or any(s.said("shape", *_BENDS)) or any(s.verbs("split"))
    lengths = [i for i in s.of_kind("length") if _is_of_stretch(s, i)]
    counts = [i for i in s.of_kind("number") if _is_count(s, i)]
    if elsewhere or not lengths or len(counts) < _TWO or not 0 <= len(counts) - len(lengths) <= 1:
        return [], []
    kinds = [i in lengths for i in sorted([*lengths, *counts])]
    same = any(s.tokens[a].number == s.tokens[b].number for a, b in pairwise(counts))
    if any(a == b for a, b in pairwise(kinds)) or same or not _goes_on(s, counts):
        return [], []
    return counts, lengths


def _is_of_stretch(s: Sentence, i: int) -> bool:
    """Whether the length at i is that of a stretch: "for 300 m", "over the next 300 m", "another 800 m"."""
    j = i - 1
    words: list[str] = []
    while j >= 0 and s.tokens[j].kind in _FILLS and s.tokens[j].text not in _OVER:
        words += s.tokens[j].text.split()
        j -= 1
    over = j >= 0 and s.tokens[j].text in _OVER
    return i not in s.used and (over or bool(_FURTHER & set(words)))


def _is_count(s: Sentence, i: int) -> bool:
    """Whether the number at i counts lanes, said with the word or, after a first one, without."""
    if i in s.used or not is_lane_count(s, i):
        return any(item.first == i and not item.per for item in s.lanes) and i not in s.used
    told = any(item.first == i for item in s.lanes)
    ends = i + 1 == len(s.tokens) or s.tokens[i + 1].kind in ("comma", "stop") or s.tokens[i + 1].text in _OVER
    return told or (ends and any(item.last < i for item in s.lanes))


def _goes_on(s: Sentence, counts: list[int]) -> bool:
    """Whether every number is said to follow the one before it in time or place."""
    joins = ("seq", "later", "verb", "comma", "and", "stop")
    return all(s.between(a, b, *joins) for a, b in pairwise(counts))
