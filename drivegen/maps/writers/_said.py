"""What is said of the things along a road, each looked up in what was built: junctions, ramps, bends, ways, control."""

from collections.abc import Iterator
from dataclasses import dataclass

from drivegen.maps.writers._built import Built
from drivegen.maps.writers._forks import lanes_of_named
from drivegen.maps.writers._owners import is_turning_place
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._sentence import Sentence

_NEXT = 5
_SEVERAL = 2
_FEWEST_ARMS = 3
_RAMPS = {"on": ("on_ramp",), "off": ("off_ramp",), "": ("on_ramp", "off_ramp")}
_BENDS = ("curve", "s_curve", "hairpin")
_WHOLLY = frozenset(
    ("perfectly", "completely", "totally", "absolutely", "entirely", "dead", "arrow", "strictly", "exactly", "without")
)
_PARTS = frozenset(("section", "part", "approach", "stretch", "piece", "bit", "before", "after", "otherwise"))
OTHERS = frozenset(("other", "others", "further", "more", "additional", "else", "extra", "another", "otherwise", "intermediate"))


@dataclass(frozen=True)
class Said:
    """One fact: what it is of, its tokens, and whether the road has it."""

    what: str
    first: int
    last: int
    kept: bool


def said_places(s: Sentence, found: Built) -> Iterator[Said]:
    """How many junctions of a form there are, and that there are none."""
    for phrase in s.phrases:
        if phrase.kind != "place":
            continue
        form = phrase.value if phrase.value in ("roundabout", "grid") else "crossing"
        there = found.arms.count(_FEWEST_ARMS) if phrase.value == "t" else found.counts[form]
        if s.tokens[phrase.head].text in ("junctions", "intersections"):
            there += found.counts["roundabout"]
        if phrase.negated:
            yield Said(form, phrase.first, phrase.head, not there or _leaves_some(s, phrase) or form == "grid")
        elif phrase.value not in ("grid", "staggered"):
            whole = (form == "crossing" and found.counts["grid"] > 0) or s.word(phrase.head + 1, "total")
            enough = there == phrase.number if whole and (phrase.number or 0) >= _SEVERAL else there >= (phrase.number or 1)
            enough = enough or (form == "crossing" and found.counts["fork"] > 0)
            yield Said(form, phrase.first, phrase.head, enough or _is_no_thing(s, phrase))


def _leaves_some(s: Sentence, phrase: Phrase) -> bool:
    """Whether what is denied is only more of it, or one of several: "no other ramps", "no traffic lights at the second"."""
    near = s.tokens[max(0, phrase.first - 2) : phrase.head + 4]
    words = {word for t in near for word in t.text.split()}
    return bool(words & OTHERS) or any(t.kind in ("but", "ordinal") for t in s.tokens[phrase.head + 1 : phrase.head + 3])


def _is_no_thing(s: Sentence, phrase: Phrase) -> bool:
    """Whether the words name no junction of the map: where the road leads to, or what it is far from."""
    return phrase.number is None and phrase.head not in s.used


def said_ramps(s: Sentence, found: Built) -> Iterator[Said]:
    for phrase in s.phrases:
        if phrase.kind == "weaving":
            yield Said("weaving", phrase.first, phrase.head, phrase.negated != bool(found.counts["weaving"]))
        if phrase.kind != "ramp":
            continue
        there = max(found.counts[name] for name in _RAMPS[phrase.value.split("_")[0]])
        if phrase.negated:
            yield Said("ramps", phrase.first, phrase.head, not there or _leaves_some(s, phrase))
        elif phrase.head in s.used and phrase.value in ("on", "off") and not found.counts["fork"]:
            leaves = phrase.value == "on" and s.word(phrase.head + 1, "verb") and s.tokens[phrase.head + 1].value == "leave"
            yield Said("ramps", phrase.first, phrase.head, there >= (phrase.number or 1) and not leaves)
            for i in s.verbs("leave" if phrase.value == "on" else "join", "leave" if phrase.value == "on" else "merge"):
                says = [t.text in ("which", "that") for t in s.tokens[phrase.head + 1 : i]]
                if any(says) and i - phrase.head <= _NEXT and not s.between(phrase.head, i, "comma", "stop", "and", "ramp"):
                    yield Said("ramps", phrase.first, i, kept=False)  # "an on-ramp by which cars leave"


