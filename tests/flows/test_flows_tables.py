"""Which runs the published tables ask for, and that they are made without touching this workspace."""

import subprocess
from pathlib import Path
from typing import Any

import pytest
import yaml

from drivegen.core.settings import read_section
from drivegen.lm.ledger import Call, Ledger
from flows import FlowFailed
from flows.rooms import BY_SEED, CORNER, FRONT, MEASURED, PARTS, ROOMS, left_out, rooms
from flows.tables import nearest
from flows.workspace import CHECKPOINTS, PARAMS, overridden, renew
from stages import publish_corner

ROOT = Path(__file__).parents[2]
PUBLISH = {
    "seeds": [7, 8],
    "sampling_seeds": [7, 17],
    "temperatures": [0.5],
    "params": {"run.workers": 1},
    "data": {
        "corpus": {"folder": "", "params": {}, "folders": {}, "front": True},
        "real": {
            "folder": "recordings",
            "params": {"ingest.source": "real"},
            "folders": {"ingest.root": "FOLDER", "ingest.roots": {"real": "FOLDER"}},
            "front": False,
        },
    },
}
TABLES = {"tables": {"quality": PUBLISH}}


def test_every_data_set_is_run_with_every_pair_of_seeds_and_its_front_with_the_first(tmp_path: Path) -> None:
    (tmp_path / "recordings").mkdir()
    found = {room.name: room for room in rooms("quality", TABLES, tmp_path)}
    assert list(found) == [
        "corpus/7-7", "corpus/7-17", "corpus/8-7", "corpus/8-17", "corpus/t0.5", "real/7-7", "real/7-17", "real/8-7", "real/8-17",
    ]  # fmt: skip
    assert found["real/8-17"].params == {
        "run.workers": 1, "ingest.source": "real", "ingest.root": str(tmp_path / "recordings"),
        "ingest.roots": {"real": str(tmp_path / "recordings")}, "run.training_seed": 8, "run.sampling_seed": 17,
    }  # fmt: skip
    assert (found["real/8-7"].measured, found["corpus/t0.5"].measured) == (MEASURED, FRONT)
    assert found["corpus/t0.5"].params["run.own"] == ["drivegen"]


def test_a_run_begins_with_what_one_of_the_same_training_seed_made(tmp_path: Path) -> None:
    (tmp_path / "recordings").mkdir()
    asked = list(rooms("quality", TABLES, tmp_path))
    found = [nearest(room, asked[:n]) for n, room in enumerate(asked)]
    assert [room and room.name for room in found] == [
        None, "corpus/7-7", "corpus/7-17", "corpus/8-7", "corpus/7-17", "corpus/7-17", "real/7-7", "corpus/8-17", "real/8-7",
    ]  # fmt: skip


def test_recordings_that_are_not_there_are_left_out(tmp_path: Path) -> None:
    assert [room.name for room in rooms("quality", TABLES, tmp_path)] == [
        "corpus/7-7", "corpus/7-17", "corpus/8-7", "corpus/8-17", "corpus/t0.5",
    ]  # fmt: skip


def test_results_are_left_out_with_their_recordings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    values = {"tables": {"quality": PUBLISH, "drivers": PUBLISH, "corner": {"seeds": [7]}}}
    for run in ("corpus/7-7", "real/7-7", "real/7-17", "drivers/corpus", "drivers/real", "corner/7"):
        (ROOMS / run / "reports").mkdir(parents=True)
    assert {run.as_posix() for run in left_out("quality", values, tmp_path)} == {
        ".drivegen/tables/real/7-7/reports", ".drivegen/tables/real/7-17/reports",
    }  # fmt: skip
    assert list(left_out("drivers", values, tmp_path)) == [ROOMS / "drivers/real/reports"]
    assert list(left_out("corner", values, tmp_path)) == []
    (tmp_path / "recordings").mkdir()
    assert not [*left_out("quality", values, tmp_path), *left_out("drivers", values, tmp_path)]


@pytest.mark.parametrize("name", PUBLISH)
def test_what_tables_lack_is_said_before_any_run(name: str, tmp_path: Path) -> None:
    without = {other: value for other, value in PUBLISH.items() if other != name}
    for section, fault in ((without, f"'{name}' is missing"), ({**PUBLISH, name: None}, "'NoneType' object")):
        with pytest.raises(FlowFailed, match=rf"^tables.quality of params.yaml, or the file named there, .*: {fault}"):
            rooms("quality", {"tables": {"quality": section}}, tmp_path)
    with pytest.raises(FlowFailed, match="'tables' is missing"):
        rooms("quality", {}, tmp_path)


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("real", [True, False])
def test_what_the_runs_of_a_part_replace_is_there(part: str, real: bool, tmp_path: Path) -> None:
    values = yaml.safe_load((ROOT / "params.yaml").read_text())
    for section in ("tables.quality.data", "tables.drivers.data"):
        for data in read_section(section).values() if real else ():
            (tmp_path / data["folder"]).mkdir(parents=True, exist_ok=True)
    runs = list(rooms(part, values, tmp_path))
    assert len({room.name for room in runs}) == len(runs) > 0
    every = {name: value for file in PARAMS for name, value in yaml.safe_load((ROOT / file).read_text()).items()}
    for room in runs:
        replaced = overridden(every, room.params)  # raises FlowFailed for a name that is not there
        assert {name: valued(replaced, name) for name in room.params} == room.params


