"""Set the checker's limits from logs: people drove them, so nearly all of their tracks must pass each rule.

Who is parked beside the lanes shows nothing of how people drive and is left out.
The limit of a rule is the larger of a floor (what is sensible on any road) and the quantile of the logged severities. Where
several rules set one flag, each may reject only its part of the rest, so that the share holds for the flag too.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegen.checker.limits import FLAGS, RULES, Limits
from drivegen.checker.scene import SceneChecker
from drivegen.core.errors import UnusableInput
from drivegen.core.samples import Violation
from drivegen.core.scenario import Scenario
from drivegen.roads.graph import LaneGraph
from drivegen.roads.parked import parked

_DECIMALS = 1000


@dataclass(frozen=True)
class Calibration:
    """Limits, and how the logs that they come from fare under them.

    Attributes:
        limits: Limits.
        tracks: number of logged tracks.
        judged: rule -> number of tracks that had anything to judge (a signal to pass, a limit to exceed).
        quantile: rule -> the logs' own quantile, None where it lies among tracks with nothing to judge.
        pass_rate: see `pass_rates`.
    """

    limits: Limits
    tracks: int
    judged: dict[str, int]
    quantile: dict[str, float | None]
    pass_rate: dict[str, float | None]

    def to_json(self) -> dict[str, Any]:
        """A plain mapping, for the stage's metrics."""
        return {
            "tracks": self.tracks,
            "judged": self.judged,
            "quantile": self.quantile,
            "pass_rate": self.pass_rate,
            "limits": self.limits.to_json(),
        }


def logged_severities(scenario: Scenario, limits: Limits) -> NDArray[np.float32]:
    """(tracks, R) severities of every logged track of one scenario but the parked ones'; none for a scenario without log.

    Severities don't depend on the limits; one set is needed to build a checker.
    """
    if scenario.log is None:
        return np.zeros((0, len(RULES)), np.float32)
    worst = SceneChecker(scenario, limits).severities(scenario.log[None]).worst[0]
    driven = scenario.log.valid.any(axis=-1) & ~parked(LaneGraph.of(scenario.map), scenario.vehicles)
    tracks: NDArray[np.float32] = worst[driven]
    return tracks


def calibrate(parts: list[NDArray[np.float32]], floors: Limits, share: float) -> Calibration:
    """Limits such that at least `share` of the logged tracks pass each rule, and none below `floors`.

    `parts` is what `logged_severities` found, scenario by scenario. Raises UnusableInput where there is no logged track.
    """
    severity = np.concatenate([np.zeros((0, len(RULES)), np.float32), *parts])
    if not len(severity):
        raise UnusableInput("there is no logged track to calibrate the checker on", reason="no-logs")
    rules_of_flag = np.array([FLAGS.count(flag) for flag in FLAGS])
    shares = 1 - (1 - share) / rules_of_flag
    severest = np.array([np.quantile(severity[:, r], shares[r], method="higher") for r in range(len(RULES))], np.float64)
    limits = Limits.from_severities(np.maximum(floors.severities(), np.ceil(severest * _DECIMALS) / _DECIMALS))
    return Calibration(
        limits=limits,
        tracks=len(severity),
        judged=_by_rule(np.isfinite(severity).sum(axis=0).tolist()),
        quantile=_by_rule([v if np.isfinite(v) else None for v in severest.tolist()]),
        pass_rate=pass_rates(severity, limits),
    )


def pass_rates(severity: NDArray[np.float32], limits: Limits) -> dict[str, float | None]:
    """Share of the tracks (M, R) that pass each rule, that are free of each flag, and that are `legal`; None without tracks."""
    passes = severity <= limits.severities().astype(np.float32)
    flags = np.array(FLAGS)
    groups = {name: [r] for r, name in enumerate(RULES)}
    groups |= {str(flag.name): np.flatnonzero(flags == flag).tolist() for flag in Violation if flag}
    groups["legal"] = list(range(len(RULES)))
    if not len(severity):
        return dict.fromkeys(groups)
    return {name: float(np.all(passes[:, rules], axis=1).mean()) for name, rules in groups.items()}


def _by_rule(values: list[Any]) -> dict[str, Any]:
    return dict(zip(RULES, values, strict=True))
