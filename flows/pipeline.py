"""The one file that knows DVC: its graph, which stages are out of date, and how to run one of them.

DVC owns whether a stage runs (hashes, cache, lock), Prefect owns when: Prefect's own task cache stays off. A stage runs
in a process of its own, so its lines can be streamed and its crash hurts nobody. DVC lets independent stages run at
once but refuses, without waiting, a stage whose files another one holds: `reproduce` waits and asks again. For the
workspace's own lock, held for moments only, DVC itself is told to wait: who is refused it after a stage's work does it twice.
"""

import json
import logging
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import networkx as nx
import yaml
from dvc.exceptions import DvcException
from dvc.lock import LockError
from dvc.repo import Repo
from dvc.scm import SCMError

from flows import FlowFailed, attended
from flows.costs import forget_costs
from flows.mending import is_whole, mend, write_whole

MEASURES = "stages/dvc.yaml"
"""The stages that only measure us: `make tables` runs them, each part its own; `make run` and a plain `dvc repro` do not."""

_LOG = logging.getLogger("flows")
_BUSY = ("is busy", "Unable to acquire lock")
_RAN = "failed to run: "
_IN_USE = "another run has files in use, wait for it or end it"
_UNCHANGED, _RESTORED = "didn't change, skipping", "is cached - skipping run"
_HINTS = ("To track the changes with git", "git add ", "To enable auto staging", "Use `dvc push`", "dvc config core.autostage")
_TRIES = 60
"""How often to ask again for files that another stage holds, every few seconds. Not a time: a stage may have worked for long
before it was refused, and is then asked for what it has made."""


class StageFailed(FlowFailed):
    """A stage ended with an error; its last lines say why."""


@dataclass(frozen=True)
class Pipeline:
    """DVC's graph at one moment.

    Attributes:
        needs: each stage's direct predecessors; keys are in an order in which the stages can run.
        stale: stages that changed, or depend on one that did; DVC would skip all others.
    """

    needs: dict[str, list[str]]
    stale: frozenset[str]

    def upstream(self, stage: str) -> list[str]:
        """All stages that `stage` depends on, directly or not, in running order."""
        reached: set[str] = set()
        frontier = [stage]
        while frontier:
            for name in self.needs[frontier.pop()]:
                if name not in reached:
                    reached.add(name)
                    frontier.append(name)
        return [name for name in self.needs if name in reached]

    def up_to(self, stage: str) -> list[str]:
        """`stage` behind all stages that it depends on, in running order."""
        return [*self.upstream(stage), stage]


def read(root: Path = Path(), measures: bool = False) -> Pipeline:
    """Read dvc.yaml, and `MEASURES` if wanted, and compare them with the workspace: half a second when nothing changed.

    Raises FlowFailed where another run has files in use and goes on having them, and where DVC can't read what it has to.
    """
    with _repo(root) as repo:
        graph = repo.index.graph  # an edge (a, b) means that a depends on b
        order = [s for s in nx.topological_sort(graph.reverse(copy=True)) if measures or s.path_in_repo != MEASURES]
        needs = {_name(stage): sorted(_name(d) for d in graph.successors(stage)) for stage in order}
        changed = _status(repo)
        stale = {_name(stage) for stage in order if stage.addressing in changed}
    for stage, before in needs.items():
        if stale.intersection(before):
            stale.add(stage)
    return Pipeline(needs, frozenset(stale))


def _status(repo: Repo) -> Any:
    for _ in range(_TRIES):
        try:
            return repo.status()
        except LockError as error:
            busy = " ".join(str(error).split("\n\n")[0].split())
            time.sleep(0.5)
    raise FlowFailed(f"{_IN_USE}: {busy}")


