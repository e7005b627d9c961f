"""A project's folder as `make run` leaves it, in a second: with models that were trained for seconds (tests/models.py)."""

import shutil
from pathlib import Path

import yaml

from drivegen.core.settings import MEASURES
from drivegen.placement.table import build_table
from drivegen.store.assets import write_assets
from tests.scenes import busy_crossing

PARAMS = Path(__file__).parents[1] / "params.yaml"


def copy_params(folder: Path) -> None:
    """Both files of parameters, as they are, into `folder`."""
    (folder / MEASURES).parent.mkdir()
    for name in ("params.yaml", MEASURES):
        shutil.copy(PARAMS.parent / name, folder / name)


def make_project(folder: Path, models: Path) -> Path:
    """`folder` with both files of parameters, data/assets.parquet and a copy of `models` as data/models."""
    tree = yaml.safe_load(PARAMS.read_text())
    for section in ("rollout", "ship"):
        tree[section]["generation"]["rollout"] |= {"attempts": 2, "rounds": 2}
    (folder / "params.yaml").write_text(yaml.safe_dump(tree))
    (folder / MEASURES).parent.mkdir()
    shutil.copy(PARAMS.parent / MEASURES, folder / MEASURES)
    shutil.copytree(models, folder / "data" / "models")
    write_assets(folder / "data" / "assets.parquet", build_table([busy_crossing()]).to_arrow())
    return folder
