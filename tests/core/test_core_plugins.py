"""Plugins are found by file name, and a wrong name teaches."""

import pytest

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput


def test_base_and_private_files_are_no_plugins():
    found = plugins.names("planners")
    assert "base" not in found
    assert not any(name.startswith("_") for name in found)
    assert found == sorted(found)


def test_an_unknown_name_lists_the_known_ones_and_the_file_to_write():
    with pytest.raises(UnusableInput, match=r"no generators plugin is called 'gan'.*log.*drivegen/generators/gan\.py") as error:
        plugins.load("generators", "gan")
    assert error.value.exit_code == 2


@pytest.mark.parametrize("name", ["base", "__init__", "../seeds", "log.Plugin"])
def test_what_is_no_plugin_cannot_be_loaded_by_a_crooked_name(name):
    with pytest.raises(UnusableInput):
        plugins.load("generators", name)


def test_a_file_without_plugin_is_told_apart(tmp_path, monkeypatch):
    import drivegen.generators

    (tmp_path / "empty.py").write_text('"""Nothing."""\n')
    monkeypatch.setattr(drivegen.generators, "__path__", [*drivegen.generators.__path__, str(tmp_path)])
    with pytest.raises(UnusableInput, match="must define `Plugin`"):
        plugins.load("generators", "empty")
