"""Tasks on the workers of a Dask cluster, where `run.cluster` of params.yaml has the address of its scheduler (docs/cluster.md).

Files are read and written where the task is, at the paths that it names: a worker must work in the project's folder, mounted
there as here, and have the same code and packages. Each task is checked for that on its worker, before it begins.
"""

import hashlib
import platform
import re
import socket
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar
from uuid import uuid4

from drivegen.core.cpu import cpu_seconds
from drivegen.core.errors import MissingTool

Task = TypeVar("Task")
Result = TypeVar("Result")

MARKS = Path(".drivegen/cluster")
"""Where a run leaves a file, by which its workers know the project's folder."""

USED = {"cpu_seconds": 0.0}
"""What tasks of this process took on the cluster."""

_PATIENCE = 60.0
"""So many seconds a run waits for the first worker."""


@dataclass(frozen=True)
class Run:
    """What a worker must have as the run has it: the file `mark` in its folder, the code, the packages by name."""

    mark: Path
    code: str
    packages: dict[str, str]


def on_cluster(
    address: str, work: Callable[[Task], Result], tasks: Sequence[Task], what: str, ahead: int
) -> Iterator[tuple[int, Result]]:
    """The number and the result of each task, in the order in which they are done. Tasks of a worker that dies go to another.

    So many tasks a thread are begun `ahead` of the first that is not done: results that wait for it must not fill the memory.

    Raises MissingTool where no cluster is at `address`, where it goes away, where a worker has not what this run has, or where
    several died of one task; and what `work` raises.
    """
    with _marked() as mark, _connected(address, what) as client:
        from distributed import as_completed

        run, most = Run(mark, code(), packages()), ahead * max(1, sum(client.nthreads().values()))
        futures, numbers, done, due = as_completed(), dict[Any, int](), set[int](), 0
        upcoming = iter(enumerate(tasks))
        while due < len(tasks):
            for number, task in islice(upcoming, most - len(numbers) - len(done)):
                future = client.submit(_checked, work, task, run, pure=False)
                numbers[future] = number
                futures.add(future)
            future = next(futures)
            result, seconds = _result(future, address, what)
            USED["cpu_seconds"] += seconds
            done.add(number := numbers.pop(future))
            while due in done:
                done.remove(due)
                due += 1
            yield number, result


@contextmanager
def _marked() -> Iterator[Path]:
    mark = MARKS / uuid4().hex
    mark.parent.mkdir(parents=True, exist_ok=True)
    mark.touch()
    try:
        yield mark
    finally:
        mark.unlink(missing_ok=True)


@contextmanager
def _connected(address: str, what: str) -> Iterator[Any]:
    """A client of the scheduler, as soon as that has a worker."""
    try:
        from distributed import Client
    except ImportError:
        raise MissingTool(f"{what}: run.cluster needs Dask: .venv/bin/pip install -c constraints.txt -e '.[cluster]'") from None
    try:
        client = Client(address, timeout=_PATIENCE)
    except (OSError, ValueError, TypeError, RuntimeError) as error:  # the last three: an address, keys, no encryption
        raise MissingTool(f"{what}: no Dask scheduler answers at {address} (run.cluster of params.yaml): {error}") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=_PATIENCE)
        except TimeoutError:
            raise MissingTool(f"{what}: {address} has no worker after {_PATIENCE:g} s: start some (docs/cluster.md)") from None
        yield client


def _result(future: Any, address: str, what: str) -> Any:
    from distributed import KilledWorker

    try:
        return future.result()
    except KilledWorker:
        raise MissingTool(f"{what}: several workers died of the same task, most likely because memory ran out") from None
    except CancelledError:
        raise MissingTool(f"{what}: the Dask scheduler at {address} went away; what is done is kept") from None
    except ImportError as error:
        raise MissingTool(f"{what}: a worker can't load the code ({error}): install the project's .venv there, too") from None


def _checked(work: Callable[[Task], Result], task: Task, run: Run) -> tuple[Result, float]:
    """On the worker: the result and the processor's seconds; raises MissingTool unless the worker has what the run has."""
    from distributed import get_worker

    worker = get_worker()
    if fault := _fault(run, worker.state.nthreads):
        raise MissingTool(f"the worker {worker.address} on {socket.gethostname()} {fault}")
    began = cpu_seconds()
    return work(task), cpu_seconds() - began


def _fault(run: Run, threads: int) -> str:
    """Why a worker of so many threads would not do what the run's own process does; empty if it would."""
    if threads != 1:
        return f"has {threads} threads: start it with --nthreads 1, for SUMO's library runs one simulation in a process"
    if not run.mark.exists():
        return f"works in {Path.cwd()}, which is not the project's folder (it has no {run.mark}): start it in that, shared by all"
    if code() != run.code:
        return "has other code of DriveGen than this run: bring it to the same state, then start the worker again"
    theirs = packages()
    for name in sorted(run.packages):
        if theirs.get(name) != run.packages[name]:
            return f"has {name} {theirs.get(name)}, this run {run.packages[name]}: install what constraints.txt says on both"
    return ""


@cache
def code() -> str:
    """Hex digest of the sources of `drivegen` and `stages`, read once: what a worker has loaded does not change with them."""
    total, stages = hashlib.sha256(), Path(__file__).parents[1]
    for root in (stages, stages.parent / "drivegen"):
        for path in sorted(path for path in root.rglob("*") if path.is_file() and "__pycache__" not in path.parts):
            total.update(f"{path.relative_to(root.parent)} {hashlib.sha256(path.read_bytes()).hexdigest()}\n".encode())
    return total.hexdigest()


@cache
def packages() -> dict[str, str]:
    """The versions of Python and of what DriveGen is declared to need."""
    requirements = [line for line in metadata.requires("drivegen") or [] if "extra ==" not in line]
    names = [name[0] for line in requirements if (name := re.match(r"[\w.-]+", line))]
    return {"Python": platform.python_version(), **{name: metadata.version(name) for name in names}}
