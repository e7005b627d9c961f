"""The file that a command writes: refused before any work where it cannot be written or another file would be lost."""

import pytest

from drivegen.av2.export import export_scenario
from drivegen.cli import _files, bench, rate
from drivegen.maps.build import build_map
from drivegen.store.files import write_json
from drivegen.words.writer import Writer
from tests import scenes
from tests.cli.test_cli_commands import run


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A scenario's folder, a map's and one of models, and a file of somebody's own."""
    folder = tmp_path_factory.mktemp("files")
    scene = scenes.busy_crossing(110)
    export_scenario(scene, scene.log, folder, "scene")
    build_map("a straight road", 7, Writer()).save(folder / "map")
    write_json(folder / "data/models/limits.json", {})
    (folder / "params.yaml").write_text("run: {seed: 8}\n")
    write_json(folder / "mine.json", {"name": 1})
    return folder


WRITE = [
    ("view", "scene", "--no-show", "--out"),
    ("map", "export", "map", "--to", "sumo", "--out"),
    ("map", "export", "map", "--to", "opendrive", "--out"),
    ("weights", "save"),
    ("rate", "--driver", "idm", "--scenarios", "scene", "--out"),
    ("bench", "--json"),
    ("bench", "maps", "--every", "400", "--json"),
]


@pytest.mark.parametrize("words", WRITE, ids=" ".join)
def test_a_file_of_another_kind_is_not_replaced_and_a_place_that_takes_none_is_refused_first(made, monkeypatch, words):
    monkeypatch.setattr(rate, "read_traffic", None)
    monkeypatch.setattr(bench, "measure", None)
    monkeypatch.setattr(bench, "own_cases", None)
    before = {file: (made / file).read_bytes() for file in ("params.yaml", "mine.json")}
    for file, content in before.items():
        done = run(*words, file, cwd=made)
        assert (done.returncode, (made / file).read_bytes()) == (2, content)
        assert f"{file} is there and no " in done.stderr
        assert "name another file" in done.stderr
    done = run(*words, "/proc/made/here", cwd=made)
    assert done.returncode == 2
    assert done.stderr == "drivegen: /proc/made/here cannot be written, /proc takes no files: name a place that does\n"


@pytest.mark.parametrize("words", WRITE[:4], ids=" ".join)
def test_its_own_file_and_an_empty_one_are_replaced(made, tmp_path, words):
    (tmp_path / "out").touch()
    for _ in range(2):
        done = run(*words, str(tmp_path / "out"), cwd=made)
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "out").stat().st_size > 100


@pytest.mark.parametrize(
    ("kind", "value"),
    [
        (_files.RATE, {"scenes": 3, "folder": "scenes", "driver": "idm", "draws": 8}),
        (_files.SPEED, [{"unit": "ms", "name": "raster", "pass": True}]),
        (_files.MAPS, {"writers": [], "descriptions": 400}),
    ],
)
def test_a_file_of_numbers_is_known_again(tmp_path, kind, value):
    write_json(tmp_path / "numbers.json", value)
    _files.expect_own(tmp_path / "numbers.json", kind)


@pytest.mark.parametrize(
    "words",
    [
        ("map", "a straight road", "--out"),
        ("map", "import", "map/map.net.xml", "--out"),
        ("generate", "--map", "map", "--out"),
        ("export", "map", "--out"),
    ],
    ids=" ".join,
)
def test_a_folder_that_cannot_be_made_is_one_sentence_and_exit_code_2(made, words):
    done = run(*words, "/proc/made/here", cwd=made)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert "/proc/made" in done.stderr
    assert ": name a place" in done.stderr
