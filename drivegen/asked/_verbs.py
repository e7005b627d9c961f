"""What vehicles do, put together from the verb, where to, and whose way it is."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from drivegen.asked._said import ACROSS, Said, What
from drivegen.asked._tokens import Tags
from drivegen.asked.request import Manoeuvre
from drivegen.assets.where import Relation

_X = "(ADV|HARD|GENTLY|FURTHER|APPROX|LANE|(DET|NUM) LANE|ITS LANE)*"
"""Words between a verb and where it leads."""

_LANE = "(OUR (LANE|PATH)|DET (LANE|PATH) OF TARGET|TARGET (LANE|PATH)|INLANE (AND TARGET)?)"
"""The target's lane."""

_SIDE = "(DET|OUR|ITS)? FURTHER? SIDE HAND? LANE?"
_ON_SIDE = "((IN|FROM|TO) (DET|OUR|ITS)? SIDE HAND? LANE?)?"
_DOES = "(TAKE|MAKE|BE)*"
_GOAL = f"(AHEAD TARGET|INTO {_LANE}|ACROSS ({_LANE}|TARGET)|IN {_LANE})"
_LEADS = "(SLIP|MOVE|COME|GO|TAKE|DRIVE|TURN|CUT)"
_TO_SIDE = "(TO? DET? SIDE COMMA?)?"
_INWARDS = "(IN|OVER|OUT|INTO)?"
_OUR = "(DET|OUR|ITS)"
_JUNCTION = "((IN|TO|AHEAD) DET? ADV? JUNCTION)?"
_CROSSING = f"((ACROSS|AHEAD|OVER|INTO) ({_LANE}|OUR LANE|TARGET)|OVER DET PATH OF TARGET)"


@dataclass(frozen=True)
class _Span:
    """Tokens [begin, end) that a rule matches."""

    tags: Tags
    begin: int
    end: int

    @property
    def words(self) -> str:
        return self.tags.words(self.begin, self.end)

    @property
    def verb(self) -> str:
        return self.tags.words(self.begin, self.begin + 1)

    @property
    def following(self) -> str:
        return self.tags.tag(self.end)


def _anything(_: _Span) -> bool:
    return True


def _no_place(span: _Span) -> bool:
    """ "Moving in front of us" and "driving ahead" say where, not what is done."""
    return span.verb not in ("moving", "sliding")


def _in_front(span: _Span) -> bool:
    """ "Merges in front", "pulls in ahead", but not "pulls ahead"."""
    return _no_place(span) and ("front" in span.words or " in " in span.words)


def _inwards(span: _Span) -> bool:
    """ "Squeezes in", but not "darts in the left lane"; who pulls in may well park."""
    if span.following in (
        "DET",
        "OUR",
        "ITS",
        "SIDE",
        "NUM",
        "NP",
        "LANE",
        "INLANE",
        "GAP",
        "JUNCTION",
        "ROAD",
        "TARGET",
    ) or _beside_others(span):
        return False
    return span.words.split()[-1] == "in" and not span.verb.startswith(("pull", "mov", "chang"))


def _of_target(span: _Span) -> bool:
    """What is overtaken is the target, or not said."""
    named = any(span.tags.tag(i) == "TARGET" for i in range(span.begin, span.end))
    return named or span.following not in ("NP", "ROAD", "JUNCTION", "DET", "NOBODY", "NUM")


def _beside_others(span: _Span) -> bool:
    """ "In front of a truck" follows: not the target's way."""
    return span.tags.at("AHEAD (NP|NOBODY|IT)", span.end) is not None


def _is_cut_off(span: _Span) -> bool:
    """ "Cuts in", but not "cuts in the left lane"."""
    if span.following in ("NP", "NOBODY", "IT") or _beside_others(span):
        return False
    return span.words.split()[-1] != "in" or span.following not in ("DET", "OUR", "NUM", "SIDE", "JUNCTION", "ROAD")


def _hard(span: _Span) -> bool:
    return all(span.tags.tag(i) != "GENTLY" for i in range(span.begin - 2, span.end + 2))


def _named_standing(span: _Span) -> bool:
    return span.following not in ("KIND", "TRAFFIC")


@dataclass(frozen=True)
class _Rule:
    rule: str
    value: Any
    check: Callable[[_Span], bool] = _anything


