"""Stage calibrate: limits of the legal checker, so that a stated share of logged train tracks passes each rule.

argv: scenarios (folder with train and val), limits (JSON), pass rates (JSON). The validation split shows how the limits do
on logs that they were not set by.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from drivegen.checker.calibration import calibrate, logged_severities, pass_rates
from drivegen.checker.limits import RULES, Limits
from drivegen.checker.verdicts import write_limits_file
from drivegen.core.errors import UnusableInput
from drivegen.core.settings import Count, Share
from drivegen.store.files import write_json
from drivegen.store.scenarios import read_shard, shards
from stages._door import spread_splits


@dataclass(frozen=True)
class Params:
    """`share` of logged tracks that must pass each rule; `floors` below which no limit is set."""

    workers: Count
    share: Share
    floors: Limits


def main(params: Params, scenarios: Path, limits: Path, rates: Path) -> None:
    """Measure every logged track, set the limits, report who passes."""
    train, held_out = _severities(scenarios, params)
    if not train:
        raise UnusableInput(f"{scenarios}/train holds no scenario to calibrate the checker on", reason="no-scenarios")
    calibration = calibrate(train, params.floors, params.share)
    unseen = np.concatenate([np.zeros((0, len(RULES)), np.float32), *held_out])
    write_limits_file(limits, calibration.limits)
    write_json(rates, calibration.to_json() | {"share": params.share, "held_out": pass_rates(unseen, calibration.limits)})


def _severities(scenarios: Path, params: Params) -> tuple[list[NDArray[np.float32]], list[NDArray[np.float32]]]:
    """Of both splits, shard by shard: a few numbers for each track."""
    by_split: dict[str, list[NDArray[np.float32]]] = {"train": [], "val": []}

    def tasks(split: Path) -> list[tuple[Path, Limits]]:
        return [(shard, params.floors) for shard in shards(split)]

    for split, severities in spread_splits(_shard_severities, scenarios, tasks, params.workers, "calibrate"):
        by_split[split].append(severities)
    return by_split["train"], by_split["val"]


def _shard_severities(task: tuple[Path, Limits]) -> NDArray[np.float32]:
    shard, floors = task
    parts = [logged_severities(scenario, floors) for scenario in read_shard(shard)]
    return np.concatenate([np.zeros((0, len(RULES)), np.float32), *parts])
