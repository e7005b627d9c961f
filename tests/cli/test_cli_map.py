"""`drivegen map`: words, files, edits and other programs' formats, through the command line itself."""

import json
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from drivegen.av2.export import export_scenario
from drivegen.cli import build, main
from drivegen.maps.refine import refine_map
from drivegen.render.map_picture import draw_map
from drivegen.render.png import png
from drivegen.words.edits import edited
from tests import scenes

ROUND = "roundabout with four arms"


def run(*words: object) -> str:
    """What `drivegen map WORDS` prints where it succeeds."""
    done = CliRunner().invoke(build(["map"]), ["map", *map(str, words)], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return done.output


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("map")
    run(ROUND, "--out", folder)
    return folder


def files(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in folder.iterdir()}


@pytest.mark.parametrize(
    "words", [["words", ROUND, "--out", "OUT"], ["--out", "OUT", ROUND], [ROUND, "--seed", "7", "--out", "OUT"]]
)
def test_a_description_needs_no_command_and_options_may_come_first(folder, tmp_path, words):
    run(*(tmp_path if word == "OUT" else word for word in words))
    assert files(tmp_path) == files(folder)


def test_a_description_may_begin_with_the_name_of_a_command(tmp_path):
    assert "roundabout" in run("roundabout with three arms", "--out", tmp_path)


def test_an_edit_changes_the_map_in_place_and_is_kept_in_its_history(tmp_path):
    run(ROUND, "--out", tmp_path)
    before = files(tmp_path)
    assert "30 km/h" in run("refine", tmp_path, "set the limit to 30 km/h")
    assert files(tmp_path).keys() == before.keys()
    assert files(tmp_path)["map.net.xml"] != before["map.net.xml"]
    assert [edit["edit"] for edit in json.loads(files(tmp_path)["map.json"])["history"]] == ["set the limit to 30 km/h"]


def test_the_picture_says_the_edits_too(tmp_path):
    run(ROUND, "--out", tmp_path)
    run("refine", tmp_path, "add a lane")
    built = refine_map(tmp_path, "30 km/h", edited)
    built.save(tmp_path)
    assert built.caption == f"{ROUND}; add a lane; 30 km/h"
    assert files(tmp_path)["map.png"] == png(draw_map(built.road_map, built.caption)[..., ::-1], compression=6)


def test_a_map_is_replaced_only_where_that_is_asked_for(folder, tmp_path):
    run("a straight road", "--out", tmp_path)
    run("refine", tmp_path, "add a lane")
    run(ROUND, "--out", tmp_path, "--force")
    assert files(tmp_path) == files(folder)
    run("import", folder / "map.net.xml", "--out", tmp_path, "--force")
    assert json.loads(files(tmp_path)["map.json"])["source"] == "SUMO network"


def test_a_map_is_named_by_its_folder_or_its_network(folder, tmp_path):
    for place, out in ((folder, "a.xodr"), (folder / "map.net.xml", "b.xodr")):
        run("export", place, "--to", "opendrive", "--out", tmp_path / out)
    assert (tmp_path / "a.xodr").read_bytes() == (tmp_path / "b.xodr").read_bytes()


@pytest.mark.parametrize("word", ["-h", "--help"])
def test_help_is_no_description(word):
    assert "Commands:" in run(word)
    assert "--seed" in run("words", word)


def test_a_network_goes_out_as_it_is_and_comes_back(folder, tmp_path):
    run("export", folder, "--to", "sumo", "--out", tmp_path / "a.net.xml")
    assert "SUMO network" in run("import", tmp_path / "a.net.xml", "--out", tmp_path / "back")
    assert files(tmp_path / "back")["map.net.xml"] == files(folder)["map.net.xml"]


def test_a_window_is_smaller_than_the_whole(folder, tmp_path):
    run("import", folder / "map.net.xml", "--out", tmp_path, "--around", "80,0", "--radius", "80")
    edges = [json.loads((where / "map.json").read_text())["structure"]["edges"] for where in (tmp_path, folder)]
    assert 0 < edges[0] < edges[1]


def test_opendrive_is_written_and_read(folder, tmp_path):
    said = run("export", folder, "--to", "opendrive", "--out", tmp_path / "a.xodr")
    lanes = [re.search(r"(\d+) car, 0 bus, 0 bicycle lanes; (\d+) ways", line).groups() for line in said.splitlines()[:2]]
    assert lanes[0] == lanes[1]
    assert "the same lanes and ways" in said
    assert "lost        which two directions are one road, at 8 of 8 lanes" in said
    assert b"<OpenDRIVE" in (tmp_path / "a.xodr").read_bytes()
    assert "OpenDRIVE" in run("import", tmp_path / "a.xodr", "--out", tmp_path / "back")


def test_opendrive_loses_that_traffic_keeps_left_and_says_so(folder, tmp_path):
    run("a straight road, left-hand traffic", "--out", tmp_path / "left")
    said = [run("export", place, "--to", "opendrive", "--out", tmp_path / "a.xodr") for place in (tmp_path / "left", folder)]
    assert ["left-hand traffic" in text for text in said] == [True, False]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["import", "nowhere", "--out", "o"], "drivegen: nowhere is no file"),
        (["import", "FOLDER/map.png", "--out", "o"], "drivegen: "),
        (["import", "FOLDER/map.net.xml", "--out", "o", "--around", "here"], "--around takes two numbers"),
        (["import", "FOLDER/map.net.xml", "--out", "o", "--around", "0,0", "--junction", "a"], "one of --around and --junction"),
        (["import", "FOLDER/map.net.xml", "--out", "o", "--junction", "nothing"], "no junction 'nothing': name one of its "),
        (
            ["import", "FOLDER/map.net.xml", "--out", "o", "--around", "1e6,0"],
            "of (1000000, 0): name a place on its roads (x from ",
        ),
        (["import", "FOLDER/map.net.xml", "--out", "o", "--around", "nan,0"], "place must be two finite numbers, as 120,80"),
        (["import", "FOLDER/map.net.xml", "--out", "o", "--around", "400,0", "--radius", "60"], "no road within 60 m"),
        (["import", "FOLDER/map.net.xml", "--out", "o", "--radius", "nan"], "radius must be between 10 and 5000 m"),
        (["import", "--out", "o"], "Missing argument"),
        (["refine", "nowhere", "add a lane"], "make the map first"),
        (["refine", "FOLDER", "sing me a song"], "I do not read"),
        (["export", "nowhere", "--to", "sumo", "--out", "x"], "nowhere is not there: `drivegen map` makes maps"),
        (["a straight road", "--out", "FOLDER"], "holds a map already: name another folder"),
        (["import", "FOLDER/map.net.xml", "--out", "FOLDER"], "holds a map already: name another folder"),
        (["refine", "FOLDER", "limit 9999 km/h"], "must be less than or equal to"),
        (["import", "FOLDER", "--out", "o"], "holds 0 files log_map_archive_<id>.json"),
        (["export", "FOLDER", "--to", "opendrive", "--out", "FOLDER/map.net.xml"], "would lie in the map that is read"),
        (["export", "FOLDER/map.net.xml", "--to", "sumo", "--out", "FOLDER/map.net.xml"], "would lie in the map that is read"),
        (["export", "FOLDER", "--to", "lanelet", "--out", "x"], "'lanelet'"),
    ],
)
def test_what_cannot_be_done_is_one_sentence_and_exit_code_2(folder, tmp_path, monkeypatch, capsys, words, sentence):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", ["drivegen", "map", *(word.replace("FOLDER", str(folder)) for word in words)])
    before = files(folder)
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 2
    assert sentence in " ".join(capsys.readouterr().err.split())
    assert files(folder) == before
    assert not list(tmp_path.iterdir())


