"""The driver that docs/drivers.md shows is one: it keeps the protocol and drives."""

import re
import shutil
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from drivegen.simulators.batch import Plugin as Batch
from drivegen.store.scenarios import write_shard
from tests.scenes import busy_crossing, drive, scenario, stack, straight_road

DOCS = Path(__file__).parents[2] / "docs" / "drivers.md"


@pytest.fixture
def late(monkeypatch):
    code, _ = re.findall(r"^```python\n(.*?)^```", DOCS.read_text(), re.DOTALL | re.MULTILINE)
    module = ModuleType("late")
    monkeypatch.setitem(sys.modules, "late", module)  # where its dataclass looks itself up
    exec(code, vars(module))
    return module


@pytest.mark.parametrize(("reacts", "crashes"), [(3.0, False), (0.3, True)])
def test_it_drives_and_brakes_as_late_as_it_is_told(late, reacts, crashes):
    road = straight_road()
    line = road.centreline[0].astype(np.float64)
    free, blocked = stack([drive(line, 10, 8, 101)]), stack([drive(line, 10, 8, 101), drive(line, 70, 0, 101)])
    driver = late.Plugin(late.Settings(reacts=reacts, braking=8.0, cruise=13.9))
    outcome = Batch().run(driver, [scenario(road, free), scenario(road, blocked)], [free, blocked])
    assert outcome.end[0, 0] > 60
    assert outcome.collided.tolist() == [False, crashes]


def test_a_policy_is_trained_and_tested_by_what_the_page_shows(tmp_path, monkeypatch, capsys):
    """The same lines with fewer rows and steps."""
    _, code = re.findall(r"^```python\n(.*?)^```", DOCS.read_text(), re.DOTALL | re.MULTILINE)
    assert len([line for line in code.splitlines() if line]) <= 20
    for word, smaller in (("5120", "16"), ("512", "4"), ("n_steps=100", "n_steps=16"), ("1_000_000", "64")):
        assert word in code
        code = code.replace(word, smaller)
    scenes = [busy_crossing(61, f"scene-{letter}") for letter in "ab"]
    for place in ("data/shipped", "data/scenarios/test"):
        write_shard(tmp_path / place / "shard-00000.parquet", scenes)
    shutil.copy(DOCS.parents[1] / "params.yaml", tmp_path)
    monkeypatch.chdir(tmp_path)
    exec(code, {"__name__": "mine"})
    assert re.fullmatch(r"[\d.]+% collide, [\d.]+% at fault by nuPlan's classes\n", capsys.readouterr().out)
