"""`drivegen generate`: traffic for a logged scene, a road network, or a road in words."""

import re
from collections import Counter
from contextlib import nullcontext
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

from rich.console import Console
from rich.progress import Progress
from typer import BadParameter, Exit, Option

from drivegen.asked import language_model
from drivegen.av2.folder import read_folder
from drivegen.cli import _project
from drivegen.cli._console import plain
from drivegen.cli._lm import MaxUsd, Words, announce, calling
from drivegen.cli._maps import name_of, network_of, sentences_of, with_way_in
from drivegen.core import seeds
from drivegen.core.errors import UnusableInput
from drivegen.core.wording import many
from drivegen.generators.base import Settings
from drivegen.lm.model import LanguageModel
from drivegen.lm.prices import MAP_TOKENS, TRAFFIC_TOKENS
from drivegen.maps.build import NETWORK, BuiltMap, build_map, build_spec
from drivegen.maps.writers.base import ROUNDS
from drivegen.placement.scenes import Initialiser
from drivegen.rollout.models import Equipment
from drivegen.store.files import write_json
from drivegen.store.folders import whole_folder
from drivegen.sumo.network import Network
from drivegen.traffic import Start, from_log, from_network, from_words, make, row, write_sample
from drivegen.words.read import Words as Description
from drivegen.words.read import read
from drivegen.words.request import TrafficRequest
from drivegen.words.traffic import request_sentences
from drivegen.words.writer import OFFLINE, Writer, asking_writer

METRICS, MAP, TRAFFIC = "metrics.json", "map", "traffic.json"
"""Of a folder of generated scenarios: a row per sample, the road that was drawn from words, the traffic that they asked for."""

_WRITER = "language_model"
"""The file in drivegen/maps/writers that asks a language model for the road."""

LARGEST = 128
"""Vehicles in a scenario at most."""


def command(
    out: Annotated[Path, Option(help="New folder for <id>/ (official layout, recording) and metrics.json, a row per sample.")],
    scenario: Annotated[Path | None, Option(help="An Argoverse 2 scenario folder: regenerate the traffic of its log.")] = None,
    map: Annotated[Path | None, Option(help="A map's folder or SUMO network: place vehicles on it and let them drive.")] = None,  # noqa: A002
    text: Annotated[str | None, Option(help="A road and its traffic in words; with --map, the traffic alone.")] = None,
    samples: Annotated[int, Option(min=1, max=1000, help="Futures of the scenario.")] = 10,
    vehicles: Annotated[int, Option(min=1, max=LARGEST, help="Target and social vehicles together.")] = 16,
    beset: Annotated[
        bool, Option("--beset", help="With --map: lanes beside, before, behind and across the target's way are taken.")
    ] = False,
    seed: Annotated[
        int, Option(min=0, max=seeds.LARGEST, help="Same seed, same bytes; of recordings (.rrd) the same content.")
    ] = 7,
    lm: Words = None,
    max_usd: MaxUsd = None,
) -> None:
    """Generate traffic for --scenario, --map or --text, or for --map as --text asks, with the models that `make run` trained.

    What was read of the words is said back, then for each thing that was asked for whether it was done. Exits 2 where a word is
    not read, 1 where nothing of what was asked for was done.
    """
    if (scenario is None) == (map is None and text is None):
        raise BadParameter("give exactly one of --scenario, --map and --text (--text may come with --map)")
    if lm is not None and text is None:
        raise BadParameter("--lm reads words: give --text")
    if beset and (map is None or text is not None):
        raise BadParameter("--beset places vehicles on a map: give --map, without --text")
    console = plain(stderr=True)
    model = calling("generate", "maps", lm, max_usd) if lm not in (None, OFFLINE) else nullcontext()
    with whole_folder(out) as folder, model as reader, _progress(console) as progress:
        task = progress.add_task("reading", total=None)
        settings = _project.generation(scored=scenario is not None)
        order = _Order(map, text, vehicles, beset, seed, reader)
        wishes = None if reader else _read_wishes(order, console)  # a language model is asked once all that it takes is there
        tools = _project.equipment(settings)
        start = _logged(scenario, vehicles) if scenario else _new(order, wishes, folder, tools, settings, console)
        progress.update(task, description=f"planning {samples} futures of {len(start.scenario.vehicles)} vehicles")
        traffic = make(start, tools, settings, samples, seed)
        for k in progress.track(range(samples), task_id=task, description="writing"):
            write_sample(traffic, k, folder)
        rows = [{**row(traffic, k), "seed": seed} for k in range(samples)]
        write_json(folder / METRICS, rows)
    for line in _done(rows):
        console.print(line)
    console.print(f"{out}: {_summary(rows)}")
    if (items := _items(rows)) and not any(item["got"] for item in items):
        raise Exit(1)


