"""Compiled loops are those of the code as it is, also where what was edited is in another file than the loop."""

import os
import shutil
import stat
import subprocess
import sys
import tempfile
from pathlib import Path

import numba
import pytest

import drivegen
from drivegen.core.compiled import keep_compiled

LOOP = """
from numba import njit
from drivegen.core.boxes import depth

@njit(cache=True)
def deep():
    return depth(0.0, 0.0, 0.0, 4.0, 2.0, 0.0, 4.0, 2.0)
"""


def test_a_loop_is_compiled_anew_when_what_it_calls_is_edited(tmp_path: Path) -> None:
    package = tmp_path / "drivegen"
    shutil.copytree(Path(drivegen.__file__).parent, package, ignore=shutil.ignore_patterns("__pycache__"))
    (package / "roads" / "tried.py").write_text(LOOP)
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}

    def deep() -> float:
        command = [sys.executable, "-c", "from drivegen.roads.tried import deep; print(deep())"]
        return float(subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, check=True).stdout)

    assert deep() == 2.0
    compiled = list(package.rglob("tried.deep*.nbc"))
    before = compiled[0].stat().st_mtime_ns
    assert deep() == 2.0
    assert compiled[0].stat().st_mtime_ns == before
    boxes = package / "core" / "boxes.py"
    boxes.write_text(boxes.read_text().replace("return min(on_a, on_b)", "return min(on_a, on_b) + 1.0"))
    assert deep() == 3.0


@pytest.fixture
def named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """A folder for compiled code of all projects."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    return tmp_path


def test_in_a_shared_folder_each_code_has_its_own_and_nothing_of_others_is_removed(
    named: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    foreign = named / "package_1" / "loop.f-1.py311.nbi"
    foreign.parent.mkdir()
    foreign.write_text("x")
    keep_compiled()
    ours = Path(os.environ["NUMBA_CACHE_DIR"])
    assert foreign.exists()
    assert (ours.parent, numba.config.CACHE_DIR) == (named, str(ours))
    keep_compiled()  # as a process that this one starts
    assert os.environ["NUMBA_CACHE_DIR"] == str(ours)
    monkeypatch.setattr("drivegen.core.compiled.PACKAGE", named / "other code")
    keep_compiled()
    other = Path(os.environ["NUMBA_CACHE_DIR"])
    assert other.parent == named
    assert other != ours


@pytest.mark.parametrize("home", ["", "kept"])
def test_compiled_code_has_a_place_where_the_checkout_cannot_be_written(
    named: Path, monkeypatch: pytest.MonkeyPatch, home: str
) -> None:
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", str(named / "home"))
    monkeypatch.setattr(os, "access", lambda path, _: home and named in path.parents)
    monkeypatch.setattr(tempfile, "tempdir", str(named))
    keep_compiled()
    ours = named / f"drivegen-{os.getuid()}"
    assert Path(os.environ["NUMBA_CACHE_DIR"]).parent == (named / "home" / "numba" if home else ours)
    if not home:
        assert stat.S_IMODE(ours.stat().st_mode) == 0o700
        monkeypatch.delenv("NUMBA_CACHE_DIR")
        other = os.getuid() + 1
        monkeypatch.setattr(os, "getuid", lambda: other)
        ours.rename(named / f"drivegen-{other}")
        keep_compiled()  # of somebody else's folder nothing is run
        assert Path(os.environ["NUMBA_CACHE_DIR"]).parent.parent == named
        assert Path(os.environ["NUMBA_CACHE_DIR"]).parent.name != f"drivegen-{other}"
