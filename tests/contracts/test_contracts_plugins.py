"""Each plugin folder has a protocol and a contract test that finds its plugins by itself; each plugin can be loaded."""

from pathlib import Path

import pytest

from drivegen.core import plugins

ROOT = Path(__file__).parents[2]
FOLDERS = sorted(".".join(base.parent.relative_to(ROOT / "drivegen").parts) for base in (ROOT / "drivegen").rglob("base.py"))


def test_the_known_seams_are_plugin_folders():
    assert {"datasets", "drivers", "generators", "planners", "selectors", "simulators"} <= set(FOLDERS)


@pytest.mark.parametrize("folder", FOLDERS)
def test_every_plugin_of_a_folder_can_be_loaded_by_its_name(folder):
    found = plugins.names(folder)
    assert found
    for name in found:
        assert plugins.load(folder, name).__doc__


@pytest.mark.parametrize("folder", FOLDERS)
def test_a_contract_test_goes_through_the_folder(folder):
    """A new file is tested the moment it exists."""
    tests = "".join(file.read_text() for file in (ROOT / "tests").rglob("test_*.py"))
    assert f'names("{folder}")' in tests
