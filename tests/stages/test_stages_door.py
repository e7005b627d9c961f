"""The stages' door: strict parameters, results in task order, one sentence and an exit code for an error."""

import errno
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
import yaml

from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.settings import read_tree
from drivegen.store.files import whole
from drivegen.sumo.netconvert import NetconvertRefused
from stages import _door, asked, attack, corner, drive, evaluate, goals, ingest, place, rollout, train_planner
from tests.stages.tasks import begin, killed, killed_later, refused, refused_first, square


@dataclass(frozen=True)
class Inner:
    width: int
    names: tuple[str, ...]


@dataclass(frozen=True)
class Params:
    seed: int
    rate: float
    inner: Inner
    limit: float | None


GOOD = "run:\n  seed: 7\n  workers: 2\nwork:\n  rate: 1\n  limit: null\n  inner:\n    width: 3\n    names: [a, b]\n"


def nested(values: dict[str, Any], where: str) -> tuple[dict[str, Any], str]:
    *sections, name = where.split(".")
    for word in sections:
        values = values[word]
    return values, name


def write(folder: Path, text: str) -> Path:
    path = folder / "params.yaml"
    path.write_text(text)
    return path


def test_a_section_becomes_its_dataclass_with_the_shared_seed(tmp_path):
    params = _door.read_params("work", Params, write(tmp_path, GOOD))
    assert params == Params(7, 1.0, Inner(3, ("a", "b")), None)
    assert isinstance(params.rate, float)


def test_a_dotted_section_is_a_section_inside_a_section(tmp_path):
    assert _door.read_params("work.inner", Inner, write(tmp_path, GOOD)).width == 3


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (("rate: 1", "rate: 1\n  speed: 2"), r"work: unknown name 'speed'; known are inner, limit, rate, seed"),
        (("width: 3", "width: 3\n    hight: 1"), r"work\.inner: unknown name 'hight'; known are names, width"),
        (("  rate: 1\n", ""), r"work: 'rate' is missing"),
        (("rate: 1", "rate: fast"), r"work\.rate must be float, not 'fast'"),
        (("width: 3", "width: true"), r"work\.inner\.width must be int, not True"),
        (("[a, b]", "[a, 1]"), r"work\.inner\.names\[1\] must be str, not 1"),
        (("work:", "play:"), r"no section 'work'"),
        (("seed: 7", "seed: -1"), r"run\.seed must be between 0 and 9\.22337e\+18, not -1"),
        (("workers: 2", "workers: 0"), r"run\.workers must be at least 1, not 0"),
    ],
)
def test_a_wrong_parameter_is_named_with_its_place(tmp_path, change, sentence):
    with pytest.raises(UnusableInput, match=sentence):
        _door.read_params("work", Params, write(tmp_path, GOOD.replace(*change)))


def test_results_come_in_task_order_whatever_the_number_of_workers(capsys):
    tasks = [5, 3, 8, 1]
    expected = [(5, 25), (3, 9), (8, 64), (1, 1)]
    assert list(_door.spread(square, tasks, 1, "squares")) == expected
    assert list(_door.spread(square, tasks, 2, "squares")) == expected
    assert capsys.readouterr().out.splitlines()[-1] == "squares 4/4"


def test_a_process_that_is_killed_is_one_sentence():
    with pytest.raises(MissingTool, match=r"^squares: a process was killed, .*: lower run\.workers in params\.yaml"):
        list(_door.spread(killed, [1, 2], 2, "squares"))


def test_a_process_that_is_killed_while_others_wait_is_one_sentence():
    with pytest.raises(MissingTool, match=r"^squares: a process was killed"):
        list(_door.spread(killed_later, list(range(40)), 2, "squares"))


def test_what_a_process_refuses_is_refused_here():
    with pytest.raises(NetconvertRefused, match=r"^network 1 is none$") as refusal:
        list(_door.spread(refused, [1, 1], 2, "networks"))
    assert (refusal.value.reason, refusal.value.messages) == ("netconvert", ("no nodes",))


def test_once_a_task_failed_those_that_wait_are_not_done(tmp_path):
    with pytest.raises(NetconvertRefused):
        list(_door.spread(refused_first, [tmp_path / str(n) for n in range(16)], 2, "networks"))
    assert len(list(tmp_path.iterdir())) < 8


def test_no_tasks_are_no_results():
    assert list(_door.spread(square, [], 2, "squares")) == []


@pytest.mark.parametrize("workers", [1, 2])
def test_both_splits_are_spread_together_and_come_apart_again(tmp_path, workers, capsys):
    (tmp_path / "train").mkdir()
    numbers = {tmp_path / "train": [3, 4], tmp_path / "val": [5]}
    found = list(_door.spread_splits(square, tmp_path, numbers.__getitem__, workers, "squares"))
    assert found == [("val", 25), ("train", 9), ("train", 16)]
    assert capsys.readouterr().out.splitlines() == ["squares 1/3", "squares 2/3", "squares 3/3"]


def test_without_a_train_split_the_stage_that_makes_it_is_named(tmp_path):
    with pytest.raises(MissingTool, match="train is not there: run the ingest stage"):
        list(_door.spread_splits(square, tmp_path, lambda split: [1], 1, "squares"))


