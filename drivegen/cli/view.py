"""`drivegen view`: look at a scenario folder or a sensor log, recorded or generated, in the Rerun viewer."""

import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Annotated

from rich.console import Console
from typer import Argument, Option

from drivegen.av2.folder import read_folder
from drivegen.cli import _files
from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.wording import many
from drivegen.datasets.argoverse2_sensor import read_whole_log
from drivegen.ingest.selection import everybody
from drivegen.ingest.vehicles import PLANNED_KINDS
from drivegen.recording.record import record_scenario
from drivegen.store.lookup import find_sample, find_scenario, ids_in, traffic_files
from drivegen.store.samples import holds_samples

SHARDS = tuple(Path("data") / name for name in ("shipped", "scenarios/test", "scenarios/val", "scenarios/train"))
"""Where an id is looked for, in this order."""

GENERATED = Path("data/generated/drivegen")
"""Futures of test scenarios, where no other folder is named: `<id>-s03` is number 3."""

RECORDING = "recording.rrd"
"""What `drivegen corner` writes beside the scenario of each kind."""

_LISTED = 20

LOCAL = ("--bind", "127.0.0.1")
"""The viewer takes data from the network, too: from this machine alone."""


def command(
    scenario: Annotated[
        str, Argument(help="A scenario folder in Argoverse 2's layout, a sensor log's folder, an id of data/, or a recording.")
    ],
    out: Annotated[Path | None, Option(help="Write the recording here; else <folder>.rrd in the current folder.")] = None,
    futures: Annotated[
        Path, Option(help="Folder of the futures that `ID-s03` is one of, as data/corner/2/samples or data/attack/DRIVER/ATTACK.")
    ] = GENERATED,
    show: Annotated[bool, Option(help="Open the viewer; without a screen only the file is written.")] = True,
) -> None:
    """Open the recording of SCENARIO: the one that lies in its folder, else one made of its log.

    SCENARIO may be an id that a table or a query prints (`ID`, or `ID-s03` for a future of it); a folder of scenarios lists them.
    """
    console = Console()
    folder = Path(scenario)
    if folder.is_file() and folder.suffix == ".rrd":
        if out is not None:
            raise UnusableInput(f"{folder} is a recording already, and --out is for new ones: leave that out")
        path = folder
    elif folder.is_file():
        raise UnusableInput(f"{folder} is a file and no recording (.rrd): give one or a folder, of which all is listed")
    elif not folder.is_dir():
        path = _record_id(scenario, out, futures)
    else:
        folder = _chosen(folder, out)
        path = _recorded(folder, out) or _record(folder, out, console)
    if not _files.RECORDING.holds(path):
        raise UnusableInput(f"{path} is no recording, or was cut off: give a scenario's folder, or make it again")
    if show and _has_screen():
        _open(path)
    else:
        line = shlex.join([_viewer() or "rerun", *LOCAL, str(path)])
        console.print(f"{path}: look at it with `{line}`", soft_wrap=True, highlight=False, markup=False)


def _chosen(folder: Path, out: Path | None) -> Path:
    """The folder itself, or the only scenario or kind of corner cases in it; raises UnusableInput that lists them where there
    are several, or shards of them.
    """
    scenes = sorted({file.parent for name in ("scenario_*.parquet", RECORDING) for file in folder.glob(f"*/{name}")})
    if any(folder.glob("scenario_*.parquet")) or (out is None and (folder / RECORDING).is_file()):
        return folder
    if len(scenes) == 1:
        return _chosen(scenes[0], out)
    words = [shlex.quote(str(scene)) for scene in scenes] or _words_for_shards(folder)
    if not words:
        return folder
    names = "".join(f"\n  drivegen view {one}" for one in words[:_LISTED])
    more = f"\n  and {len(words) - _LISTED} more" if len(words) > _LISTED else ""
    raise UnusableInput(f"{folder} holds {many(len(words), 'scenario')}, view one of them:{names}{more}")


def _words_for_shards(folder: Path) -> list[str]:
    """What views each scenario of a folder of shards, a round of corner cases or an attack, or its first future; raises
    UnusableInput where no id leads into it.
    """
    files = traffic_files(folder)
    futures = bool(files) and holds_samples(files[0])
    if files and not futures and files[0].parent.resolve() not in [known.resolve() for known in SHARDS]:
        raise UnusableInput(f"{folder} holds shards: `drivegen export` makes folders of them, which can be viewed")
    number = f"-s00 --futures {shlex.quote(str(files[0].parent))}" if futures else ""
    return [shlex.quote(name) + number for file in files for name in ids_in(file)]


