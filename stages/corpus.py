"""Stage `corpus`: simulate logs on SUMO networks, for machines without data.

argv: the corpus' folder, which gets <split>/{tracks,maps}-<network>-<part>.parquet, networks/ and corpus.json.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from drivegen.core.scenario import SPLITS
from drivegen.core.settings import Count, Share
from drivegen.datasets.sumo_corpus import write_part
from drivegen.layouts.corpus import Networks
from drivegen.store.files import write_bytes, write_json
from drivegen.sumo.corpus import CorpusSettings, moving_vehicles, prepare_network, simulate_scenarios
from stages._door import spread


@dataclass(frozen=True)
class Params:
    """Section `corpus`.

    Attributes:
        scenarios: how many per split. per_part: at most so many in one file and one task.
        networks: of each split, see `Networks`. only: names of those in use, all where none is named.
        outside: the folder of those outside SUMO's package, "" for none.
        density: for "real" and "own" networks the least and the most vehicles per kilometre of lane that a run begins with.
        own_share: share of the scenarios that own networks give where a split has both.
        settings: see `CorpusSettings`.
    """

    seed: int
    workers: Count
    scenarios: dict[str, int]
    per_part: Count
    networks: Networks
    only: tuple[str, ...]
    outside: str
    density: dict[str, tuple[float, float]]
    own_share: Share
    settings: CorpusSettings


@dataclass(frozen=True)
class Task:
    """One part: `count` scenarios of one network."""

    network: Path
    city: str
    folder: Path
    part: int
    count: int
    density: tuple[float, float]
    settings: CorpusSettings
    seed: int


def main(params: Params, out: Path) -> None:
    """Prepare the networks, simulate all parts, and count what came out."""
    params.networks.check(params.scenarios, params.density)
    networks, missing = params.networks.chosen(params.only).located(params.outside)
    if missing:
        print(f"corpus: without {', '.join(missing)}: corpus.outside ({params.outside!r}) is no folder that holds their files")
    tasks: list[Task] = []
    for split in SPLITS:
        settings = params.settings if split == "train" else replace(params.settings, without_signals=0.0)
        for city, raw, density, count in _networks(replace(params, networks=networks), split):
            network = out / "networks" / f"{city}.net.xml"
            write_bytes(network, prepare_network(raw, city, params.seed))
            tasks += [
                Task(network, city, out / split, part, some, density, settings, params.seed)
                for part, some in enumerate(_parts(count, params.per_part))
            ]
    counts: dict[str, dict[str, dict[str, int]]] = {}
    for task, (moving, vehicles) in spread(simulate_part, tasks, params.workers, "corpus"):
        place = counts.setdefault(task.folder.name, {}).setdefault(task.city, {"scenarios": 0, "vehicles": 0, "moving": 0})
        place["scenarios"] += task.count
        place["vehicles"] += vehicles
        place["moving"] += moving
    write_json(out / "corpus.json", counts)


def simulate_part(task: Task) -> tuple[int, int]:
    """Simulate and write one part; returns how many vehicles move and how many there are."""
    raw = task.network.read_bytes()
    scenarios = simulate_scenarios(raw, task.city, task.part, task.count, task.density, task.settings, task.seed)
    write_part(task.folder, f"{task.city}-{task.part:03d}", scenarios)
    return moving_vehicles(scenarios)


def _networks(params: Params, split: str) -> Iterator[tuple[str, bytes, tuple[float, float], int]]:
    """Name, file, density and number of scenarios of each network of the split."""
    shares = params.networks.shares(split, params.scenarios.get(split, 0), params.own_share)
    for city, kind, count in shares:
        yield city, params.networks.read(split, city), params.density[kind], count


def _parts(count: int, most: int) -> list[int]:
    return [min(most, count - start) for start in range(0, count, most)]
