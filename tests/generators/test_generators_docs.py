"""The sizes and steps that docs/rivals.md tells are those of the parameters."""

from pathlib import Path
from typing import Any

import pytest

from drivegen.core.methods import LEARNED, read_methods
from drivegen.core.settings import read_section, read_yaml

ROOT = Path(__file__).parents[2]
SECTION = "train_generator.generators"
OWN = {"DriveGen, planner": "train_planner.planners.route_fm", "DriveGen, goal selector": "train_selector.learned"}


def rows() -> dict[str, list[str]]:
    """Of the table of sizes, by the name in front: width here and there, what a step learns from, steps here and there."""
    table = (ROOT / "docs/rivals.md").read_text().partition("| | width in")[2].partition("\n\n")[0]
    lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()[2:]]
    return {cells[0]: cells[1:] for cells in lines}


def first_number(cell: str) -> int:
    """64 of "64 (256)", 2700 of "2 700"."""
    return int(cell.partition("(")[0].replace(" ", ""))


TABLES: dict[str, Any] = read_yaml(ROOT / "flows/tables.yaml")["quality"]["params"]
HERE = read_section("run", ROOT / "params.yaml")["rivals"]
RIVALS = {about.title: name for name, about in read_methods().items() if about.kind == LEARNED and name in TABLES["run.rivals"]}


def test_every_model_has_a_row():
    assert set(rows()) == {*RIVALS, *OWN}


@pytest.mark.parametrize("title", [*RIVALS, *OWN])
def test_a_model_is_as_large_and_learns_as_long_as_is_told(title: str):
    section = OWN.get(title) or f"{SECTION}.{RIVALS[title]}"
    settings = read_section(section, ROOT / "params.yaml")
    width, width_there, learns_from, here, there = rows()[title]
    assert first_number(width) == settings["width"]
    assert first_number(width_there) == TABLES.get(f"{section}.width", settings["width"])
    assert int(learns_from.split()[0]) == settings["training"]["batch"]
    assert here == "–" if RIVALS.get(title, HERE[0]) not in HERE else first_number(here) == settings["training"]["steps"]
    assert first_number(there) == TABLES.get(f"{section}.training.steps", settings["training"]["steps"])
