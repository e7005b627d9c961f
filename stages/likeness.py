"""Stage `likeness`: how near the corpus' traffic is to that of people, in seven distances.

argv: the corpus, the table (JSON). Without a folder of real data the table says so.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drivegen.core import plugins, seeds
from drivegen.core.settings import Count
from drivegen.datasets.base import Dataset
from drivegen.metrics.likeness import NAMES, Traffic, distances, halves_apart, traffic
from drivegen.store.files import write_json

SPLIT = "train"


@dataclass(frozen=True)
class Real:
    """Recordings of one data set: its `plugin`, its `folder` below the root, scenes as SPLIT/SCENE in groups that share cars."""

    plugin: str
    folder: str
    groups: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Params:
    """Section `likeness`: training `scenes` of the corpus at most, `draws` of halves, the `root` of `real` data ("": none)."""

    seed: int
    scenes: Count
    draws: Count
    root: str
    real: dict[str, Real]


def main(params: Params, corpus: Path, table: Path) -> None:
    """Measure the corpus against all real data together and against each data set."""
    missing = [name for name, real in params.real.items() if not params.root or not (Path(params.root) / real.folder).is_dir()]
    if missing:
        print(f"likeness: not measured: likeness.root ({params.root!r}) has no folder of {', '.join(missing)}")
        write_json(table, {"without": missing})
        return
    real = {name: _groups(Path(params.root), one) for name, one in params.real.items()}
    simulated, scenes = _corpus(plugins.load("datasets", "sumo_corpus")(corpus), params.scenes)
    unit = halves_apart(list(real.values()), params.draws, seeds.rng(params.seed, "likeness"))
    totals = {name: Traffic.total(groups) for name, groups in real.items()}
    apart = {"all": list(totals.values()), **{name: [total] for name, total in totals.items()}}
    gaps = {name: dict(zip(NAMES, distances([simulated], sources).tolist(), strict=True)) for name, sources in apart.items()}
    write_json(table, {"scenes": scenes, "unit": dict(zip(NAMES, unit.tolist(), strict=True)), "distance": gaps})


def _corpus(data: Dataset, most: int) -> tuple[Traffic, int]:
    """The traffic of so many scenes at most, spread over the split, and their number."""
    names = data.scenes(SPLIT)
    chosen = names[:: -(-len(names) // most)]
    return _total(data, (f"{SPLIT}/{name}" for name in chosen)), len(chosen)


def _groups(root: Path, real: Real) -> list[Traffic]:
    data = plugins.load("datasets", real.plugin)(root / real.folder)
    return [_total(data, group) for group in real.groups]


def _total(data: Any, scenes: Iterable[str]) -> Traffic:
    return Traffic.total([traffic(data.read(*scene.split("/", 1))) for scene in scenes])