def said_numbers(s: Sentence, found: Built) -> Iterator[Said]:
    """Ramps and junctions of which the road has more than all that are spoken of."""
    for name in ("on", "off"):
        ramps = [p for p in s.said("ramp") if p.value.startswith(name)]
        yield from _enough(s, ramps, found.counts[f"{name}_ramp"] * (not found.counts["interchange"]))
    places = [p for p in s.said("place") if p.value not in ("grid", "staggered")]
    several = any(p.role == "side" or (p.number or 1) > 1 for p in s.said("road"))
    if not several and not any(s.said("place", "grid", "staggered")) and not found.counts["interchange"]:
        yield from _enough(s, places, found.counts["crossing"] + found.counts["roundabout"])


def _enough(s: Sentence, spoken: list[Phrase], there: int) -> Iterator[Said]:
    if spoken and all(p.number or not s.tokens[p.head].text.endswith("s") for p in spoken):
        kept = sum(p.number or 1 for p in spoken) >= there
        yield Said(f"number of {spoken[0].kind}s", spoken[0].first, spoken[0].head, kept)


def said_control(s: Sentence, found: Built) -> Iterator[Said]:
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
        elif phrase.value == "stop" and not phrase.negated and "sign" in phrase.text:  # "stop" alone may be a telegram's
            kept = found.controls["stop"] + found.controls["all_way_stop"] > 0
        yield Said("control", phrase.first, phrase.head, kept or phrase.head not in s.used)


def said_shapes(s: Sentence, found: Built) -> Iterator[Said]:
    bent = found.counts["bend"] > 0
    for phrase in s.said("shape", "straight"):
        yield Said("bends", phrase.first, phrase.head, not (bent and _is_straight_throughout(s, phrase)))
    for phrase in s.phrases:
        if phrase.kind == "shape" and phrase.value in _BENDS and phrase.head in s.used:
            elsewhere = bool(found.counts["crossing"] or found.counts["fork"] or found.counts["interchange"])
            yield Said("bends", phrase.first, phrase.head, not bent if phrase.negated else bent or elsewhere)


def _is_straight_throughout(s: Sentence, phrase: Phrase) -> bool:
    """Whether the whole road is said to be straight, and not only a part of it or the road that a bend interrupts."""
    near = {word for t in s.tokens[max(0, phrase.head - 2) : phrase.head + 1] for word in t.text.split()}
    after = [t.text for t in s.tokens[phrase.head + 1 : phrase.head + 4]]
    part = bool(set(after[:1]) & _PARTS) or s.word(phrase.head + 1, "but") or s.word(phrase.head + 1, "prep")
    says_it = bool(near & _WHOLLY) or any(t in ("throughout", "everywhere") for t in after)
    explained = s.word(phrase.head + 1, "road") and after[1:2] in (["that"], ["which"]) and not s.word(phrase.head + 3, "seq")
    explained = explained or (
        s.word(phrase.head + 1, "road") and any(t.text == "whose" for t in s.tokens[phrase.head : phrase.head + 6])
    )
    bent = any(p.value in _BENDS for p in s.said("shape") if phrase.head < p.head <= phrase.head + 1)  # "straight hairpin"
    return (says_it and not part) or explained or bent or phrase.text.endswith("line")


def said_turns(s: Sentence, found: Built) -> Iterator[Said]:
    """To which side the only bend turns: "a curve to the left that bends to the right"."""
    if found.counts["bend"] != 1:
        return
    for phrase in s.said("shape", "curve"):
        i = phrase.head + 1
        while i < len(s.tokens) and s.tokens[i].kind in ("but", "angle", "bend_size", "by"):
            i += 1
        if s.word(i, "turn"):
            yield Said("side of the bend", i, i, (s.tokens[i].value == "left") == (found.counts["left_bend"] > 0))


