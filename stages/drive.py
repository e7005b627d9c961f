"""Stage drive: how one driver does in logged and in generated traffic, in the batch simulator.

argv: scenarios of one split, generated samples of any number of methods (folders beside one another), results (Parquet
rows), summary (JSON, flat numbers). The driver is named by the results' stem. Traffic called "log" is the scenarios' own. Each
traffic is driven through twice: replayed, and with neighbours that react; metrics of the latter begin with "reactive.".
"""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.intervals import recording
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.core.seeds import rng
from drivegen.drivers.base import Driver
from drivegen.metrics.driving import driving_summary
from drivegen.simulators.shared.drives import Drives
from drivegen.store.files import write_json
from drivegen.store.results import Run, result_rows, write_results
from drivegen.store.samples import read_samples
from drivegen.store.scenarios import read_shard, shards
from drivegen.world.reactive import Reaction
from stages._door import build, enter, require, spread

LOG = "log"
SIMULATOR = "batch"


@dataclass(frozen=True)
class Params:
    """`draws` bootstrap draws for intervals; `drivers`: settings of each driver by its name; `reaction` of neighbours."""

    seed: int
    workers: int
    draws: int
    drivers: dict[str, dict[str, Any]]
    reaction: Reaction


def main(params: Params, scenarios: Path, *paths: Path) -> None:
    """Drive through every method's traffic."""
    *generated, results, summary = paths
    name = results.stem
    driver = make_driver(name, params)
    tables = []
    numbers: dict[str, float] = {}
    for folder in (None, *generated):
        method = folder.name if folder else LOG
        inputs = [scenarios, folder] if folder else [scenarios]
        run = Run.of("drive", name, asdict(params), inputs, method=method, driver=name, backend=SIMULATOR)
        for kind, reaction in (("", None), ("reactive.", params.reaction)):
            drives = _drive_all(driver, scenarios, folder, reaction, params.workers, f"drive {name} {kind}{method}")
            metrics = drives.per_scenario()
            ids, sample, each = drives.per_run()
            tables.append(result_rows(run, drives.scenarios, {f"{kind}{key}": value for key, value in metrics.items()}))
            tables.append(result_rows(run, ids, {f"{kind}{key}": value for key, value in each.items()}, sample))
            recordings = [recording(scenario) for scenario in drives.scenarios]
            random = rng(params.seed, "drive", "bootstrap", method, *([kind] if kind else []))
            means = driving_summary(metrics, recordings, drives.outcome.motion, drives.scene, params.draws, random)
            numbers |= {f"{method}.{kind}{key}": value for key, value in means.items()}
    write_results(results, tables)
    write_json(summary, numbers)


def make_driver(name: str, params: Params) -> Driver:
    """The driver plugin `name` with its settings; raises UnusableInput where params know none."""
    plugin = plugins.load("drivers", name)
    if name not in params.drivers:
        raise UnusableInput(f"params.yaml: drive.drivers has no settings for the driver {name!r}")
    driver: Driver = plugin(build(plugin.settings_type, params.drivers[name], f"params.yaml: drive.drivers.{name}"))
    return driver


def _drive_all(
    driver: Driver, scenarios: Path, generated: Path | None, reaction: Reaction | None, workers: int, what: str
) -> Drives:
    tasks = [(driver, shard, generated, reaction) for shard in shards(scenarios)]
    parts = [part for _, part in spread(_drive_shard, tasks, workers, what)]
    parts = [part for part in parts if part.scenarios]
    if not parts:
        raise UnusableInput(f"{scenarios} holds no scenario with traffic to drive through", reason="no-scenarios")
    return Drives.joined(parts)


def _drive_shard(task: tuple[Driver, Path, Path | None, Reaction | None]) -> Drives:
    driver, shard, generated, reaction = task
    return Drives.of(plugins.load("simulators", SIMULATOR)(reaction=reaction), driver, _traffic(shard, generated))


def _traffic(shard: Path, generated: Path | None) -> list[tuple[Scenario, Trajectories]]:
    """Every scenario of a shard with its log, or with each of its samples."""
    scenarios = read_shard(shard)
    if generated is None:
        return [(scenario, scenario.log) for scenario in scenarios if scenario.log is not None]
    by_id = {samples.scenario_id: samples for samples in read_samples(require(generated / shard.name, "run the rollout stage"))}
    if missing := [s.scenario_id for s in scenarios if s.scenario_id not in by_id]:
        raise UnusableInput(f"{generated} lacks scenario {missing[0]}: run the rollout stage again")
    return [(s, by_id[s.scenario_id].motion[k]) for s in scenarios for k in range(len(by_id[s.scenario_id].motion.valid))]


if __name__ == "__main__":
    enter("drive", Params, main)
