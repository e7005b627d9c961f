"""What one round of corner cases came to, with intervals over scenarios, and its price in realism."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.corner_cases.rounds import COUNTED, Drive
from drivegen.metrics.driving import comfort, run_numbers
from drivegen.metrics.intervals import bootstrap_means
from drivegen.rollout import Choices
from drivegen.scenario import TARGET
from drivegen.simulators.base import AT_FAULT, CollisionKind


@dataclass(frozen=True)
class RoundSummary:
    """Means over each scenario's K runs; `metrics` maps names to (C,) arrays over scenarios. `runs` counts all runs."""

    metrics: dict[str, NDArray[np.float64]]
    runs: int

    @classmethod
    def joined(cls, parts: "Sequence[RoundSummary]") -> "RoundSummary":
        """Scenarios of all parts, in order."""
        names = parts[0].metrics
        return cls({n: np.concatenate([p.metrics[n] for p in parts]) for n in names}, sum(p.runs for p in parts))

    def numbers(self, draws: int, random: np.random.Generator) -> dict[str, float]:
        """Each metric's mean over scenarios and its 95 % bootstrap interval, and Comfort in both readings."""
        names = sorted(self.metrics)
        intervals = bootstrap_means(np.stack([self.metrics[n] for n in names], axis=1), draws, random)
        out = {"scenarios": float(len(self.metrics[names[0]])), "runs": float(self.runs)}
        for name, interval in zip(names, intervals, strict=True):
            out |= {name: interval.value, f"{name}.low": interval.low, f"{name}.high": interval.high}
        out["comfort_absolute"] = comfort(out["absolute_acceleration"])
        out["comfort_signed"] = comfort(out["acceleration"])
        return out


def summarise(choices: Sequence[Choices], drives: Sequence[Drive]) -> RoundSummary:
    """Per scenario: collisions by kind, distance, accelerations, legality of the social traffic, importance ratios.

    `collision_rate` counts every collision after the spawn; `collision_rate_counted` those that teach something about
    the driver. `log_ratio` is the mean over social vehicles of log(used / natural): 0 where nothing was leaned on.
    """
    rows = [_row(choice, drive) for choice, drive in zip(choices, drives, strict=True)]
    return RoundSummary(
        {name: np.array([row[name] for row in rows]) for name in rows[0]}, sum(len(d.outcome.kind) for d in drives)
    )


def _row(choice: Choices, drive: Drive) -> dict[str, float]:
    outcome, samples = drive.outcome, drive.samples
    numbers = run_numbers(outcome.motion)
    social = np.arange(len(choice.scenario.vehicles)) != TARGET
    ratio = np.log(samples.used[:, social] / np.maximum(samples.natural[:, social], 1e-9))
    after_spawn = outcome.collided & (outcome.kind != CollisionKind.AT_SPAWN)
    kinds = {f"collision.{kind.name.lower()}": float((outcome.kind == kind).mean()) for kind in CollisionKind if kind}
    return kinds | {
        "collision_rate": float(after_spawn.mean()),
        "collision_rate_counted": float((np.isin(outcome.kind, COUNTED) & ~outcome.in_first_second).mean()),
        "collision_rate_at_fault": float(np.isin(outcome.kind, AT_FAULT).mean()),
        "collision.in_first_second": float(outcome.in_first_second.mean()),
        "distance": float(numbers.distance.mean()),
        "absolute_acceleration": float(np.nanmean(numbers.absolute_acceleration)),
        "acceleration": float(np.nanmean(numbers.acceleration)),
        "social_illegal": float((samples.violation[:, social] != 0).mean()) if social.any() else 0.0,
        "log_ratio": float(ratio.mean()) if social.any() else 0.0,
        "natural_probability": float(samples.natural[:, social].mean()) if social.any() else 1.0,
    }