_BRAKE = "(BRAKE|SLAM) (DET|OUR|ITS)? BRAKE"
_RULES = (
    _Rule(f"CUT ADV* TARGET (OFF|UP|IN) ({_GOAL})?", Manoeuvre.CUT_IN),
    _Rule(f"CUT ADV* (OFF|UP|IN)? {_X} ({_GOAL}|OFF TARGET|UP TARGET|IN TARGET)", Manoeuvre.CUT_IN),
    _Rule("CUT ADV* (OFF|IN) AHEAD(?!NP|NOBODY|IT)", Manoeuvre.CUT_IN),
    _Rule("CUT ADV* (OFF|IN)", Manoeuvre.CUT_IN, _is_cut_off),
    _Rule(f"{_DOES} (SLIP|MOVE) {_X} {_INWARDS} {_X} (AHEAD TARGET|(IN|ACROSS) {_LANE})", Manoeuvre.CUT_IN, _no_place),
    _Rule(f"{_LEADS} {_X} (IN|OVER|OUT|ACROSS)? {_X} {_TO_SIDE} (INTO|TO) {_LANE} (AHEAD TARGET?)?", Manoeuvre.CUT_IN),
    _Rule(f"(COME|GO|DRIVE|CUT) {_X} (IN|OVER|OUT) {_X} AHEAD TARGET", Manoeuvre.CUT_IN),
    _Rule(f"(SLIP|MOVE|CUT|COME|GO|DRIVE) {_X} (IN|INTO|TO) GAP (AHEAD TARGET?)(?!NP)", Manoeuvre.CUT_IN),
    _Rule("DET? CHANGE AHEAD TARGET", Manoeuvre.CUT_IN),
    _Rule(f"(SLIP|MOVE) {_X} IN? {_X} AHEAD(?!NP|DET|NUM)", Manoeuvre.CUT_IN, _in_front),
    _Rule(f"(SLIP|MOVE) {_X} IN", Manoeuvre.CUT_IN, _inwards),
    _Rule(f"{_DOES} DET? (HARD|HEAVY)* (HARD|HEAVY) (BRAKE|STOP) MANOEUVRE?", Manoeuvre.HARD_BRAKING, _hard),
    _Rule(f"{_DOES} SLAM (ADV|HARD)* (IN|UP|DOWN)? (DET|OUR|ITS)? BRAKE IN? HARD*", Manoeuvre.HARD_BRAKING, _hard),
    _Rule("BRAKE (ADV|DOWN|BE)* HARD+ (TO (DET HARD? (STOP|STANDING)|STANDING))?", Manoeuvre.HARD_BRAKING, _hard),
    _Rule("(HARD|ADV)* SCREECH MANOEUVRE?", Manoeuvre.HARD_BRAKING, _hard),
    _Rule("(STOP|STANDING) (ADV|BE)* HARD", Manoeuvre.HARD_BRAKING, _hard),
    _Rule("(COME|BRAKE|GO) TO DET HARD (STOP|STANDING)", Manoeuvre.HARD_BRAKING, _hard),
    _Rule(f"OVERTAKE (ADV|HARD)* TARGET? (ADV|HARD)* {_ON_SIDE}", Manoeuvre.OVERTAKE, _of_target),
    _Rule(f"PASS (ADV|HARD)* TARGET (ADV|HARD)* {_ON_SIDE}", Manoeuvre.OVERTAKE, _of_target),
    _Rule("PASS (ADV|HARD)* (IN|FROM) (DET|OUR|ITS)? SIDE HAND? LANE?", Manoeuvre.OVERTAKE, _of_target),
    _Rule(f"(DRIVE|GO|MOVE|COME|SLIP|CUT) (ADV|HARD)* PAST TARGET? (ADV|HARD)* {_ON_SIDE}", Manoeuvre.OVERTAKE, _of_target),
    _Rule("BE (ADV|HARD)* PAST TARGET", Manoeuvre.OVERTAKE),
    _Rule(f"TURN (ADV|OFF|HARD)* {_CROSSING}", ACROSS),
    _Rule("(BE|REL|ADV)* STANDING", Manoeuvre.STOPPED, _named_standing),
)  # fmt: skip
_TURNS = (
    f"(TURN|GO) (ADV|OFF|UP|OUT|HARD)* (TO {_OUR}?|INTO DET?)? SIDE HAND?(?!LANE|SIDEROAD|CHANGE) {_JUNCTION} {_CROSSING}?",
    f"TURN (ADV|HARD)* {_CROSSING} (TO (DET|OUR|ITS)?)? SIDE",
    f"{_DOES} DET? (HARD|ADV)* SIDE HAND? TURN(?!LANE) {_JUNCTION} {_CROSSING}?",
    f"(TAKE|MAKE) DET SIDE(?!LANE|HAND|CHANGE|KIND) {_JUNCTION} {_CROSSING}?",
    "(MOVE|SLIP) (ADV|OFF|OUT|HARD)* (TO (DET|OUR|ITS)?)? SIDE HAND? (IN|AHEAD) DET? ADV? JUNCTION",
    "TURN (ADV|OFF)* INTO DET SIDEROAD (IN|TO) (DET|OUR|ITS) SIDE",
    "TURN (ADV|OFF)* INTO (DET|OUR) SIDE HAND? SIDEROAD",
)
_CHANGES = (
    f"(SLIP|MOVE) {_X} FROM DET SIDE HAND? LANE? {_X} (OVER|ACROSS)? (INTO|TO) {_SIDE}",
    f"LEAVE ({_LANE}|(DET|OUR|ITS) LANE) (TO|IN) {_SIDE}",
    f"{_DOES} DET? (ADV|HARD|GENTLY)* CHANGE (INTO|TO|IN) {_SIDE}",
    f"{_DOES} DET? (ADV|HARD|GENTLY)* SIDE HAND? CHANGE",
    f"(SLIP|MOVE) {_X} (OVER|ACROSS|OUT)? {_X} (INTO|TO|TOWARDS)? {_SIDE}",
    f"(GO|COME|DRIVE|TURN|CUT|TAKE) {_X} (OVER|ACROSS|OUT)? {_X} (INTO|TO) (DET|OUR|ITS)? SIDE HAND? LANE",
)