def test_results_come_in_order_and_few_are_begun_before_they_are_taken(tmp_path, monkeypatch):
    monkeypatch.setattr(_door, "AHEAD", 2)
    found = _door.spread(begin, [tmp_path / str(n) for n in range(20)], 2, "files")
    assert next(found)[1] == "0"
    assert len(list(tmp_path.iterdir())) <= 4
    assert [name for _, name in found] == [str(n) for n in range(1, 20)]


@dataclass(frozen=True)
class Nothing:
    """No parameters."""


def full_disk(params: Nothing, out: Path) -> None:
    raise OSError(errno.ENOSPC, "No space left on device", str(out))


def no_table(params: Nothing, out: Path) -> None:
    pq.read_table(out)


def no_schema(params: Nothing, out: Path) -> None:
    pq.read_schema(out)


def full_disk_below_pyarrow(params: Nothing, out: Path) -> None:
    with whole(out):
        raise OSError("Error writing bytes to file.\nDetail: disk quota")


def no_weights(params: Nothing, out: Path) -> None:
    raise MissingTool(f"{out} is not there: run `make run`")


def absurd(params: Nothing, out: Path) -> None:
    np.zeros(2**50)


def bad_file(params: Nothing, out: Path) -> None:
    raise UnusableInput(f"{out} is empty", reason="empty")


@pytest.mark.parametrize(
    ("main", "code", "sentence"),
    [
        (full_disk, 1, "work: x.bin: No space left on device; nothing half-written was kept\n"),
        (no_table, 1, "work: x.bin: No such file or directory; nothing half-written was kept\n"),
        (
            no_schema,
            1,
            "work: Failed to open local file 'x.bin'. Detail: [errno 2] No such file or directory; "
            "nothing half-written was kept\n",
        ),
        (
            full_disk_below_pyarrow,
            1,
            "work: x.bin: Error writing bytes to file. Detail: disk quota; nothing half-written was kept\n",
        ),
        (no_weights, 1, "work: x.bin is not there: run `make run`\n"),
        (bad_file, 2, "work: x.bin is empty\n"),
        (
            absurd,
            1,
            "work: there is not enough memory for that (Unable to allocate 8.00 PiB for an array with shape (1125899906842624,) "
            "and data type float64): ask for less (params.yaml)\n",
        ),
    ],
)
def test_an_error_is_one_sentence_and_an_exit_code(tmp_path, monkeypatch, capsys, main, code, sentence):
    write(tmp_path, "work: {}\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(_door, "_stage", lambda word: SimpleNamespace(Params=Nothing, main=main))
    with pytest.raises(SystemExit) as left:
        _door.enter("work", "x.bin")
    assert left.value.code == code
    assert capsys.readouterr().err == sentence


@pytest.mark.parametrize("paths", [[], ["a", "b"]])
def test_a_stage_without_its_paths_names_them(tmp_path, monkeypatch, capsys, paths):
    write(tmp_path, "work: {}\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(_door, "_stage", lambda word: SimpleNamespace(Params=Nothing, main=bad_file))
    with pytest.raises(SystemExit) as left:
        _door.enter("work", *paths)
    assert left.value.code == 2
    assert f"work: takes 1 paths (out), {len(paths)} are given" in capsys.readouterr().err


@pytest.mark.parametrize("word", ["no_such", "_door", "../ingest", ""])
def test_a_word_that_is_no_stage_is_one_sentence(capsys, word):
    with pytest.raises(SystemExit) as left:
        _door.enter(word)
    assert left.value.code == 2
    assert capsys.readouterr().err.startswith(f"{word}: there is no such stage: ")


def test_what_is_required_and_absent_is_told_with_its_remedy(tmp_path):
    with pytest.raises(MissingTool, match="run the corpus stage"):
        _door.require(tmp_path / "data", "run the corpus stage")
    assert _door.require(tmp_path, "never said") == tmp_path


@pytest.mark.parametrize(
    ("params", "where", "value"),
    [
        (asked.Params, "asked.settings.placements", 0),
        (attack.Params, "attack.queries", [0]),
        (corner.Params, "corner.samples", 0),
        (corner.Params, "corner.pressure.max_ratio", 0.5),
        (corner.Params, "corner.pressure.strength", 200.0),
        (drive.Params, "drive.draws", -1),
        (evaluate.Params, "evaluate.draws", -1),
        (ingest.Params, "ingest.shard_size", 0),
        (place.Params, "place.per_shard", 0),
        (rollout.Params, "rollout.generation.rollout.rounds", 17),
        (goals.Params, "goals.candidates.most", 10**9),
        (goals.Params, "goals.candidates.spacing", 1e-9),
        (train_planner.Params, "train_planner.seen", 1.5),
    ],
)
def test_a_number_with_which_a_stage_could_do_nothing_is_refused_by_name(tmp_path, params, where, value):
    values = read_tree()
    section, name = nested(values, where)
    section[name] = value
    bounds = r"(at least 1|between 0 and (1|20)|between 1 and (16|40)|between 0.1 and 100)"
    with pytest.raises(UnusableInput, match=rf"{where.partition('.')[2]}(\[0\])? must be {bounds}"):
        _door.read_params(where.partition(".")[0], params, write(tmp_path, yaml.safe_dump(values)))