def _progress(console: Console) -> Progress:
    """Moves on a terminal; in a file it would be an empty line."""
    return Progress(console=console, transient=True, disable=not console.is_terminal)


def _logged(folder: Path, vehicles: int) -> Start:
    """The first frame of the recording in `folder`, its vehicles chosen as for training."""
    if not folder.is_dir():
        raise UnusableInput(f"{folder} is no folder: give one that holds scenario_<id>.parquet and log_map_archive_<id>.json")
    log = read_folder(folder, "log in the Argoverse 2 layout")
    return from_log(log, _project.selection(vehicles))


@dataclass(frozen=True)
class _Order:
    """New traffic: a network, words, or both; `reader` is the language model that reads the words, None for the rules."""

    net: Path | None
    text: str | None
    vehicles: int
    beset: bool
    seed: int
    reader: LanguageModel | None


def _new(
    order: _Order, read_before: "_Wishes | None", folder: Path, tools: Equipment, settings: Settings, console: Console
) -> Start:
    """Vehicles on a network: as the words ask for, on the road that they describe where no network is given."""
    wishes = read_before or _read_wishes(order, console)
    network, name, source = _road(order, wishes, folder, console)
    initial, seed = _project.initial(order.vehicles), order.seed
    table, gaps = _project.assets(), _project.gaps(initial)
    for sentence in request_sentences(wishes.request):
        console.print(f"reads: {sentence}")
    if not wishes.request:
        start = from_network(network, _as_id(name), source, table, initial, seed, gaps, order.beset)
    else:
        initialiser = Initialiser(network, _as_id(name), source, table, initial, gaps)
        start = from_words(initialiser, wishes.request, _project.asked_settings(), order.vehicles, tools, settings, seed)
        write_json(folder / TRAFFIC, _account(wishes, start))
    if start.left_out:
        reasons = ", ".join(f"{count} {reason}" for reason, count in start.left_out.items())
        console.print(f"not placed: {many(sum(start.left_out.values()), 'vehicle')} ({reasons})")
    return start


@dataclass(frozen=True)
class _Wishes:
    """What was read of the words: the traffic, by whom, and the road where no language model reads it."""

    request: TrafficRequest
    reader: str
    words: Description | None = None


def _read_wishes(order: _Order, console: Console) -> _Wishes:
    """Read the words of a request. Raises UnusableInput where they cannot be, or say nothing of what is wanted."""
    if order.text is None:
        return _Wishes(TrafficRequest(), "")
    if order.reader is not None:
        _announce(order.reader, order.text, road=order.net is None)
        reading = language_model.read(order.text, order.reader, order.seed)
        console.print(f"traffic read by: {reading.reader}")
        wishes = _Wishes(reading.request, reading.reader)
    else:
        words = read(order.text, order.seed)
        wishes = _Wishes(words.traffic, Writer.description, words)
        if order.net is not None and words.road is not None:
            alone = " ".join(request_sentences(words.traffic)) or "There is dense traffic."
            raise UnusableInput(f"a road is described, and --map names one\ntry: {alone}", reason="not-understood")
        if order.net is None and words.road is None:
            raise UnusableInput(
                f"no road is described: name one, or give --map\ntry: A road. {' '.join(words.sentences())}",
                reason="not-understood",
            )
    if order.net is not None and not wishes.request:
        raise UnusableInput(f"no traffic is described in {order.text!r}", reason="not-understood")
    return wishes


