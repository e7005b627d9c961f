"""What is said of a corner case: its kind, whether it could have been avoided, whether it holds, and all that in a sentence."""

from collections.abc import Sequence
from dataclasses import dataclass

from drivegen.core.scenario import DT
from drivegen.corner_cases.avoidance import Avoidable, Avoidance, judge
from drivegen.corner_cases.case import Case
from drivegen.corner_cases.kinds import Kind, kind_of
from drivegen.corner_cases.survival import Reacting, attentions, survival
from drivegen.drivers.base import Driver
from drivegen.world.outcome import CollisionKind
from drivegen.world.reactive import Reaction

_HOW = {
    Kind.CUT_IN: "comes over into its lane",
    Kind.OWN_SHIFT: "is in the lane into which the target goes over",
    Kind.REAR: "drives ahead of it",
    Kind.STANDING: "stands in its way",
    Kind.BESIDE: "drives beside it",
    Kind.MERGE: "turns into its way",
    Kind.ONCOMING_TURN: "comes towards it and turns across its way",
    Kind.OWN_TURN: "has the way across which the target turns",
    Kind.ONCOMING: "comes towards it in its way",
    Kind.CROSSING_LEFT: "crosses its way from the left",
    Kind.CROSSING_RIGHT: "crosses its way from the right",
    Kind.PERSON: "on foot or two wheels is in its way",
}
_HIT = {
    CollisionKind.FRONT: "{driver} runs into it with its front",
    CollisionKind.SIDE: "its side and that of {driver} meet",
    CollisionKind.HIT_IN_SIDE: "it runs into the side of {driver}",
}


@dataclass(frozen=True)
class Judgement:
    """A case and what is said of it.

    Attributes:
        replayed, reacting: how it could have been avoided while everybody else is replayed, and while all but the attacker react.
        holds: by the neighbours' attention and who reacts, whether the driver collides there, too.
    """

    case: Case
    kind: Kind
    replayed: Avoidance
    reacting: Avoidance
    holds: dict[tuple[str, Reacting], bool]

    @property
    def sentence(self) -> str:
        """What happens, when, and until when it could have been avoided."""
        case, other = self.case, self.case.other[0]
        hit = _HIT.get(case.kind, "it and {driver} collide").format(driver=case.driver)
        speeds = f"{case.driven.speed[case.step]:.0f} against {other.speed[case.step]:.0f} m/s"
        return f"Another {_HOW[self.kind]}; after {case.step * DT:.1f} s {hit} ({speeds}). {_until(self.replayed)}"


def _until(avoidance: Avoidance) -> str:
    if not avoidance.cue:
        return "Nothing shows it coming."
    warning = f"It can be seen coming {avoidance.cue:.1f} s before"
    if avoidance.verdict == Avoidable.NO:
        return f"{warning}, when it can no longer be avoided."
    return f"{warning} and avoided until {avoidance.cue - avoidance.budget:.1f} s before: {avoidance.budget:.1f} s to react."


def judgements(cases: Sequence[Case], driver: Driver, law: Reaction) -> list[Judgement]:
    """What is said of each of `cases` of `driver`; neighbours that react do so by `law`, at other delays and braking, too."""
    replayed, reacting = judge(cases), judge(cases, law)
    held = survival(cases, driver, attentions(law))
    return [
        Judgement(case, kind_of(case), replayed[c], reacting[c], {key: bool(holding[c]) for key, holding in held.items()})
        for c, case in enumerate(cases)
    ]
