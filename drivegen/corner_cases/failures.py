"""Which of a driver's runs failed: ended in a counted collision that could have been avoided, and by which kind."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import Scenario, Trajectories
from drivegen.corner_cases.avoidance import Avoidable, judge
from drivegen.corner_cases.case import Case
from drivegen.corner_cases.kinds import kind_of
from drivegen.world.outcome import CollisionKind, DrivingOutcome

NONE = ""

Failures = NDArray[np.object_]
"""(R,) the kind of each run's failure by its name, NONE where it did not fail."""


def failures(
    outcome: DrivingOutcome, case: Callable[[int], Case], known: tuple[DrivingOutcome, Failures] | None = None
) -> Failures:
    """Of R runs, whose cases are made by `case` where they count.

    `known` are R runs of another driver in the same scenes and their failures: where both did the same, to the bit, nothing is
    judged again.
    """
    found = np.full(len(outcome.kind), NONE, object)
    rows = np.flatnonzero(outcome.counted)
    if known is not None:
        same = alike(outcome, known[0])
        found[same] = known[1][same]
        rows = rows[~same[rows]]
    cases = [case(run) for run in rows.tolist()]
    for run, one, said in zip(rows.tolist(), cases, judge(cases), strict=True):
        if said.verdict != Avoidable.NO:
            found[run] = str(kind_of(one))
    return found


def alike(one: DrivingOutcome, other: DrivingOutcome) -> NDArray[np.bool_]:
    """(R,) whether runs in the same scenes went and ended alike, to the bit."""
    ended = (one.kind == other.kind) & (one.step == other.step) & (one.partner == other.partner)
    pairs = (np.equal(getattr(one.motion, name), getattr(other.motion, name)) for name in ("position", "heading", "velocity"))
    there = one.motion.valid & other.motion.valid
    went = [(same.reshape(*there.shape, -1).all(-1) | ~there).all(-1) for same in pairs]
    return np.asarray(ended & (one.motion.valid == other.motion.valid).all(-1) & np.logical_and.reduce(went))


def replayed_case(scenario: Scenario, traffic: Trajectories, outcome: DrivingOutcome, run: int, driver: str) -> Case:
    """One of R runs through traffic (N, T) as it is: nobody attacks, and whether it is legal, or likely, is not asked."""
    return Case(
        scenario=scenario,
        traffic=traffic,
        attacker=0,
        driven=outcome.motion[run].until(traffic.steps),  # scenes driven with it may be longer
        step=int(outcome.step[run]),
        partner=int(outcome.partner[run]),
        kind=CollisionKind(int(outcome.kind[run])),
        at_fault=bool(outcome.at_fault[run]),
        impact_speed=float(outcome.impact_speed[run]),
        violation=0,
        odds=float("nan"),
        queries=1,
        driver=driver,
        method="",
    )
