"""The code of docs/python.md runs, block after block, in a project's folder."""

import re
from pathlib import Path

import pytest

from drivegen.av2.export import export_scenario
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import write_shard
from tests.projects import make_project
from tests.scenes import busy_crossing, noisy_samples

DOCS = Path(__file__).parents[1] / "docs" / "python.md"
SHARD = "shard-00000.parquet"


def test_its_code_runs_in_a_projects_folder(models: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, scene = make_project(tmp_path, models), busy_crossing(101, "scene-0")
    assert scene.log is not None
    for place in ("shipped", "scenarios/test"):
        write_shard(folder / "data" / place / SHARD, [scene])
    write_samples(folder / "data" / "generated" / "drivegen" / SHARD, [noisy_samples(scene, 2)])
    export_scenario(scene, scene.log, folder, "SCENARIO")
    monkeypatch.chdir(folder)
    names: dict[str, object] = {}
    for block in re.findall(r"^```python\n(.*?)^```", DOCS.read_text(), re.DOTALL | re.MULTILINE):
        exec(block, names)
    assert len(list((folder / "out").iterdir())) == 10
    assert {"where", "futures", "traffic", "built"} <= set(names)
