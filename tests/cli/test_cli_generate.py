"""`drivegen generate`, from the words of the command line to the files, with models that learnt next to nothing."""

import json
import resource
import shutil
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from drivegen import cli
from drivegen.av2.export import export_scenario
from drivegen.av2.folder import read_folder
from drivegen.av2.schema import COLUMNS
from drivegen.core.scenario import Actors, Scenario, VehicleKind
from drivegen.gym.folders import SELECTION
from drivegen.ingest.selection import select
from drivegen.lm.ledger import FOLDER
from drivegen.maps.build import build_map
from drivegen.metrics.displacement import scene_errors
from drivegen.words.writer import Writer
from tests import scenes
from tests.lm.chat_server import Says, serving
from tests.projects import make_project

Run = Callable[..., tuple[int, str]]


def crossing() -> Scenario:
    """The busy crossing with a lorry among the cars, and somebody on foot."""
    scene = scenes.busy_crossing(scenario_id="logged-0")
    scene.vehicles.kind[1] = VehicleKind.TRUCK
    walk = scenes.stack([scenes.drive(np.array([[30.0, 30.0], [200.0, 200.0]]), 0, 1.2, 101)])
    size = np.array([[0.6, 0.6, 1.7]], np.float32)
    return replace(scene, context=Actors(np.array(["walker"]), np.uint8([VehicleKind.PEDESTRIAN]), size, walk))


