"""What every stage does at its door: strict parameters, one sentence for an error, processes, progress.

@dataclass(frozen=True)
class Params:
    seed: int
    horizon: int

def main(params: Params, scenarios: Path, out: Path) -> None: ...

is all of a stage: `stages/run WORD PATH...` reads the section WORD of params.yaml, or what the file calls SECTION, and calls it.
"""

import errno
import importlib
import importlib.util
import inspect
import multiprocessing
import os
import resource
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any, TypeVar

from drivegen.core.cpu import cpu_seconds
from drivegen.core.errors import DriveGenError, MissingTool, UnusableInput
from drivegen.core.settings import SHARED
from drivegen.core.settings import build as build
from drivegen.core.settings import read_params as read_params
from drivegen.core.settings import read_section as read_section
from drivegen.store.columns import Columns, Table
from drivegen.store.costs import write_cost
from stages._door.cluster import USED, on_cluster

Task = TypeVar("Task")
Result = TypeVar("Result")
Learnt = TypeVar("Learnt", bound=Table)

COST_FOLDER = Path(".drivegen/costs")
"""Where times are kept: they differ from run to run, so no stage's output holds any."""


SCRATCH = Path(".drivegen/scratch")
"""Where files without a name lie that trainings learn from; empty to look at, and once nobody trains."""

AHEAD = 8
"""Tasks of each process that may be begun before the result of the first of them is taken."""


def enter(word: str, *argv: str) -> None:
    """Run stages/WORD.py with its section of params.yaml and these paths; exit 0, 1 or 2 as `drivegen` does.

    What it took goes to the cost table, beside the counts that `main` may return (such as {"scenarios": 120}); the last
    path names the item (method, driver, ...).
    """
    paths = [Path(place) for place in argv]
    began = time.perf_counter()
    try:
        stage = _stage(word)
        section = getattr(stage, "SECTION", word)
        _expect_paths(stage.main, len(paths))
        counts = stage.main(read_params(section, stage.Params), *paths) or {}
        write_cost(COST_FOLDER, section, paths[-1].stem if paths else "", {**counts, **_taken(began)})
    except DriveGenError as error:
        print(f"{word}: {error}", file=sys.stderr)
        sys.exit(error.exit_code)
    except MemoryError as error:
        print(f"{word}: there is not enough memory for that ({error}): ask for less (params.yaml)", file=sys.stderr)
        sys.exit(1)
    except OSError as error:
        print(f"{word}: {_what_failed(error)}; nothing half-written was kept", file=sys.stderr)
        sys.exit(1)


def _stage(word: str) -> Any:
    """The module stages/WORD.py; raises UnusableInput where there is none."""
    name = f"stages.{word}"
    if word.startswith("_") or not (word.isidentifier() and importlib.util.find_spec(name)):
        raise UnusableInput("there is no such stage: `stages/run WORD PATH...`, where WORD is a file of stages/")
    return importlib.import_module(name)


def _what_failed(error: OSError) -> str:
    """Which file and why, in one line. pyarrow leaves `filename` empty: its text names the file, or is only its name."""
    text = error.strerror or (str(error.args[0]) if error.args else type(error).__name__)
    if isinstance(error, FileNotFoundError) and not error.strerror:
        text = f"{text}: {os.strerror(errno.ENOENT)}"
    return " ".join((f"{error.filename}: {text}" if error.filename else text).split())


def _expect_paths(main: Callable[..., object], count: int) -> None:
    """Raise UnusableInput unless `main` takes its parameters and so many paths: `dvc repro` gives them, a person may not."""
    expected = list(inspect.signature(main).parameters.values())[1:]
    if count != len(expected) and all(path.kind is not path.VAR_POSITIONAL for path in expected):
        names = ", ".join(path.name for path in expected)
        raise UnusableInput(f"takes {len(expected)} paths ({names}), {count} are given; `dvc repro` knows them (dvc.yaml)")


