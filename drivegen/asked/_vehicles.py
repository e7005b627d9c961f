"""Noun phrases of vehicles: how many of which kind, and what their adjectives say."""

from itertools import chain
from typing import cast

from drivegen.asked._said import Role, Said, Subject, What
from drivegen.asked._tokens import UNKNOWN, USED, Tags
from drivegen.asked.request import Kind, Manoeuvre
from drivegen.assets.where import Relation

_COUNT = "(DET? HALF? (NUM|SOME) X?|DET|OUR|ITS)"
_VERB = "OVERTAKE|PASS|FOLLOW|BRAKE|TURN|MOVE|SLIP|DRIVE|COME|STOP|CUT IN"
_MOD = f"(ONCOMING|STANDING|LEADING|HEAVY|LIGHT|ADV|QUEUED|SIDE TURN|HARD|ORD|FURTHER|APPROX|{_VERB}|{UNKNOWN}|DENSE|SIDE HAND?)"
_VEHICLES = f"(DET? {_MOD}? QUEUE (OF|WITH))? (APPROX|BE|BOUND)* {_COUNT}? {_MOD}{{0,3}} KIND (?!LANE|TRAFFIC|ROAD|CHANGE)"
_MEMBERS = "(APPROX? (NUM|DET) (MEMBER|OF (DET|OUR) NUM? KIND)|REL? (NUM|DET) MEMBER|MEMBER NUM|DET (ORD|WORD) MEMBER)"
_BARE = "(DET? ORD NUM?|NUM|ORD|OTHERS|DET)"
_AFTER_BARE = ("IN", "TO", "AHEAD", "BEHIND", "BESIDE", "FROM", "ONCOMING", "COMMA", "SIDE", USED, "CUT", "MOVE", "SLIP", "BRAKE",
               "OVERTAKE", "TURN", "SLAM", "BE", "PASS", "FOLLOW", "")  # fmt: skip
_ADDS_NOTHING = (UNKNOWN, "BOUND", "ADV", "HARD", "LIGHT", "DENSE", "HEAVY", *_VERB.split("|"))
_MOST_BARE = 50
_MANOEUVRES = {"STANDING": Manoeuvre.STOPPED, "OVERTAKE": Manoeuvre.OVERTAKE, "PASS": Manoeuvre.OVERTAKE, "CUT": Manoeuvre.CUT_IN}
_TAGS = {Role.GROUP: "NP", Role.NOBODY: "NOBODY", Role.ALL: "ALL"}
_OBJECT_OF = ("OVERTAKE", "PASS", "FOLLOW", "BEHIND", "BESIDE", "AHEAD")
_HARDLY = ("hardly", "barely", "scarcely", "almost no", "next to no", "not much")


def vehicles(tags: Tags) -> list[Subject]:
    """Vehicles with a noun."""
    found = []
    rules = (_VEHICLES, "SOMEBODY", f"DET LEADING(?!KIND|{UNKNOWN}|TARGET)")
    for begin, end in chain.from_iterable(map(tags.find, rules)):
        begin = _without_loose_words(tags, begin, end)
        if tags.tag(begin - 1) == "OR":
            tags.mark(begin, end)
            continue  # "a bus or a truck": one of them will do
        subject = _group(tags, begin, end)
        subject.object = tags.tag(begin - 1) in _OBJECT_OF
        found.append(subject)
        tags.mark(begin, end, _TAGS[subject.role])
    return found


def _without_loose_words(tags: Tags, begin: int, end: int) -> int:
    """Where a noun phrase without an article really begins: words before it that are no adjectives belong to others."""
    has_article = any(tags.tag(i) in ("DET", "NUM", "SOME", "OUR", "ITS", "QUEUE") for i in range(begin, end))
    boundary = tags.tag(begin - 1) in ("", "COMMA", "DOT", "AND", "WITH", "IN")
    while begin < end - 1 and tags.tag(begin) in ("BE", "APPROX", "ADV", "BOUND"):
        begin += 1
    if has_article or boundary:
        return begin
    while begin < end - 1 and tags.tag(begin) in _VERB.split("|"):
        begin += 1
    return begin