@pytest.fixture(scope="module")
def project(models: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = make_project(tmp_path_factory.mktemp("project"), models)
    scene = crossing()
    export_scenario(scene, scene.log, folder, "logged-0")
    built = build_map("a crossing of two roads with traffic lights", 7, Writer())
    (folder / "town centre.net.xml").write_bytes(built.network)
    return folder


def call(project: Path, *words: str) -> int:
    """The exit code of the command in a project's folder."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(project)
        patch.setattr(sys, "argv", ["drivegen", *words])
        with pytest.raises(SystemExit) as left:
            cli.main()
    return int(left.value.code or 0)


@pytest.fixture
def run(project: Path, capsys: pytest.CaptureFixture[str]) -> Run:
    """Runs `drivegen generate` in a folder (the project's) and gives its exit code and what it said on stderr."""
    return lambda *words, cwd=project: (call(cwd, "generate", *words), capsys.readouterr().err)


@pytest.fixture(scope="module")
def regenerated(project: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return once(project, tmp_path_factory.mktemp("a") / "out", "--scenario", "logged-0", "--vehicles", "6")


@pytest.fixture(scope="module")
def written(project: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return once(project, tmp_path_factory.mktemp("b") / "out", "--text", "a motorway with 3 lanes in each direction, 1 km long")


def once(project: Path, out: Path, *words: str) -> Path:
    assert call(project, "generate", *words, "--samples", "3", "--out", str(out)) == 0
    return out


def rows_of(out: Path) -> list[dict]:
    return json.loads((out / "metrics.json").read_text())


def test_regenerated_traffic_is_in_the_official_layout_with_the_logs_ids_and_first_frame(regenerated, project):
    assert sorted(p.name for p in regenerated.iterdir()) == [*(f"logged-0-s0{k}" for k in range(3)), "metrics.json"]
    log = read_folder(project / "logged-0", "log")
    for k in range(3):
        name = f"logged-0-s0{k}"
        files = {f"scenario_{name}.parquet", f"log_map_archive_{name}.json", f"signals_{name}.json", f"{name}.rrd"}
        assert {p.name for p in (regenerated / name).iterdir()} == files
        table = pq.read_table(regenerated / name / f"scenario_{name}.parquet")
        assert table.schema.names == COLUMNS.names
        assert set(table["object_type"].to_pylist()) == {"vehicle", "pedestrian"}  # the lorry is a vehicle
        made = read_folder(regenerated / name, "made")
        assert made.motion.steps == 101
        assert made.track_id[made.focal] == "track-0"
        assert set(made.track_id) < set(log.track_id)
        rows = [log.track_id.tolist().index(track) for track in made.track_id]
        assert np.allclose(made.motion.position[:, 0] + made.map.origin, log.motion.position[rows, 0] + log.map.origin, atol=0.01)
        assert np.array_equal(made.signals.state, log.signals.state)


def test_its_rows_hold_the_errors_of_what_was_written(regenerated, project):
    rows = rows_of(regenerated)
    assert [row["id"] for row in rows] == [f"logged-0-s0{k}" for k in range(3)]
    log = select(read_folder(project / "logged-0", "log"), replace(SELECTION, max_vehicles=6))
    for row in rows:
        made = read_folder(regenerated / row["id"], "made")
        order = [made.track_id.tolist().index(track) for track in log.vehicles.track_id]
        motion = made.motion[order]
        motion = replace(motion, position=motion.position + (made.map.origin - log.map.origin).astype(np.float32))
        sade, sfde = scene_errors(motion[np.newaxis], log.log)
        assert (row["sade"], row["sfde"]) == (pytest.approx(sade[0], abs=0.01), pytest.approx(sfde[0], abs=0.01))
        assert row["sade"] > 0
        assert (row["vehicles"], row["dropped"], row["rejected"]) == (6, 0, None)
        assert row["illegal"] >= max(row["violations"].values(), default=0)


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others(regenerated, run, tmp_path):
    words = ("--scenario", "logged-0", "--vehicles", "6", "--samples", "3")
    for out, seed in (("again", "7"), ("other", "8")):
        assert run(*words, "--seed", seed, "--out", str(tmp_path / out))[0] == 0

    def contents(folder):
        return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file() and p.suffix != ".rrd"}

    assert contents(tmp_path / "again") == contents(regenerated)
    assert contents(tmp_path / "other") != contents(regenerated)


def test_new_traffic_counts_everyone_and_holds_only_what_is_legal(written):
    assert {"map.net.xml", "map.json", "map.png"} == {p.name for p in (written / "map").iterdir()}
    rows = rows_of(written)
    assert len(rows) == 3
    for row in rows:
        assert row["vehicles"] + sum(row["not_placed"].values()) == 16
        assert row["sade"] is None
        if row["rejected"]:
            assert row["id"] is None
            continue
        assert row["illegal"] == 0
        assert row["violations"] == {}
        assert len(read_folder(written / row["id"], "made").track_id) == row["vehicles"] - row["dropped"]
    folders = {p.name for p in written.iterdir()} - {"map", "metrics.json"}
    assert folders == {row["id"] for row in rows if row["id"]}
    assert all(name.startswith("a-motorway-with") for name in folders)


def test_a_network_needs_no_words_and_any_name_becomes_an_id(run, tmp_path):
    code, said = run("--map", "town centre.net.xml", "--vehicles", "4", "--samples", "2", "--out", str(tmp_path / "out"))
    assert (code, said.count("scenarios of")) == (0, 1), said
    rows = rows_of(tmp_path / "out")
    assert all(row["id"].startswith("town-centre-7-0000-s0") for row in rows if row["id"])
    made = next(tmp_path.glob("out/town-centre-*/signals_*.json"))
    assert set(json.loads(made.read_text())["signals"][0]["states"]) <= set("GYR")


def test_vehicles_beset_the_target_on_request_and_only_on_a_map(run, tmp_path):
    words = ("--map", "town centre.net.xml", "--vehicles", "6", "--samples", "8")
    for more in ("", "--beset"):
        code, said = run(*words, *filter(None, [more]), "--out", str(tmp_path / f"out{more}"))
        assert code == 0, said
    beset, as_always = (sorted(tmp_path.glob(f"out{more}/town-centre-*/scenario_*.parquet")) for more in ("--beset", ""))
    assert beset
    assert [file.read_bytes() for file in beset] != [file.read_bytes() for file in as_always]
    code, said = run("--text", "a roundabout", "--beset", "--out", str(tmp_path / "words"))
    assert code == 2
    assert "--beset places vehicles on a map" in said


def test_a_map_is_given_by_its_folder_too_and_what_was_not_got_is_named(run, project, tmp_path):
    (tmp_path / "Old harbour").mkdir()
    shutil.copy(project / "town centre.net.xml", tmp_path / "Old harbour" / "map.net.xml")
    words = ("--map", str(tmp_path / "Old harbour"), "--text", "sixty cars", "--samples", "6", "--seed", "8")
    code, said = run(*words, "--out", str(tmp_path / "out"))
    assert code == 1, said  # nothing of what was asked for was done
    made = sum(not row["rejected"] for row in rows_of(tmp_path / "out"))
    assert len(list(tmp_path.glob("out/old-harbour-8-0000-s0*"))) == made
    assert "not done: 60 vehicles beside the target" in said


def test_view_takes_what_was_generated_and_can_record_it_again(regenerated, tmp_path, capsys):
    folder = regenerated / "logged-0-s00"
    assert call(tmp_path, "view", str(folder), "--no-show") == 0
    assert str(folder / "logged-0-s00.rrd") in capsys.readouterr().out
    assert call(tmp_path, "view", str(folder), "--no-show", "--out", "mine.rrd") == 0
    assert [p.name for p in tmp_path.iterdir()] == ["mine.rrd"]


@pytest.fixture
def broken(project: Path, tmp_path: Path) -> Path:
    """Inputs that cannot be used, each by its name."""
    for name in ("truncated", "mapless", "walkers"):
        shutil.copytree(project / "logged-0", tmp_path / name)
    tracks = next((tmp_path / "truncated").glob("*.parquet"))
    tracks.write_bytes(tracks.read_bytes()[:5000])
    next((tmp_path / "mapless").glob("log_map*.json")).write_text("{}")
    tracks = next((tmp_path / "walkers").glob("*.parquet"))
    table = pq.read_table(tracks)
    pq.write_table(table.filter(np.array(table["object_type"].to_pylist()) == "pedestrian"), tracks)
    (tmp_path / "not.net.xml").write_text("a town of two roads")
    (tmp_path / "town.xodr").write_text("<OpenDRIVE></OpenDRIVE>")
    (tmp_path / "bomb.net.xml").write_text('<!DOCTYPE net [<!ENTITY a "a">]><net>&a;</net>')
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").write_text("mine")
    return tmp_path


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--scenario", "{}/truncated"], "is no whole Parquet file"),
        (["--scenario", "{}/mapless"], "log_map_archive_logged-0.json"),
        (["--scenario", "{}/walkers"], "has no vehicles"),
        (["--scenario", "{}"], "holds 0 files scenario_<id>.parquet"),
        (["--map", "{}/not.net.xml"], "not.net.xml"),
        (["--map", "{}/bomb.net.xml"], "bomb.net.xml"),
        (["--map", "{}/nowhere.net.xml"], "is not there: `drivegen map` makes maps"),
        (["--map", "{}/full"], "full/map.net.xml is not there"),
        (["--map", "{}/town.xodr"], "bring other formats in with `drivegen map import`"),
        (["--text", "sing me a song"], "I do not read"),
        (["--scenario", "logged-0", "--out", "{}/full"], "is not empty: name a new folder"),
        (["--scenario", "logged-0", "--out", "{}/not.net.xml"], "is there and no folder"),
        (["--scenario", "logged-0", "--vehicles", "0"], "--vehicles"),
        (["--scenario", "logged-0", "--seed", "-1"], "--seed"),
        ([], "give exactly one of"),
    ],
)
def test_what_cannot_be_used_exits_2_with_a_sentence_and_leaves_nothing(run, broken, words, sentence):
    before = sorted(broken.rglob("*"))
    code, said = run("--out", str(broken / "out"), *(word.format(broken) for word in words))
    assert code == 2
    assert sentence in said.replace("\n", " ")
    assert "Traceback" not in said
    assert sorted(broken.rglob("*")) == before


@pytest.mark.parametrize(
    ("missing", "words"),
    [
        ("data/models/planners", ["--scenario", "logged-0"]),
        ("data/models/selector", ["--scenario", "logged-0"]),
        ("data/models/limits.json", ["--scenario", "logged-0"]),
        ("data/assets.parquet", ["--text", "roundabout with four arms"]),
        ("params.yaml", ["--scenario", "logged-0"]),
    ],
)
def test_without_what_make_run_leaves_it_exits_1_and_says_so(run, project, tmp_path, missing, words):
    folder = shutil.copytree(project, tmp_path / "project")
    lost = folder / missing
    (shutil.rmtree if lost.is_dir() else Path.unlink)(lost)
    code, said = run("--out", "out", *words, cwd=folder)
    assert code == 1
    assert "make run" in said or missing == "params.yaml"
    assert missing.split("/")[-1] in said
    assert not list(folder.glob("*out*"))


def test_words_are_read_before_models_are_looked_for(run, project, tmp_path):
    folder = shutil.copytree(project, tmp_path / "project")
    shutil.rmtree(folder / "data/models/selector")
    code, said = run("--out", "out", "--text", "a motorway with a blorb", cwd=folder)
    assert (code, "'blorb'" in said, "try: A motorway." in said) == (2, True, True)


@pytest.fixture
def small_disk(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[int], None]]:
    """Sets the size that a file may grow to, which fails as a full disk does."""
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # cut-off compiled modules would be left
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    yield lambda size: resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.parametrize("room", [3_000, 80_000])  # the tracks do not fit, the recording does not
def test_a_full_disk_exits_1_and_leaves_nothing(run, small_disk, tmp_path, room):
    small_disk(room)
    code, said = run("--scenario", "logged-0", "--samples", "1", "--out", str(tmp_path / "out"))
    assert code == 1
    assert "File too large" in said or "is the disk full?" in said
    assert "Traceback" not in said
    assert not list(tmp_path.iterdir())


def test_what_a_model_was_asked_for_words_is_a_row_of_its_calls(run: Run, project: Path, tmp_path: Path) -> None:
    words = ("--map", "town centre.net.xml", "--text", "three cars", "--samples", "1", "--out", str(tmp_path / "asked"))
    with serving([Says("six lorries, or so")]) as server:
        code, said = run(*words, "--lm", f"openai:little-model@{server.url}")
        assert (code, len(server.requests)) == (2, 3)
    assert "the traffic could not be read by the language model little-model" in said
    assert "about 1 calls" in said
    assert "dollars unknown" in said
    [file] = (project / FOLDER).glob("generate-*.parquet")
    assert pq.read_table(file)["outcome"].to_pylist() == ["asked again", "asked again", "invalid-answer"]
