"""Whether a driver that learnt from its corner cases fails less: versions of it, attacked anew and driven through logs.

Recordings are halved: who learnt from cases of one half is tested in the other, so every scene is tested once, by a driver that
saw none of its recording. Versions are tested in the same scenes, so their differences are paired.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegen.adversaries.base import Adversary
from drivegen.adversaries.shared.arena import Arena, Bounds, Ground
from drivegen.adversaries.shared.findings import Findings
from drivegen.adversaries.shared.ground import logged, sampled
from drivegen.checker.limits import Limits
from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.intervals import bootstrap_means, recording
from drivegen.core.samples import Samples
from drivegen.core.scenario import TARGET, Trajectories
from drivegen.core.seeds import rng
from drivegen.corner_cases.kinds import Kind
from drivegen.corner_cases.trials import Trials, Variants
from drivegen.drivers.base import Driver
from drivegen.drivers.shared.conditions import Traffic
from drivegen.drivers.shared.tuning import exemplary
from drivegen.planners.base import Planner
from drivegen.rollout.choices import Choices
from drivegen.world.reactive import Reaction

BEFORE, LONGER, REPAIRED = VERSIONS = ("before", "longer", "repaired")
"""Taught on logs; then tuned on logs for as long; then tuned for as long on logs with cases among them."""

SHARES = ("collision", "counted", "avoidable")
MEASURES = ("distance", "comfort_absolute")


@dataclass(frozen=True)
class Half:
    """Half of the recordings, or all of them (`whole`): their logs, and the traffic that was generated from them."""

    logs: Ground
    generated: Ground


def halved(
    choices: Sequence[Choices], samples: Sequence[Samples], scenes: int, planner: Planner, limits: Limits, seed: int
) -> list[Half]:
    """Both halves of scenarios (C,) with their samples (C,), of which `scenes` are traffic.

    All scenarios of a recording are in one half; a half has as many recordings as the other, or one more. Raises UnusableInput
    where all are of one recording.
    """
    of = [recording(choice.scenario.scenario_id) for choice in choices]
    names = sorted(set(of))
    if len(names) < 2:
        raise UnusableInput("all scenarios are of one recording: what a driver learns from it can't be tested elsewhere")
    side = dict(zip(names, (rng(seed, "repair", "halves").permutation(len(names)) % 2).tolist(), strict=True))
    members = [[i for i, name in enumerate(of) if side[name] == half] for half in (0, 1)]
    return [whole([choices[i] for i in rows], [samples[i] for i in rows], scenes, planner, limits) for rows in members]


def whole(choices: Sequence[Choices], samples: Sequence[Samples], scenes: int, planner: Planner, limits: Limits) -> Half:
    """Scenarios (C,) with their samples (C,), of which `scenes` are traffic, none held back."""
    return Half(logged(choices, planner, limits), sampled(choices, samples, scenes, planner, limits))


def attacked(
    driver: Driver, half: Half, adversaries: Mapping[str, Adversary], bounds: Bounds, seed: int, law: Reaction
) -> dict[str, Findings]:
    """What each adversary finds of `driver`, in logs or in generated traffic, whichever it is for."""
    found = {}
    for name, adversary in adversaries.items():
        of_logs = plugins.about("adversaries", name)["traffic"] == "log"
        arena = Arena(driver, half.logs if of_logs else half.generated, bounds, seed)
        adversary.attack(arena)
        found[name] = Findings.of(arena.runs(), driver, name, law)
    return found


def found_cases(found: Mapping[str, Findings]) -> list[Traffic]:
    """The cases that the adversaries which search have found; not what happens in logs, or in traffic as it is."""
    searches = [findings for name, findings in found.items() if plugins.about("adversaries", name)["varies"] != "nothing"]
    return [(case.scenario, case.traffic) for findings in searches for case in findings.cases]


def lessons_of(traffic: Sequence[Traffic], teacher: Driver) -> list[Traffic]:
    """Scenes with their target driving as `teacher` does in them, of those that this gets through without a collision.

    The target's own plan shows less: in half of all corner cases it runs into somebody, as the driver did that followed it.
    """
    if not traffic:
        return []
    trials = Trials(teacher, [scenario for scenario, _ in traffic], [motion for _, motion in traffic])
    outcome = trials.run(Variants.unchanged(np.arange(len(traffic)), trials.steps))
    shown = [
        (scenario, Trajectories.joined([outcome.motion[n : n + 1].until(motion.steps), motion[TARGET + 1 :]]))
        for n, (scenario, motion) in enumerate(traffic)
        if not outcome.collided[n]
    ]
    return exemplary(shown)


def repair_rows(
    tests: Mapping[str, Sequence[Mapping[str, Findings]]], taught: int, draws: int, seed: int
) -> Iterator[dict[str, Any]]:
    """Rows {version, tester, metric, value, low, high, n}; `tests`: of each version and half what each adversary found.

    `taught`: how many cases were among the lessons of the repaired version, which `cases_taught` says again.

    "kind.NAME" is the share of scenes with a case of that kind. "METRIC.minus_longer" of the repaired version is paired by
    scene. Intervals are over recordings; low and high are None where none was made, as of `comfort_absolute`.
    """
    for version, of_halves in tests.items():
        for tester in of_halves[0]:
            findings, longer = (Findings.joined([half[tester] for half in halves]) for halves in (of_halves, tests[LONGER]))
            about = {"version": version, "tester": tester, "n": len(findings.scenarios)}
            yield from (about | row for row in _measured(findings, draws, seed))
            shares = _shares(findings)
            if version == REPAIRED:
                yield about | {"metric": "cases_taught", "value": float(taught), "low": None, "high": None}
                shares |= {f"{name}.minus_{LONGER}": shares[name] - old for name, old in _shares(longer).items()}
            recordings = [recording(name) for name in findings.scenarios]
            random = rng(seed, "repair", "bootstrap")  # the same draws for all, as all are tested in the same scenes
            intervals = bootstrap_means(np.stack(list(shares.values()), axis=1), recordings, draws, random)
            yield from (about | {"metric": name, **asdict(one)} for name, one in zip(shares, intervals, strict=True))


def _measured(findings: Findings, draws: int, seed: int) -> Iterator[dict[str, Any]]:
    summary = findings.summary(draws, seed)
    for metric in MEASURES:
        yield {"metric": metric, "value": summary[metric]} | {end: summary.get(f"{metric}.{end}") for end in ("low", "high")}


def _shares(findings: Findings) -> dict[str, NDArray[np.float64]]:
    """(C,) of each share and kind, 1 where the scenario has it."""
    of_kind = {
        kind: {case.scenario_id for case, name in zip(findings.cases, findings.kinds, strict=True) if name == kind}
        for kind in Kind
    }
    kinds = {f"kind.{kind}": np.array([s in some for s in findings.scenarios], np.float64) for kind, some in of_kind.items()}
    return {name: findings.metrics[name].astype(np.float64) for name in SHARES} | kinds
