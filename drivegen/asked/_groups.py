"""Groups of vehicles as they are meant: members of groups that were named before, and places put together of their parts."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product, takewhile
from typing import Any

from drivegen.asked._clauses import apart
from drivegen.asked._said import ACROSS, BOTH, FROM_SIDE, Role, Said, Subject, What
from drivegen.asked.request import Kind, Manoeuvre
from drivegen.assets.where import Relation

_FROM_BESIDE = (Manoeuvre.CUT_IN, Manoeuvre.OVERTAKE, Manoeuvre.CHANGE_LEFT, Manoeuvre.CHANGE_RIGHT)
_BESIDE = {"left": Relation.LEFT, "right": Relation.RIGHT}


def settled(subjects: Sequence[Subject]) -> list[Subject]:
    """The groups, members told apart from those that they belong to."""
    kept: list[Subject] = []
    parent: Subject | None = None
    _lists(subjects)
    for subject in subjects:
        if subject.role is not Role.GROUP:
            continue
        named = next((other for other in reversed(kept) if subject.known and _same(subject, other)), None)
        if named is not None and all(named.accepts(said) for said in subject.heard):
            named.own = (*named.own, *subject.own)
        elif not subject.member or (parent is None and not subject.bare):
            subject.member = 0
            kept.append(subject)
            parent = subject
            parent.named = parent.count
        elif parent is not None:
            kept += _members(subject, parent)
    kept = _listed(kept)
    return [part for subject in kept if subject.count > 0 for part in _sides(subject)]


def _listed(groups: list[Subject]) -> list[Subject]:
    """Without vehicles that those after them are: "six vehicles: five cars and a bus"."""
    for number, group in enumerate(groups):
        after = groups[number + 1 :]
        as_many = group.count > 1 and sum(other.count for other in after) == group.count
        if group.kind is Kind.VEHICLE and as_many and (group.known or not group.heard):
            for other, said in product(after, group.heard):
                other.accepts(said)
            after[0].own = (*group.own, *after[0].own)
            return groups[:number] + after
    return groups


def _same(subject: Subject, before: Subject) -> bool:
    """Whether "the truck" is one that was named before: nothing says where it is."""
    places = (What.ALONG, What.SIDE, What.FROM, What.ABREAST, What.HERE)
    return subject.kind is before.kind and all(subject.value(place) is None for place in places)


def _sides(subject: Subject) -> list[Subject]:
    """Two groups of who is on both sides: as many on each if one was named, else half of them."""
    if subject.value(What.SIDE) != BOTH:
        return [subject]
    if subject.count > 1 and subject.count % 2:
        subject.forget(What.SIDE)
        return [subject]
    each = max(subject.count // 2, 1)
    parts = []
    for side in ("left", "right"):
        heard = [Said(s.what, side, s.begin, s.end) if s.what is What.SIDE else s for s in subject.heard]
        parts.append(replace(subject, count=each, heard=heard))
    return parts


def _lists(subjects: Sequence[Subject]) -> None:
    """Mark those that together are all of the group before them: "two cars ahead, one on the left, the other on the right"."""
    groups = [subject for subject in subjects if subject.role is Role.GROUP]
    for number, parent in enumerate(groups):
        bare = list(takewhile(lambda subject: subject.bare, groups[number + 1 :]))
        named = sum(abs(subject.member) for subject in bare)
        if parent.member == 0 and len(bare) > 1 and (named == parent.count or parent.vague):
            parent.count = named
            for subject in bare:
                subject.listed = True


def _members(subject: Subject, parent: Subject) -> list[Subject]:
    """A member as a group of its own; none where its manoeuvre is the one that its group does, or where none are left."""
    subject.kind = parent.kind if subject.kind is Kind.VEHICLE else subject.kind
    does = bool(subject.heard) and all(said.what in (What.MANOEUVRE, What.WITHIN) for said in subject.heard)
    if (
        subject.bare
        and (parent.named <= 1 or (apart(parent) and not does and not subject.listed and parent.value(What.ABREAST) is None))
        and subject.member > 0
    ):
        subject.count = subject.member  # "two cars ahead, one behind": others of the same kind
        return [subject]
    if parent.vague and not subject.bare and not subject.heard:  # "vehicles, nine of them"
        parent.count, parent.vague, parent.own = subject.member, False, (*parent.own, *subject.own)
        return []
    wanted = parent.count if subject.member < 0 else subject.member
    if wanted > parent.count or (subject.member < 0 and not subject.heard):
        return []
    side = subject.value(What.SIDE)
    same_side = side is None or str(side).removeprefix("from ") == parent.value(What.SIDE)
    only_does = same_side and all(said.what in (What.MANOEUVRE, What.WITHIN, What.SIDE) for said in subject.heard)
    if only_does and subject.heard and wanted == 1 and parent.count > 1 and parent.value(What.MANOEUVRE) is None:
        parent.heard += [said for said in subject.heard if said.what is not What.SIDE]
        parent.own = (*parent.own, *subject.own)
        return []
    parent.count -= wanted
    subject.count = wanted
    if parent.count == 0:
        subject.own = (*parent.own, *subject.own)
    for said in parent.heard:
        if said.what is not What.ABREAST or side is None:
            subject.accepts(said if parent.count == 0 else Said(said.what, said.value, parent.begin, parent.begin))
    return [subject]


def fields(subject: Subject) -> dict[str, Any]:
    """What a group says, as the request has it; the subject forgets what cannot be said."""
    _manoeuvre(subject)
    place = _place(subject)
    manoeuvre = subject.value(What.MANOEUVRE)
    if manoeuvre is Manoeuvre.TURN_LEFT and place is Relation.ONCOMING:
        manoeuvre = Manoeuvre.TURN_LEFT_ACROSS
    elif manoeuvre is Manoeuvre.TURN_LEFT_ACROSS and place not in (None, Relation.ONCOMING):
        manoeuvre = Manoeuvre.TURN_LEFT
    if manoeuvre is None:
        subject.forget(What.WITHIN)
    if manoeuvre is None and place is None:
        subject.forget(What.DISTANCE)
    return {
        "count": subject.count,
        "kind": subject.kind,
        "place": place,
        "distance": subject.value(What.DISTANCE),
        "queue": bool(subject.value(What.QUEUE)),
        "manoeuvre": manoeuvre,
        "within": subject.value(What.WITHIN),
    }


def _manoeuvre(subject: Subject) -> None:
    """Forget what the one who comes the other way cannot do, and a turn across the way of those who go the same way."""
    does, oncoming = subject.value(What.MANOEUVRE), subject.value(What.ALONG) is Relation.ONCOMING
    if does is Manoeuvre.CUT_IN and oncoming:
        subject.forget(What.MANOEUVRE)
    if does == ACROSS:
        kept = [Said(s.what, Manoeuvre.TURN_LEFT_ACROSS, s.begin, s.end) for s in subject.heard if s.what is What.MANOEUVRE]
        subject.forget(What.MANOEUVRE)
        subject.heard += kept if oncoming else []


def _place(subject: Subject) -> Relation | None:
    along, side, does = subject.value(What.ALONG), subject.value(What.SIDE), subject.value(What.MANOEUVRE)
    if along in (Relation.ONCOMING, Relation.RIGHT_BEHIND):
        subject.forget(What.SIDE)
        subject.forget(What.ABREAST)
        return Relation(along)
    if side is not None and side.startswith("from "):
        side = side.removeprefix("from ")
        if does not in _FROM_BESIDE and along is None:
            return FROM_SIDE[side]
    here = subject.value(What.HERE)
    if along is None and side is None and here is not None and does in (Manoeuvre.STOPPED, Manoeuvre.HARD_BRAKING):
        return Relation.AHEAD
    if along is None:
        if here is not None:
            subject.forget(What.HERE)
        beside = side or subject.value(What.ABREAST)
        aside: Relation | None = subject.value(What.FROM)
        return aside or (_BESIDE[beside] if beside else None)
    if side is None and does is Manoeuvre.CUT_IN and along is Relation.AHEAD:
        return None  # in a lane beside, whichever
    if side is None:
        return Relation(along)
    if does is Manoeuvre.OVERTAKE and along is Relation.BEHIND and side == "left":
        return Relation.LEFT_BEHIND
    return Relation(f"{side}_{along}")