def refused(monkeypatch, capsys, *words: str) -> str:
    """What `drivegen map WORDS` says where it exits with 2."""
    monkeypatch.setattr("sys.argv", ["drivegen", "map", *words])
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 2
    return " ".join(capsys.readouterr().err.split())


def test_what_is_no_network_is_refused_with_the_way_in(tmp_path, monkeypatch, capsys):
    (tmp_path / "a.xodr").write_text("<OpenDRIVE/>")
    said = refused(monkeypatch, capsys, "export", str(tmp_path / "a.xodr"), "--to", "sumo", "--out", str(tmp_path / "b.net.xml"))
    assert "not <net>: bring other formats in with `drivegen map import`" in said


def test_links_that_lead_in_a_circle_and_a_history_that_is_none_are_refused(folder, tmp_path, monkeypatch, capsys):
    circle = tmp_path / "circle.net.xml"
    circle.symlink_to(circle.name)
    assert "is not there" in refused(monkeypatch, capsys, "export", str(circle), "--to", "sumo", "--out", str(tmp_path / "o"))
    assert "no plain file" in refused(monkeypatch, capsys, "export", str(folder), "--to", "sumo", "--out", str(circle))
    account = json.loads(files(folder)["map.json"])
    for history in (5, [5], ["add a lane"], [{"edit": "add a lane"}]):
        (tmp_path / "map.json").write_text(json.dumps(account | {"history": history}))
        assert "holds no map specification, as of imported maps, which cannot be refined: change the network in" in refused(
            monkeypatch, capsys, "refine", str(tmp_path), "add a lane"
        )


def test_what_netconvert_refuses_names_the_file(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty.osm").write_text("<osm></osm>")
    assert "empty.osm: netconvert refuses" in refused(monkeypatch, capsys, "import", "empty.osm", "--out", "o")
    (tmp_path / "m").mkdir()
    (tmp_path / "m" / "map.net.xml").write_text("a town")
    for form in ("sumo", "opendrive"):
        assert "m/map.net.xml is not XML" in refused(monkeypatch, capsys, "export", "m", "--to", form, "--out", "o")
    assert not (tmp_path / "o").exists()


def test_an_argoverse_2_log_is_imported_by_its_folder(tmp_path):
    road = scenes.straight_road()
    log = scenes.stack([scenes.drive(road.centreline[0], 20.0, 8.0, 101)])
    scene = export_scenario(scenes.scenario(road, log), log, tmp_path, "scene-0")
    assert "Argoverse 2" in run("import", scene, "--out", tmp_path / "of-log")
    run("import", scene / "log_map_archive_scene-0.json", "--out", tmp_path / "of-file")
    assert files(tmp_path / "of-log")["map.net.xml"] == files(tmp_path / "of-file")["map.net.xml"]