def said_ways(s: Sentence, found: Built) -> Iterator[Said]:
    both = found.counts["two_way"] > 0 or found.counts["median"] > 0
    for i, token in enumerate(s.tokens):
        if token.kind == "one_way" and not s.negated_at(i):
            yield Said("ways", i, i, found.counts["one_way"] > 0)
        elif (token.kind == "two_way" and not s.negated_at(i)) or (token.kind == "each" and _means_both_ways(s, i)):
            yield Said("ways", i, i, both)


def _means_both_ways(s: Sentence, i: int) -> bool:
    """Whether "in each direction" is said of traffic, or "in both directions" of anything."""
    words = s.tokens[i].text.split()
    of_lanes = any(item.first - 3 < i <= item.last for item in s.lanes)
    return words[-1] in ("direction", "directions", "ways") and (
        "both" in words or "2" in words or ("each" in words and not of_lanes)
    )


def _is_only(s: Sentence, phrase: Phrase) -> bool:
    """Whether no more than one is meant: "only one street", "a single side road", "into one branch"."""
    near = {word for t in s.tokens[max(0, phrase.first - 2) : phrase.head + 1] for word in t.text.split()}
    return bool(near & {"only", "just", "exactly", "single", "into"})


def said_others(s: Sentence, found: Built) -> Iterator[Said]:
    """Turn lanes, dead ends, rings, medians, the side of traffic, roads that never meet."""
    for phrase in s.phrases:
        if phrase.kind == "pocket" and not found.counts["fork"]:
            yield Said("turn lanes", phrase.first, phrase.head, phrase.negated != bool(found.counts["pocket"]))
        elif is_turning_place(s, phrase):
            continue
        elif phrase.kind == "dead_end":
            an_arm = not phrase.negated and found.counts["crossing"] == 1  # every arm of a crossing ends somewhere
            yield Said("dead end", phrase.first, phrase.head, phrase.negated != bool(found.counts["dead_end"]) or an_arm)
        elif phrase.kind == "ring" and phrase.negated:
            yield Said("ring", phrase.first, phrase.head, not found.counts["roundabout"])
    for i in s.of_kind("left_hand"):
        yield Said("side", i, i, (s.tokens[i].value == "left") == bool(found.counts["left_hand"]))
    divided = list(s.of_kind("divided"))
    for i in divided:
        yield Said("median", i, i, not s.negated_at(i) or all(map(s.negated_at, divided)))
    meeting = any(found.counts[name] for name in ("crossing", "roundabout", "on_ramp"))
    for i in s.verbs("meet", "cross", "join", "merge"):
        yield Said("meeting", i - 1, i, not (meeting and s.tokens[i - 1].text == "never"))


def said_branches(s: Sentence, found: Built) -> Iterator[Said]:
    """Forks that do not split, and single roads where there must be several."""
    for side, i in lanes_of_named(s).items() if found.branches else ():
        yield Said("lanes", i, i, s.tokens[i].number == found.branches[side])
    splits = list(s.verbs("split"))
    for i in splits:  # "fork where the road does not split"
        yield Said("fork", i, i, not s.negated_at(i) or all(map(s.negated_at, splits)))
    for phrase in (*s.said("road"), *s.said("arm")):
        one = s.word(phrase.first - 1, "number") and s.tokens[phrase.first - 1].number == 1
        single = "single" in [t.text for t in s.tokens[max(0, phrase.first - 1) : phrase.head]]
        if phrase.number == 1 or one or single:
            several = bool(splits) if phrase.kind == "arm" or phrase.role == "side" else any(s.said("place", "grid"))
            pair = phrase.role == "side" and any(s.said("place", "staggered"))
            yield Said("roads", phrase.first, phrase.head, not (_is_only(s, phrase) and (several or pair)))
