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
from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.datasets.argoverse2_sensor import read_whole_log
from drivegen.ingest.selection import Settings, select
from drivegen.recording.record import record_scenario

EVERYTHING = Settings(target="focal", max_vehicles=128, first_step=0, horizon=10_000, map_radius=None, smallest_shrink=0.7)
"""All vehicles over the whole recording, on the whole map."""


def command(
    scenario: Annotated[Path, Argument(help="A scenario folder in Argoverse 2's layout, or the folder of a sensor log.")],
    out: Annotated[Path | None, Option(help="Write the recording here; else <folder>.rrd in the current folder.")] = None,
    show: Annotated[bool, Option(help="Open the viewer; without a screen only the file is written.")] = True,
) -> None:
    """Open the recording of SCENARIO; one that `drivegen generate` left there is taken, else it is made from the log."""
    console = Console()
    path = _recorded(scenario, out) or _record(scenario, out)
    if show and _has_screen():
        _open(path)
    else:
        said = shlex.join([_viewer() or "rerun", str(path)])
        console.print(f"{path}: look at it with `{said}`", soft_wrap=True, highlight=False, markup=False)


def _recorded(scenario: Path, out: Path | None) -> Path | None:
    """The recording that lies in the folder, unless another place is asked for."""
    if not scenario.is_dir():
        raise UnusableInput(f"{scenario} is no folder: give one that holds scenario_<id>.parquet and log_map_archive_<id>.json")
    found = sorted(scenario.glob("*.rrd"))
    return found[0] if found and out is None else None


def _record(scenario: Path, out: Path | None) -> Path:
    sensor = any(scenario.glob("annotations*.feather"))
    log = read_whole_log(scenario) if sensor else read_folder(scenario, f"log in {scenario.name}")
    path = out or Path(f"{scenario.resolve().name}.rrd")  # not the id in the file, which may be anything
    record_scenario(path, select(log, EVERYTHING))
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
    if subprocess.run([viewer, str(path)], check=False).returncode:
        served = shlex.join([viewer, "--serve-web", "--bind", "127.0.0.1", str(path)])
        raise MissingTool(f"{path} is written but the viewer cannot open a window: try `{served}`")
