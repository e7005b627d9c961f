"""Stage drive: how one driver does in logged and in generated traffic, in the batch simulator.

argv: scenarios of one split, generated samples of any number of methods (folders beside one another), the runs through replayed
logs (Parquet), results (Parquet rows), summary (JSON, flat numbers). The driver is named by the results' stem. Traffic called
"log" is the scenarios' own. Each traffic is driven through twice: replayed, and with neighbours that react; metrics of the latter
begin with "reactive.".
"""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.intervals import recording
from drivegen.core.samples import Samples
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.core.seeds import rng
from drivegen.core.settings import Count
from drivegen.drivers.base import Driver
from drivegen.metrics.driving import NEIGHBOURS, driving_summary
from drivegen.simulators.shared.drives import Drives
from drivegen.store.files import write_json
from drivegen.store.lookup import futures_in, logs_in
from drivegen.store.results import Run, result_rows, write_results
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import shards
from drivegen.world.paths import target_paths
from drivegen.world.reactive import Reaction
from stages._door import require, spread
from stages._driven_by import weights_of

LOG = "log"
SIMULATOR = "batch"
"""What metrics begin with where neighbours are replayed, and where they react."""


@dataclass(frozen=True)
class Params:
    """`draws` bootstrap draws for intervals; `drivers`: settings of each driver by its name; `reaction` of neighbours."""

    seed: int
    workers: Count
    draws: Count
    drivers: dict[str, dict[str, Any]]
    reaction: Reaction


def main(params: Params, scenarios: Path, *paths: Path) -> None:
    """Drive through every method's traffic."""
    *generated, runs, results, summary = paths
    name = results.stem
    driver: Driver = plugins.make("drivers", name, params.drivers, "drive.drivers")
    settings = {**asdict(params), "drivers": {name: params.drivers[name]}}  # what others drive by does not change its runs
    tables, through_logs = [], list[Samples]()
    numbers: dict[str, float] = {}
    for folder in (None, *generated):
        method = folder.name if folder else LOG
        inputs = [scenarios, *([folder] if folder else []), *weights_of(params.drivers[name])]
        run = Run.of("drive", name, settings, inputs, method=method, driver=name, backend=SIMULATOR)
        for kind, drives in _drive_all(driver, scenarios, folder, params, f"drive {name} {method}").items():
            metrics = drives.per_scenario()
            ids, sample, each = drives.per_run()
            tables.append(result_rows(run, drives.scenarios, {f"{kind}{key}": value for key, value in metrics.items()}))
            tables.append(result_rows(run, ids, {f"{kind}{key}": value for key, value in each.items()}, sample))
            if not folder and not kind:
                through_logs = drives.as_samples(name)
            recordings = [recording(scenario) for scenario in drives.scenarios]
            random = rng(params.seed, "drive", "bootstrap", method, *([kind] if kind else []))
            means = driving_summary(metrics, recordings, drives.outcome.motion, drives.scene, params.draws, random)
            numbers |= {f"{method}.{kind}{key}": value for key, value in means.items()}
    write_samples(runs, through_logs)
    write_results(results, tables)
    write_json(summary, numbers)


def _drive_all(driver: Driver, scenarios: Path, generated: Path | None, params: Params, what: str) -> dict[str, Drives]:
    """Drives among neighbours of both kinds, by what their metrics' names begin with."""
    tasks = [(driver, shard, generated, params.reaction) for shard in shards(scenarios)]
    parts = [part for _, part in spread(_drive_shard, tasks, params.workers, what) if part]
    if not parts:
        raise UnusableInput(f"{scenarios} holds no scenario with traffic to drive through", reason="no-scenarios")
    return {kind: Drives.joined([part[kind] for part in parts]) for kind in NEIGHBOURS.values()}


def _drive_shard(task: tuple[Driver, Path, Path | None, Reaction]) -> dict[str, Drives]:
    """As `_drive_all` for a shard; nothing where it has no traffic."""
    driver, shard, generated, reaction = task
    traffic = _traffic(shard, generated)
    if not traffic:
        return {}
    paths = target_paths([scenario for scenario, _ in traffic], [motion for _, motion in traffic])
    simulator = plugins.load("simulators", SIMULATOR)
    return {
        kind: Drives.of(simulator(reaction=reaction if kind else None, counts_lights=True), driver, traffic, paths)
        for kind in NEIGHBOURS.values()
    }


def _traffic(shard: Path, generated: Path | None) -> list[tuple[Scenario, Trajectories]]:
    """Every scenario of a shard with its log, or with each of its samples."""
    if generated is None:
        return logs_in(shard)
    futures = futures_in(require(generated / shard.name, "run the rollout stage"), shard.parent)
    return [(scenario, samples.motion[k]) for scenario, samples in futures for k in range(len(samples.dropped))]
