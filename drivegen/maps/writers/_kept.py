"""Whether the road that was built keeps what was said of it.

The rules take facts from the words one by one, and a fact that is said twice is kept once. Here the words are read a second
time, fact by fact, and each is looked up in what was built. One that isn't there is contradicted by another, or was
misunderstood: both are reasons not to draw.
"""

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass

from drivegen.errors import UnusableInput
from drivegen.maps.spec import MapSpec
from drivegen.maps.writers._built import Built, built
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._quantities import Lanes
from drivegen.maps.writers._sentence import Sentence

_NEAR = 0.03
_NEXT = 5
_SEVERAL = 2
_FEWEST_ARMS = 3
_RAMPS = {"on": ("on_ramp",), "off": ("off_ramp",), "": ("on_ramp", "off_ramp")}
_BENDS = ("curve", "s_curve", "hairpin")
_WHOLLY = frozenset(
    ("perfectly", "completely", "totally", "absolutely", "entirely", "dead", "arrow", "strictly", "exactly", "without")
)
_PARTS = frozenset(("section", "part", "approach", "stretch", "piece", "bit", "before", "after", "otherwise"))
_OTHERS = frozenset(("other", "others", "further", "more", "additional", "else", "extra", "another", "otherwise", "intermediate"))


@dataclass(frozen=True)
class _Said:
    """One fact: what it is of, its tokens, and whether the road has it."""

    what: str
    first: int
    last: int
    kept: bool


def refuse_unkept(s: Sentence, spec: MapSpec, waived: Collection[float] = ()) -> None:
    """Raise UnusableInput at a fact that the road doesn't have; `waived` are lengths [m] that it needn't."""
    found = built(spec)
    said = [fact for read in _READERS for fact in read(s, found)]
    said = [fact for fact in said if not (fact.what == "length" and s.tokens[fact.first].amount[0] in waived)]
    for fact in said:
        if fact.kept:
            continue
        rivals = [other for other in said if other.what == fact.what and other.kept and _words(s, other) != _words(s, fact)]
        if rivals:
            raise UnusableInput(
                f"{_words(s, rivals[0])!r} and {_words(s, fact)!r} cannot both hold for one road", reason="impossible-map"
            )
        raise UnusableInput(
            f"the road that I understand does not keep {_words(s, fact)!r}; please say it in other words", reason="not-understood"
        )


def _words(s: Sentence, fact: _Said) -> str:
    first = fact.first - 1 if s.word(fact.first - 1, "neg") else fact.first
    return " ".join(t.text for t in s.tokens[first : fact.last + 1]).strip(" ,.")


def _is_near(value: float, values: Collection[float]) -> bool:
    return any(abs(value - other) <= _NEAR * max(value, other) for other in values)


def _measures(s: Sentence, found: Built) -> Iterator[_Said]:
    """Speeds, lengths and angles that some rule took."""
    for i, token in enumerate(s.tokens):
        if i not in s.used or not token.amount:
            continue
        amount = token.amount[0]
        if token.kind == "speed":
            yield _Said("speed", i, i, _is_near(amount, found.speeds))
        elif token.kind == "length":
            yield _Said("length", i, i, _is_near(amount, found.lengths))
        elif token.kind == "angle":
            yield _Said("angle", i, i, _is_near(amount, {a for b in found.angles for a in (b, 180.0 - b, 360.0 - b)}))


def _lanes(s: Sentence, found: Built) -> Iterator[_Said]:
    for item in s.lanes:
        if item.first in s.used:
            yield _Said("lanes", item.first, item.last, item.count in _possible(item, found))
    for i in s.of_kind("lane", "", "ring"):
        ends = i + 1 == len(s.tokens) or s.tokens[i + 1].kind in ("comma", "stop", "each")
        if ends and s.tokens[i].text.endswith("lanes") and any(s.word(j, "neg") for j in (i - 1, i - 2)):
            yield _Said("lanes", i, i, s.negated_at(i) and s.word(i - 2, "neg") and s.tokens[i - 1].text in _OTHERS)


def _possible(item: Lanes, found: Built) -> set[int]:
    if item.per in ("each", "arms", "all"):
        return found.lanes | found.changes
    if item.per == "total":
        return found.totals
    return found.lanes | found.changes | found.totals


