"""What one round of corner cases came to, with intervals over recordings, and its price in realism.

Names are those of the drive stage's summaries, so that a round stands beside the same driver in logged traffic.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegen.core.intervals import recording
from drivegen.core.scenario import TARGET, Trajectories
from drivegen.corner_cases.rounds import Drive
from drivegen.metrics.displacement import scene_errors
from drivegen.metrics.driving import driving_summary
from drivegen.rollout.choices import Choices
from drivegen.simulators.shared.drives import impacts, kind_shares, numbered, run_metrics


@dataclass(frozen=True)
class RoundSummary:
    """Numbers of C scenarios with R runs in all.

    Attributes:
        metrics: (C,) arrays by name, each scenario's mean over its runs.
        runs: (R,) arrays by name, each run's numbers; NaN where it has none.
        scenarios: (C,) ids.
        motion: Trajectories (R, T) of the driven targets. scene: (R,) the scenario of each run.
    """

    metrics: dict[str, NDArray[np.float64]]
    runs: dict[str, NDArray[np.float64]]
    scenarios: list[str]
    motion: Trajectories
    scene: NDArray[np.int64]

    @classmethod
    def joined(cls, parts: "Sequence[RoundSummary]") -> "RoundSummary":
        """Scenarios of all parts, in order."""
        before = np.cumsum([0, *(len(p.scenarios) for p in parts)])[:-1]
        return cls(
            {n: np.concatenate([p.metrics[n] for p in parts]) for n in parts[0].metrics},
            {n: np.concatenate([p.runs[n] for p in parts]) for n in parts[0].runs},
            [name for p in parts for name in p.scenarios],
            Trajectories.joined([p.motion for p in parts]),
            np.concatenate([p.scene + first for p, first in zip(parts, before, strict=True)]),
        )

    def per_run(self) -> tuple[list[str], NDArray[np.int64], dict[str, NDArray[np.float64]]]:
        """The scenario of each run (R,), its sample, and `runs`."""
        return [self.scenarios[scene] for scene in self.scene], numbered(self.scene), self.runs

    def numbers(self, draws: int, random: np.random.Generator) -> dict[str, float]:
        """See `driving_summary`."""
        recordings = [recording(scenario) for scenario in self.scenarios]
        return driving_summary(self.metrics, recordings, self.motion, self.scene, draws, random)


def summarise(choices: Sequence[Choices], drives: Sequence[Drive]) -> RoundSummary:
    """Per scenario: collisions by kind, the driver's numbers, and the price: how legal, likely and realistic traffic was.

    `collision` counts every run that ends in one, `collision.counted` those that knowledge is made of, `left_map` those that
    end because the target has driven out of the map. `log_ratio` is the
    mean over social vehicles of log(used / natural), 0 where nothing was leaned on; `min_sade` and `mean_sade` [m] are those
    of the social vehicles against the log, NaN without one.
    """
    each = [_runs(drive) | impacts(drive.outcome) for drive in drives]
    rows = [_row(choice, drive) for choice, drive in zip(choices, drives, strict=True)]
    runs = [len(drive.outcome.kind) for drive in drives]
    return RoundSummary(
        {name: np.array([row[name] for row in rows]) for name in rows[0]},
        {name: np.concatenate([run[name] for run in each]) for name in each[0]},
        [choice.scenario.scenario_id for choice in choices],
        Trajectories.joined([drive.outcome.motion for drive in drives]),
        np.repeat(np.arange(len(drives)), runs),
    )


def _row(choice: Choices, drive: Drive) -> dict[str, float]:
    values = _runs(drive) | kind_shares(drive.outcome)
    return {name: _mean(value) for name, value in values.items()} | _price(choice, drive)


def _runs(drive: Drive) -> dict[str, NDArray[Any]]:
    """What is said of each run, (K,) by name."""
    return run_metrics(drive.outcome) | {"collision.counted": drive.outcome.counted}


def _price(choice: Choices, drive: Drive) -> dict[str, float]:
    """What leaning on the social vehicles cost; all NaN where there are none."""
    samples, scenario = drive.samples, choice.scenario
    social = np.arange(len(scenario.vehicles)) != TARGET
    if not social.any():
        return dict.fromkeys(("social_illegal", "log_ratio", "natural_probability", "min_sade", "mean_sade"), np.nan)
    natural, used = samples.natural[:, social].astype(np.float64), samples.used[:, social].astype(np.float64)
    log = scenario.log
    scored = log is not None and bool(log.valid[social, 1:].any())
    errors = scene_errors(samples.motion[:, social], log[social])[0] if log is not None and scored else np.array([np.nan])
    return {
        "social_illegal": float((samples.violation[:, social] != 0).mean()),
        "log_ratio": float(np.log(used / natural).mean()),
        "natural_probability": float(natural.mean()),
        "min_sade": float(errors.min()),
        "mean_sade": float(errors.mean()),
    }


def _mean(values: NDArray[Any]) -> float:
    """Mean of what is known; NaN where nothing is."""
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if len(finite) else np.nan
