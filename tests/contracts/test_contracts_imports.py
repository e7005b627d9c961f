"""The house's rules would notice if they were broken (that they hold on the tree is `make lint`)."""

import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]

PLANTED = {
    "drivegen/core/geometry.py": "from drivegen.core.scenario import Scenario",
    "drivegen/unplaced.py": "import json",
    "drivegen/goals/planted.py": "from drivegen.planners.base import Planner",
    "drivegen/metrics/planted.py": "import torch",
    "drivegen/checker/planted.py": "import cv2",
    "drivegen/maps/planted.py": "import openai",
    "drivegen/placement/planted.py": "import gymnasium",
    "drivegen/core/seeds.py": "import prefect",
    "drivegen/words/planted.py": "from drivegen.maps import build",
    "stages/planted.py": "import prefect\nfrom stages.collect import main",
    "flows/planted.py": "import drivegen",
}
NOTICED = (
    "drivegen.core.geometry -> drivegen.core.scenario",
    "- drivegen.unplaced",
    "drivegen.goals.planted -> drivegen.planners.base",
    "drivegen.metrics.planted -> torch",
    "drivegen.checker.planted -> cv2",
    "drivegen.maps.planted -> openai",
    "drivegen.placement.planted -> gymnasium",
    "drivegen.words.planted -> drivegen.maps.build",
    "drivegen.core.seeds -> prefect",
    "stages.planted -> prefect",
    "stages.planted -> stages.collect",
    "flows.planted -> drivegen",
)


def test_every_contract_notices_a_planted_violation(tmp_path):
    for folder in ("drivegen", "stages", "flows"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    for name, line in PLANTED.items():
        with (tmp_path / name).open("a") as file:
            file.write(f"\n{line}\n")
    command = [str(Path(sys.executable).parent / "lint-imports"), "--no-logo", "--no-cache"]
    done = subprocess.run(command, cwd=tmp_path, env={"PYTHONPATH": str(tmp_path)}, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "Contracts: 0 kept" in done.stdout
    assert [words for words in NOTICED if words not in done.stdout] == []