def _group(tags: Tags, begin: int, end: int) -> Subject:
    kind, plural, place = cast(
        tuple[Kind, bool, Relation | None],
        tags.value(begin, end, "KIND") or tags.value(begin, end, "SOMEBODY") or (Kind.VEHICLE, False, None),
    )
    count = _count(tags, begin, end, plural)
    if _denied(tags, begin, end) or (tags.words(end, end + 1) == "stops" and not plural and count > 1):
        return Subject(Role.NOBODY, begin, end)  # "no trucks", "two bus stops"
    used = {tags.tag(i) for i in range(begin, end)}
    if tags.words(begin, end).startswith("other ") or (" other " in tags.words(begin, end) and not {"NUM", "SOME", "DET"} & used):
        return Subject(Role.ALL, begin, end)
    subject = Subject(Role.GROUP, begin, end, kind, count)
    subject.member = count if tags.tag(begin - 1) == "INCLUDING" else 0
    subject.vague = plural and {"NUM", "SOME"}.isdisjoint(used)
    subject.known = tags.tokens[begin].tag == "DET" and tags.tokens[begin].value is None
    meant = [i for i in range(begin, end) if tags.tag(i) not in _ADDS_NOTHING]
    for i in range(begin, end):
        meant += _adjective(subject, tags, i)
    if place is not None:
        subject.heard.append(Said(What.ALONG, place, begin, end))
    if {"QUEUE", "QUEUED"} & used:
        subject.heard.append(Said(What.QUEUE, True, begin, begin))
    subject.own = tuple(sorted(set(meant)))
    return subject


def _denied(tags: Tags, begin: int, end: int) -> bool:
    """ "No trucks", "hardly any buses", "mostly cars": nothing of which a number is known."""
    before = (tags.tag(begin - 1), tags.tag(begin - 2))
    denied = before[0] in ("NOT", "MOSTLY") or (before[1] in ("NOT", "MOSTLY") and before[0] in ("ADV", "APPROX"))
    return denied or tags.words(begin - 1, begin).startswith(_HARDLY) or "any" in tags.words(begin, end).split()


def _adjective(subject: Subject, tags: Tags, i: int) -> list[int]:
    """What an adjective says, and the tokens of it."""
    tag, value = tags.tag(i), tags.tokens[i].value
    if tag == "LEADING":
        subject.accepts(Said(What.ALONG, value, i, i + 1))
    elif tag == "ONCOMING":
        subject.accepts(Said(What.ALONG, Relation.ONCOMING, i, i + 1))
    elif tag == "SIDE" and tags.tag(i + 1) != "TURN":
        subject.accepts(Said(What.SIDE, value, i, i + 1))
    elif tag == "SIDE":
        turn = Manoeuvre.TURN_LEFT if value == "left" else Manoeuvre.TURN_RIGHT
        subject.accepts(Said(What.MANOEUVRE, turn, i, i + 2))
        return [i, i + 1]
    elif tag in _MANOEUVRES and (tag == "STANDING" or tags.words(i, i + 1).endswith("ing")):
        subject.accepts(Said(What.MANOEUVRE, _MANOEUVRES[tag], i, i + 1))
    elif tag == "BRAKE" and tags.tag(i - 1) == "HARD":
        subject.accepts(Said(What.MANOEUVRE, Manoeuvre.HARD_BRAKING, i - 1, i + 1))
        return [i - 1, i]
    else:
        return []
    return [i]


def _count(tags: Tags, begin: int, end: int, plural: bool) -> int:
    said = tags.value(begin, end, "NUM") or tags.value(begin, end, "SOME")
    count = int(cast(float, said)) if said is not None else 2 if plural else 1
    return max(count // 2, 1) if tags.value(begin, end, "HALF") is not None else count


def members(tags: Tags) -> list[Subject]:
    """One or several of a group that was named before: "one of them"."""
    found = []
    for begin, end in tags.find(_MEMBERS):
        number = tags.value(begin, begin + (3 if tags.tag(begin) == "MEMBER" else 2), "NUM")
        meant = tuple(i for i in range(begin, end) if tags.tag(i) not in ("ORD", UNKNOWN))
        found.append(Subject(Role.GROUP, begin, end, member=int(cast(float, number or 1)), own=meant))
        tags.mark(begin, end, "NP")
    return found


def bare(tags: Tags) -> list[Subject]:
    """Numbers and pronouns that stand for vehicles: "one on the left", "another behind", "the others"."""
    found = []
    for begin, end in tags.find(_BARE):
        tag, token = tags.tag(begin), tags.tokens[begin]
        if tags.tag(end) not in _AFTER_BARE or (tag == "DET" and end - begin == 1 and token.value != "another"):
            continue
        if tag == "ORD" and token.words not in ("second", "third", "fourth"):
            continue
        if tag == "NUM" and (tags.tag(begin - 1), tags.tag(end)) in (("COMMA", "COMMA"), ("COMMA", "DOT"), ("COMMA", "")):
            continue  # a number of what was named before
        if tags.tag(begin - 1) in ("APPROX", "WITHIN", "OF", "METRE", UNKNOWN) or tags.tag(begin - 1) == "LANE":
            continue
        others = -1 if tag == "OTHERS" else int(cast(float, token.value)) if tag == "NUM" else 1
        if others > _MOST_BARE or others == 0:
            continue
        found.append(
            Subject(Role.GROUP, begin, end, count=max(others, 1), member=others, bare=True, own=tuple(range(begin, end)))
        )
        tags.mark(begin, end, "NP")
    return found
