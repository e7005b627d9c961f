"""Scenes drawn by seed for pictures and recordings, so that nobody chose the good ones."""

from dataclasses import dataclass
from pathlib import Path

import pyarrow.parquet as pq

from drivegen.errors import UnusableInput
from drivegen.samples import Samples
from drivegen.scenario import Scenario
from drivegen.seeds import rng
from drivegen.store.samples import read_samples
from drivegen.store.scenarios import read_shard, shards


@dataclass(frozen=True)
class Drawn:
    """A scene with its samples, and the shard that both are in (its file name)."""

    shard: str
    scenario: Scenario
    samples: Samples


def draw_scenes(seed: int, scenarios: Path, generated: Path, count: int) -> list[Drawn]:
    """`count` scenes of all shards below `scenarios` (fewer if there are fewer) with their samples; in a random order.

    The first scenes are the same whatever the count. Reads only the shards that scenes are drawn from. Raises
    UnusableInput where `generated` lacks one.
    """
    files = shards(scenarios)
    places = [(file, row) for file in files for row in range(pq.read_metadata(file).num_rows)]
    order = rng(seed, "draw").permutation(len(places))[:count]
    read: dict[Path, tuple[list[Scenario], dict[str, Samples]]] = {}
    drawn = []
    for place in order:
        file, row = places[int(place)]
        if file not in read:
            read[file] = read_shard(file), {s.scenario_id: s for s in read_samples(generated / file.name)}
        scenes, samples = read[file]
        if scenes[row].scenario_id not in samples:
            raise UnusableInput(f"{generated / file.name} lacks scenario {scenes[row].scenario_id}: run the rollout stage again")
        drawn.append(Drawn(file.name, scenes[row], samples[scenes[row].scenario_id]))
    return drawn
