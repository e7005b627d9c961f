"""`drivegen map`: a road network from words or from a file, edited in words, written for others."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

from typer import Argument, BadParameter, Option, Typer
from typer.core import TyperGroup

from drivegen.cli import _files
from drivegen.cli._console import plain
from drivegen.cli._lm import MaxUsd, Words, announce, calling
from drivegen.cli._maps import MapMode, Mode, network_of, sentences_of, with_way_in, writer_of
from drivegen.core.errors import UnusableInput
from drivegen.core.seeds import LARGEST
from drivegen.core.wording import many
from drivegen.lm.prices import MAP_TOKENS
from drivegen.maps.build import ACCOUNT, NETWORK, PICTURE, BuiltMap, build_map
from drivegen.maps.imports import Window, import_map
from drivegen.maps.opendrive import Extent, export_opendrive, keeps_left, losses, read_back
from drivegen.maps.refine import refine_map
from drivegen.maps.writers.base import ROUNDS
from drivegen.store.files import write_bytes
from drivegen.sumo.network import Network
from drivegen.words.edits import edited
from drivegen.words.writer import OFFLINE, Writer, asking_writer

WORDS, WINDOW_RADIUS = "words", 150.0
_FILES = f"{NETWORK} (SUMO), {ACCOUNT} (understood, ignored) and {PICTURE}"

Force = Annotated[bool, Option("--force", help="Replace the map that lies in the folder, its history with it.")]
"""The option `--force`."""


class Form(StrEnum):
    """What a map can be written as."""

    SUMO = "sumo"
    OPENDRIVE = "opendrive"


class DescriptionUnlessCommand(TyperGroup):
    """`drivegen map "TEXT"` is short for `drivegen map words "TEXT"`: what is no command is a description."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Put the command in front where it was left out."""
        if args and args[0] not in {*self.commands, "--help", "-h"}:
            args = [WORDS, *args]
        return super().parse_args(ctx, args)


command = Typer(cls=DescriptionUnlessCommand, no_args_is_help=True, rich_markup_mode=None)


@command.callback()
def about() -> None:
    """Road networks: `drivegen map "TEXT" --out DIR` draws the road that TEXT describes."""


@command.command(WORDS)
def words(
    text: Annotated[str, Argument(help='The road in words, e.g. "four-way crossing with signals, two lanes each way, 50 km/h".')],
    out: Annotated[Path, Option(help=f"Folder for {_FILES}.")],
    seed: Annotated[int, Option(min=0, max=LARGEST, help="What the words leave open is drawn from it.")] = 7,
    lm: Words = None,
    map_mode: MapMode = Mode.SPECIFICATION,
    max_usd: MaxUsd = None,
    force: Force = False,
) -> None:
    """Draw the road that TEXT describes, and say back what was read, defaults included. Exits 2 where a word of TEXT is not read;
    the last line is then a sentence to try.

    The word `words` can be left out. Lanes: 'N lanes in each direction' is always right. 'N lanes' are in each direction, 'a
    four-lane road' has four in both directions together. On motorways, one-way roads, ramps, forks and rings every number of
    lanes is that of one carriageway. Turn lanes are counted on each road into a junction.
    """
    _check_free(out, force=force)
    account = _build(text, seed, out, lm, map_mode, max_usd).account
    _tell("written by", account["backend"])
    _tell("reads", *sentences_of(account))
    _tell("understood", *(f"{reading['phrase']}: {reading['meaning']}" for reading in account["understood"]))
    for word in ("assumed", "ignored", "failed"):
        _tell(word, *filter(None, ["; ".join(map(str, account[word]))]))
    _tell_written(out)


@command.command("import")
def bring(
    file: Annotated[Path, Argument(help="A SUMO network (also gzipped), OpenStreetMap, OpenDRIVE, an Argoverse 2 map or log.")],
    out: Annotated[Path, Option(help=f"Folder for {_FILES}.")],
    around: Annotated[str | None, Option(metavar="X,Y", help="Cut a window around this place [m, the network's frame].")] = None,
    radius: Annotated[
        float | None,
        Option(
            help=f"Metres to each side ({WINDOW_RADIUS:g} if only a place is given); alone: around the largest junction."
            " Roads that reach into the window stay whole."
        ),
    ] = None,
    junction: Annotated[str | None, Option(metavar="ID", help="Cut a window around this junction.")] = None,
    force: Force = False,
) -> None:
    """Take a road network from a file, whole or a window of it."""
    _check_free(out, force=force)
    window = _window(around, radius, junction)
    file = _map_of(file) if file.is_dir() else file
    if not file.is_file():
        raise UnusableInput(f"{file} is no file: give a SUMO network, OpenStreetMap, OpenDRIVE or Argoverse 2 map")
    built = import_map(file.read_bytes(), str(file), window)
    built.save(out)
    _tell("read", f"{built.account['source']}: {_counts(built)}; {Extent.of(built.road_map)}")
    _tell("assumed", *built.account["assumed"])
    _tell_written(out)


