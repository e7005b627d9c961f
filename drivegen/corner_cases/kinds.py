"""Kinds of corner cases: named by how the other came to be where the target ran into it, and who of the two turned or shifted.

Relative headings and what each did are those of `encounters`, over the last 3 s before the collision; whether one that came
towards the target turns, its way up to 3 s after it tells, too.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from drivegen.core.geometry import Floats, arc_length, distinct, line_heading, project, wrap_angle
from drivegen.core.roadmap import NO_LANE
from drivegen.core.scenario import TARGET, Trajectories
from drivegen.corner_cases.case import Case
from drivegen.corner_cases.cue import WANDER
from drivegen.corner_cases.encounters import AGAINST, ALONG, LOOK_BACK, TURNED, Behaviour, Direction, encounters, seen_since
from drivegen.roads.graph import LaneGraph
from drivegen.world.outcome import CollisionKind

LANE_WIDTH = 3.5
"""[m] The target is in a lane whose middle is no farther away."""

_TURNS = (Behaviour.TURNING_LEFT, Behaviour.TURNING_RIGHT)
_SHIFTS = (Behaviour.SHIFTING_LEFT, Behaviour.SHIFTING_RIGHT)


class Kind(StrEnum):
    """How a case came about; the value is its name for readers."""

    CUT_IN = "cut-in"
    OWN_SHIFT = "own lane change"
    REAR = "rear"
    STANDING = "standing"
    BESIDE = "side by side"
    MERGE = "merge"
    ONCOMING_TURN = "oncoming turn"
    OWN_TURN = "own turn"
    ONCOMING = "oncoming"
    CROSSING_LEFT = "crossing from the left"
    CROSSING_RIGHT = "crossing from the right"
    PERSON = "person or two-wheeler"


@dataclass(frozen=True)
class Meeting:
    """How target and other met.

    Attributes:
        direction: where the other came from in the end. opposed: whether it came the other way before.
        did, own: what the other and the target did.
    """

    direction: Direction
    opposed: bool
    did: Behaviour
    own: Behaviour


def meeting(case: Case) -> Meeting:
    """How the two of a case met."""
    other, size = case.other
    own, own_size = case.driven.until(case.step + 1), case.scenario.vehicles.size[TARGET]
    other = other.until(case.step + 1)
    met = encounters(own, own_size, other[np.newaxis], size[np.newaxis])
    mirrored = encounters(other, size, own[np.newaxis], own_size[np.newaxis])
    since = _since(case)
    before = float(wrap_angle(np.asarray(other.heading[since] - own.heading[since])))
    return Meeting(
        Direction(int(met.direction[0])),
        abs(before) > AGAINST,
        Behaviour(int(met.behaviour[0])),
        Behaviour(int(mirrored.behaviour[0])),
    )


def _since(case: Case) -> int:
    """The step from which on what the other did before the collision was seen."""
    return int(seen_since(case.other[0].valid, np.asarray(case.step)))


def kind_of(case: Case) -> Kind:
    """The kind of a case."""
    if case.partner >= len(case.scenario.vehicles):
        return Kind.PERSON
    met = meeting(case)
    if met.did == Behaviour.STANDING:
        return Kind.STANDING
    if met.opposed:
        return _against(case)
    if met.did in _TURNS and met.own not in _TURNS and (aside := _beside(case)) is not None:
        return Kind.REAR if aside < LANE_WIDTH / 2 and case.kind == CollisionKind.FRONT else Kind.CUT_IN
    if met.direction == Direction.SAME:
        return _same_way(met, case)
    if met.own in _TURNS:
        return Kind.OWN_TURN
    if met.did in _TURNS:
        return Kind.MERGE
    if met.direction == Direction.OPPOSITE:
        return Kind.ONCOMING
    return Kind.CROSSING_LEFT if met.direction == Direction.FROM_LEFT else Kind.CROSSING_RIGHT


def _against(case: Case) -> Kind:
    """Of two that came towards one another. Who has only begun to turn when it is hit turns: its way afterwards says so."""
    other, own = case.other[0], case.traffic[TARGET]
    since = _since(case)
    after = int(np.flatnonzero(other.valid[: case.step + LOOK_BACK + 1])[-1])
    if _turns_from(other, since, case.step, own):
        return Kind.ONCOMING_TURN
    if _turns_from(case.driven, since, case.step, other):
        return Kind.OWN_TURN
    return Kind.ONCOMING_TURN if _turns_from(other, since, after, own) else Kind.ONCOMING


def _turns_from(mover: Trajectories, since: int, step: int, opposite: Trajectories) -> bool:
    """Whether the mover turns between two steps, and not as one does who follows a bend that the other way follows, too."""
    turned = abs(float(wrap_angle(np.asarray(mover.heading[step] - mover.heading[since]))))
    if turned <= TURNED or (beside := _alongside(opposite, mover.position[step])) is None:
        return turned > TURNED
    return abs(float(wrap_angle(np.asarray(mover.heading[step] - beside[1] + np.pi)))) > TURNED


def _same_way(met: Meeting, case: Case) -> Kind:
    if met.own in _SHIFTS and met.did not in _SHIFTS:
        return Kind.OWN_SHIFT
    if met.did in _TURNS and met.own not in _TURNS:
        return Kind.MERGE
    if met.did in _SHIFTS:
        return Kind.CUT_IN
    if case.kind == CollisionKind.FRONT:
        return Kind.REAR
    other, own = _sideways(case)
    if other + own < WANDER:
        return Kind.BESIDE
    return Kind.CUT_IN if other >= own else Kind.OWN_SHIFT


def _beside(case: Case) -> float | None:
    """[m] how far beside the target's way the other drove along it before, None if it drove elsewhere.

    Who follows a bend turns with it, and who changes lanes slowly turns by as much as one who comes from another road.
    """
    other = case.other[0]
    before = _since(case)
    if (beside := _alongside(case.traffic[TARGET], other.position[before])) is None:
        return None
    offset, heading = beside
    turned = abs(float(wrap_angle(np.asarray(other.heading[before] - heading))))
    return abs(offset) if turned < ALONG and abs(offset) < 1.5 * LANE_WIDTH else None


def _alongside(mover: Trajectories, place: Floats) -> tuple[float, float] | None:
    """How far left of a mover's way (T,) a place (2,) lies [m], and where that way leads there [rad]; None of who stands."""
    way = distinct(mover.position[mover.valid].astype(np.float64))
    if len(way) < 2:
        return None
    along, offset = project(way, place.astype(np.float64))
    return offset, float(line_heading(way)[np.searchsorted(arc_length(way), along, side="right") - 1])


