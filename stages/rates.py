"""Stage rates: how often drivers fail in traffic that follows the natural law, and whether intervals from few runs hold that.

argv: scenarios of one split, models, recorded goals of one selector, traffic that says who is there and what targets plan (folder
of shards), who failed in which draw (Parquet rows), rates (JSON). Neighbours react.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from drivegen.adversaries.shared.ground import legal
from drivegen.checker.verdicts import read_limits
from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.settings import Count
from drivegen.corner_cases.exposure import Exposure, expose
from drivegen.corner_cases.rates import Trial
from drivegen.drivers.base import Driver
from drivegen.drivers.mutants.table import mutated
from drivegen.rollout.batch import recorded_choices
from drivegen.rollout.models import read_planner
from drivegen.store.files import write_json, write_table
from drivegen.store.goals import read_goals
from drivegen.store.lookup import evenly, shared
from drivegen.store.samples import read_samples
from drivegen.store.scenarios import read_shard, shards
from drivegen.world.reactive import Reaction
from stages._door import enter, require, spread


@dataclass(frozen=True)
class Params:
    """Section `rates`.

    Attributes:
        drivers: settings of the sound ones, of which mutated ones are made. tested: those whose rates are asked for; house: those
            whose failures tell where to look, for a tested driver only those that are made of another sound one. Names are of
            sound or of mutated drivers.
        planner: fills in motion. scenes: of all shards. draws: of the law in each scene, the first legal ones of so many `tries`.
        trial: of intervals. reaction: of neighbours.
    """

    seed: int
    workers: Count
    drivers: dict[str, dict[str, Any]]
    tested: tuple[str, ...]
    house: tuple[str, ...]
    planner: str
    scenes: Count
    draws: Count
    tries: Count
    trial: Trial
    reaction: Reaction

    def make(self) -> dict[str, Driver]:
        """All that are named, by name."""
        sound: dict[str, Driver] = {name: plugins.make("drivers", name, self.drivers, "rates.drivers") for name in self.drivers}
        known = sound | mutated(sound)
        named = dict.fromkeys((*self.tested, *self.house))
        if unknown := [name for name in named if name not in known]:
            raise UnusableInput(f"params.yaml: rates names the driver {unknown[0]}: known are {', '.join(known)}")
        return {name: known[name] for name in named}


@dataclass(frozen=True)
class Task:
    """So many `scenes` of a shard."""

    shard: Path
    scenes: int
    models: Path
    goals: Path
    traffic: Path
    params: Params


def main(params: Params, scenarios: Path, models: Path, goals: Path, traffic: Path, table: Path, results: Path) -> None:
    """Draw, drive, and take the draws for the law whose rates are known."""
    params.make()  # to say what is wrong with them before anything takes long
    files = shards(require(scenarios, "run the ingest stage"))
    share = shared(params.scenes, [pq.read_metadata(file).num_rows for file in files])
    tasks = [Task(file, count, models, goals, traffic, params) for file, count in zip(files, share, strict=True) if count]
    found = Exposure.joined([part for _, part in spread(_exposed, tasks, params.workers, "rates")])
    write_json(results, found.rates(params.tested, params.house, params.trial, params.seed))
    write_table(table, _table(found))


def _exposed(task: Task) -> Exposure:
    params, scenarios = task.params, read_shard(task.shard)
    recorded = recorded_choices(scenarios, read_goals(require(task.goals / task.shard.name, "run the goals stage")), 1.0)
    samples = read_samples(require(task.traffic / task.shard.name, "run the corner stage"))
    rows = evenly(len(scenarios), task.scenes)
    choices, traffic = [recorded[r] for r in rows], [legal(samples[r], 0) for r in rows]
    made_with = read_planner(task.models, params.planner), read_limits(task.models)
    return expose(choices, traffic, *made_with, params.make(), params.draws, params.tries, params.reaction, params.seed)


def _table(found: Exposure) -> pa.Table:
    """A row for each draw."""
    scenes, draws, _ = found.failed.shape
    at = {"scenario": np.repeat(found.scenarios, draws), "draw": np.tile(np.arange(draws, dtype=np.int32), scenes)}
    return pa.table(at | {name: found.failed[:, :, m].ravel() for m, name in enumerate(found.drivers)})


if __name__ == "__main__":
    enter("rates", Params, main)
