"""Stage `map_diversity`: how much maps from words differ, beside real road networks, in windows of one size.

argv: folder of maps from words, the table (JSON). Real networks are SUMO's own and, where a folder is named, Argoverse 2's.
"""

from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from drivegen.av2.maps import read_map
from drivegen.core import seeds
from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.roadmap import RoadMap
from drivegen.core.settings import Count, Positive
from drivegen.maps.diversity import summary, windows
from drivegen.store.files import write_json
from drivegen.sumo.network import read_network
from stages._door import read_section, require

MADE, SUMO, ARGOVERSE = "maps from words", "SUMO's real networks", "Argoverse 2"


@dataclass(frozen=True)
class Params:
    """Section `map_diversity`.

    Attributes:
        radius: of a window [m]. per_made, per_network, per_log: windows out of every map from words, network, Argoverse 2 log.
        networks: names of real ones in `corpus.networks`. argoverse2: a folder of logs, "" for none.
    """

    seed: int
    radius: Positive
    per_made: Count
    per_network: Count
    per_log: Count
    networks: tuple[str, ...]
    argoverse2: str


def main(params: Params, maps: Path, table: Path) -> None:
    """Measure every source; one that is not there stands in the table as not measured."""
    files = sorted(maps.glob("*/map.net.xml"))
    logs = sorted(Path(params.argoverse2).rglob("log_map_archive_*.json")) if params.argoverse2 else []
    places = {name: path for split in read_section("corpus.networks.real").values() for name, path in split.items()}
    if unknown := set(params.networks) - set(places):
        raise UnusableInput(f"map_diversity.networks names {min(unknown)!r}, which is no real network of corpus.networks")
    real = {name: _home() / places[name] for name in sorted(params.networks)}
    measured = {
        MADE: _measured(params, {f.parent.name: read_network(f.read_bytes(), str(f)) for f in files}, params.per_made),
        SUMO: _measured(params, {name: _network(name, file) for name, file in real.items()}, params.per_network),
        ARGOVERSE: _measured(params, {f.name: read_map(f.read_bytes(), str(f)) for f in logs}, params.per_log),
    }
    write_json(table, {"radius": params.radius, "sources": measured})


def _measured(params: Params, maps: dict[str, RoadMap], count: int) -> dict[str, float] | None:
    """The summary of one source's windows; None without any."""
    cut = [
        window
        for name, road_map in maps.items()
        for window in windows(road_map, count, params.radius, seeds.rng(params.seed, "map_diversity", name))
    ]
    return {"maps": float(len(maps)), **summary(cut)} if cut else None


def _network(name: str, file: Path) -> RoadMap:
    raw = require(file, f"map_diversity: network {name!r} is not part of this SUMO").read_bytes()
    return read_network(raw, name)


def _home() -> Path:
    spec = find_spec("sumo")
    if spec is None or spec.origin is None:
        raise MissingTool("real networks come with eclipse-sumo: pip install eclipse-sumo==1.28.0")
    return Path(spec.origin).parent