def _one_lane(tags: Tags, begin: int, end: int) -> bool:
    """By one lane, to a side that is not where somebody stands: "to the left of us"."""
    number = tags.value(begin, end, "NUM")
    return number in (None, 1.0) and not (tags.tag(end) == "OF" and tags.tag(end + 1) == "TARGET")


def verbs(tags: Tags) -> list[Said]:
    """Everything that is done, in the passive too: "we are overtaken by a bus"."""
    found: list[Said] = []
    for begin, end in tags.find(f"{_DOES} (OVERTAKE|PASS|CUT (OFF|UP)) BY (?=NP|NOBODY)"):
        value = Manoeuvre.CUT_IN if tags.words(begin, end).find("cut") >= 0 else Manoeuvre.OVERTAKE
        side = tags.at("NP USED* (IN|FROM) (DET|OUR|ITS)? SIDE HAND?(?!LANE)", end)
        if side is not None and value is Manoeuvre.OVERTAKE:
            start = next(i for i in range(end, side) if tags.tag(i) in ("IN", "FROM"))
            found.append(_said(tags, value, start, side))
        found.append(_said(tags, value, begin, end, forward=True))
    found += _changes(tags, _CHANGES[:1]) + [said for rule in _RULES[:11] for said in _by(tags, rule)]
    found += _turns(tags) + _changes(tags, _CHANGES[1:])
    return found + [said for rule in _RULES[11:] for said in _by(tags, rule)]


def _said(tags: Tags, value: Any, begin: int, end: int, *, forward: bool = False) -> Said:
    tags.mark(begin, end, "DONE")
    return Said(What.MANOEUVRE, value, begin, end, forward)


def _negated(tags: Tags, begin: int) -> bool:
    """Whether the verb is denied: "does not brake hard", "almost cuts in"."""
    if tags.words(begin - 1, begin) in ("almost", "nearly"):
        return True
    return any(tags.tag(begin - k) == "NOT" for k in (1, 2) if tags.tag(begin - 1) in ("NOT", "ADV", "BE"))


def _by(tags: Tags, rule: _Rule) -> list[Said]:
    found = []
    for begin, end in tags.find(rule.rule):
        while tags.tag(begin) in ("BE", "MAKE", "ADV") and rule.value is not Manoeuvre.STOPPED and tags.tag(begin - 1) == "EGO":
            begin += 1
        if rule.check(_Span(tags, begin, end)) and not _negated(tags, begin):
            nominal = tags.tag(end) in ("BY", "OF", "FROM") and tags.at("(BY|OF|FROM) NP", end) is not None
            overtakes_from_right = rule.value is Manoeuvre.OVERTAKE and tags.value(begin, end, "SIDE") == "right"
            found.append(_said(tags, rule.value, begin, end, forward=nominal))
            if overtakes_from_right:
                found.append(Said(What.ALONG, Relation.RIGHT_BEHIND, begin, end))
    return found


def _turns(tags: Tags) -> list[Said]:
    found = []
    for rule in _TURNS:
        for begin, end in tags.find(rule):
            if _negated(tags, begin):
                continue
            left = tags.value(begin, end, "SIDE") == "left"
            crossing = any(tags.tag(i) in ("TARGET", "OUR") and i > begin + 1 for i in range(begin, end))
            value = Manoeuvre.TURN_LEFT_ACROSS if left and crossing else Manoeuvre.TURN_LEFT if left else Manoeuvre.TURN_RIGHT
            found.append(_said(tags, value, begin, end))
    return found


def _changes(tags: Tags, rules: tuple[str, ...]) -> list[Said]:
    found = []
    for rule in rules:
        for begin, end in tags.find(rule):
            moving_in = tags.words(begin, begin + 1) == "moving" and tags.tag(begin + 1) == "IN"
            if not _one_lane(tags, begin, end) or _negated(tags, begin) or moving_in:
                continue
            sides = [token.value for token in tags.tokens[begin:end] if token.tag == "SIDE"]
            value = Manoeuvre.CHANGE_LEFT if sides[-1] == "left" else Manoeuvre.CHANGE_RIGHT
            found.append(_said(tags, value, begin, end))
            if len(sides) == 2 and sides[0] != sides[1]:
                found.append(Said(What.SIDE, sides[0], begin, end))
    return found
