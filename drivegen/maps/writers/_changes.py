"""Roads that narrow or widen, and how many lanes there are before and after."""

from drivegen.errors import UnusableInput
from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._lane_ends import is_of_auxiliary, read_extra, read_lane_verb, read_next_lane_verb
from drivegen.maps.writers._sentence import Sentence

_NO_NOUNS = frozenset(
    ("over", "within", "about", "here", "there", "soon", "because", "as", "since", "due", "near", "behind", "ahead", "so")
)
_SKIPPED = ("prep", "but", "det", "is", "that", "role", "verb", "unknown", "with", "turn")


def read_changes(s: Sentence, facts: Facts) -> None:
    """Lane drops and gains, by numbers or in words."""
    _read_from_to(s, facts)
    _leave_out_lost(s)
    for i in s.verbs("narrow", "widen", "become", "lose", "gain", "merge"):
        if facts.from_lanes is None and not s.negated_at(i) and i not in s.used and not is_of_auxiliary(s, i):
            _read_verb(s, facts, i)
    for i in s.verbs("narrow", "widen", "lose", "gain", "end"):
        if s.negated_at(i) or i in s.used or is_of_auxiliary(s, i):
            continue
        if not facts.has("lane_drop", "lane_gain", "lane_change"):
            read_lane_verb(s, facts, i)
        else:
            read_next_lane_verb(s, facts, i)
    extras = list(s.said("extra"))
    heads = bool(extras) and not s.between(-1, extras[0].first, "length", "turn", "number", "road", "lane")
    if heads and s.word(extras[0].head + 1, "comma") and (len(extras) > 1 or facts.has("lane_drop")):
        s.use(extras[0].first, extras[0].head, "")  # a heading: "Lane closure: the left lane ends"
    for phrase in (p for p in extras if p.head not in s.used):
        read_extra(s, facts, phrase.head)


def lane_count(s: Sentence, start: int, end: int) -> int | None:
    """The first number of lanes from token `start` on, over small words."""
    for i in range(start, end):
        token = s.tokens[i]
        if token.kind == "number":
            return i
        if token.kind == "ordinal" and token.text == "first" and s.word(i + 1, "prep"):
            continue  # "narrowing first to three"
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
    bound = bound and following[0].text not in _NO_NOUNS
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
        ramp = s.last_before(before, "ramp", "road")
        joined = joined or (bool(verbs & {"merge", "join"}) and ramp is not None and ramp.kind == "ramp")
        own = ("lane", "each", "verb", "but", "road")
        if all(t.kind in own for t in between) and lanes_said and not joined:
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
    if verb == "gain" and (at := _ordinal_before(s, i)) is not None:
        third = int(s.tokens[at].value)
        last = after if after is not None and s.tokens[after].number == third - 1 else i  # "a fourth lane is added to three"
        _change(s, facts, third - 1, third, at, last)
        return
    if verb in ("lose", "gain") and not s.between(i, (after or i) + 1, "prep"):
        return
    if after is not None and any(t.kind == "prep" and t.value == "from" for t in s.tokens[i:after]):
        return
    if after is None or not is_lane_count(s, after) or (verb in ("lose", "gain", "merge") and _adjectival(s, after)):
        return
    if verb == "merge" and not (s.between(i, after, "prep") and _lane_or_end(s, after) and not _of_ramp(s, i, after)):
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


def _leave_out_lost(s: Sentence) -> None:
    """Take the number of lanes that are lost or gained where those before and after are told: "five lanes, loses one lane and
    carries on with four".
    """
    for i in s.verbs("become"):
        counts = [item for item in s.lanes if item.last < i and item.first not in s.used]
        verb = s.tokens[counts[-1].first - 1] if len(counts) > 1 else None
        if verb is not None and verb.kind == "verb" and verb.value in ("lose", "gain"):
            s.use(counts[-1].first - 1, counts[-1].last, "")


def _of_ramp(s: Sentence, i: int, after: int) -> bool:
    """Whether it is a ramp that merges: "a two-lane ramp that merges into three through lanes"."""
    subject = s.last_before(i, "ramp", "road")
    through = s.word(after + 1, "lane") and s.tokens[after + 1].value == "main"
    return through and subject is not None and subject.kind == "ramp"


def _adjectival(s: Sentence, i: int) -> bool:
    return any(item.inside for item in s.lanes if item.first == i)


def _lane_or_end(s: Sentence, i: int) -> bool:
    return i + 1 >= len(s.tokens) or s.tokens[i + 1].kind in ("lane", "comma", "stop", "prep", "number")


def _ordinal_lane(s: Sentence, i: int) -> int | None:
    for token, following in zip(s.tokens[i + 1 : i + 4], s.tokens[i + 2 : i + 5], strict=False):
        if token.kind == "ordinal" and following.kind == "lane":
            return int(token.value)
    following_kinds = ("prep", "and", "comma", "later", "length", "stop", "turn")
    one = s.word(i + 3, "number") and s.tokens[i + 3].text == "1" and not s.word(i + 4, "lane")  # "gains a third one"
    alone = one or i + 3 >= len(s.tokens) or s.tokens[i + 3].kind in following_kinds
    if alone and s.word(i + 1, "det") and s.word(i + 2, "ordinal") and int(s.tokens[i + 2].value) > 1:
        return int(s.tokens[i + 2].value)  # "gains a third after 400 m"
    return None


def _ordinal_before(s: Sentence, i: int) -> int | None:
    """The ordinal of "a third lane is added", "a fourth lane begins"."""
    places = (j for j in range(i - 1, max(0, i - 4), -1) if s.word(j, "lane") and s.word(j - 1, "ordinal"))
    at = next(places, None)
    return at - 1 if at is not None and int(s.tokens[at - 1].value) > 1 else None


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
