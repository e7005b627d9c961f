"""The whole pipeline with a tiny profile: it runs, then has nothing to do, and gives the same bytes elsewhere."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from flows import workspace

ROOT = Path(__file__).parents[1]
LEAVES = ("drivegen.duckdb", ".rrd", "reports/recordings", "reports/index.html")
"""DuckDB and Rerun write something new every time; nothing depends on these."""

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def tiny(tmp_path_factory) -> Path:
    """A copy of this tree in which `dvc repro` has run once."""
    root = copy(tmp_path_factory.mktemp("tiny"))
    done = repro(root)
    assert done.returncode == 0, done.stdout[-3000:]
    return root


def copy(folder: Path) -> Path:
    params = yaml.safe_load((ROOT / "tests" / "tiny.yaml").read_text())
    workspace.duplicate(ROOT, folder / "tree", params, cache=folder / "cache")
    (folder / "tree" / "dvc.lock").unlink(missing_ok=True)
    return folder / "tree"


def repro(root: Path) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    return subprocess.run(
        [sys.executable, "-m", "dvc", "repro"],
        cwd=root, env={**os.environ, "PATH": path}, text=True, check=False, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip


def hashes(root: Path) -> dict[str, str]:
    """DVC's hash of every output that is not a leaf."""
    lock = yaml.safe_load((root / "dvc.lock").read_text())
    outs = [out for stage in lock["stages"].values() for out in stage.get("outs", [])]
    return {out["path"]: out["md5"] for out in outs if not any(word in out["path"] for word in LEAVES)}


def test_the_report_and_the_tables_are_there(tiny):
    assert "<html" in (tiny / "reports" / "index.html").read_text()
    assert list((tiny / "reports" / "tables").glob("*.md"))


def test_a_second_run_executes_nothing(tiny):
    again = repro(tiny)
    assert again.returncode == 0
    assert "Running stage" not in again.stdout
    assert "Data and pipelines are up to date." in again.stdout


def test_the_flow_gives_the_same_bytes_in_another_process_order_and_hash_seed(tiny, tmp_path, monkeypatch):
    root = copy(tmp_path)
    params = yaml.safe_load((root / "params.yaml").read_text())
    (root / "params.yaml").write_text(yaml.safe_dump(workspace.overridden(params, {"run.workers": 1}), sort_keys=False))
    for name, value in {"PYTHONHASHSEED": "123", "OMP_NUM_THREADS": "2"}.items():
        monkeypatch.setenv(name, value)
    done = subprocess.run(
        [sys.executable, "-m", "flows", "experiment"],
        cwd=root, env={**os.environ, "PYTHONPATH": str(root)}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    assert hashes(root) == hashes(tiny)
