"""Folders appear whole or not at all, and never in the place of something else."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from drivegen.core.errors import UnusableInput
from drivegen.store.files import HOST
from drivegen.store.folders import whole_folder


def test_a_folder_appears_when_everything_in_it_is_written(tmp_path: Path):
    with whole_folder(tmp_path / "deep" / "out") as folder:
        (folder / "a").write_text("a")
        assert not (tmp_path / "deep" / "out").exists()
    assert [p.name for p in (tmp_path / "deep").iterdir()] == ["out"]
    assert (tmp_path / "deep" / "out" / "a").read_text() == "a"


def test_an_empty_folder_is_taken_also_the_one_we_are_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    with whole_folder(Path()) as folder:
        (folder / "a").write_text("a")
    assert (tmp_path / "here" / "a").exists()


@pytest.mark.parametrize("fault", [OSError, KeyboardInterrupt])
def test_nothing_is_left_of_a_failure(tmp_path: Path, fault: type[BaseException]):
    def fail() -> None:
        with whole_folder(tmp_path / "out") as folder:
            (folder / "a").write_text("a")
            raise fault

    with pytest.raises(fault):
        fail()
    assert not list(tmp_path.iterdir())


def test_a_link_that_leads_in_a_circle_is_left_alone(tmp_path: Path):
    circle = tmp_path / "circle"
    circle.symlink_to(circle.name)
    with pytest.raises(OSError), whole_folder(circle) as folder:
        (folder / "a").touch()
    assert [one.name for one in tmp_path.iterdir()] == ["circle"]


def test_what_is_there_is_neither_replaced_nor_mixed_with(tmp_path: Path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine").write_text("mine")
    for path in (tmp_path / "out", tmp_path / "out" / "mine"):
        with pytest.raises(UnusableInput, match="name "), whole_folder(path):
            raise AssertionError("it must not come to this")
    assert [p.name for p in tmp_path.rglob("*")] == ["out", "mine"]


def test_a_folder_in_a_file_is_refused_and_a_fault_names_the_folder_that_was_asked_for(tmp_path: Path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(UnusableInput, match="would lie in a file"), whole_folder(tmp_path / "file" / "out"):
        raise AssertionError("it must not come to this")

    def fill() -> None:
        with whole_folder(tmp_path / "out") as folder:
            raise OSError(28, "No space left on device", str(folder / "a"))

    with pytest.raises(OSError, match="No space left") as fault:
        fill()
    assert fault.value.filename == str(tmp_path / "out" / "a")


KILLED = """
import os, signal
from pathlib import Path
from drivegen.store.folders import whole_folder
with whole_folder(Path("out")) as folder:
    (folder / "a").write_text("a")
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_what_a_killed_run_left_is_removed_by_the_next_and_what_others_are_at_is_not(tmp_path: Path):
    subprocess.run([sys.executable, "-c", KILLED], cwd=tmp_path, check=False)
    [left] = tmp_path.iterdir()
    assert left.name.endswith(".part")
    others = [tmp_path / f".out.{HOST}.{os.getppid()}.part", tmp_path / f".out2.{HOST}.4194305.part", tmp_path / ".out.txt.part"]
    for other in others:
        other.mkdir()
    with whole_folder(tmp_path / "out") as folder:
        (folder / "b").write_text("b")
    assert sorted(tmp_path.iterdir()) == sorted([*others, tmp_path / "out"])
    assert [p.name for p in (tmp_path / "out").iterdir()] == ["b"]
