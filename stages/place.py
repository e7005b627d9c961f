"""Stage `place`: put vehicles on the maps made from words, as new scenarios without a log.

argv: maps (a folder with <name>/map.net.xml), assets, gaps, held-out logs (a folder of shards), out (folder of shards), counts
(JSON). Headways of both modes of placement stand in the counts, beside those of logs that nothing was drawn from.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any

from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.scenario import Scenario
from drivegen.core.settings import Count
from drivegen.placement.gaps import Following, Gaps, headways
from drivegen.placement.place import MODES
from drivegen.placement.scenes import Initialiser, Settings
from drivegen.placement.table import Table
from drivegen.store.assets import read_assets
from drivegen.store.files import write_json
from drivegen.store.scenarios import read_shard, shards, write_shard
from drivegen.sumo.network import Network
from stages._door import require

SOURCE = "DriveGen (map from words)"


@dataclass(frozen=True)
class Params:
    """Section `place`: `per_map` scenarios on each map; `initial`: see `placement.scenes.Settings`; `compared` held-out logs."""

    seed: int
    per_map: Count
    per_shard: Count
    compared: Count
    initial: Settings


def main(params: Params, maps: Path, assets: Path, gaps: Path, held_out: Path, out: Path, counts: Path) -> None:
    """Place `per_map` scenes on every map; asked = placed + rejected."""
    table = Table.from_arrow(read_assets(require(assets, "run the assets stage")), str(assets))
    gap_table = Gaps.from_arrow(read_assets(require(gaps, "run the assets stage")), str(gaps))
    files = sorted(require(maps, "run the maps stage").glob("*/map.net.xml"))
    if not files:
        raise MissingTool(f"{maps} holds no map: run the maps stage")
    rejected: Counter[str] = Counter()
    placer = _Placer(params, table, gap_table)
    scenarios = (scenario for file in files for scenario in placer.scenes(file, params.initial, rejected))
    sizes: list[int] = []
    while part := list(islice(scenarios, params.per_shard)):
        write_shard(out / f"shard-{len(sizes) // params.per_shard:05d}.parquet", part)
        sizes += [len(scenario.vehicles) for scenario in part]
    placed, vehicles = sum(sizes), len(files) * params.per_map * params.initial.vehicles
    numbers = {"maps": len(files), "scenarios": len(sizes), "asked": vehicles, "placed": placed, "rejected": rejected}
    write_json(counts, {**numbers, "mode": params.initial.placement.mode, "headways": _headways(placer, files, held_out)})
    print(f"place: {placed} of {vehicles} vehicles on {len(files)} maps")


def _headways(placer: "_Placer", files: list[Path], held_out: Path) -> dict[str, Any]:
    """Of both modes and of the held-out logs."""
    params = placer.params
    logs = (s for shard in shards(require(held_out, "run the ingest stage")) for s in read_shard(shard))
    truth = Following.of(islice(logs, params.compared))
    by_name = {"held-out logs": headways(truth)}
    for mode in MODES:
        initial = replace(params.initial, placement=replace(params.initial.placement, mode=mode))
        scenes = (scene for file in files for scene in placer.scenes(file, initial, Counter()))
        by_name[f"placed, mode {mode}"] = headways(Following.of(scenes), truth)
    return by_name


@dataclass(frozen=True)
class _Placer:
    params: Params
    table: Table
    gaps: Gaps

    def scenes(self, file: Path, initial: Settings, rejected: Counter[str]) -> Iterator[Scenario]:
        """The scenes on one map; `rejected` counts vehicles that found no place."""
        network = Network.read(file.read_bytes(), str(file))
        initialiser = Initialiser(network, file.parent.name, SOURCE, self.table, initial, self.gaps)
        for number in range(self.params.per_map):
            try:
                scenario, left_out = initialiser.scenario(number, self.params.seed)
            except UnusableInput as error:
                rejected[error.reason] += initial.vehicles
                continue
            rejected.update(left_out)
            yield scenario