def _sideways(case: Case) -> tuple[float, float]:
    """[m] that the other, and the target, have come nearer to one another across the lane."""
    steps = [_since(case), case.step]
    at, own_heading = case.driven.position[steps[1:]], case.driven.heading[steps[1:]]
    lane, nearest = LaneGraph.of(case.scenario.map).nearest(at, own_heading, radius=LANE_WIDTH, max_angle=ALONG)
    heading = float(nearest[0, 2] if lane[0] != NO_LANE else own_heading[0])
    left = np.array([-np.sin(heading), np.cos(heading)])
    other, own = (motion.position[steps].astype(np.float64) @ left for motion in (case.other[0], case.driven))
    side = np.sign(other[1] - own[1])
    return float(side * (other[0] - other[1])), float(side * (own[1] - own[0]))


@dataclass(frozen=True)
class Group:
    """The cases of one kind.

    Attributes:
        kind: theirs. cases: their numbers, the likeliest of each pair of scenario and partner, likeliest first.
        duplicates: how many more of the same pairs there are.
    """

    kind: Kind
    cases: tuple[int, ...]
    duplicates: int


def groups(cases: Sequence[Case]) -> list[Group]:
    """Cases by kind, the kind of most cases first; of a pair in a scenario the likeliest, whatever the kinds of the others."""
    pairs: dict[tuple[str, int], list[int]] = {}
    for c in sorted(range(len(cases)), key=lambda c: (-np.nan_to_num(cases[c].odds), c)):
        pairs.setdefault((cases[c].scenario_id, cases[c].partner), []).append(c)
    of: dict[Kind, list[list[int]]] = {}
    for members in pairs.values():
        of.setdefault(kind_of(cases[members[0]]), []).append(members)
    kinds = [Group(kind, tuple(m[0] for m in several), sum(map(len, several)) - len(several)) for kind, several in of.items()]
    return sorted(kinds, key=lambda group: (-len(group.cases), group.kind))
