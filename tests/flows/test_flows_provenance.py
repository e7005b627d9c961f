"""Of which code a run is, and which times survive when its workspace is made anew."""

import json
import logging
import subprocess
from pathlib import Path
from unittest.mock import Mock

import pytest
import yaml

from flows import pipeline, tables
from flows.costs import COSTS
from flows.provenance import CODE, Times, note_code
from flows.rooms import ROOMS, Room
from tests.flows import toy


def lock(root: Path, **stages: str) -> None:
    root.mkdir(parents=True, exist_ok=True)
    (root / "dvc.lock").write_text(
        yaml.safe_dump({"schema": "2.0", "stages": {n.replace("__", "@"): {"cmd": v} for n, v in stages.items()}})
    )


def cost(root: Path, name: str, text: str) -> Path:
    file = root / COSTS / f"{name}.parquet"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)
    return file


def test_times_stay_of_stages_that_are_as_they_were(tmp_path: Path) -> None:
    old, new = tmp_path / "old", tmp_path / "new"
    lock(old, train__bits="a", train__idm="a", select="a", goals__log="a", attack__gail="a")
    for name in ("train-bits", "train-idm", "select-ranker", "goals-log", "attack-gail-cat.legal.10"):
        cost(old, name, "old")
    times = Times.of(old)
    lock(new, train__bits="a", train__idm="b", select="a", goals__log="a", attack__gail="a")
    mine = cost(new, "goals-log", "new")
    times.put_back(new)
    assert {file.stem for file in (new / COSTS).iterdir()} == {
        "train-bits", "select-ranker", "goals-log", "attack-gail-cat.legal.10",
    }  # fmt: skip
    assert mine.read_text() == "new"


def test_times_stay_of_stages_that_measure_us(tmp_path: Path) -> None:
    for root in (tmp_path / "old", tmp_path / "new"):
        lock(root / "stages", map_suite="a")
    cost(tmp_path / "old", "map_suite-map_suite", "old")
    Times.of(tmp_path / "old").put_back(tmp_path / "new")
    assert (tmp_path / "new" / COSTS / "map_suite-map_suite.parquet").exists()


def test_where_there_was_no_workspace_nothing_is_put_back(tmp_path: Path) -> None:
    Times.of(tmp_path / "nowhere").put_back(tmp_path)
    assert not (tmp_path / COSTS).exists()


def test_times_stay_of_a_run_that_is_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(toy.build_tables(tmp_path))
    room = Room("toy/7-7", {}, ("evaluate",))

    def stopped(_plan: object, _stages: object, root: Path) -> dict[str, Mock]:
        pipeline.reproduce("ingest", lambda _: None, root)
        return {"evaluate@log": Mock(wait=Mock(side_effect=KeyboardInterrupt))}

    monkeypatch.setattr(tables, "submit", stopped)
    monkeypatch.setattr(tables, "get_run_logger", logging.getLogger)
    with pytest.raises(KeyboardInterrupt):
        tables._bring_up(room, [])
    file = cost(ROOMS / room.name, "ingest", "an hour")  # as the stage itself would leave it
    with pytest.raises(KeyboardInterrupt):
        tables._bring_up(room, [])
    assert file.read_text() == "an hour"


def test_times_stay_of_a_run_that_is_killed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is put back by who is killed while the stages run, or come back from the cache."""
    monkeypatch.chdir(toy.build_tables(tmp_path))
    room = Room("toy/7-7", {}, ("evaluate",))

    def run(_plan: object, _stages: object, root: Path) -> dict[str, Mock]:
        pipeline.reproduce("ingest", lambda _: None, root)
        return {}

    monkeypatch.setattr(tables, "submit", run)
    monkeypatch.setattr(tables, "get_run_logger", logging.getLogger)
    tables._bring_up(room, [])
    file = cost(ROOMS / room.name, "ingest", "an hour")  # as the stage itself would leave it
    with monkeypatch.context() as killed:
        killed.setattr(Times, "put_back", lambda _times, _root: None)
        tables._bring_up(room, [])
        assert not file.exists()
        tables._bring_up(room, [])
    tables._bring_up(room, [])
    assert file.read_text() == "an hour"


@pytest.mark.parametrize("content", [b"", b"[]", b"{", b'{"a": 1}', b'{"a": ["!", "b"]}', b"\xff"])
def test_damaged_times_are_none(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "room.costs.json").write_bytes(content)
    assert Times.of(tmp_path / "room") == Times({})


def test_a_run_knows_its_commit_and_whether_what_makes_runs_differs_from_it(tmp_path: Path) -> None:
    source = tmp_path / "source"
    source.mkdir()
    toy.build(source)
    who = ("-c", "user.name=a", "-c", "user.email=a@example.org", "-c", "commit.gpgsign=false")
    subprocess.run(["git", *who, "commit", "-q", "-m", "toy"], cwd=source, check=True)
    note_code(source, tmp_path / "room")
    said = json.loads((tmp_path / "room" / CODE).read_text())
    head = subprocess.run(["git", "rev-parse", "HEAD"], cwd=source, capture_output=True, text=True, check=True).stdout.strip()
    assert said == {"commit": head, "changed": False}
    (source / "README.md").write_text("words")
    note_code(source, tmp_path / "room")
    assert json.loads((tmp_path / "room" / CODE).read_text())["changed"] is False
    for name in ("params.yaml", "stages/params.yaml", "flows/tables.yaml", "drivegen/a.py", "pyproject.toml", "constraints.txt"):
        file = source / name
        before = file.read_bytes() if file.exists() else None
        file.parent.mkdir(exist_ok=True)
        file.write_text("run: {seed: 8}")
        note_code(source, tmp_path / "room")
        assert json.loads((tmp_path / "room" / CODE).read_text())["changed"] is True, name
        file.unlink() if before is None else file.write_bytes(before)
    note_code(source, tmp_path / "room")
    assert json.loads((tmp_path / "room" / CODE).read_text())["changed"] is False


def test_without_git_a_run_knows_nothing_of_its_code(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    note_code(tmp_path, tmp_path / "room")
    assert json.loads((tmp_path / "room" / CODE).read_text()) == {"commit": None, "changed": None}