def _taken(began: float) -> dict[str, float]:
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return {
        "cpu_seconds": cpu_seconds() + USED["cpu_seconds"],
        "wall_seconds": time.perf_counter() - began,
        "peak_megabytes": max(u.ru_maxrss for u in used) / 1024,
    }


def spread(work: Callable[[Task], Result], tasks: Sequence[Task], workers: int, what: str) -> Iterator[tuple[Task, Result]]:
    """Run `work` over tasks and yield (task, result) in task order, with a line of progress each; no result is kept here.

    `work` must be a top-level function. With one worker everything runs here; with more in so many spawned processes, or on
    the cluster that `run.cluster` names. Results never depend on where.
    """
    results: dict[int, Result] = {}
    following = 0
    for done, (number, result) in enumerate(_done(work, tasks, workers, what), 1):
        results[number] = result
        _progress(what, done, len(tasks))
        while following in results:
            yield tasks[following], results.pop(following)
            following += 1


def _done(work: Callable[[Task], Result], tasks: Sequence[Task], workers: int, what: str) -> Iterator[tuple[int, Result]]:
    """The number and the result of each task, in the order in which they are done."""
    if workers <= 1 or len(tasks) <= 1:
        yield from enumerate(map(work, tasks))
    elif cluster := read_section(SHARED).get("cluster"):
        yield from on_cluster(cluster, work, tasks, what, AHEAD)
    else:
        context = multiprocessing.get_context("spawn")  # fork is unsafe with torch, rerun and threads
        with ProcessPoolExecutor(min(workers, len(tasks)), mp_context=context) as pool:
            waiting: deque[Future[Result]] = deque()
            try:
                for number, task in enumerate(tasks):
                    waiting.append(pool.submit(work, task))
                    if len(waiting) == AHEAD * workers:
                        yield number + 1 - len(waiting), waiting.popleft().result()
                while waiting:
                    yield len(tasks) - len(waiting), waiting.popleft().result()
            except BrokenProcessPool:
                raise MissingTool(
                    f"{what}: a process was killed, most likely because memory ran out: lower run.workers in params.yaml, or "
                    "make room"
                ) from None
            except BaseException:
                pool.shutdown(cancel_futures=True)  # else leaving the block would do all that is waiting first
                raise


def spread_splits(
    work: Callable[[Task], Result], scenarios: Path, tasks: Callable[[Path], Sequence[Task]], workers: int, what: str
) -> Iterator[tuple[str, Result]]:
    """Results for the splits `val` and, after it, `train` of `scenarios`, each in order, by the same processes.

    `tasks` gives the tasks of a split's folder, none where there is no folder; without a train split MissingTool is raised.
    One set of processes does both splits because to start one takes two seconds.
    """
    train, held_out = tasks(require(scenarios / "train", "run the ingest stage")), tasks(scenarios / "val")
    for number, (_, result) in enumerate(spread(work, [*held_out, *train], workers, what)):
        yield ("val" if number < len(held_out) else "train"), result


def learnt_from(
    kind: type[Learnt], work: Callable[[Task], Learnt], scenarios: Path, tasks: Callable[[Path], Sequence[Task]], workers: int,
    what: str,
) -> tuple[Learnt, Learnt]:  # fmt: skip
    """What `work` makes of the shards of both splits, as two tables in mapped files: memory does not grow with them."""
    made = {split: Columns(kind, SCRATCH) for split in ("train", "val")}
    for split, part in spread_splits(work, scenarios, tasks, workers, what):
        made[split].add(part)
    return made["train"].whole(), made["val"].whole()


def _progress(what: str, done: int, total: int) -> None:
    print(f"{what} {done}/{total}", flush=True)


def one_thread() -> None:
    """Let numerical libraries use one thread: sums depend on the thread count, and shared cores are slower with two."""
    for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ[name] = "1"


def require(path: Path, remedy: str) -> Path:
    """`path` if it exists, else MissingTool with the remedy."""
    if not path.exists():
        raise MissingTool(f"{path} is not there: {remedy}")
    return path


one_thread()
