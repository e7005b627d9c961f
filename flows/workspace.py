"""A second workspace beside this one: the same tree, the same DVC cache, parameters of its own.

What runs there cannot disturb this workspace or its dvc.lock, and nothing that this one has computed is computed again.
"""

import copy
import fcntl
import shutil
import subprocess
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import yaml

from flows import FlowFailed
from flows.mending import write_whole

PARAMS = ("params.yaml", "stages/params.yaml")
"""What one would change of the pipeline, and of the stages that only measure us."""

LIKE = "like"
"""Beside this name stands the section whose values hold where no others are said: one more may be said."""

CHECKPOINTS = Path(".drivegen/checkpoints")
"""Where trainings keep what they go on from after they were interrupted."""

ANSWERS, CALLS = "lm_store", ".drivegen/calls"
"""Folders of language models' answers, where parameters name no other, and of rows of what they cost."""

_LOCKS = Path(".drivegen/locks")


@contextmanager
def alone(what: str) -> Iterator[None]:
    """Nobody else does `what` in this folder meanwhile: workspaces are deleted first. Raises FlowFailed where somebody does.

    The lock is the system's, so who is killed holds it no more.
    """
    _LOCKS.mkdir(parents=True, exist_ok=True)
    with (_LOCKS / what).open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise FlowFailed(f"another run is at work on {what} in this folder: wait for it or end it") from None
        yield


def duplicate(source: Path, target: Path, params: Mapping[str, Any], cache: Path | None = None) -> None:
    """Copy the files that git knows or does not ignore to the new folder `target`, with `params` over those of `PARAMS`,
    and what has been compiled of them.

    DVC keeps its files in `cache`, by default that of `source`. Raises FileExistsError if `target` exists, FlowFailed for a
    parameter that there is not and where git knows no files.
    """
    target.mkdir(parents=True)
    for name in _files(source):
        there = target / name
        there.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(source / name, there)
    share_compiled(source, target)
    override(target, params)
    folder = (cache or source / ".dvc" / "cache").resolve()
    (target / ".dvc" / "config.local").write_text(f"[core]\n    no_scm = true\n[cache]\n    dir = {folder}\n")


def renew(source: Path, target: Path, params: Mapping[str, Any]) -> None:
    """As `duplicate`, where the folder `target` may exist: of that remain the checkpoints of trainings that were interrupted,
    and what was paid for, in `source` (`bring_home`).

    Checkpoints are named after everything that a training depends on, so one that would be another is never gone on with.
    """
    bring_home(target, source)
    interrupted, aside = target / CHECKPOINTS, target.with_name(f"{target.name}.checkpoints")
    if interrupted.is_dir():
        shutil.rmtree(aside, ignore_errors=True)
        interrupted.rename(aside)
    shutil.rmtree(target, ignore_errors=True)
    duplicate(source, target, params)
    if aside.is_dir():
        interrupted.parent.mkdir(parents=True, exist_ok=True)
        aside.rename(interrupted)


def bring_home(room: Path, source: Path) -> None:
    """Copy to `source` what was paid for in its workspace `room`, which will be deleted: what is missing there, or older.

    To be called when a run ends and, for one that was killed, before its workspace is made anew.
    """
    for file in _paid(room):
        home = source / file.relative_to(room)
        if not home.exists() or home.stat().st_mtime < file.stat().st_mtime:
            home.parent.mkdir(parents=True, exist_ok=True)
            write_whole(home, file.read_bytes())


def _paid(room: Path) -> Iterator[Path]:
    """Answers in the folder that the workspace's parameters name, unless it is elsewhere, and rows of calls.

    Rows of replays have no number and were not paid for.
    """
    params = read_yaml(room / PARAMS[0]) if (room / PARAMS[0]).exists() else {}
    answers = Path(params.get("lm", {}).get("records", {}).get("folder", ANSWERS))
    if not answers.is_absolute() and ".." not in answers.parts:
        yield from (room / answers).glob("*/*.json")
    yield from (room / CALLS).glob(f"*-{'[0-9a-f]' * 12}.parquet")


def share_compiled(source: Path, target: Path) -> None:
    """Copy what Python and Numba have compiled in `source` to the same folders of `target`.

    Python compares each file with its code, and `import drivegen` all that Numba has compiled with all code, before it is used.
    Compiling all anew takes a workspace about a minute.
    """
    for folder in sorted({file.parent.relative_to(target) for file in target.rglob("*.py")}):
        compiled = source / folder / "__pycache__"
        if compiled.is_dir():
            shutil.copytree(compiled, target / folder / "__pycache__", dirs_exist_ok=True)


def override(root: Path, params: Mapping[str, Any]) -> None:
    """Write `params` over those of the workspace `root`, each into the file that has its section."""
    left = dict(params)
    for file in [root / name for name in PARAMS if (root / name).exists()]:
        values = read_yaml(file)
        own = {name: left.pop(name) for name in params if name.split(".")[0] in values}
        file.write_text(yaml.safe_dump(overridden(values, own), sort_keys=False))
    if left:
        raise FlowFailed(f"{' and '.join(PARAMS)} have no section for {min(left)!r}")


def read_yaml(file: Path) -> dict[str, Any]:
    """The names and values of a YAML file. Raises FlowFailed where it is none, or holds no names."""
    try:
        values: Any = yaml.safe_load(file.read_text())
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise FlowFailed(f"{file} is not YAML: {' '.join(str(error).split())}") from None
    if not isinstance(values, dict):
        raise FlowFailed(f"{file} holds no names with values")
    return values


def overridden(values: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """`values` with some replaced whole, named by dotted paths as in `dvc exp run -S`.

    >>> overridden({"run": {"seed": 7, "workers": 2}}, {"run.seed": 8})
    {'run': {'seed': 8, 'workers': 2}}

    Raises FlowFailed for a name that `values` does not have.
    """
    result = copy.deepcopy(dict(values))
    for name, value in over.items():
        *sections, last = name.split(".")
        unknown = FlowFailed(f"the parameters have no {name!r} to replace")
        place: Any = result
        free = False
        for word in sections:
            place = place.setdefault(word, {}) if free else place.get(word)
            if not isinstance(place, dict):
                raise unknown
            free |= LIKE in place
        if last not in place and not free:
            raise unknown
        place[last] = value
    return result


def _files(source: Path) -> list[str]:
    """Tracked files, and new ones that nothing ignores; those deleted but still tracked are left out."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=source, capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    if listed.returncode:
        raise FlowFailed(f"git does not know the files of {source.resolve()}: {' '.join(listed.stderr.split())}")
    return [name for name in sorted(set(listed.stdout.split("\0"))) if name and (source / name).is_file()]
