"""Tasks on a Dask cluster: the same bytes as here, nothing lost with a worker, one sentence for what does not fit."""

import os
import signal
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from drivegen.checker.verdicts import write_limits_file
from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.store.scenarios import write_shard
from stages import _door, rollout_baseline
from stages._door import cluster as on_dask
from tests.checking import LIMITS
from tests.scenes import busy_crossing

distributed = pytest.importorskip(
    "distributed", reason="Dask is not here: .venv/bin/pip install -c constraints.txt -e '.[cluster]'"
)
dask = pytest.importorskip("dask")
pytestmark = pytest.mark.filterwarnings("default")  # Dask's own


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A project's folder with params.yaml, in which two workers of a cluster work, as its `run.cluster` says."""
    folder = tmp_path_factory.mktemp("project")
    few = dask.config.set({"distributed.scheduler.allowed-failures": 1})  # 3 cost three more processes
    with pytest.MonkeyPatch.context() as patch, few:
        patch.chdir(folder)
        with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address="127.0.0.1:0") as cluster:
            (folder / "params.yaml").write_text(f"run:\n  cluster: {cluster.scheduler_address}\n")
            yield folder


@pytest.fixture(autouse=True)
def _there(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(project)


def process(number: int) -> tuple[int, int]:
    return number * number, os.getpid()


def killed_once(name: str) -> str:
    """Writes its name; in the first process that does the task `b` it is killed before."""
    if name == "b" and not Path("killed").exists():
        Path("killed").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    Path(name).write_text(name)
    return name


def killed(number: int) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def refused(number: int) -> None:
    raise UnusableInput(f"number {number} is no good", reason="bad")


def test_tasks_run_in_the_workers_and_come_in_order(capsys):
    done = list(_door.spread(process, list(range(8)), 2, "squares"))
    assert [(task, square) for task, (square, _) in done] == [(i, i * i) for i in range(8)]
    assert os.getpid() not in {pid for _, (_, pid) in done}
    assert capsys.readouterr().out.splitlines()[-1] == "squares 8/8"
    assert not any(on_dask.MARKS.iterdir())


def slow_first(number: int) -> int:
    if number == 0:
        time.sleep(1.5)
    return number


def test_few_tasks_are_begun_before_the_first_is_done():
    run = on_dask.on_cluster(str(_door.read_section("run")["cluster"]), slow_first, list(range(100)), "numbers", 4)
    order = [number for number, _ in run]
    assert sorted(order) == list(range(100))
    assert max(order[: order.index(0)], default=0) < 4 * 2  # of two workers


def test_a_stage_gives_the_same_bytes_there_as_here_and_its_seconds_are_counted(project):
    write_limits_file(project / "models" / "limits.json", LIMITS)
    for i in range(3):
        write_shard(project / "test" / f"shard-{i:05d}.parquet", [busy_crossing(101, f"scene-{i}")])
    params = rollout_baseline.Params(sampling_seed=7, workers=1, samples=2)
    before = on_dask.USED["cpu_seconds"]
    for folder, workers in (("here", 1), ("there", 2)):
        given = Path("test"), Path("models"), Path(folder) / "random_agent"
        rollout_baseline.main(replace(params, workers=workers), *given)
    assert on_dask.USED["cpu_seconds"] > before
    here, there = (sorted(path.read_bytes() for path in Path(folder).rglob("*.parquet")) for folder in ("here", "there"))
    assert (len(here), here) == (3, there)


def test_the_task_of_a_worker_that_is_killed_goes_to_another():
    assert [name for _, name in _door.spread(killed_once, list("abcd"), 2, "names")] == list("abcd")
    assert [Path(name).read_text() for name in "abcd"] == list("abcd")


def test_a_task_that_kills_every_worker_is_one_sentence():
    with pytest.raises(MissingTool, match=r"^squares: several workers died of the same task, most likely because memory ran"):
        list(_door.spread(killed, [1, 2], 2, "squares"))


def test_what_a_task_refuses_is_refused_here():
    with pytest.raises(UnusableInput, match=r"^number 1 is no good$") as refusal:
        list(_door.spread(refused, [1, 1], 2, "numbers"))
    assert refusal.value.reason == "bad"


def test_a_worker_with_other_code_or_packages_or_in_another_folder_does_nothing(tmp_path, monkeypatch):
    def refusal() -> str:
        with pytest.raises(MissingTool) as error:
            list(_door.spread(process, [1, 2], 2, "squares"))
        return str(error.value)

    with monkeypatch.context() as patch:
        patch.setattr(on_dask, "code", lambda: "of yesterday")
        assert "has other code of DriveGen than this run: bring it to the same state, then start the worker again" in refusal()
    with monkeypatch.context() as patch:
        patch.setattr(on_dask, "packages", lambda: {"numpy": "1.0"})
        assert "this run 1.0: install what constraints.txt says on both" in refusal()
    (tmp_path / "params.yaml").write_text(Path("params.yaml").read_text())
    monkeypatch.chdir(tmp_path)
    assert "which is not the project's folder" in refusal()


def test_two_threads_in_a_worker_are_refused():
    run = on_dask.Run(Path("params.yaml"), on_dask.code(), on_dask.packages())
    assert on_dask._fault(run, 1) == ""
    assert on_dask._fault(run, 2).startswith("has 2 threads: start it with --nthreads 1")


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nonsense://x", "tcp://127.0.0.1:notaport"])
def test_without_a_scheduler_the_address_is_named(tmp_path, monkeypatch, address):
    (tmp_path / "params.yaml").write_text(f"run:\n  cluster: {address}\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(on_dask, "_PATIENCE", 1)
    with pytest.raises(MissingTool, match=f"^squares: no Dask scheduler answers at {address}"):
        list(_door.spread(process, [1, 2], 2, "squares"))


def test_a_cluster_without_workers_is_one_sentence(tmp_path, monkeypatch):
    monkeypatch.setattr(on_dask, "_PATIENCE", 0.2)
    with (
        distributed.LocalCluster(n_workers=0, dashboard_address="127.0.0.1:0") as cluster,
        pytest.raises(MissingTool, match=r"has no worker after 0\.2 s: start some \(docs/cluster\.md\)"),
    ):
        list(on_dask.on_cluster(cluster.scheduler_address, process, [1], "squares", 8))
