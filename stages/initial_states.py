"""Stage `initial_states`: how vehicles stand in the first frames of held-out logs, and in those generated on the same maps.

argv: scenarios (folder with train and test), assets, gaps, models, table (JSON). Ours, in both modes, draws its own target in one
row and is given the log's in another; every trained generator that places vehicles (`Learned.placements`) is given the log's.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch

from drivegen import plugins, seeds
from drivegen.assets.beginnings import Beginning, compared, rates
from drivegen.assets.draws import Draws
from drivegen.assets.gaps import Gaps
from drivegen.assets.place import MODES, Placer
from drivegen.assets.retrieve import draw_kinds, retrieve
from drivegen.assets.slots import Slots
from drivegen.assets.table import Table
from drivegen.assets.ways import closed_lanes
from drivegen.errors import UnusableInput
from drivegen.generators._learned import Placement
from drivegen.initialise import Settings, kind_named
from drivegen.lanes.graph import LaneGraph
from drivegen.metrics.intervals import Interval
from drivegen.scenario import TARGET, Scenario, Vehicles
from drivegen.settings import Count
from drivegen.store.assets import read_assets
from drivegen.store.files import write_json
from drivegen.store.scenarios import read_shard, shards
from stages._door import enter, read_params, require

GIVEN = ", the log's target"
"""What our rows are called in which the target is given, as it is to the rivals."""


@dataclass(frozen=True)
class Params:
    """Section `initial_states`: so many held-out `scenes`, spread over the split; bootstrap `draws`."""

    seed: int
    scenes: Count
    draws: Count


def main(params: Params, scenarios: Path, assets: Path, gaps: Path, models: Path, out: Path) -> dict[str, float]:
    """Distances of each method's first frames to the logs'; a map without room for one method counts for none."""
    table = Table.from_arrow(read_assets(require(assets, "run the assets stage")), str(assets))
    seen = Gaps.from_arrow(read_assets(require(gaps, "run the assets stage")), str(gaps))
    initial = read_params("place.initial", Settings)
    logs = _spread(_logged(scenarios / "test"), params.scenes)
    own, rivals = _Own(table, Draws(seen), initial, params.seed), _rivals(models, scenarios / "train", params.seed)
    names = [*own.names, *rivals]
    truth: list[Beginning] = []
    made: dict[str, list[Beginning]] = {name: [] for name in names}
    asked = 0
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
            made[name].append(Beginning.of(scenario, placed[name], graph))
        asked += len(scenario.vehicles)
    rng = seeds.rng(params.seed, "initial_states", "bootstrap")
    told = {"held-out logs": _told(truth, asked, rates(truth, params.draws, rng))}
    told |= {name: _told(made[name], asked, compared(truth, made[name], params.draws, rng)) for name in names}
    recordings = len({one.recording for one in truth})
    write_json(out, {"scenes": len(truth), "recordings": recordings, "left_out": len(logs) - len(truth), "methods": told})
    print(f"initial_states: {len(names)} methods on {len(truth)} maps")
    return {"scenes": float(len(truth))}


def _told(made: list[Beginning], asked: int, found: dict[str, Interval]) -> dict[str, Any]:
    ends = {"": "value", ".low": "low", ".high": "high"}
    numbers = {f"{name}{end}": getattr(value, part) for name, value in found.items() for end, part in ends.items()}
    return {"placed": sum(one.vehicles for one in made), "asked": asked, **numbers}


@dataclass(frozen=True)
class _Own:
    """Our placement on the maps of logs."""

    table: Table
    draws: Draws
    initial: Settings
    seed: int

    @property
    def names(self) -> list[str]:
        """Of what `places` makes."""
        return [f"drivegen, mode {mode}{around}" for mode in MODES for around in ("", GIVEN)]

    def places(self, scenario: Scenario) -> dict[str, Vehicles]:
        """By name, as many vehicles as the log has, of the same kinds in all, around a target of our own or the log's."""
        random = seeds.rng(self.seed, "initial_states", scenario.scenario_id)
        shares = {kind_named(word): share for word, share in self.initial.shares.items()}
        kinds = draw_kinds(shares, len(scenario.vehicles), random)
        rows = [int(retrieve(self.table, kind, 1, random)[0]) for kind in kinds]
        closed, slots = closed_lanes(scenario.signals), Slots(scenario.map)
        made = {}
        for mode in MODES:
            placer = Placer(slots, self.table, replace(self.initial.placement, mode=mode), self.draws)
            for around, target in (("", None), (GIVEN, scenario.vehicles[[TARGET]])):
                drawn = seeds.rng(self.seed, "initial_states", mode, scenario.scenario_id)
                made[f"drivegen, mode {mode}{around}"] = placer.place(rows, drawn, closed, target=target).vehicles
        return made


def _rivals(models: Path, train: Path, seed: int) -> Mapping[str, Placement]:
    """The placements of all generators that were trained."""
    torch.set_num_threads(1)  # sums depend on the number of threads
    logs = _logged(train, shards_read=1)
    found: dict[str, Placement] = {}
    for folder in sorted((models / "generators").glob("*/")):
        generator = plugins.load("generators", folder.name)(models, None)
        found |= generator.placements(logs, seed)
    return found


def _logged(split: Path, shards_read: int | None = None) -> list[Scenario]:
    files = shards(require(split, "run the ingest stage"))[:shards_read]
    return [scenario for file in files for scenario in read_shard(file) if scenario.log is not None]


def _spread(scenarios: list[Scenario], most: int) -> list[Scenario]:
    rows = np.linspace(0, len(scenarios), min(most, len(scenarios)), endpoint=False).astype(int)
    return [scenarios[row] for row in rows]


if __name__ == "__main__":
    enter("initial_states", Params, main)