def reproduce(stage: str, say: Callable[[str], None], root: Path = Path()) -> bool:
    """Run `dvc repro --single-item STAGE`, hand each line of output to `say`; True if it ran, False if DVC skipped it.

    What DVC brings back from an earlier run took what it took then, which is forgotten.
    Raises StageFailed when it ends with an error, and where another run has its files in use and goes on having them.
    """
    command = [sys.executable, "-m", "dvc", "--wait-for-lock", "repro", "--single-item", stage]
    for _ in range(_TRIES):
        code, lines = _run(command, root, say)
        if code == 0:
            if restored := any(_RESTORED in line for line in lines):
                forget_costs([stage], root)
            return not restored and not any(_UNCHANGED in line for line in lines)
        if not _was_refused(lines):
            raise StageFailed(f"stage {stage} failed: {_reason(lines)}")
        time.sleep(0.5)
    by = " ".join(line.strip() for line in lines if line.lstrip().startswith("(PID"))
    raise StageFailed(f"stage {stage} did not run: {_IN_USE}: {by or _reason(lines)}")


def run_door(stage: str, paths: list[Path], say: Callable[[str], None]) -> None:
    """Run a stage's door itself, for the one that is in no dvc.yaml: it pools the results of several workspaces.

    Raises StageFailed when it ends with an error.
    """
    code, lines = _run(["stages/run", stage, *map(str, paths)], Path(), say)
    if code:
        raise StageFailed(f"stage {stage} failed: {_reason(lines)}")


def checkout(paths: list[str], root: Path) -> None:
    """Put tracked files of dvc.lock back from the cache. Raises StageFailed if the cache lacks them."""
    done = subprocess.run(
        [sys.executable, "-m", "dvc", "checkout", "--quiet", *paths],
        cwd=root, env=_environment(), capture_output=True, text=True, check=False,
    )  # fmt: skip
    if done.returncode:
        raise StageFailed(f"cannot bring back {', '.join(paths)}: run `make run` first ({_reason(done.stderr.splitlines())})")


def restore(root: Path) -> None:
    """Put back whatever dvc.lock names and the cache has: what changed is then made again from there, the rest stands."""
    command = [sys.executable, "-m", "dvc", "checkout", "--quiet", "--force", "--allow-missing"]
    subprocess.run(command, cwd=root, env=_environment(), capture_output=True, check=False)


def discard(stages: Collection[str], root: Path, but: Collection[Path] = ()) -> None:
    """Remove what dvc.lock says that `stages` wrote: nothing of another run may be taken for this one's.

    What lies outside the workspace stays, and `but` these, with what holds them and what they hold.
    """
    entries, here = locked(root), root.absolute()
    for out in [out["path"] for stage in stages for out in entries.get(stage, {}).get("outs", ())]:
        path = Path(os.path.normpath(here / out))
        if here not in path.parents or any(_overlap(str(path), str(other)) for other in but):
            continue
        if path.is_dir():
            shutil.rmtree(path)
        path.unlink(missing_ok=True)


def forget_all_but(stages: Collection[str], root: Path) -> None:
    """Leave only `stages` in dvc.lock: DVC reads and writes all of it round every stage, two seconds where it has fifty."""
    entries = {name: entry for name, entry in locked(root).items() if name in stages and not name.startswith(MEASURES)}
    lock = yaml.dump({"schema": "2.0", "stages": entries}, None, yaml.CSafeDumper, sort_keys=False)
    write_whole(root / "dvc.lock", lock.encode())


def discard_gone(root: Path = Path()) -> list[str]:
    """Remove what dvc.yaml, with today's params.yaml, makes no more, what that took, and its entries in dvc.lock; returns names.

    DVC leaves them, so the report would show them on. Its cache keeps them: who names them again has them back at once. What
    another stage writes today, as after a stage got another name, stays.
    """
    with _repo(root) as repo, repo.lock:
        made = {_name(stage) for stage in repo.index.stages}
        gone = [name for name in locked(root) if name not in made and not name.startswith(MEASURES)]
        if gone:
            discard(gone, Path(repo.root_dir), {Path(out.fs_path) for stage in repo.index.stages for out in stage.outs})
            forget_costs(gone, root)
            forget_all_but(made, root)
    return gone


def outputs(stage: str, root: Path = Path()) -> list[str]:
    """The paths that `stage` writes, metrics and plots included."""
    with _repo(root) as repo:
        return [str(out.def_path) for out in _find(repo, stage).outs]


def inputs(stage: str, root: Path = Path()) -> list[str]:
    """The paths that `stage` reads and another stage writes."""
    with _repo(root) as repo:
        entry = _find(repo, stage)
        written = {out.fs_path: str(out.def_path) for other in repo.index.stages for out in other.outs}
        return [path for where, path in written.items() if any(_overlap(where, dep.fs_path) for dep in entry.deps)]