@command.command()
def refine(
    folder: Annotated[Path, Argument(metavar="DIR", help="A folder that `drivegen map` made from words.")],
    text: Annotated[str, Argument(help='The edit, e.g. "add a lane" or "make it a roundabout".')],
) -> None:
    """Edit a map in words, in place, and say back what it is; map.json keeps the history. Exits 2 with an edit to try, and
    changes nothing, where a word of it is not read.
    """
    built = refine_map(folder, text, edited)
    built.save(folder)
    _tell("reads", *sentences_of(built.account))
    _tell("failed", *built.account["failed"])
    _tell_written(folder)


@command.command()
def export(
    folder: Annotated[Path, Argument(metavar="DIR", help=f"A folder that holds {NETWORK}, or a SUMO network.")],
    to: Annotated[Form, Option(help="sumo: the network as it is; opendrive: .xodr.")],
    out: Annotated[Path, Option(help="The file to write.")],
) -> None:
    """Write a map for other programs. OpenDRIVE is read back, and what was written and what came back stand beside each other."""
    source = network_of(folder)
    if _files.lies_in(out, folder):
        raise UnusableInput(f"{out} would lie in the map that is read: name a place beside {folder}")
    _files.expect_own(out, _files.NETWORK if to is Form.SUMO else _files.OPENDRIVE)
    network = source.read_bytes()
    with with_way_in():
        before = Network.read(network, str(source))
    written = network if to is Form.SUMO else export_opendrive(network)
    write_bytes(out, written)
    if to is Form.OPENDRIVE:
        after = read_back(written, str(out))
        there, back = Extent.of(before.map), Extent.of(after.map)
        _tell("written", f"{out}: {there}")
        _tell("read back", f"{'the same lanes and ways' if back.holds(there) else 'not the same'}: {back}")
        _tell("lost", *losses(before, after))
        if keeps_left(network):
            _tell("lost", "left-hand traffic: who reads the file takes its roads for right-hand ones")
    else:
        _tell("written", str(out))


def _check_free(folder: Path, *, force: bool) -> None:
    """Raises UnusableInput where nothing can be written in `folder`, or a map lies there: it may have been edited, and its words
    cannot be had back.
    """
    _files.expect_writable(folder / NETWORK)
    if not force and any((folder / name).exists() for name in (NETWORK, ACCOUNT, PICTURE)):
        raise UnusableInput(f"{folder} holds a map already: name another folder, or replace that map with --force")


def _build(text: str, seed: int, out: Path, lm: str | None, mode: Mode, max_usd: float | None) -> BuiltMap:
    if lm in (None, OFFLINE):
        return build_map(text, seed, Writer(), out)
    with calling("map", "maps", str(lm), max_usd) as model:
        writer = asking_writer(writer_of(mode), model)
        announce(model, writer.first_questions([text]), MAP_TOKENS, ROUNDS)
        return build_map(text, seed, writer, out)


def _map_of(folder: Path) -> Path:
    """The map of an Argoverse 2 log: beside the tracks of a scenario, in `map/` of a sensor log."""
    files = [*folder.glob("log_map_archive_*.json"), *folder.glob("map/log_map_archive_*.json")]
    if len(files) != 1:
        raise UnusableInput(f"{folder} holds {len(files)} files log_map_archive_<id>.json: give a map's file, or a log's folder")
    return files[0]


def _window(around: str | None, radius: float | None, junction: str | None) -> Window | None:
    if around is not None and junction is not None:
        raise BadParameter("give one of --around and --junction")
    if around is None and junction is None and radius is None:
        return None
    return Window(WINDOW_RADIUS if radius is None else radius, None if around is None else _place(around), junction)


def _place(around: str) -> tuple[float, float]:
    try:
        x, y = (float(number) for number in around.split(","))
    except ValueError:
        raise BadParameter(f"--around takes two numbers X,Y, not {around!r}") from None
    return x, y


def _counts(built: BuiltMap) -> str:
    road = built.structure
    places = f"{many(road.edges, 'edge')}, {many(road.junctions, 'junction')} ({road.signals} with signals)"
    return f"{places}, {road.size:.0f} m across"


def _tell_written(folder: Path) -> None:
    _tell("written", ", ".join(str(folder / name) for name in (NETWORK, ACCOUNT, PICTURE)))


def _tell(word: str, *sentences: Any) -> None:
    """One line a sentence, none without."""
    console = plain()
    for sentence in sentences:
        console.print(f"{word:10}  {sentence}")