def _places(s: Sentence, found: Built) -> Iterator[_Said]:
    """How many junctions of a form there are, and that there are none."""
    for phrase in s.phrases:
        if phrase.kind != "place":
            continue
        form = phrase.value if phrase.value in ("roundabout", "grid") else "crossing"
        there = found.arms.count(_FEWEST_ARMS) if phrase.value == "t" else found.counts[form]
        if phrase.negated:
            yield _Said(form, phrase.first, phrase.head, not there or _leaves_some(s, phrase) or form == "grid")
        elif phrase.value not in ("grid", "staggered"):
            whole = (form == "crossing" and found.counts["grid"] > 0) or s.word(phrase.head + 1, "total")
            enough = there == phrase.number if whole and (phrase.number or 0) >= _SEVERAL else there >= (phrase.number or 1)
            enough = enough or (form == "crossing" and found.counts["fork"] > 0)
            yield _Said(form, phrase.first, phrase.head, enough or _is_no_thing(s, phrase))


def _leaves_some(s: Sentence, phrase: Phrase) -> bool:
    """Whether what is denied is only more of it, or one of several: "no other ramps", "no traffic lights at the second"."""
    near = s.tokens[max(0, phrase.first - 2) : phrase.head + 4]
    words = {word for t in near for word in t.text.split()}
    return bool(words & _OTHERS) or any(t.kind in ("but", "ordinal") for t in s.tokens[phrase.head + 1 : phrase.head + 3])


def _is_no_thing(s: Sentence, phrase: Phrase) -> bool:
    """Whether the words name no junction of the map: where the road leads to, or what it is far from."""
    return phrase.number is None and phrase.head not in s.used


def _ramps(s: Sentence, found: Built) -> Iterator[_Said]:
    for phrase in s.phrases:
        if phrase.kind == "weaving":
            yield _Said("weaving", phrase.first, phrase.head, phrase.negated != bool(found.counts["weaving"]))
        if phrase.kind != "ramp":
            continue
        there = max(found.counts[name] for name in _RAMPS[phrase.value.split("_")[0]])
        if phrase.negated:
            yield _Said("ramps", phrase.first, phrase.head, not there or _leaves_some(s, phrase))
        elif phrase.head in s.used and phrase.value in ("on", "off") and not found.counts["fork"]:
            yield _Said("ramps", phrase.first, phrase.head, there >= (phrase.number or 1))
            for i in s.verbs("leave" if phrase.value == "on" else "join", "leave" if phrase.value == "on" else "merge"):
                says = [t.text in ("which", "that") for t in s.tokens[phrase.head + 1 : i]]
                if any(says) and i - phrase.head <= _NEXT and not s.between(phrase.head, i, "comma", "stop", "and", "ramp"):
                    yield _Said("ramps", phrase.first, i, kept=False)  # "an on-ramp by which cars leave"


def _control(s: Sentence, found: Built) -> Iterator[_Said]:
    """Who goes first, as long as there is somewhere to go first."""
    lit, all_of_them = found.controls["signals"], sum(found.controls.values())
    for phrase in s.phrases:
        if phrase.kind != "control" or phrase.value == "signs":
            continue
        kept = True
        if phrase.value in ("signals", "unsignalled"):
            wanted = (phrase.value == "signals") != phrase.negated
            kept = lit > 0 if wanted else lit == 0 or (all_of_them > 1 and lit < all_of_them)
        elif phrase.value in ("all_way_stop", "uncontrolled") and not phrase.negated:
            kept = found.controls[phrase.value] > 0 or not all_of_them
        elif phrase.value == "stop" and not phrase.negated and phrase.text != "stop":  # the word alone may be a telegram's
            kept = found.controls["stop"] + found.controls["all_way_stop"] > 0
        yield _Said("control", phrase.first, phrase.head, kept or phrase.head not in s.used)


def _shapes(s: Sentence, found: Built) -> Iterator[_Said]:
    bent = found.counts["bend"] > 0
    for phrase in s.said("shape", "straight"):
        yield _Said("bends", phrase.first, phrase.head, not (bent and _is_straight_throughout(s, phrase)))
    for phrase in s.phrases:
        if phrase.kind == "shape" and phrase.value in _BENDS and phrase.head in s.used:
            elsewhere = bool(found.counts["crossing"] or found.counts["fork"] or found.counts["interchange"])
            yield _Said("bends", phrase.first, phrase.head, not bent if phrase.negated else bent or elsewhere)


