"""The whole pipeline with a tiny profile, in a copy of this tree: first by the flow, then again in one process."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from drivegen.store.scenarios import read_shard, shards
from drivegen.sumo.network import Network
from flows import pipeline, workspace
from tests.checking import FARTHEST_OFF, off_the_road

ROOT = Path(__file__).parents[1]
LEAVES = ("drivegen.duckdb", "reports/costs.md", "reports/recordings", "reports/index.html")
"""DuckDB and Rerun write something new every time; nothing depends on these."""

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def tiny(tmp_path_factory) -> Path:
    """A copy of this tree in which the flow has run once, with two processes a stage."""
    folder = tmp_path_factory.mktemp("tiny")
    params = yaml.safe_load((ROOT / "tests" / "tiny.yaml").read_text())
    workspace.duplicate(ROOT, folder / "tree", {**params, "run.workers": 2}, cache=folder / "cache")
    (folder / "tree" / "dvc.lock").unlink(missing_ok=True)
    run(folder / "tree", "flows", "experiment")
    return folder / "tree"


def run(root: Path, *words: str, **environment: str) -> str:
    """What `python -m WORDS` prints in the copy; its last lines are shown if it fails."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    done = subprocess.run(
        [sys.executable, "-m", *words], cwd=root, text=True, check=False, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        env={**os.environ, "PATH": path, "PYTHONPATH": str(root), **environment},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-3000:]
    return done.stdout


def hashes(root: Path) -> dict[str, str]:
    """DVC's hash of every output that is not a leaf."""
    lock = yaml.safe_load((root / "dvc.lock").read_text())
    outs = [out for stage in lock["stages"].values() for out in stage.get("outs", [])]
    return {out["path"]: out["md5"] for out in outs if not any(word in out["path"] for word in LEAVES)}


def changed(root: Path) -> set[str]:
    """The outputs that are not what dvc.lock says, or are not there."""
    stages = json.loads(run(root, "dvc", "status", "--json"))
    return {path for found in stages.values() for each in found for path in each.get("changed outs", ())}


def test_the_report_and_the_tables_are_there(tiny):
    assert "<html" in (tiny / "reports" / "index.html").read_text()
    assert list((tiny / "reports" / "tables").glob("*.md"))


def test_no_shipped_vehicle_is_off_the_road_of_its_whole_network(tiny):
    networks = {file.parent.name: Network.read(file.read_bytes(), str(file)) for file in tiny.glob("data/maps/*/map.net.xml")}
    shipped = [scenario for shard in shards(tiny / "data" / "shipped") for scenario in read_shard(shard)]
    assert shipped
    for scenario in shipped:
        assert off_the_road(scenario, networks[scenario.city]).max() <= FARTHEST_OFF, scenario.scenario_id


def test_nothing_is_left_to_do_for_dvc(tiny):
    said = run(tiny, "dvc", "repro")
    assert "Running stage" not in said
    assert "Data and pipelines are up to date." in said


def test_one_process_with_another_hash_seed_gives_the_same_bytes(tiny):
    kept = hashes(tiny)
    assert len(kept) > 20
    shutil.rmtree(tiny / ".drivegen")  # nothing may be taken from what the first run kept outside DVC
    pipeline.discard(pipeline.locked(tiny), tiny)
    assert not any((tiny / path).exists() for path in kept)
    workspace.override(tiny, {"run.workers": 1})
    run(tiny, "tests.in_one_process", PYTHONHASHSEED="123")
    differing = changed(tiny)
    assert "reports/recordings" in differing  # which are written anew each time: what differs is seen
    assert not kept.keys() & differing
