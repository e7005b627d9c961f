"""A writer's way with every description of the suites: drawn as asked, declined, drawn as its offered sentence says, or wrong."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

from drivegen.core.cpu import cpu_seconds
from drivegen.core.errors import UnusableInput
from drivegen.maps.checks import failures
from drivegen.maps.examine import examine
from drivegen.maps.suite.cases import Case, Judge
from drivegen.maps.writers.base import MapWriter
from drivegen.sumo.loading import load_all

TRY = "\ntry: "
"""What stands before the sentence that a writer offers where it declines."""


@dataclass(frozen=True)
class Trial:
    """What became of one description.

    Attributes:
        drawn: whether a network was made. loads: whether SUMO loads it. wrong: what it lacks of what was asked.
        refused: why the writer declined, "" where it did not. offer: the sentence that it offered instead.
        offer_wrong: what the network of the offered sentence lacks; None where none was offered or nothing is to be drawn.
        repairs: rounds of repair that it took. seconds: processor time, netconvert's included; it differs from run to run.
    """

    case: Case
    drawn: bool = False
    loads: bool = False
    wrong: tuple[str, ...] = ()
    refused: str = ""
    offer: str = ""
    offer_wrong: tuple[str, ...] | None = None
    repairs: int = 0
    seconds: float = 0.0
    network: bytes = b""

    @property
    def right(self) -> bool:
        """At once: what was asked for, in a network that SUMO loads; or declined where nothing may be drawn."""
        if self.case.expect is None:
            return bool(self.refused)
        return self.drawn and self.loads and not self.wrong

    @property
    def right_after_offer(self) -> bool:
        """At once, or after the offered sentence was pasted."""
        return self.right or self.offer_wrong == ()

    @property
    def is_wrong(self) -> bool:
        """Something was drawn at once that is not what was asked for."""
        return not self.right and not self.refused


def tried(cases: Iterable[Case], writer: MapWriter, seed: int, judge: Judge | None = None) -> list[Trial]:
    """One trial per case, in order. Raises MissingTool where netconvert or a model's records are missing."""
    trials = [_tried(case, writer, seed, judge) for case in cases]
    networks = [(i, trial.network) for i, trial in enumerate(trials) if trial.drawn]
    for (i, _), loads in zip(networks, load_all([network for _, network in networks]), strict=True):
        trials[i] = replace(trials[i], loads=loads, network=b"")
    return trials


def _tried(case: Case, writer: MapWriter, seed: int, judge: Judge | None) -> Trial:
    began = cpu_seconds()
    trial = _written(case, case.text, writer, seed, judge)
    offer = trial.refused.rpartition(TRY)[2].strip() if TRY in trial.refused else ""
    if offer and case.expect is not None:
        second = _written(case, offer, writer, seed, judge)
        trial = replace(trial, offer=offer, offer_wrong=second.wrong if second.drawn else (second.refused,))
    return replace(trial, seconds=cpu_seconds() - began)


def _written(case: Case, text: str, writer: MapWriter, seed: int, judge: Judge | None) -> Trial:
    try:
        understanding = writer.write(text, seed)
    except UnusableInput as refusal:
        return Trial(case, refused=str(refusal))
    try:
        findings = examine(understanding.spec)
    except UnusableInput as error:
        return Trial(case, wrong=(str(error),), repairs=understanding.repairs)
    if case.expect is None:
        wrong: tuple[str, ...] = ("a road was drawn where nothing may be",)
    else:
        wrong = (*failures(findings.checks), *case.wrong(findings.network, findings.structure))
        wrong += tuple(judge(text, case.traffic)) if judge is not None and case.traffic else ()
    return Trial(case, drawn=True, wrong=wrong, repairs=understanding.repairs, network=findings.network)
