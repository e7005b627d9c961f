"""Stage `place`: put vehicles on the maps made from words, as new scenarios without a log.

argv: maps (a folder with <name>/map.net.xml), assets, out (folder of shards), counts (JSON).
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from drivegen.assets.table import Table
from drivegen.errors import MissingTool, UnusableInput
from drivegen.initialise import Initialiser, Settings
from drivegen.scenario import Scenario
from drivegen.store.assets import read_assets
from drivegen.store.files import write_json
from drivegen.store.scenarios import write_shard
from drivegen.sumo.network import Network
from stages._door import enter, require

SOURCE = "DriveGen (map from words)"


@dataclass(frozen=True)
class Params:
    """Section `place`: `per_map` scenarios on each map; `initial`: see `initialise.Settings`."""

    seed: int
    per_map: int
    per_shard: int
    initial: Settings


def main(params: Params, maps: Path, assets: Path, out: Path, counts: Path) -> None:
    """Place `per_map` scenes on every map; asked = placed + rejected."""
    table = Table.from_arrow(read_assets(require(assets, "run the assets stage")), str(assets))
    files = sorted(require(maps, "run the maps stage").glob("*/map.net.xml"))
    if not files:
        raise MissingTool(f"{maps} holds no map: run the maps stage")
    rejected: Counter[str] = Counter()
    scenarios = [scenario for file in files for scenario in _scenes(params, file, table, rejected)]
    for shard, start in enumerate(range(0, len(scenarios), params.per_shard)):
        write_shard(out / f"shard-{shard:05d}.parquet", scenarios[start : start + params.per_shard])
    placed = sum(len(scenario.vehicles) for scenario in scenarios)
    asked = len(files) * params.per_map * params.initial.vehicles
    write_json(counts, {"maps": len(files), "scenarios": len(scenarios), "asked": asked, "placed": placed, "rejected": rejected})
    print(f"place: {placed} of {asked} vehicles on {len(files)} maps")


def _scenes(params: Params, file: Path, table: Table, rejected: Counter[str]) -> Iterator[Scenario]:
    network = Network.read(file.read_bytes(), str(file))
    initialiser = Initialiser(network, file.parent.name, SOURCE, table, params.initial)
    for number in range(params.per_map):
        try:
            scenario, left_out = initialiser.scenario(number, params.seed)
        except UnusableInput as error:
            rejected[error.reason] += params.initial.vehicles
            continue
        rejected.update(left_out)
        yield scenario


if __name__ == "__main__":
    enter("place", Params, main)