def metrics(stage: str) -> dict[str, Any]:
    """What the JSON files hold that `stage` writes, merged. Raises StageFailed where it writes none or they are missing."""
    with _repo(Path()) as repo:
        files = [Path(out.fs_path) for out in _find(repo, stage).outs if out.fs_path.endswith(".json")]
    merged: dict[str, Any] = {}
    for file in files:
        if not file.exists():
            raise StageFailed(f"stage {stage} has not written {file}")
        merged.update(json.loads(file.read_text()))
    if not merged:
        raise StageFailed(f"stage {stage} writes no JSON file, says dvc.yaml")
    return merged


def locked(root: Path) -> dict[str, Any]:
    """What dvc.lock, and that of `MEASURES`, say of each stage; nothing where there is none, or a broken one (`mending`)."""
    entries: dict[str, Any] = {}
    for lock, prefix in ((root / "dvc.lock", ""), ((root / MEASURES).with_suffix(".lock"), f"{MEASURES}:")):
        read = yaml.load(lock.read_text(), yaml.CSafeLoader) if lock.exists() and is_whole(lock.read_bytes()) else {}
        entries |= {f"{prefix}{name}": entry for name, entry in (read.get("stages") or {}).items()}
    return entries


@contextmanager
def _repo(root: Path) -> Iterator[Repo]:
    """The workspace as DVC sees it, mended, waiting for its lock: another run may be looking just now.

    Raises FlowFailed, with its words, for whatever DVC refuses.
    """
    try:
        with Repo(str(root), _wait_for_lock=True) as repo:
            with repo.lock:
                for sentence in mend(root, Path(repo.tmp_dir)):
                    _LOG.warning(sentence)
            yield repo
    except SCMError as error:
        raise FlowFailed(f"{error}, which DVC needs: clone DriveGen, or `git init` what was downloaded") from None
    except DvcException as error:
        words = f"{error}: {error.__cause__}" if error.__cause__ else str(error)
        raise FlowFailed(f"DVC: {' '.join(words.split())}") from None


def _find(repo: Repo, stage: str) -> Any:
    return next(s for s in repo.index.stages if _name(s) == stage)


def _name(stage: Any) -> str:
    """How `dvc repro` knows a stage in its workspace's folder, wherever we stand."""
    return str(stage.name) if stage.path_in_repo != MEASURES else f"{MEASURES}:{stage.name}"


def _overlap(one: str, other: str) -> bool:
    return Path(one).is_relative_to(other) or Path(other).is_relative_to(one)


def _run(command: list[str], root: Path, say: Callable[[str], None]) -> tuple[int, list[str]]:
    """Exit code and all lines of output, handed to `say` as they come. Raises StageFailed where the flow was stopped."""
    lines: list[str] = []
    output = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True, "errors": "replace"}
    try:
        with attended.work(command, cwd=root, env=_environment(), **output) as process:
            assert process.stdout is not None
            for line in process.stdout:
                lines.append(line.rstrip())
                if lines[-1] and not line.lstrip().startswith(_HINTS):
                    say(lines[-1])
            code = process.wait()
    except InterruptedError as error:
        raise StageFailed(str(error)) from None
    return code, lines


def _environment() -> dict[str, str]:
    """Our own environment, with this Python first on the path for stages that find no .venv above them."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    return {**os.environ, "PATH": path, "PYTHONUNBUFFERED": "1", "DVC_NO_ANALYTICS": "1"}


def _was_refused(lines: list[str]) -> bool:
    """Whether DVC says, in its own last error, that others hold what it needs; a stage may use the same words for its own."""
    error = next((line for line in reversed(lines) if line.startswith("ERROR: ")), "")
    return _RAN not in error and any(words in error for words in _BUSY)


def _reason(lines: list[str]) -> str:
    """The last words of a failed stage itself, which come before DVC's."""
    noise = ("ERROR: failed to reproduce", "Running stage", "> ", *_HINTS)
    words = [line for line in lines if line.strip() and not line.lstrip().startswith(noise)]
    return words[-1] if words else "it said nothing"
