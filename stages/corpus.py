"""Stage `corpus`: simulate logs on SUMO networks, for machines without data.

argv: the corpus' folder, which gets <split>/{tracks,maps}-<network>-<part>.parquet, networks/ and corpus.json.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from drivegen.datasets.sumo_corpus import write_part
from drivegen.errors import MissingTool, UnusableInput
from drivegen.maps.compile import compile_map
from drivegen.maps.spec import MapSpec
from drivegen.settings import Count, Share
from drivegen.store.files import whole, write_json
from drivegen.sumo.corpus import CorpusSettings, moving_vehicles, prepare_network, simulate_scenarios
from stages._door import enter, require, spread

SPLITS = ("train", "val", "test")


@dataclass(frozen=True)
class Params:
    """Section `corpus`.

    Attributes:
        scenarios: how many per split. per_part: at most so many in one file and one task.
        real: networks of each split by name, as paths below SUMO_HOME. own: map specifications likewise, by name.
        density: for "real" and "own" networks the least and the most vehicles per kilometre of lane that a run begins with.
        own_share: share of the scenarios that own networks give where a split has both.
        settings: see `CorpusSettings`.
    """

    seed: int
    workers: Count
    scenarios: dict[str, int]
    per_part: Count
    real: dict[str, dict[str, str]]
    own: dict[str, dict[str, Any]]
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
    _check_disjoint(params)
    tasks: list[Task] = []
    for split in SPLITS:
        for city, raw, density, count in _networks(params, split):
            network = out / "networks" / f"{city}.net.xml"
            with whole(network) as temporary:
                temporary.write_bytes(prepare_network(raw, city, params.seed))
            tasks += [
                Task(network, city, out / split, part, some, density, params.settings, params.seed)
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


def _check_disjoint(params: Params) -> None:
    if set(params.density) != {"real", "own"}:
        raise UnusableInput("corpus.density needs a range for `real` and one for `own`, and nothing else")
    for known in (params.scenarios, params.real, params.own):
        if unknown := set(known) - set(SPLITS):
            raise UnusableInput(f"corpus: there is no split {unknown.pop()!r}; there are {', '.join(SPLITS)}")
    seen: dict[str, str] = {}
    for split in SPLITS:
        for name, source in [*params.real.get(split, {}).items(), *params.own.get(split, {}).items()]:
            for word in (name, str(source)):
                if seen.setdefault(word, split) != split or not name.replace("_", "").isalnum():
                    raise UnusableInput(f"corpus: network {name!r} is in {seen[word]} and {split}, or its name is no plain word")


def _networks(params: Params, split: str) -> Iterator[tuple[str, bytes, tuple[float, float], int]]:
    """Name, file, density and number of scenarios of each network of the split."""
    real, own, total = params.real.get(split, {}), params.own.get(split, {}), params.scenarios.get(split, 0)
    of_own = 0 if not own else total if not real else round(total * params.own_share)
    for names, kind, count in ((real, "real", total - of_own), (own, "own", of_own)):
        for i, (name, source) in enumerate(names.items()):
            share = count * (i + 1) // len(names) - count * i // len(names)
            if share:
                yield name, _source(name, source), params.density[kind], share


def _source(name: str, source: Any) -> bytes:
    if not isinstance(source, str):
        try:
            return compile_map(MapSpec.model_validate({"road": source}))
        except ValueError as error:  # pydantic's
            raise UnusableInput(f"corpus: the map {name!r} is no sound specification: {error}") from None
    found = find_spec("sumo")
    if found is None or found.origin is None:
        raise MissingTool("the corpus takes its networks from eclipse-sumo: pip install eclipse-sumo==1.28.0")
    return require(Path(found.origin).parent / source, f"corpus: network {name!r} is not part of this SUMO").read_bytes()


def _parts(count: int, most: int) -> list[int]:
    return [min(most, count - start) for start in range(0, count, most)]


if __name__ == "__main__":
    enter("corpus", Params, main)
