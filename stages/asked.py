"""Stage `asked`: our own suite of traffic in words, on some of the maps: what was asked against what was got, and its price.

argv: maps (a folder with <name>/map.net.xml), assets, gaps, models, results (Parquet rows), table (JSON). Every request is
read by `drivegen.words`, placed on maps in turn, and rolled out twice from the same first frame: with the goals that realise its
manoeuvres, and with the selector's own, so that the price of the words is seen beside what the same scene costs without them.
"""

from dataclasses import asdict, dataclass
from pathlib import Path

from drivegen.asked.start import Settings as AskedSettings
from drivegen.asked.suite import Bench, offers, sample_records, scene_records, suite, summary
from drivegen.core.errors import MissingTool
from drivegen.core.settings import Count
from drivegen.generators.base import Settings as GeneratorSettings
from drivegen.placement.gaps import Gaps
from drivegen.placement.scenes import Initialiser
from drivegen.placement.scenes import Settings as InitialSettings
from drivegen.placement.table import Table
from drivegen.rollout.models import Equipment
from drivegen.store.assets import read_assets
from drivegen.store.files import write_json
from drivegen.store.results import Run, record_rows, write_results
from drivegen.sumo.network import Network
from drivegen.words.read import READER, read
from stages._door import read_params, require

SOURCE, SELECTOR = "DriveGen (map from words)", "learned"


@dataclass(frozen=True)
class Params:
    """Section `asked`.

    Attributes:
        requests: the first so many of the suite, all if null. maps: names of maps. per_request: on how many of the maps that
            offer what it asks for each request is tried. samples: futures of each scene.
        vehicles: in a scene, where the request gives no number. settings: see `AskedSettings`.
    """

    seed: int
    requests: Count | None
    samples: Count
    maps: list[str]
    per_request: Count
    vehicles: Count
    settings: AskedSettings


def main(params: Params, maps: Path, assets: Path, gaps: Path, models: Path, results: Path, out: Path) -> dict[str, float]:
    """One row for each request on each map, and rates by kind of request."""
    table = Table.from_arrow(read_assets(require(assets, "run the assets stage")), str(assets))
    apart = Gaps.from_arrow(read_assets(require(gaps, "run the assets stage")), str(gaps))
    initial, generation = read_params("place.initial", InitialSettings), read_params("ship.generation", GeneratorSettings)
    tools = Equipment.open(models, generation.planner, SELECTOR)
    bench = Bench(
        lambda text: read(text, params.seed).traffic,
        params.settings,
        generation,
        tools,
        params.vehicles,
        params.samples,
        params.seed,
    )
    there = [name for name in params.maps if (maps / name / "map.net.xml").exists()]
    if not there:
        raise MissingTool(f"{maps} holds none of the maps {', '.join(params.maps)}: run the maps stage")
    networks = {name: _network(maps / name / "map.net.xml") for name in there}
    initialisers = {name: Initialiser(network, name, SOURCE, table, initial, apart) for name, network in networks.items()}
    has = {name: offers(network.map) for name, network in networks.items()}
    requests = suite()[: params.requests]
    rows = []
    for number, request in enumerate(requests):
        fit = [name for name in there if request.road in has[name]] or there
        chosen = [fit[(number + i) % len(fit)] for i in range(min(params.per_request, len(fit)))]
        rows += [bench.row(request, name, initialisers[name]) for name in chosen]
    made_with = [models / "planners" / generation.planner, models / "selector", models / "limits.json"]
    read_files = [assets, gaps, *made_with, *(maps / name / "map.net.xml" for name in there)]
    run = Run.of("asked", out.stem, asdict(params), read_files, backend=READER)
    of_samples = [record_rows(run, sample_records(rows, k), k) for k in range(params.samples)]
    write_results(results, [record_rows(run, scene_records(rows)), *of_samples])
    numbers = summary(rows)
    of_suite = {"requests": len(requests), "maps": there, "reader": READER}
    write_json(out, {**of_suite, **numbers, "rows": rows})
    meant = f"{numbers['read_as_meant']} of {numbers['scenes']} read as meant"
    print(f"asked: {meant}; {numbers['got']:.0%} of what was asked for was got")
    return {"scenes": float(len(rows))}


def _network(file: Path) -> Network:
    return Network.read(file.read_bytes(), str(file))
