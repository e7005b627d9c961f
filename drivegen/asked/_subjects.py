"""Who a description speaks of: vehicles, the target, everybody, and what cannot be placed."""

from typing import cast

from drivegen.asked._said import Role, Subject
from drivegen.asked._tokens import UNKNOWN, Tags
from drivegen.asked._vehicles import bare, members, vehicles
from drivegen.asked.request import Kind

_OBJECT_OF = ("IN", "OF", "TO", "INTO", "FROM", "BY", "AHEAD", "BEHIND", "BESIDE", "AROUND", "APPROX", "OVERTAKE", "PASS", "PAST",
              "FOLLOW", "CUT", "ACROSS", "TOWARDS", "PRECEDE", "LEADING", "BLOCK", "SURROUND", "COME", "AWAY", "OFF")  # fmt: skip
"""After these the target is what others do something to."""

_OBJECTS = ("us", "me", "you", "ourselves", "myself")
_NO_SUBJECT_AFTER = ("IN", "OF", "TO", "INTO", "FROM", "BY", "AROUND", "ACROSS", "TOWARDS", "APPROX", "AHEAD", "BEHIND")
_BEGINNINGS = ("", "COMMA", "DOT", "AND", "WITH", "BE", "REL", "MAKE", "NOT", "ADV", "HARD")
_KNOWN = {"NOBODY", "ROAD", "JUNCTION", "NOT"}


def subjects(tags: Tags) -> tuple[list[Subject], list[tuple[Kind, int, int]]]:
    """All subjects in order, and what kinds of vehicle the target is said to be, with the tokens that say it."""
    kinds = _target_kinds(tags)
    found = [*members(tags), *vehicles(tags), *bare(tags), *_everybody(tags), *_nobody(tags), *_targets(tags)]
    found = sorted(found, key=lambda subject: subject.begin)
    _counted_after(tags, found)
    return _predicates(tags, found), kinds


def _counted_after(tags: Tags, found: list[Subject]) -> None:
    """ "Cars: 5" and "trucks on the left: 2" name their number after a colon."""
    for at, _ in tags.find("NUM (?=COMMA|DOT|$)"):
        before = [subject for subject in found if subject.begin < at]
        if before and before[-1].vague and tags.tag(at - 1) == "COMMA" and tags.tokens[at].value != 0:
            before[-1].count, before[-1].vague = int(cast(float, tags.tokens[at].value)), False
            before[-1].own = (*before[-1].own, at)
            tags.mark(at, at + 1)


def _predicates(tags: Tags, found: list[Subject]) -> list[Subject]:
    """Without the nouns that only say of which kind others are: "the follower is a truck", "three of them trucks"."""
    kept: list[Subject] = []
    for subject in found:
        before = kept[-1] if kept else None
        if before is not None and before.role is subject.role is Role.GROUP and _is_a(tags, before, subject):
            before.kind = subject.kind
            before.own = (*before.own, *range(before.end, subject.begin), *subject.own)
            tags.mark(subject.begin, subject.end)
        else:
            kept.append(subject)
    return kept


def _is_a(tags: Tags, before: Subject, subject: Subject) -> bool:
    between = [tags.tag(i) for i in range(before.end, subject.begin)]
    if before.kind not in (Kind.VEHICLE, subject.kind) or subject.heard:
        return False
    if not between and before.known and before.heard and subject.count == 1:
        return True
    if before.member and between in ([], ["BE"]):
        return True
    return between[-1:] == ["BE"] and subject.count == 1 and not {"COMMA", "DOT", "AND", "WITH", "NOT"} & set(between)