def _is_straight_throughout(s: Sentence, phrase: Phrase) -> bool:
    """Whether the whole road is said to be straight, and not only a part of it or the road that a bend interrupts."""
    near = {word for t in s.tokens[max(0, phrase.head - 2) : phrase.head + 1] for word in t.text.split()}
    after = [t.text for t in s.tokens[phrase.head + 1 : phrase.head + 4]]
    part = bool(set(after[:1]) & _PARTS) or s.word(phrase.head + 1, "but") or s.word(phrase.head + 1, "prep")
    says_it = bool(near & _WHOLLY) or any(t in ("throughout", "everywhere") for t in after)
    explained = s.word(phrase.head + 1, "road") and after[1:2] in (["that"], ["which"]) and not s.word(phrase.head + 3, "seq")
    bent = any(p.value in _BENDS for p in s.said("shape") if phrase.head < p.head <= phrase.head + 1)  # "straight hairpin"
    return (says_it and not part) or explained or bent or phrase.text.endswith("line")


def _ways(s: Sentence, found: Built) -> Iterator[_Said]:
    both = found.counts["two_way"] > 0 or found.counts["median"] > 0
    for i, token in enumerate(s.tokens):
        if token.kind == "one_way" and not s.negated_at(i):
            yield _Said("ways", i, i, found.counts["one_way"] > 0)
        elif token.kind == "two_way" or (token.kind == "each" and _means_both_ways(s, i)):
            yield _Said("ways", i, i, both)


def _means_both_ways(s: Sentence, i: int) -> bool:
    """Whether "in each direction" is said of traffic, or "in both directions" of anything."""
    words = s.tokens[i].text.split()
    of_lanes = any(item.first <= i <= item.last for item in s.lanes)
    return words[-1] in ("direction", "directions", "ways") and ("both" in words or ("each" in words and not of_lanes))


def _is_only(s: Sentence, phrase: Phrase) -> bool:
    """Whether no more than one is meant: "only one street", "a single side road", "into one branch"."""
    near = {word for t in s.tokens[max(0, phrase.first - 2) : phrase.head + 1] for word in t.text.split()}
    return bool(near & {"only", "just", "exactly", "single", "into"})


def _others(s: Sentence, found: Built) -> Iterator[_Said]:
    """Turn lanes, dead ends, medians, rings, branches."""
    divided = list(s.of_kind("divided"))
    for i in divided:
        yield _Said("median", i, i, not s.negated_at(i) or all(map(s.negated_at, divided)))
    splits = list(s.verbs("split"))
    for i in splits:  # "fork where the road does not split"
        yield _Said("fork", i, i, not s.negated_at(i) or all(map(s.negated_at, splits)))
    for phrase in s.denied("ring"):
        yield _Said("ring", phrase.first, phrase.head, not found.counts["roundabout"])
    for phrase in (*s.said("road"), *s.said("arm")):
        one = s.word(phrase.first - 1, "number") and s.tokens[phrase.first - 1].number == 1
        if phrase.number == 1 or one or "single" in phrase.text.split():
            several = bool(splits) if phrase.kind == "arm" or phrase.role == "side" else found.counts["grid"] > 0
            pair = phrase.role == "side" and any(s.said("place", "staggered"))
            yield _Said("roads", phrase.first, phrase.head, not (_is_only(s, phrase) and (several or pair)))
    for phrase in s.phrases:
        if phrase.kind == "pocket":
            yield _Said("turn lanes", phrase.first, phrase.head, phrase.negated != bool(found.counts["pocket"]))
        elif phrase.kind == "dead_end":
            an_arm = not phrase.negated and found.counts["crossing"] == 1  # every arm of a crossing ends somewhere
            yield _Said("dead end", phrase.first, phrase.head, phrase.negated != bool(found.counts["dead_end"]) or an_arm)


def _changes(s: Sentence, found: Built) -> Iterator[_Said]:
    """Roads that narrow and widen."""
    less = found.counts["lane_drop"] + found.counts["off_ramp"] + found.counts["fork"] + found.counts["on_ramp"]
    more = found.counts["lane_gain"] + found.counts["on_ramp"] + found.counts["fork"]
    for i in s.verbs("narrow", "widen", "gain", "lose"):
        of_lanes = s.tokens[i].value in ("narrow", "widen") or any(t.kind == "lane" for t in s.tokens[i + 1 : i + 4])
        if of_lanes and not s.negated_at(i):
            yield _Said("lanes", i, i, (less if s.tokens[i].value in ("narrow", "lose") else more) > 0)
    for phrase in s.said("extra", "drop", "gain"):
        yield _Said("lanes", phrase.first, phrase.head, (less if phrase.value == "drop" else more) > 0)


_READERS: tuple[Callable[[Sentence, Built], Iterator[_Said]], ...] = (
    *(_places, _ramps, _control, _shapes, _ways, _changes, _lanes, _measures, _others),
)
