"""`drivegen generate`: traffic for a logged scene, a road network, or a road in words."""

import re
from pathlib import Path
from typing import Annotated, Any

from rich.console import Console
from rich.progress import Progress
from typer import BadParameter, Option

from drivegen.av2.folder import read_folder
from drivegen.cli import _project
from drivegen.errors import UnusableInput
from drivegen.make import Start, from_log, from_network, make, row, write_sample
from drivegen.maps.build import NETWORK, build_map
from drivegen.store.files import write_json
from drivegen.store.folders import whole_folder
from drivegen.sumo.network import Network

METRICS, MAP = "metrics.json", "map"
"""Of a folder of generated scenarios: a row per sample, and the road that was drawn from words."""

LARGEST = 128
"""Vehicles in a scenario at most."""


def command(
    out: Annotated[Path, Option(help="New folder for <id>/ (official layout, recording) and metrics.json, a row per sample.")],
    scenario: Annotated[Path | None, Option(help="An Argoverse 2 scenario folder: regenerate the traffic of its log.")] = None,
    map: Annotated[Path | None, Option(help="A SUMO network (.net.xml): place vehicles on it and let them drive.")] = None,  # noqa: A002
    text: Annotated[str | None, Option(help="A road in words: draw it, place vehicles on it and let them drive.")] = None,
    samples: Annotated[int, Option(min=1, max=1000, help="Futures of the scenario.")] = 10,
    vehicles: Annotated[int, Option(min=1, max=LARGEST, help="Target and social vehicles together.")] = 16,
    seed: Annotated[int, Option(min=0, help="Same seed, same bytes.")] = 7,
) -> None:
    """Generate traffic for exactly one of --scenario, --map and --text, with the models that `make run` trained."""
    if sum(source is not None for source in (scenario, map, text)) != 1:
        raise BadParameter("give exactly one of --scenario, --map and --text")
    console = Console(stderr=True, soft_wrap=True, highlight=False, markup=False)
    with whole_folder(out) as folder, Progress(console=console, transient=True) as progress:
        task = progress.add_task("reading", total=None)
        start = _logged(scenario, vehicles) if scenario else _new(map, text, folder, vehicles, seed, console)
        progress.update(task, description=f"planning {samples} futures of {len(start.scenario.vehicles)} vehicles")
        settings = _project.generation(scored=start.scenario.log is not None)
        traffic = make(start, _project.equipment(settings), settings, samples, seed)
        for k in progress.track(range(samples), task_id=task, description="writing"):
            write_sample(traffic, k, folder)
        rows = [{**row(traffic, k), "seed": seed} for k in range(samples)]
        write_json(folder / METRICS, rows)
    console.print(f"{out}: {_summary(rows)}")


def _logged(folder: Path, vehicles: int) -> Start:
    """The first frame of the recording in `folder`, its vehicles chosen as for training."""
    if not folder.is_dir():
        raise UnusableInput(f"{folder} is no folder: give one that holds scenario_<id>.parquet and log_map_archive_<id>.json")
    log = read_folder(folder, "log in the Argoverse 2 layout")
    return from_log(log, _project.selection(vehicles))


def _new(net: Path | None, text: str | None, folder: Path, vehicles: int, seed: int, console: Console) -> Start:
    """Vehicles on the network `net`, or on the one that `text` describes, which is kept in `folder`."""
    if net is not None:
        if not net.is_file():
            raise UnusableInput(f"{net} is no file: give a SUMO network (.net.xml, also gzipped)")
        network, name, source = Network.read(net.read_bytes(), str(net)), net.name.split(".")[0], f"DriveGen ({net.name})"
    else:
        built = build_map(str(text), seed, folder=folder / MAP)
        if ignored := built.account["ignored"]:
            console.print(f"ignored: {'; '.join(ignored)}")
        network, name, source = Network.read(built.network, NETWORK), str(text), "DriveGen (map from words)"
    start = from_network(network, _as_id(name), source, _project.assets(), _project.initial(vehicles), seed)
    if start.left_out:
        reasons = ", ".join(f"{count} {reason}" for reason, count in start.left_out.items())
        console.print(f"not placed: {sum(start.left_out.values())} of {vehicles} vehicles ({reasons})")
    return start


def _as_id(name: str) -> str:
    """A name that can begin a scenario's id: of a file or of a road in words."""
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")[:40].strip("-") or "map"


def _summary(rows: list[dict[str, Any]]) -> str:
    """What was made, in one line."""
    written = [r for r in rows if not r["rejected"]]
    legal = sum(r["illegal"] == 0 for r in written)
    said = [f"{len(written)} scenarios of {rows[0]['vehicles']} vehicles ({rows[0]['source']})", f"{legal} legal throughout"]
    if len(written) < len(rows):
        said.append(f"not written for want of a legal target: {len(rows) - len(written)}")
    if dropped := sum(r["dropped"] for r in written):
        said.append(f"vehicles left out because nothing legal was found: {dropped}")
    if rows[0]["sade"] is not None:
        said.append("sADE " + f"min {min(r['sade'] for r in rows):.2f} m, mean {sum(r['sade'] for r in rows) / len(rows):.2f} m")
    return "; ".join(said)
