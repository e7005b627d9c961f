"""Compiled loops are those of the code as it is, also where what was edited is in another file than the loop."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import drivegen

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