def _announce(reader: LanguageModel, text: str, *, road: bool) -> None:
    """What the questions will cost: of the traffic, and of the road where the words describe that too."""
    questions = [language_model.prompt(text), *(asking_writer(_WRITER, reader).first_questions([text] * road))]
    announce(reader, questions, (TRAFFIC_TOKENS + MAP_TOKENS * road) // len(questions), ROUNDS * road)


def _road(order: _Order, wishes: _Wishes, folder: Path, console: Console) -> tuple[Network, str, str]:
    """The network, its name and where it is from; a road that was drawn from words is kept in `folder`."""
    if order.net is not None:
        net = network_of(order.net)
        with with_way_in():
            return Network.read(net.read_bytes(), str(net)), name_of(net), f"DriveGen ({name_of(net)})"
    built = _build_road(order, wishes)
    built.save(folder / MAP)
    if order.reader is not None:
        console.print(f"road written by: {built.account['backend']}")
        if ignored := built.account["ignored"]:
            console.print(f"ignored: {'; '.join(ignored)}")
    for sentence in sentences_of(built.account):
        console.print(f"reads: {sentence}")
    return Network.read(built.network, NETWORK), str(order.text), "DriveGen (map from words)"


def _build_road(order: _Order, wishes: _Wishes) -> BuiltMap:
    """The road that the words describe."""
    if wishes.words is not None and wishes.words.road is not None:
        account: dict[str, Any] = {"text": order.text, "seed": order.seed, "backend": Writer.description, "ignored": []}
        return build_spec(wishes.words.road, {**account, "sentences": wishes.words.sentences()})
    return build_map(str(order.text), order.seed, asking_writer(_WRITER, order.reader))


def _account(wishes: _Wishes, start: Start) -> dict[str, Any]:
    """What was read of the words of traffic and by whom, and what was got of it at the first frame."""
    request = wishes.request.model_dump(mode="json", exclude_defaults=True)
    got = [asdict(item) for item in start.got]
    return {"reader": wishes.reader, "sentences": request_sentences(wishes.request), "request": request, "first_frame": got}


def _as_id(name: str) -> str:
    """A name that can begin a scenario's id: of a file or of a road in words."""
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")[:40].strip("-") or "map"


def _items(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Everything that the words asked for, in every scenario that was written."""
    return [item for r in rows if not r["rejected"] for item in r.get("asked", [])]


def _done(rows: list[dict[str, Any]]) -> list[str]:
    """For each thing that the words asked for, whether it was done: one line."""
    items = _items(rows)
    asked, got = Counter(item["what"] for item in items), Counter(item["what"] for item in items if item["got"])
    lines = []
    for what, count in asked.items():
        some = f" in {got[what]} of {count}" if 0 < got[what] < count else ""
        lines.append(f"{'done' if got[what] else 'not done'}{some}: {what}")
    return lines


def _summary(rows: list[dict[str, Any]]) -> str:
    """What was made, in one line."""
    written = [r for r in rows if not r["rejected"]]
    legal = sum(r["illegal"] == 0 for r in written)
    made = f"{many(len(written), 'scenario')} of {many(rows[0]['vehicles'], 'vehicle')}"
    parts = [f"{made} ({rows[0]['source']})", f"{legal} legal throughout"]
    if len(written) < len(rows):
        parts.append(f"not written for want of a legal target: {len(rows) - len(written)}")
    if dropped := sum(r["dropped"] for r in written):
        parts.append(f"vehicles left out because nothing legal was found: {dropped}")
    if rows[0]["sade"] is not None:
        parts.append("sADE " + f"min {min(r['sade'] for r in rows):.2f} m, mean {sum(r['sade'] for r in rows) / len(rows):.2f} m")
    return "; ".join(parts)
