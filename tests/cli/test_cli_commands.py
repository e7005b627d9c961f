"""The command line as a user meets it: exit codes, one sentence, no traceback."""

import importlib.metadata
import io
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
import pytest
import rerun as rr

from drivegen import cli
from drivegen.av2.export import export_scenario
from drivegen.cli import doctor
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import write_shard
from tests import scenes
from tests.small_datasets import sensor_log

COMMAND = [sys.executable, "-c", "from drivegen.cli import main; main()"]


def process(*words: str, cwd: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """`drivegen WORDS` in a process of its own, as a user starts it: seconds, most of which import libraries."""
    return subprocess.run(
        [*COMMAND, *words], cwd=cwd, env={**os.environ, "DISPLAY": "", **environment}, capture_output=True, text=True, check=False
    )


def run(*words: str, cwd: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """The same in this process."""
    said, complained = (io.TextIOWrapper(io.BytesIO(), "utf-8", write_through=True) for _ in range(2))
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(said), redirect_stderr(complained):
        patch.chdir(cwd)
        patch.setattr(sys, "argv", ["drivegen", *words])
        for name, value in {"DISPLAY": "", **environment}.items():
            patch.setenv(name, value)
        with pytest.raises(SystemExit) as left:
            cli.main()
    texts = (stream.detach().getvalue().decode() for stream in (said, complained))
    return subprocess.CompletedProcess(words, int(left.value.code or 0), *texts)


@pytest.fixture
def folder(tmp_path) -> Path:
    """A scenario folder in the official layout."""
    road = scenes.straight_road()
    log = scenes.stack([scenes.drive(road.centreline[0], 20.0 + 15 * i, 8.0, 101) for i in range(3)])
    return export_scenario(scenes.scenario(road, log), log, tmp_path, "scene-0")


def test_view_writes_a_recording_where_no_screen_is(folder, tmp_path):
    done = process("view", str(folder), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "scene-0.rrd" in done.stdout
    assert (tmp_path / "scene-0.rrd").stat().st_size > 1000


def test_the_words_that_view_prints_can_be_typed_whatever_the_path(folder, tmp_path):
    place = folder.rename(tmp_path / "Straße 1, [links]")
    done = run("view", str(place), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert shlex.split(done.stdout.split("`")[1])[-1] == "Straße 1, [links].rrd"


def test_view_shows_all_of_a_sensor_log(tmp_path):
    sensor_log(tmp_path / "log-a", frames=130)
    done = run("view", "log-a", "--no-show", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    steps = {
        int(step)
        for chunk in rr.chunk.RrdReader(tmp_path / "log-a.rrd").stream()
        if chunk.entity_path == "/world/traffic/target"
        for name in chunk.timeline_names
        if name == "step"
        for step in chunk.to_record_batch().column("step").to_pylist()
    }
    assert max(steps) == 128  # of 130 frames: the first has no velocities


def test_view_shows_every_vehicle_and_says_so(folder, tmp_path):
    tracks = folder / "scenario_scene-0.parquet"
    table = pq.read_table(tracks).filter((pc.field("track_id") != "track-1") | (pc.field("timestep") > 50))
    pq.write_table(
        table.set_column(table.column_names.index("focal_track_id"), "focal_track_id", [["none"] * len(table)]), tracks
    )
    done = run("view", str(folder), "--no-show", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("3 of 3 vehicles; target: track-0, because no vehicle is the focal track\n")


def test_view_takes_the_recording_that_lies_in_the_folder(folder, tmp_path):
    (folder / "made.rrd").write_bytes(b"RRF2")
    done = run("view", str(folder), "--no-show", cwd=tmp_path)
    assert done.returncode == 0
    assert "made.rrd" in done.stdout
    (folder / "other.rrd").write_bytes(b"RRF2")
    done = run("view", str(folder), "--no-show", cwd=tmp_path)
    assert done.returncode == 2
    assert "holds 2 recordings, view one of them" in done.stderr


def test_a_log_that_calls_itself_by_a_path_is_not_recorded(folder, tmp_path):
    tracks = folder / "scenario_scene-0.parquet"
    table = pq.read_table(tracks)
    names = pa.array(["../elsewhere/scene"] * len(table))
    pq.write_table(table.set_column(table.column_names.index("scenario_id"), "scenario_id", names), tracks)
    (tmp_path / "here").mkdir()
    done = run("view", str(folder), "--no-show", cwd=tmp_path / "here")
    assert done.returncode == 2
    assert "'../elsewhere/scene' cannot be a scenario's id" in done.stderr
    assert not list((tmp_path / "here").iterdir())
    assert not (tmp_path / "elsewhere").exists()


def test_view_lists_the_scenarios_of_a_folder_and_takes_the_only_one(folder, tmp_path):
    done = run("view", str(tmp_path), "--no-show", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "scene-0.rrd" in done.stdout
    shutil.copytree(folder, tmp_path / "scene-1")
    done = run("view", ".", "--no-show", cwd=tmp_path)
    assert done.returncode == 2
    assert "holds 2 scenarios, view one of them:" in done.stderr
    assert "drivegen view scene-1" in done.stderr


def test_view_takes_a_recording_and_lets_the_viewer_listen_to_this_machine_alone(tmp_path):
    (tmp_path / "scene.rrd").write_bytes(b"RRF2")
    done = run("view", "scene.rrd", "--no-show", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert shlex.split(done.stdout.split("`")[1])[1:] == ["--bind", "127.0.0.1", "scene.rrd"]


def test_view_takes_the_id_of_a_scenario_or_of_a_future_of_it(tmp_path):
    scene = replace(scenes.busy_crossing(), scenario_id="town:7")
    write_shard(tmp_path / "data/scenarios/test/shard-00000.parquet", [scene])
    samples = scenes.noisy_samples(scene, 2)
    write_samples(tmp_path / "data/generated/drivegen/shard-00000.parquet", [samples])
    for name in ("town:7", "town-7", "town:7-s01"):
        done = run("view", name, "--no-show", cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    assert {file.name for file in tmp_path.glob("*.rrd")} == {"town-7.rrd", "town-7-s01.rrd"}
    (tmp_path / "data/generated").rename(tmp_path / "data/corner")
    done = run("view", "town:7-s01", "--futures", "data/corner/drivegen", "--out", "round.rrd", "--no-show", cwd=tmp_path)
    assert (done.returncode, (tmp_path / "round.rrd").exists()) == (0, True), done.stderr
    shard = tmp_path / "data/corner/drivegen/shard-00000.parquet"
    shard.write_bytes(shard.read_bytes()[:500])
    done = run("view", "town:7-s01", "--futures", "data/corner/drivegen", "--no-show", cwd=tmp_path)
    assert done.returncode == 2
    assert "data/corner/drivegen/shard-00000.parquet" in done.stderr


def test_without_models_generate_says_who_makes_them(tmp_path):
    (tmp_path / "stages").mkdir()
    for name in ("params.yaml", "stages/params.yaml"):
        shutil.copy(Path(__file__).parents[2] / name, tmp_path / name)
    done = run("generate", "--out", "o", "--text", "roundabout with four arms", cwd=tmp_path)
    assert done.returncode == 1
    assert "`make run`" in done.stderr
    assert not (tmp_path / "o").exists()


@pytest.mark.parametrize(
    ("words", "code", "sentence"),
    [
        (["view", "nowhere"], 2, "drivegen: nowhere is no folder"),
        (["view", "."], 2, "holds neither a scenario nor a sensor log nor a recording"),
        (["map", "sing me a song", "--out", "m"], 2, "drivegen: I do not read 'sing'"),
        (["map", "--out", "m"], 2, "Missing argument"),
        (["generate", "--out", "o"], 2, "give exactly one of --scenario, --map and --text"),
        (["generate", "--out", "o", "--map", "x", "--scenario", "y"], 2, "give exactly one of"),
        (["generate", "--out", "o", "--text", "roundabout with four arms"], 1, "change into the project's folder"),
        (["bench", "--only", "nothing"], 2, "no benchmark is called 'nothing'"),
        (["export", "nowhere", "--out", "o"], 2, "nowhere is not there: give a folder of shards"),
        (["export", __file__, "--out", "o"], 2, "is no whole shard"),
        (["generate", "--out", "o", "--text", "x", "--seed", str(2**63)], 2, "'--seed'"),
        (["map", "roundabout with four arms", "--out", "o", "--seed", str(2**63)], 2, "'--seed'"),
        (["map", "roundabout with four arms", "--out", "/dev/null"], 2, "/dev/null is there and no folder: name another one"),
    ],
)
def test_what_cannot_be_done_is_one_sentence_and_exit_code(tmp_path, words, code, sentence):
    done = run(*words, cwd=tmp_path)
    assert done.returncode == code
    assert sentence in done.stderr
    assert "Traceback" not in done.stderr


SMALL_DISK = """
import resource, signal, sys
sys.dont_write_bytecode = True  # Python would leave cut-off files of compiled modules, which nobody can import
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (16_000, resource.RLIM_INFINITY))  # the network fits, its picture does not
from drivegen.cli import main
main()
"""


def test_a_full_disk_exits_1_and_leaves_nothing_half_written(tmp_path):
    command = [sys.executable, "-c", SMALL_DISK, "map", "roundabout with four arms", "--out", "m"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1, done.stderr
    assert done.stderr.startswith("drivegen: ")
    assert "nothing half-written was kept" in done.stderr
    assert "m/map.png" in done.stderr
    assert not list(tmp_path.iterdir())


STOPPED = """
import os, signal, sys, time
from pathlib import Path
number = int(sys.argv.pop())
signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)  # nohup ignores them
from drivegen.cli import generate, main
def stop(**_):
    assert list(Path().glob(".o.*.part"))
    os.kill(os.getpid(), number)
    time.sleep(60)
generate._project.generation = stop
main()
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_a_command_that_is_stopped_leaves_nothing_half_written(tmp_path, number):
    command = [sys.executable, "-c", STOPPED, "generate", "--text", "roundabout with four arms", "--out", "o", str(int(number))]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 128 + number
    assert done.stderr.endswith("drivegen: stopped; nothing half-written was kept\n")
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())


def test_map_writes_three_files_and_refuses_what_it_does_not_read(tmp_path):
    refused = run("map", "a T-junction with purple cows", "--out", "m", "--seed", "3", cwd=tmp_path)
    assert refused.returncode == 2
    assert "I do not read 'purple'" in refused.stderr
    assert not (tmp_path / "m").exists()
    done = run("map", "a T-junction", "--out", "m", "--seed", "3", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "A T-junction with side roads that give way" in done.stdout
    assert {file.name for file in (tmp_path / "m").iterdir()} == {"map.net.xml", "map.json", "map.png"}


def test_the_table_of_maps_is_whole_where_the_terminal_is_narrow(tmp_path):
    done = run("bench", "maps", "--every", "400", cwd=tmp_path, COLUMNS="60", DRIVEGEN_REAL_DATA="")
    assert done.returncode == 0, done.stderr
    assert "right after offer" in done.stdout
    assert "…" not in done.stdout
    assert re.search(r"^own, plain( +\d+){5}", done.stdout, re.MULTILINE)


def test_the_doctor_finds_this_installation_sound_and_says_what_is_not_made_yet(tmp_path):
    done = process("doctor", cwd=tmp_path)
    assert done.returncode == 0, done.stdout
    assert "all" in done.stdout
    assert "make run" in done.stdout


def test_the_doctor_names_what_a_kill_cut_off_or_a_bit_changed(tmp_path):
    for name in ("good", "bad"):
        write_shard(tmp_path / "data" / f"{name}.parquet", [scenes.any_scenario(1)])
    assert [finding.ok for finding in doctor.damage(tmp_path)] == [True]
    raw = (tmp_path / "data" / "bad.parquet").read_bytes()
    (tmp_path / "data" / "bad.parquet").write_bytes(raw[:200] + bytes([raw[200] ^ 4]) + raw[201:])
    (tmp_path / "dvc.lock").write_text("schema: '2.0'\nstages:\n  ingest:\n    cmd: stages/r")
    (tmp_path / "stages").mkdir()
    (tmp_path / "stages/dvc.lock").write_text("schema: '2.0'\nstages:\n  rank:\n")
    lock, other, bad, good = doctor.damage(tmp_path)
    assert (lock.ok, other.ok, bad.ok, good.ok) == (False, False, False, True)
    assert "make run restores it" in lock.remedy
    assert f"{tmp_path}/data/bad.parquet is not what was written" in bad.found
    assert bad.remedy == "remove it, then make run"


def test_the_doctor_names_what_cannot_be_read_and_goes_on(tmp_path):
    (tmp_path / "data/folder.parquet").mkdir(parents=True)
    (tmp_path / "data/link.parquet").symlink_to("nothing")
    write_shard(tmp_path / "data/whole.parquet", [scenes.any_scenario(1)])
    folder, link, whole = doctor.damage(tmp_path)
    assert (folder.ok, link.ok, whole.ok) == (False, False, True)
    assert folder.found == f"{tmp_path}/data/folder.parquet cannot be read: Is a directory"
    assert link.found == f"{tmp_path}/data/link.parquet cannot be read: No such file or directory"
    assert "dvc checkout" in link.remedy


def test_the_doctor_does_not_wait_for_a_simulator_that_hangs(monkeypatch):
    monkeypatch.setattr(doctor, "plain_to_net", lambda _: b"")
    monkeypatch.setattr(doctor.subprocess, "run", Mock(side_effect=subprocess.TimeoutExpired("python", 60)))
    assert [finding.ok for finding in doctor.sumo()] == [True, False]


def test_the_doctor_names_a_wrong_version_with_its_remedy(monkeypatch):
    monkeypatch.setattr(doctor.importlib.metadata, "version", lambda name: "0.165.0" if name == "fastapi" else "nothing")
    wrong = {finding.what: finding for finding in doctor.versions()}
    assert wrong["fastapi"].ok is False
    assert wrong["fastapi"].found == "0.165.0"
    assert "<0.151" in wrong["fastapi"].remedy


def test_a_broken_package_is_told_without_a_traceback(tmp_path):
    (tmp_path / "rerun").mkdir()
    (tmp_path / "rerun" / "__init__.py").write_text("raise ImportError('broken', name='rerun')\n")
    done = process("view", ".", cwd=tmp_path, PYTHONPATH=str(tmp_path))
    assert done.returncode == 1
    assert done.stderr == "drivegen: rerun cannot be imported: `drivegen doctor` says what to do\n"


def test_help_lists_every_command(tmp_path):
    for word in ("--help", "-h"):
        done = process(word, cwd=tmp_path)
        assert done.returncode == 0
        for name, what in cli.COMMANDS.items():  # in one line each, nothing cut off
            assert re.search(rf"^  {name} +{re.escape(what)}$", done.stdout, re.MULTILINE)


def test_the_version_is_that_of_the_package(tmp_path):
    done = process("--version", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, f"drivegen {importlib.metadata.version('drivegen')}\n")