def test_every_piece_of_the_corner_tables_is_measured() -> None:
    single = {piece.stem for piece in (publish_corner.SCORE, publish_corner.REPAIRED, *publish_corner.PIECES)}
    assert single <= set(BY_SEED[CORNER])


def valued(values: Any, name: str) -> Any:
    """What a dotted name stands for."""
    for word in name.split("."):
        values = values[word]
    return values


def test_the_tables_of_drivers_are_made_from_every_data_set_that_is_there(tmp_path: Path) -> None:
    values = yaml.safe_load((ROOT / "params.yaml").read_text())
    assert [room.name for room in rooms("drivers", values, tmp_path)] == [
        "drivers/sumo_corpus",
        "drivers/unseen",
        "drivers/paper",
    ]
    for data in read_section("tables.drivers.data").values():
        (tmp_path / data["folder"]).mkdir(parents=True, exist_ok=True)
    runs = rooms("drivers", values, tmp_path)
    assert [room.name for room in runs] == [f"drivers/{name}" for name in read_section("tables.drivers.data")]


@pytest.fixture
def source(tmp_path: Path) -> Path:
    source = tmp_path / "source"
    (source / ".dvc").mkdir(parents=True)
    (source / ".dvc/config").write_text("")
    (source / "params.yaml").write_text("run: {seed: 7}\n")
    subprocess.run(["git", "init", "-q", source], check=True)
    return source


@pytest.mark.parametrize("folder", ["lm_store", "answers"])
def test_what_was_paid_for_in_a_run_outlives_it(source: Path, tmp_path: Path, monkeypatch, folder: str) -> None:
    room, answers, calls = tmp_path / "rooms" / "7-7", Path(f"{folder}/aa"), Path(".drivegen/calls")
    if folder != "lm_store":
        (source / "params.yaml").write_text(f"lm: {{records: {{folder: {folder}}}}}")
    (source / answers).mkdir(parents=True)
    for name in ("untouched", "asked again", "asked again meanwhile"):
        (source / answers / f"{name}.json").write_text("before")
    renew(source, room, {})
    monkeypatch.chdir(room)
    for name in ("asked again", "asked"):
        (answers / f"{name}.json").write_text("in the run")
    (answers / ".half.json.host.1.part").write_text("ha")
    for replayed in (False, True):
        ledger = Ledger(1.0, 1)
        ledger.add(Call("goals", "model", "1", "key", 0, 0, replayed=replayed))
        with ledger.kept("goals"):
            pass
    (paid,) = calls.glob("goals-*.parquet")
    row = paid.read_bytes()
    (source / answers / "asked again meanwhile.json").write_text("meanwhile")
    renew(source, room, {})
    assert {file.stem: file.read_text() for file in (source / answers).iterdir()} == {
        "untouched": "before", "asked again": "in the run", "asked again meanwhile": "meanwhile", "asked": "in the run",
    }  # fmt: skip
    assert (room / answers / "asked.json").read_text() == "in the run"
    assert {file.name: file.read_bytes() for file in (source / calls).iterdir()} == {paid.name: row}


def test_a_run_that_is_made_again_keeps_what_interrupted_trainings_go_on_from_and_nothing_else(
    source: Path, tmp_path: Path
) -> None:
    room = tmp_path / "rooms" / "7-7"
    renew(source, room, {"run.seed": 8})
    for name in (CHECKPOINTS / "planner-1.safetensors", Path("data/half.parquet")):
        (room / name).parent.mkdir(parents=True, exist_ok=True)
        (room / name).write_text("half")
    renew(source, room, {"run.seed": 9})
    files = {path.relative_to(room).as_posix() for path in room.rglob("*") if path.is_file()}
    assert files == {"params.yaml", ".dvc/config", ".dvc/config.local", ".drivegen/checkpoints/planner-1.safetensors"}
    assert yaml.safe_load((room / "params.yaml").read_text()) == {"run": {"seed": 9}}
    assert [path.name for path in room.parent.iterdir()] == ["7-7"]
