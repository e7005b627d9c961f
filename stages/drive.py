"""Stage drive: how one driver does in logged and in generated traffic, in the batch simulator.

argv: scenarios of one split, generated samples of any number of methods (folders beside one another), results (Parquet
rows), summary (JSON, flat numbers). The driver is named by the results' stem. Traffic called "log" is the scenarios' own.
"""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegen import plugins
from drivegen.drivers.base import Driver
from drivegen.errors import UnusableInput
from drivegen.metrics.driving import driving_summary, run_numbers, spread_over_samples
from drivegen.metrics.intervals import recording
from drivegen.scenario import Scenario, Trajectories
from drivegen.seeds import rng
from drivegen.simulators.base import AT_FAULT, CollisionKind, DrivingOutcome, with_off_road
from drivegen.store.files import write_json
from drivegen.store.results import Run, result_rows, run_id, write_results
from drivegen.store.samples import read_samples
from drivegen.store.scenarios import read_shard, shards
from stages._door import build, enter, require, spread

LOG = "log"
SIMULATOR = "batch"


@dataclass(frozen=True)
class Params:
    """`draws` bootstrap draws for intervals; `drivers`: settings of each driver by its name."""

    seed: int
    workers: int
    draws: int
    drivers: dict[str, dict[str, Any]]


@dataclass(frozen=True)
class Drives:
    """Runs of one method's traffic: scenario ids (C,), the scenario of each run (S,), and what became of the runs."""

    scenarios: list[str]
    scene: NDArray[np.int64]
    outcome: DrivingOutcome


def main(params: Params, scenarios: Path, *paths: Path) -> None:
    """Drive through every method's traffic."""
    *generated, results, summary = paths
    name = results.stem
    driver = make_driver(name, params)
    tables = []
    numbers: dict[str, float] = {}
    for folder in (None, *generated):
        method = folder.name if folder else LOG
        drives = _drive_all(driver, scenarios, folder, params, f"drive {name} {method}")
        inputs = [scenarios, folder] if folder else [scenarios]
        run = Run(run_id(asdict(params), inputs), "drive", method, name, params.seed, SIMULATOR)
        metrics = _per_scenario(drives)
        tables.append(result_rows(run, drives.scenarios, metrics))
        recordings = [recording(scenario) for scenario in drives.scenarios]
        random = rng(params.seed, "drive", "bootstrap", method)
        summed = driving_summary(metrics, recordings, drives.outcome.motion, drives.scene, params.draws, random)
        numbers |= {f"{method}.{key}": value for key, value in summed.items()}
    write_results(results, tables)
    write_json(summary, numbers)


def make_driver(name: str, params: Params) -> Driver:
    """The driver plugin `name` with its settings; raises UnusableInput where params know none."""
    plugin = plugins.load("drivers", name)
    if name not in params.drivers:
        raise UnusableInput(f"params.yaml: drive.drivers has no settings for the driver {name!r}")
    driver: Driver = plugin(build(plugin.settings_type, params.drivers[name], f"params.yaml: drive.drivers.{name}"))
    return driver


def _drive_all(driver: Driver, scenarios: Path, generated: Path | None, params: Params, what: str) -> Drives:
    tasks = [(driver, shard, generated) for shard in shards(scenarios)]
    parts = [part for _, part in spread(_drive_shard, tasks, params.workers, what)]
    parts = [part for part in parts if part.scenarios]
    if not parts:
        raise UnusableInput(f"{scenarios} holds no scenario with traffic to drive through", reason="no-scenarios")
    before = np.cumsum([0, *(len(part.scenarios) for part in parts)])
    return Drives(
        [name for part in parts for name in part.scenarios],
        np.concatenate([part.scene + first for part, first in zip(parts, before[:-1], strict=True)]),
        DrivingOutcome.joined([part.outcome for part in parts]),
    )


def _drive_shard(task: tuple[Driver, Path, Path | None]) -> Drives:
    driver, shard, generated = task
    pairs = list(_traffic(shard, generated))
    scenarios = [scenario for scenario, _ in pairs]
    ids = list(dict.fromkeys(scenario.scenario_id for scenario in scenarios))
    number = {name: i for i, name in enumerate(ids)}
    simulator = plugins.load("simulators", SIMULATOR)()
    outcome = simulator.run(driver, scenarios, [motion for _, motion in pairs])
    scene = np.array([number[scenario.scenario_id] for scenario in scenarios], np.int64)
    return Drives(ids, scene, with_off_road(outcome, scenarios))


def _traffic(shard: Path, generated: Path | None) -> list[tuple[Scenario, Trajectories]]:
    """Every scenario of a shard with its log, or with each of its samples."""
    scenarios = read_shard(shard)
    if generated is None:
        return [(scenario, scenario.log) for scenario in scenarios if scenario.log is not None]
    by_id = {samples.scenario_id: samples for samples in read_samples(require(generated / shard.name, "run the rollout stage"))}
    if missing := [s.scenario_id for s in scenarios if s.scenario_id not in by_id]:
        raise UnusableInput(f"{generated} lacks scenario {missing[0]}: run the rollout stage again")
    return [(s, by_id[s.scenario_id].motion[k]) for s in scenarios for k in range(len(by_id[s.scenario_id].motion.valid))]


def _per_scenario(drives: Drives) -> dict[str, NDArray[np.float64]]:
    """Means over each scenario's runs (C,)."""
    outcome, numbers = drives.outcome, run_numbers(drives.outcome.motion)
    per_run: dict[str, NDArray[Any]] = {
        "collision": outcome.collided,
        "collision.at_fault": np.isin(outcome.kind, AT_FAULT),
        "collision.in_first_second": outcome.in_first_second,
        **{f"collision.{kind.name.lower()}": outcome.kind == kind for kind in CollisionKind if kind},
        "distance": numbers.distance,
        "absolute_acceleration": numbers.absolute_acceleration,
        "acceleration": numbers.acceleration,
        "hardest_braking": numbers.hardest_braking,
        "off_road": outcome.off_road,
    }
    count = np.bincount(drives.scene)
    means = {name: np.bincount(drives.scene, np.asarray(value, np.float64)) / count for name, value in per_run.items()}
    return means | {"spread_over_samples": spread_over_samples(outcome.motion, drives.scene)}


if __name__ == "__main__":
    enter("drive", Params, main)
