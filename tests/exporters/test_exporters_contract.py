"""What holds of every exporter that there is."""

import pytest

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from tests.scenes import any_scenario, busy_crossing


@pytest.mark.parametrize("name", plugins.names("exporters"))
def test_same_scenario_same_bytes(name, tmp_path):
    scene = any_scenario(3)
    assert plugins.about("exporters", name)["title"]
    written = []
    for folder in (tmp_path / "a", tmp_path / "b"):
        folder.mkdir()
        plugins.load("exporters", name)().write(scene, scene.log, folder, "one")
        written.append({file.relative_to(folder): file.read_bytes() for file in folder.rglob("*.*") if file.is_file()})
    assert written[0] == written[1] != {}


@pytest.mark.parametrize("name", plugins.names("exporters"))
@pytest.mark.parametrize("word", ["../one", "a/b", "", "x" * 240])
def test_a_name_that_cannot_name_a_file_is_refused(name, word, tmp_path):
    scene = busy_crossing()
    (tmp_path / "in").mkdir()
    with pytest.raises(UnusableInput, match="cannot name"):
        plugins.load("exporters", name)().write(scene, scene.log, tmp_path / "in", word)
    assert [file.name for file in tmp_path.rglob("*")] == ["in"]
