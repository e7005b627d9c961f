"""A writer's way with every description of the suite, step by step: words, XML, netconvert, SUMO, structure as asked."""

import resource
import time
from collections.abc import Iterable
from dataclasses import dataclass, replace

from drivegen.errors import UnusableInput
from drivegen.maps.checks import failures
from drivegen.maps.examine import drawn, examine
from drivegen.maps.suite.cases import Case
from drivegen.maps.writers.base import MapWriter, Understanding
from drivegen.safe_xml import parse
from drivegen.sumo.loading import load_all
from drivegen.sumo.netconvert import NetconvertRefused


@dataclass(frozen=True)
class Trial:
    """How far one description came.

    Attributes:
        understood: the writer asked for answered itself; where another stood in for it, `stood_in` names that one.
        valid_xml: the plain XML parses. accepted: netconvert made a network. loads: so does SUMO.
        as_asked: structure and sound checks hold. wrong: what does not.
        refused: why the writer refused, "" where it did not. repairs: rounds of repair that it took.
        seconds: processor time, netconvert's included; it differs from run to run.
    """

    case: Case
    understood: bool = False
    stood_in: str = ""
    valid_xml: bool = False
    accepted: bool = False
    loads: bool = False
    as_asked: bool = False
    wrong: tuple[str, ...] = ()
    refused: str = ""
    repairs: int = 0
    seconds: float = 0.0
    network: bytes = b""

    @property
    def right(self) -> bool:
        """The road that was asked for, in a network that SUMO loads; or a refusal where there can be no road."""
        if self.case.expect is None:
            return bool(self.refused)
        return self.as_asked and self.loads


def tried(cases: Iterable[Case], writer: MapWriter, seed: int) -> list[Trial]:
    """One trial per case, in order. Raises MissingTool where netconvert or a model's records are missing."""
    trials = [_tried(case, writer, seed) for case in cases]
    networks = [(i, trial.network) for i, trial in enumerate(trials) if trial.accepted]
    for (i, _), loads in zip(networks, load_all([network for _, network in networks]), strict=True):
        trials[i] = replace(trials[i], loads=loads, network=b"")
    return trials


def _tried(case: Case, writer: MapWriter, seed: int) -> Trial:
    began = _spent()
    try:
        understanding = writer.write(case.text, seed)
    except UnusableInput as refusal:
        return Trial(case, refused=str(refusal), wrong=_unlike(case, str(refusal)), seconds=_spent() - began)
    trial = _built(Trial(case, repairs=understanding.repairs), understanding)
    if understanding.writer != writer.description:
        trial = replace(trial, stood_in=understanding.writer, as_asked=False)
    return replace(trial, understood=not trial.stood_in, seconds=_spent() - began)


def _built(trial: Trial, understanding: Understanding) -> Trial:
    try:
        for name, text in drawn(understanding.spec).files().items():
            parse(text, name)
        trial = replace(trial, valid_xml=True)
        found = examine(understanding.spec)
    except NetconvertRefused as error:
        return replace(trial, wrong=error.messages or (str(error),))
    except UnusableInput as error:
        return replace(trial, wrong=(str(error),))
    if trial.case.expect is None:
        return replace(trial, accepted=True, network=found.network, wrong=("a road was drawn where there can be none",))
    wrong = (*failures(found.checks), *trial.case.wrong(found.network, found.structure))
    wrong += tuple(f"{word!r} is not listed as ignored" for word in trial.case.ignored if word not in understanding.ignored)
    return replace(trial, accepted=True, network=found.network, as_asked=not wrong, wrong=wrong)


def _unlike(case: Case, refusal: str) -> tuple[str, ...]:
    """A refusal must say the right thing, where the case knows it."""
    if case.expect is not None:
        return ("refused",)
    return () if case.refused in refusal else (f"the refusal does not speak of {case.refused!r}",)


def _spent() -> float:
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime
