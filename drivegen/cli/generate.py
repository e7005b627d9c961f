"""`drivegen generate`: traffic for a logged scene, a road network, or a road in words."""

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

from rich.console import Console
from typer import BadParameter, Option

from drivegen import plugins
from drivegen.assets.table import Table
from drivegen.av2.export import export_scenario
from drivegen.av2.folder import read_folder
from drivegen.cli import _settings
from drivegen.errors import MissingTool, UnusableInput
from drivegen.initialise import Initialiser
from drivegen.maps.build import NETWORK, build_map
from drivegen.metrics.displacement import scene_errors
from drivegen.metrics.safety import safety_rates
from drivegen.recording import record_scenario
from drivegen.samples import Samples
from drivegen.scenario import Scenario
from drivegen.selection import select
from drivegen.store.assets import read_assets
from drivegen.store.files import write_json
from drivegen.sumo.network import Network


def command(
    out: Annotated[Path, Option(help="Folder for <id>/ (official layout, recording) and metrics.json, a row per sample.")],
    scenario: Annotated[Path | None, Option(help="An Argoverse 2 scenario folder: regenerate the traffic of its log.")] = None,
    map: Annotated[Path | None, Option(help="A SUMO network (.net.xml): place vehicles on it and let them drive.")] = None,  # noqa: A002
    text: Annotated[str | None, Option(help="A road in words: draw it, place vehicles on it and let them drive.")] = None,
    samples: Annotated[int, Option(min=1, max=1000, help="Futures of the scenario.")] = 10,
    vehicles: Annotated[int, Option(min=1, max=_settings.LARGEST, help="Target and social vehicles together.")] = 16,
    seed: Annotated[int, Option(min=0, help="Same seed, same bytes.")] = 7,
) -> None:
    """Generate traffic for exactly one of --scenario, --map and --text, with the models that `make run` trained."""
    if sum(source is not None for source in (scenario, map, text)) != 1:
        raise BadParameter("give exactly one of --scenario, --map and --text")
    console = Console(stderr=True, soft_wrap=True, highlight=False)
    with console.status("reading ..."):
        start = _logged(scenario, vehicles) if scenario is not None else _new(map, text, out, vehicles, seed, console)
    generator = plugins.load("generators", "drivegen")(_settings.MODELS, _settings.generation(start.log is None))
    with console.status(f"planning {samples} futures of {len(start.vehicles)} vehicles ..."):
        made: Samples = generator.generate([start], samples, seed)[0]
    with console.status("writing ..."):
        rows = list(_write(start, made, out))
        write_json(out / "metrics.json", rows)
    legal = sum(row["illegal_per_scene"] == 0 for row in rows)
    console.print(f"{out}: {len(rows)} scenarios of {len(start.vehicles)} vehicles ({start.source}), {legal} legal throughout")


def _logged(folder: Path, vehicles: int) -> Scenario:
    """The logged scenario, its first frame chosen as for training."""
    if not folder.is_dir():
        raise UnusableInput(f"{folder} is no folder: give one that holds scenario_<id>.parquet and log_map_archive_<id>.json")
    scenario = select(read_folder(folder, "Argoverse 2 Motion Forecasting layout"), _settings.selection(vehicles))
    scenario.validate()
    return scenario


def _new(net: Path | None, text: str | None, out: Path, vehicles: int, seed: int, console: Console) -> Scenario:
    """A new scenario on the network `net`, or on the one that `text` describes."""
    if net is not None:
        raw, name, source = net.read_bytes(), net.name.split(".")[0], f"DriveGen ({net.name})"
    else:
        built = build_map(str(text), seed, folder=out / "map")
        raw, name, source = built.network, "map", "DriveGen (map from words)"
        if ignored := built.account["ignored"]:
            console.print(f"ignored: {'; '.join(ignored)}")
    if not _settings.ASSETS.exists():
        raise MissingTool(f"{_settings.ASSETS} is not there: `make run` collects the vehicles and trains the models")
    table = Table.from_arrow(read_assets(_settings.ASSETS), str(_settings.ASSETS))
    network = Network.read(raw, str(net or out / "map" / NETWORK))
    scenario, rejected = Initialiser(network, name, source, table, _settings.initial(vehicles)).scenario(0, seed)
    for reason, count in sorted(rejected.items()):
        console.print(f"not placed: {count} vehicles ({reason})")
    return scenario


def _write(start: Scenario, made: Samples, out: Path) -> Iterator[dict[str, Any]]:
    """Each sample as a scenario folder with its recording; yields its row of metrics."""
    for k in range(len(made.violation)):
        name = f"{start.scenario_id}_{k:03d}"
        folder = export_scenario(start, made.motion[k], out, name)
        record_scenario(folder / f"{name}.rrd", start, made, sample=k)
        yield {
            "id": name,
            "sample": k,
            "vehicles": len(start.vehicles),
            **_scores(start, made, k),
            **asdict(safety_rates(_one(made, k))),
        }


def _scores(start: Scenario, made: Samples, k: int) -> dict[str, float]:
    """sADE and sFDE [m] against the log, where there is one."""
    if start.log is None:
        return {}
    sade, sfde = scene_errors(made.motion[k : k + 1], start.log)
    return {"sade": float(sade[0]), "sfde": float(sfde[0])}


def _one(made: Samples, k: int) -> Samples:
    """Sample k alone."""
    keep = slice(k, k + 1)
    return Samples(
        made.scenario_id, made.method, made.motion[keep], made.violation[keep], made.first_violation[keep], made.goal[keep],
        made.natural[keep], made.used[keep], made.attempts[keep], made.dropped[keep],
    )  # fmt: skip
