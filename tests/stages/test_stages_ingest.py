"""Stage ingest: what is accepted, rejected, kept and made again."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pyarrow.parquet as pq
import pytest
import yaml

from drivegen.av2.export import export_scenario
from drivegen.core.errors import UnusableInput
from drivegen.datasets.sumo_corpus import write_part
from drivegen.ingest.selection import Settings
from drivegen.ingest.shards import EMPTY
from drivegen.ingest.sources import open_dataset
from drivegen.store.scenarios import read_shard, shards
from stages import ingest
from tests.scenes import busy_crossing

STEPS = 20
SELECTION = Settings(target="focal", max_vehicles=5, first_step=0, horizon=15, map_radius=None, smallest_shrink=0.8)


def params(world: Path, **changes: object) -> ingest.Params:
    wanted = ingest.Params(
        workers=1,
        source="sumo_corpus",
        root=str(world / "av2"),
        train_on=("sumo_corpus",),
        roots={},
        held_out={"sumo_corpus": "test", "argoverse2": "val"},
        fewest_tracks=200,
        limits={"train": None, "val": None, "test": None},
        recordings=(),
        shard_size=2,
        selection=SELECTION,
        horizons={},
    )
    return replace(wanted, **changes)


def add_real(world: Path, split: str, *names: str) -> None:
    for name in names:
        scene = busy_crossing(STEPS, name)
        assert scene.log is not None
        export_scenario(scene, scene.log, world / "av2" / split, name)


@pytest.fixture
def world(tmp_path: Path) -> Path:
    """A corpus of 3 training, 1 validation and 2 test scenes; Argoverse 2 with 2, 1 and none."""
    for split, count in (("train", 3), ("val", 1), ("test", 2)):
        write_part(tmp_path / "corpus" / split, f"{split}town-000", [busy_crossing(STEPS, f"{split}-{i}") for i in range(count)])
    add_real(tmp_path, "train", "real-a", "real-c")
    add_real(tmp_path, "val", "real-e")
    return tmp_path


def run(world: Path, **changes: object) -> dict:
    open_dataset.cache_clear()  # a stage is a process of its own
    ingest.main(params(world, **changes), world / "corpus", world / "out", world / "ingest.json")
    return json.loads((world / "ingest.json").read_text())


def ids(world: Path, split: str) -> list[str]:
    return [scenario.scenario_id for shard in shards(world / "out" / split) for scenario in read_shard(shard)]


def contents(world: Path) -> dict[str, bytes]:
    return {str(p.relative_to(world / "out")): p.read_bytes() for p in (world / "out").rglob("*") if p.is_file()}


def test_the_corpus_keeps_its_own_splits(world: Path) -> None:
    report = run(world)
    assert [ids(world, split) for split in ingest.SPLITS] == [["train-0", "train-1", "train-2"], ["val-0"], ["test-0", "test-1"]]
    assert report["trained_on"] == "SUMO corpus (simulated)"
    counts = report["splits"]["test"]["SUMO corpus (simulated)"]
    assert counts["accepted"] == 2
    assert counts["vehicles"] == 10
    assert counts["scored_agent_steps"] == 2 * 5 * 15


def test_a_source_with_few_tracks_is_measured_on_and_the_corpus_trained_on(world: Path) -> None:
    report = run(world, source="argoverse2", train_on=("argoverse2",))
    assert ids(world, "test") == ["real-a", "real-c", "real-e"]
    assert ids(world, "train") == ["train-0", "train-1", "train-2"]
    assert report["trained_on"] == "SUMO corpus (simulated)"
    assert report["note"] == "argoverse2 has 10 usable training tracks, fewer than 200: not trained on"


def test_a_source_with_enough_tracks_is_trained_on_and_its_held_out_split_measured_on(world: Path) -> None:
    report = run(world, source="argoverse2", train_on=("argoverse2", "sumo_corpus"), fewest_tracks=10)
    assert ids(world, "test") == ["real-e"]
    assert sorted(ids(world, "train") + ids(world, "val")) == ["real-a", "real-c", "train-0", "train-1", "train-2", "val-0"]
    assert report["trained_on"] == "Argoverse 2 Motion Forecasting, SUMO corpus (simulated)"


def test_every_rejected_scene_is_counted_with_its_reason(world: Path, capsys: pytest.CaptureFixture[str]) -> None:
    add_real(world, "val", "real-f", "real-g")
    next((world / "av2/val/real-f").glob("*.parquet")).write_bytes(b"PAR1")
    next((world / "av2/val/real-g").glob("*.json")).write_text("{}")
    report = run(world, source="argoverse2")
    counts = report["splits"]["test"]["Argoverse 2 Motion Forecasting"]
    assert (counts["accepted"], counts["rejected"]) == (3, 2)
    assert counts["rejected.truncated"] == counts["rejected.bad-map"] == 1
    rows = pq.read_table(world / "out/rejected.parquet").to_pylist()
    assert [(row["split"], row["scene"], row["reason"]) for row in rows] == [
        ("test", "real-f", "truncated"),
        ("test", "real-g", "bad-map"),
    ]
    assert all(row["sentence"] for row in rows)
    told = f"ingest: 2 scenes rejected (1 x truncated, 1 x bad-map): {world / 'out/rejected.parquet'} says why of each"
    assert told in capsys.readouterr().out


def test_an_id_is_one_scenario_s_in_all_splits_and_its_folder_s_name(world: Path) -> None:
    shutil.copytree(world / "av2/train/real-a", world / "av2/val/real-a")
    shutil.copytree(world / "av2/train/real-a", world / "av2/val/copy")
    run(world, source="argoverse2", train_on=("argoverse2",), fewest_tracks=10)
    assert sorted(ids(world, "train") + ids(world, "val") + ids(world, "test")) == ["real-a", "real-c", "real-e"]
    rows = pq.read_table(world / "out/rejected.parquet").to_pylist()
    found = [(row["split"], row["scene"], row["reason"]) for row in rows]
    assert found == [("val", "real-a", "shown-in-test"), ("test", "copy", "bad-id")]  # val: a share of train, held back
    assert rows[0]["sentence"].endswith("the test split shows the same cars, so nobody learns from it")


def test_of_scenes_with_one_name_the_first_is_kept_and_the_others_are_said(world: Path) -> None:
    (world / "av2/test").mkdir()
    (world / "av2/val/real-e").rename(world / "av2/test/real-e")
    shutil.copytree(world / "av2/train/real-a", world / "av2/val/real-a")
    run(world, source="argoverse2", train_on=("argoverse2",), fewest_tracks=10, held_out={"argoverse2": "test"})
    rows = pq.read_table(world / "out/rejected.parquet").to_pylist()
    assert [(row["split"], row["scene"], row["reason"]) for row in rows] == [("val", "real-a", "duplicate-id")]
    assert rows[0]["sentence"].endswith(": remove or rename one of them")


def test_limits_take_at_most_so_many_scenes(world: Path) -> None:
    run(world, limits={"train": 2, "val": None, "test": 1})
    assert len(ids(world, "train")) == 2
    assert len(ids(world, "test")) == 1


def test_the_same_input_gives_the_same_bytes_in_one_process_or_two(world: Path) -> None:
    run(world)
    alone = contents(world)
    shutil.rmtree(world / "out")
    run(world, workers=2)
    assert contents(world) == alone


def test_more_scenes_touch_new_shards_only(world: Path) -> None:
    run(world, source="argoverse2")
    before = {path: path.stat().st_mtime_ns for path in (world / "out").rglob("shard-*")}
    add_real(world, "val", "real-b")
    run(world, source="argoverse2")
    after = {path: path.stat().st_mtime_ns for path in (world / "out").rglob("shard-*")}
    assert {path: after[path] for path in before} == before
    assert {path.stem for path in set(after) - set(before)} == {"shard-00002"}
    assert ids(world, "test") == ["real-a", "real-c", "real-e", "real-b"]


def test_changed_input_settings_lost_and_damaged_files_are_made_again(world: Path) -> None:
    run(world)
    first = contents(world)
    (world / "out/train/shard-00000.parquet").unlink()
    damaged = bytearray(first["train/shard-00001.parquet"])
    damaged[len(damaged) // 2] ^= 1
    (world / "out/train/shard-00001.parquet").write_bytes(damaged)
    (world / "out/notes/val/shard-00000.json").write_text("{")
    (world / "out/test/.shard-00000.parquet.77.part").write_bytes(b"half")
    run(world)
    assert contents(world) == first
    run(world, selection=replace(SELECTION, max_vehicles=3))
    assert all(len(s.vehicles) == 3 for shard in shards(world / "out/train") for s in read_shard(shard))
    write_part(world / "corpus/test", "testtown-000", [busy_crossing(STEPS - 2, f"test-{i}") for i in range(2)])
    run(world, selection=replace(SELECTION, max_vehicles=3, horizon=50))
    assert all(s.horizon == STEPS - 3 for shard in shards(world / "out/test") for s in read_shard(shard))


def test_a_data_set_of_short_recordings_has_a_horizon_of_its_own(world: Path) -> None:
    run(world, train_on=("sumo_corpus", "argoverse2"), fewest_tracks=1, roots={"argoverse2": str(world / "av2")},
        horizons={"argoverse2": 12})  # fmt: skip
    found = {s.scenario_id: s.horizon for shard in shards(world / "out/train") for s in read_shard(shard)}
    assert found == {"real-a": 12, "real-c": 12} | {f"train-{i}": 15 for i in range(3)}


def test_an_empty_split_says_so_in_a_file_because_no_cache_keeps_an_empty_folder(world: Path) -> None:
    note = world / "out" / "val" / EMPTY
    run(world, limits={"train": None, "val": 0, "test": None})
    assert ids(world, "val") == []
    assert [path.name for path in note.parent.iterdir()] == [EMPTY]
    assert note.read_text().startswith("No scene is in this split (source: sumo_corpus)")
    run(world)
    assert ids(world, "val") == ["val-0"]
    assert not note.exists()


def test_scenes_that_are_gone_leave_no_shard_behind(world: Path) -> None:
    run(world)
    shutil.rmtree(world / "corpus/val")
    run(world)
    assert ids(world, "val") == []


def test_a_killed_run_is_taken_up_and_ends_in_the_same_bytes(world: Path) -> None:
    for i in range(60):
        write_part(world / "corpus/train", f"more-{i:03d}", [busy_crossing(STEPS, f"more-{i:03d}")])
    written = {**vars(params(world, shard_size=1)), "selection": vars(SELECTION)}
    written["train_on"] = list(written["train_on"])
    (world / "params.yaml").write_text(yaml.safe_dump({"ingest": written}))
    command = [sys.executable, "-m", "stages._door", "ingest", "corpus", "out", "ingest.json"]
    environment = {**os.environ, "PYTHONPATH": str(Path(ingest.__file__).parents[1])}
    process = subprocess.Popen(command, cwd=world, env=environment, stdout=subprocess.DEVNULL)
    while not list((world / "out").rglob("notes/train/shard-0000[3-9].json")) and process.poll() is None:
        time.sleep(0.002)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    done = {path: path.stat().st_mtime_ns for path in (world / "out/notes").rglob("*.json")}
    assert not (world / "ingest.json").exists()
    run(world, shard_size=1)
    assert all(path.stat().st_mtime_ns == stamp for path, stamp in done.items())
    taken_up = contents(world)
    shutil.rmtree(world / "out")
    run(world, shard_size=1)
    assert contents(world) == taken_up


def test_nothing_usable_is_an_error_that_says_why(world: Path) -> None:
    for scene in (world / "av2").glob("*/*/scenario_*.parquet"):
        scene.write_bytes(b"")
    with pytest.raises(UnusableInput, match=r"no scene can be used as test scenario \(3 x truncated"):
        run(world, source="argoverse2")


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"source": "argoverse9"}, "argoverse9"),
        ({"source": "argoverse", "train_on": ("argoverse2",)}, "no datasets plugin is called 'argoverse'"),
        ({"train_on": ("argoverse2",)}, "ingest.roots"),
        ({"held_out": {}, "train_on": ("sumo_corpus",)}, "held_out"),
    ],
)
def test_settings_that_mean_nothing_are_refused(world: Path, changes: dict, word: str) -> None:
    with pytest.raises(UnusableInput, match=word):
        run(world, **changes)