def _target_kinds(tags: Tags) -> list[tuple[Kind, int, int]]:
    found: list[tuple[Kind, int, int]] = []
    rules = (
        f"TARGET (BE|DRIVE|ADV)+ (DET|NUM) (HEAVY|{UNKNOWN}){{0,2}} KIND (?!LANE)",
        f"MAKE TARGET (BE|INTO)? DET (HEAVY|{UNKNOWN}){{0,2}} KIND (?!LANE)",
        "TARGET COMMA DET KIND COMMA",
        "DET? KIND AND TARGET",
        "TARGET (BE|DRIVE|ADV)+ IN DET KIND (?!LANE)",
        "TARGET COMMA KIND (?=COMMA|DOT|$)",
    )
    for number, rule in enumerate(rules):
        for begin, end in tags.find(rule):
            if number == 3 and tags.words(begin, end).split(" as ")[0] == tags.words(begin, end):
                continue
            at = next(i for i in range(begin, end) if tags.tag(i) == "TARGET")
            if number != 3 and (tags.tag(at - 1) in _OBJECT_OF or tags.tokens[at].words in _OBJECTS):
                continue
            kind, plural, _ = cast(tuple[Kind, bool, object], tags.value(begin, end, "KIND"))
            one = tags.value(at + 1, end, "NUM") in (None, 1.0)
            if kind is not Kind.VEHICLE and not plural and one:
                found.append((kind, begin, end))
                tags.mark(begin, end, "EGO")
    return found


def _everybody(tags: Tags) -> list[Subject]:
    found = []
    for begin, end in [*tags.find("ALL"), *tags.find("DET? TRAFFIC")]:
        if tags.tag(begin) == "ALL" and tags.tokens[begin].tag != "ALL":
            continue  # a density, which is a subject already
        known = tags.tokens[begin].value == "them"
        found.append(Subject(Role.ALL, begin, end, own=tuple(range(begin, end)), known=known))
        tags.mark(begin, end, "ALL")
    return found


def _nobody(tags: Tags) -> list[Subject]:
    """Road users that cannot be placed, roads, and whatever else has an article."""
    noun = f"(NOBODY|ROAD|JUNCTION|LANE|MANOEUVRE|{UNKNOWN} (?!KIND))"
    adjective = f"(ORD|HEAVY|LIGHT|SIDE|ONCOMING|COME|QUEUED|DRIVE|LEADING|ADV|STANDING|{UNKNOWN})"
    rules = (
        f"(DET|NUM|SOME|OUR|ITS|NOT) {adjective}{{0,3}} {noun}",
        "NOBODY",
        "ROAD",
        "JUNCTION",
        f"(LANE|SOME|HEAVY|MOSTLY) {UNKNOWN}",
    )
    spans = [span for rule in rules for span in tags.find(rule)]
    found = [Subject(Role.NOBODY, begin, end) for begin, end in spans if _speaks_of_it(tags, begin, end)]
    nobody = [
        i for i, token in enumerate(tags.tokens) if tags.tag(i) == "NOT" and token.words in ("nobody", "none", "nothing", "no 1")
    ]
    return found + [Subject(Role.NOBODY, i, i + 1) for i in nobody]


def _speaks_of_it(tags: Tags, begin: int, end: int) -> bool:
    """Whether a noun begins a clause: "the corner" of "cuts the corner" does not, and a place such as "the left lane" neither."""
    words, used = set(tags.words(begin, end).split()), {tags.tag(i) for i in range(begin, end)}
    if "lane" in words and "turn" not in words:
        at_side = bool({"left", "right", "same"} & words) or tags.tag(begin) in ("OUR", "ITS", "NUM")
        if at_side or (tags.tag(begin), tags.tag(begin + 1)) == ("DET", "LANE"):
            return False
    while (
        end - begin == 1 and used & {"ROAD", "JUNCTION"} and tags.tag(begin - 1) in ("DET", "OUR", "ITS", "NUM", "ORD", UNKNOWN)
    ):
        begin, end = begin - 1, end - 1
    if not _KNOWN & used and tags.tag(begin - 1) not in _BEGINNINGS:
        return False
    return tags.tag(begin - 1) not in _NO_SUBJECT_AFTER or tags.tag(begin) == "NOT" or "NOBODY" in used


def _targets(tags: Tags) -> list[Subject]:
    found = [Subject(Role.TARGET, begin, end) for begin, end in tags.find("EGO")]
    for begin, end in tags.find("TARGET"):
        _, kind = cast(tuple[str, Kind | None], tags.tokens[begin].value)
        if tags.tag(begin - 1) in _OBJECT_OF or tags.tokens[begin].words in _OBJECTS:
            continue
        found.append(Subject(Role.TARGET, begin, end, kind=kind or Kind.VEHICLE, own=(begin,)))
        tags.mark(begin, end, "EGO")
    return found
