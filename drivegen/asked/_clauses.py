"""Clause by clause, what is said is given to the subject that it is said of."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

from drivegen.asked._said import Role, Said, Subject, What
from drivegen.asked._tokens import Tags
from drivegen.asked.request import Manoeuvre

_Thing = TypeVar("_Thing", Said, Subject)
_BOUNDARIES = ("COMMA", "DOT", "AND", "WITH")
_APART = (What.ALONG, What.SIDE, What.FROM, What.ABREAST, What.QUEUE, What.MANOEUVRE, What.HERE)
_EVENTS = (Manoeuvre.CUT_IN, Manoeuvre.HARD_BRAKING, Manoeuvre.CHANGE_LEFT, Manoeuvre.CHANGE_RIGHT, Manoeuvre.OVERTAKE)


@dataclass(frozen=True)
class _Clause:
    """Tokens [begin, end), and the tag of the boundary before them."""

    begin: int
    end: int
    opening: str

    def of(self, things: Sequence[_Thing]) -> list[_Thing]:
        return sorted((t for t in things if self.begin <= t.begin < self.end), key=lambda t: t.begin)


def apart(subject: Subject) -> bool:
    """Whether a subject is told apart from others by more than its number and kind."""
    return subject.role is Role.TARGET or any(subject.value(what) is not None for what in _APART)


def attached(tags: Tags, subjects: Sequence[Subject], said: Sequence[Said]) -> list[Subject]:
    """All subjects, with those that only their manoeuvre names; what fits nobody is given to nobody."""
    found = list(subjects)
    last: Subject | None = None
    pending: list[Said] = []
    too: list[Subject] = []  # the target of "we and the car ahead turn right"
    for clause in _clauses(tags):
        here, things = clause.of(found), clause.of(said)
        if not here and (event := _event(tags, clause, things, last)) is not None:
            found.append(event)
            here = [event]
        if clause.opening == "DOT" and not here and tags.tag(clause.begin) not in ("IT", "REL"):
            pending = [thing for thing in things if last is None or not _speed_of_all(thing, last, found)]
            last = None
            continue
        if here:
            for thing in pending:
                here[0].accepts(thing)
            pending = []
            for thing in things:
                _give(thing, here, found)
                for target in too if clause.opening == "AND" and _of_several(tags, thing) else ():
                    target.accepts(thing)
            last = here[-1]
            too = [last] if last.role is Role.TARGET and not things else []
        else:
            pending = _carry(tags, clause, things, last, found)
    return sorted(found, key=lambda subject: subject.begin)


def _clauses(tags: Tags) -> list[_Clause]:
    cuts = [i for i in range(len(tags.tokens)) if tags.tag(i) in _BOUNDARIES and not _joins(tags, i)]
    ends = [*cuts, len(tags.tokens)]
    opened = [(0, ""), *((cut + 1, tags.tag(cut)) for cut in cuts)]
    return [_Clause(begin, end, opening) for (begin, opening), end in zip(opened, ends, strict=True)]


def _joins(tags: Tags, at: int) -> bool:
    """The "and" of "between us and the car ahead"."""
    return tags.tag(at) == "AND" and "between" in tags.words(max(at - 3, 0), at).split()


def _of_several(tags: Tags, thing: Said) -> bool:
    """Whether a manoeuvre is that of several: "turn right", not "turns right" or "that turn right"."""
    verb = tags.tokens[thing.begin].words.split()[0]
    return thing.what is What.MANOEUVRE and not verb.endswith("s") and tags.tag(thing.begin - 1) != "REL"


def _event(tags: Tags, clause: _Clause, things: Sequence[Said], last: Subject | None) -> Subject | None:
    """Somebody, for a clause that begins with a manoeuvre named by a noun: "a sudden cut in", "hard braking by the leader"."""
    first = things[0] if things else None
    if first is None or first.forward or first.what is not What.MANOEUVRE or first.value not in _EVENTS:
        return None
    if any(tags.tag(i) not in ("DET", "ADV", "HARD", "GENTLY", "WORD") for i in range(clause.begin, first.begin)):
        return None
    span = tags.tokens[clause.begin : first.end]
    head = next(token for token in span if token.tag not in ("DET", "ADV"))
    named = any(token.tag == "DET" for token in span[:1])
    brakes = first.value is Manoeuvre.HARD_BRAKING and head.tag == "HARD" and not head.words.endswith("ly")
    cuts = first.value is Manoeuvre.CUT_IN and last is None
    if not (named or brakes or cuts):
        return None
    return Subject(Role.GROUP, clause.begin, clause.begin)


def _give(thing: Said, here: Sequence[Subject], found: Sequence[Subject]) -> None:
    """To the last subject before it in the clause, or to the first after it."""
    before = [subject for subject in here if subject.begin <= thing.begin]
    after = [subject for subject in here if subject.begin > thing.begin]
    if thing.forward or not before:
        following = after or [subject for subject in found if subject.begin > thing.begin]
        if following:
            min(following, key=lambda subject: subject.begin).accepts(thing)
        return
    doers = [subject for subject in before if not subject.object]
    if before[-1].object and doers and (thing.what in (What.MANOEUVRE, What.WITHIN) or str(thing.value).startswith("from ")):
        before = doers  # "the truck that overtakes the bus brakes hard"
    if thing.what is What.WITHIN:
        before = [subject for subject in before if subject.value(What.MANOEUVRE) is not None] or before
    if before[-1].known and before[-1].role is Role.ALL and thing.what is not What.SPEED:  # "all of them"
        before = [subject for subject in found if subject.role is Role.GROUP and subject.begin < thing.begin] or before
    if not before[-1].accepts(thing) and after and before[-1].role is Role.TARGET:
        after[0].accepts(thing)


def _carry(tags: Tags, clause: _Clause, things: Sequence[Said], last: Subject | None, found: list[Subject]) -> list[Said]:
    """A clause without a subject speaks of the last one; what does not fit that one waits for the next."""
    waits: list[Said] = []
    after_and = clause.opening == "COMMA" and tags.tag(clause.begin - 2) == "AND"
    moves = any(tags.tokens[i].tag in ("DRIVE", "GO", "MOVE", "COME") for i in range(clause.begin, clause.end))
    for thing in sorted(things, key=lambda thing: thing.what is not What.MANOEUVRE):
        if (
            thing.what is What.SPEED
            and last is not None
            and clause.opening == "COMMA"
            and not (apart(last) and (moves or len(found) == 1))
        ):
            _speed_of_all(thing, last, found)
        elif (
            thing.forward
            or last is None
            or after_and
            or (thing.what is What.WITHIN and last.value(What.MANOEUVRE) is None)
            or not last.accepts(thing)
        ):
            waits.append(thing)
    return waits


def _speed_of_all(thing: Said, last: Subject, found: list[Subject]) -> bool:
    """A speed in a clause of its own, after vehicles, is everybody's."""
    if thing.what is not What.SPEED or last.role is Role.NOBODY:
        return False
    found.append(Subject(Role.ALL, thing.begin, thing.begin, heard=[thing]))
    return True