def _record_id(scenario_id: str, out: Path | None, futures: Path) -> Path:
    """The recording of a scenario of the pipeline's shards, or of a future of one."""
    path = out or Path(f"{Path(scenario_id.replace(':', '-')).name}.rrd")
    _files.expect_own(path, _files.RECORDING)
    if futures != GENERATED and not futures.is_dir():
        raise UnusableInput(f"{futures} is no folder: --futures names that of the futures, as data/corner/2/samples")
    if (place := find_scenario(scenario_id, SHARDS)) is not None:
        record_scenario(path, place[1], log_name="generated" if "motion" in place[1].notes else "logged")
    elif (future := find_sample(scenario_id, SHARDS, futures)) is not None:
        record_scenario(path, *future)
    else:
        raise UnusableInput(_why_not(scenario_id, futures))
    return path


def _why_not(word: str, futures: Path) -> str:
    """Why there is nothing of that name to be viewed."""
    if word.endswith(".rrd"):
        return f"{word} is not there: give a recording that is, or a scenario's folder or id"
    of, dash, number = word.rpartition("-s")
    if dash and number.isdecimal() and find_scenario(of, SHARDS) is not None:
        lists = f"has no number {number} of {of}, `drivegen view {futures}` lists what it has"
        what = lists if futures.is_dir() else "is not there"
        return f"{word} is a future, and {futures} {what}: name the folder of its futures with --futures"
    places = ", ".join(map(str, SHARDS))
    return f"{word} is no folder, and no scenario in {places}: give a scenario's folder or, in the project's, its id"


def _recorded(scenario: Path, out: Path | None) -> Path | None:
    """The recording that lies in the folder, unless another place is asked for; raises UnusableInput where there are several."""
    recordings = sorted(scenario.glob("*.rrd")) if out is None else []
    if len(recordings) > 1:
        names = "".join(f"\n  drivegen view {shlex.quote(str(one))}" for one in recordings[:_LISTED])
        more = f"\n  and {len(recordings) - _LISTED} more" if len(recordings) > _LISTED else ""
        raise UnusableInput(f"{scenario} holds {len(recordings)} recordings, view one of them:{names}{more}")
    return recordings[0] if recordings else None


def _record(scenario: Path, out: Path | None, console: Console) -> Path:
    """The recording of a log: all vehicles over all of it, on the whole map; says how many, and who is the target."""
    sensor = any(scenario.glob("annotations*.feather"))
    if not sensor and not any(scenario.glob("scenario_*.parquet")):
        raise UnusableInput(f"{scenario} holds neither a scenario nor a sensor log nor a recording: give the folder of one")
    log = read_whole_log(scenario) if sensor else read_folder(scenario, f"log in {scenario.name}")
    path = out or Path(f"{scenario.resolve().name}.rrd")  # not the id in the file, which may be anything
    _files.expect_own(path, _files.RECORDING)
    shown = everybody(log, 1 if sensor else 0)  # velocities of a sensor log come from the frames before
    record_scenario(path, shown, log_name="recorded")
    count = many(sum(kind in PLANNED_KINDS for kind in log.kind), "vehicle")
    notes = "".join(f"; {name}: {note}" for name, note in shown.notes.items())
    console.print(f"{len(shown.vehicles)} of {count}{notes}", soft_wrap=True, highlight=False, markup=False)
    return path


def _has_screen() -> bool:
    return sys.platform in ("darwin", "win32") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _viewer() -> str | None:
    """Where Rerun's viewer is: beside this Python, or on the path."""
    return shutil.which("rerun", path=os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")]))


def _open(path: Path) -> None:
    viewer = _viewer()
    if viewer is None:
        raise MissingTool(f"{path} is written but the viewer is not installed: pip install rerun-sdk==0.41.0")
    if subprocess.run([viewer, *LOCAL, str(path)], check=False).returncode:
        served = shlex.join([viewer, "--serve-web", *LOCAL, str(path)])
        raise MissingTool(f"{path} is written but the viewer cannot open a window: try `{served}`")
