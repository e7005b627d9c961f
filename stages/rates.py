"""Stage rates: how often drivers fail in traffic that follows the natural law, and whether intervals from few runs hold that.

argv: scenarios of one split, models, recorded goals of one selector, traffic that says who is there and what targets plan (folder
of shards), who failed in which draw (Parquet rows), rates (JSON). Neighbours react.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.settings import Count
from drivegen.drivers.base import Driver
from drivegen.drivers.mutants.table import mutated
from drivegen.exposure.pool import Exposure, draw_scenes
from drivegen.exposure.rates import Trial
from drivegen.store.files import write_json, write_table
from drivegen.world.reactive import Reaction
from stages._door import spread
from stages._ground import Made, shares


@dataclass(frozen=True)
class Params:
    """Section `rates`.

    Attributes:
        drivers: settings of the sound ones, of which mutated ones are made. tested: names of sound or of mutated ones.
        planner: fills in motion. scenes: of all shards. draws: of the law in each scene, the first legal ones of so many `tries`.
        trial: of intervals. reaction: of neighbours.
    """

    seed: int
    workers: Count
    drivers: dict[str, dict[str, Any]]
    tested: tuple[str, ...]
    planner: str
    scenes: Count
    draws: Count
    tries: Count
    trial: Trial
    reaction: Reaction

    def __post_init__(self) -> None:
        if not self.tested:
            raise UnusableInput("stages/params.yaml: rates.tested: name at least one driver")

    def make(self) -> list[Driver]:
        """Those that are tested."""
        sound: dict[str, Driver] = {name: plugins.make("drivers", name, self.drivers, "rates.drivers") for name in self.drivers}
        drivers = sound | mutated(sound)
        if unknown := [name for name in self.tested if name not in drivers]:
            raise UnusableInput(f"stages/params.yaml: rates.tested names {unknown[0]}, which is none of {', '.join(drivers)}")
        return [drivers[name] for name in self.tested]


def main(params: Params, scenarios: Path, models: Path, goals: Path, traffic: Path, table: Path, results: Path) -> None:
    """Draw, drive, and take the draws for the law whose rates are known."""
    params.make()  # to say what is wrong with them before anything takes long
    parts, work = shares(scenarios, params.scenes), partial(_exposed, params, models, goals, traffic)
    exposure = Exposure.joined([part for _, part in spread(work, parts, params.workers, "rates")])
    write_json(results, exposure.rates(params.tested, params.trial, params.seed))
    write_table(table, _table(exposure, params.tested))


def _exposed(params: Params, models: Path, goals: Path, traffic: Path, part: tuple[Path, int]) -> Exposure:
    """`part`: a shard, and of how many scenes of it."""
    shard, scenes = part
    ground = Made.open(models, params.planner, goals, traffic).ground(shard, 1, scenes)
    drawn = draw_scenes(ground, params.draws, params.tries, params.seed)
    return Exposure.of(drawn, params.make(), params.draws, params.reaction)


def _table(exposure: Exposure, names: Sequence[str]) -> pa.Table:
    """A row for each draw; of each driver whether it failed, and how near [m] the others came."""
    scenes, draws, _ = exposure.failed.shape
    at = {"scenario": np.repeat(exposure.scenarios, draws), "draw": np.tile(np.arange(draws, dtype=np.int32), scenes)}
    failed = {name: exposure.failed[:, :, m].ravel() for m, name in enumerate(names)}
    return pa.table(at | failed | {f"{name}.near": exposure.near[:, :, m].ravel() for m, name in enumerate(names)})
