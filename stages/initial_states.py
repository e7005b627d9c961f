"""Stage `initial_states`: how vehicles stand in the first frames of held-out logs, and in those generated on the same maps.

argv: scenarios (folder with train and test), assets, gaps, models, table (JSON). Ours, in both modes, draws its own target in one
row and is given the log's in another; every trained generator that says it places vehicles is given the log's.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch

from drivegen.core import plugins, seeds
from drivegen.core.errors import UnusableInput
from drivegen.core.intervals import Interval
from drivegen.core.scenario import Scenario
from drivegen.core.settings import Count
from drivegen.generators.shared.learned import Placement
from drivegen.placement.beginnings import Beginning, compared, rates, without_parked
from drivegen.placement.draws import Draws
from drivegen.placement.gaps import Gaps
from drivegen.placement.on_logs import OnLogs
from drivegen.placement.scenes import Settings
from drivegen.placement.table import Table
from drivegen.roads.graph import LaneGraph
from drivegen.store.assets import read_assets
from drivegen.store.files import write_json
from drivegen.store.lookup import evenly
from drivegen.store.scenarios import read_shard, shards
from stages._code_library import library
from stages._door import read_params, require

LOGS = "held-out logs"


@dataclass(frozen=True)
class Params:
    """Section `initial_states`: so many held-out `scenes`, spread over the split; bootstrap `draws`."""

    seed: int
    scenes: Count
    draws: Count


def main(params: Params, scenarios: Path, assets: Path, gaps: Path, models: Path, out: Path) -> dict[str, float]:
    """Distances of each method's first frames to the logs'; a map without room for one method counts for none."""
    table = Table.from_arrow(read_assets(require(assets, "run the assets stage")), str(assets))
    draws = Draws(Gaps.from_arrow(read_assets(require(gaps, "run the assets stage")), str(gaps)))
    own = OnLogs(table, draws, read_params("place.initial", Settings), params.seed)
    logged = _logged(scenarios / "test")
    logs = [logged[row] for row in evenly(len(logged), params.scenes)]
    rivals = _rivals(models, scenarios, params.seed)
    names = [*own.names, *rivals]
    truth: list[Beginning] = []
    beginnings: dict[str, list[Beginning]] = {name: [] for name in names}
    vehicles = 0
    for scenario in logs:
        try:
            placed = own.places(scenario) | {name: place(scenario) for name, place in rivals.items()}
        except UnusableInput as error:
            if error.reason != "no-place":
                raise
            continue
        graph = LaneGraph.of(scenario.map)
        truth.append(Beginning.of(scenario, scenario.vehicles, graph))
        for name in names:
            beginnings[name].append(Beginning.of(scenario, placed[name], graph))
        vehicles += len(scenario.vehicles)
    rows = [_row(LOGS, truth, vehicles, rates(truth, params.draws, _draws(params)))]
    rows += [
        _row(name, beginnings[name], vehicles, compared(truth, beginnings[name], params.draws, _draws(params))) for name in names
    ]
    recordings = len({one.recording for one in truth})
    write_json(out, {"scenes": len(truth), "recordings": recordings, "left_out": len(logs) - len(truth), "methods": rows})
    print(f"initial_states: {len(names)} methods on {len(truth)} maps")
    return {"scenes": float(len(truth))}


def _draws(params: Params) -> np.random.Generator:
    """A stream for one row, the same for each: all methods meet the same draws, whoever else has a row."""
    return seeds.rng(params.seed, "initial_states", "bootstrap")


def _row(name: str, beginnings: list[Beginning], vehicles: int, measures: dict[str, Interval]) -> dict[str, Any]:
    ends = {"": "value", ".low": "low", ".high": "high"}
    numbers = {f"{measure}{end}": getattr(value, part) for measure, value in measures.items() for end, part in ends.items()}
    return {"name": name, "placed": sum(one.vehicles for one in beginnings), "asked": vehicles, **numbers}


def _rivals(models: Path, scenarios: Path, seed: int) -> Mapping[str, Placement]:
    """The placements of all generators that were trained and say that they place."""
    torch.set_num_threads(1)  # sums depend on the number of threads
    placements: dict[str, Placement] = {}
    for folder in sorted((models / "generators").glob("*/")):
        plugin = plugins.load("generators", folder.name)
        if plugin.about.places:
            logs = map(without_parked, library(scenarios, seed))
            placements |= plugin(models, None).placements(logs, seed)
    return placements


def _logged(split: Path) -> list[Scenario]:
    files = shards(require(split, "run the ingest stage"))
    return [without_parked(scenario) for file in files for scenario in read_shard(file) if scenario.log is not None]
