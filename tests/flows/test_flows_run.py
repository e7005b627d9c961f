"""The three flows under a local Prefect server, on a pipeline of shell commands."""

import json
import os
from pathlib import Path

import pytest

from flows import server
from tests.flows import toy


@pytest.fixture(scope="module")
def running(tmp_path_factory):
    """A server of our own for this file, and no trace of it afterwards."""
    before = dict(os.environ)
    with server.local_server(tmp_path_factory.mktemp("prefect")) as url:
        yield url
    os.environ.clear()
    os.environ.update(before)


@pytest.fixture
def root(running, tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(toy.build(tmp_path))
    return tmp_path


def states(rows: list[dict[str, str]]) -> dict[str, str]:
    return {row["stage"]: row["state"] for row in rows}


def test_everything_runs_once_and_the_second_flow_finds_nothing_to_do(root):
    from flows.experiment import experiment

    assert set(states(experiment()).values()) == {"Completed"}
    assert (root / "data" / "shipped" / "shard").read_text() == "seed: 7\nlogs\n"
    before = (root / "dvc.lock").read_bytes()
    assert set(states(experiment()).values()) == {"Cached"}
    assert (root / "dvc.lock").read_bytes() == before


def test_a_failed_stage_fails_the_flow_by_name_and_stops_only_what_needs_it(root):
    from flows.experiment import experiment

    (root / "dvc.yaml").write_text(toy.DVC.replace("cat data/maps", "echo no map here; cat data/map"))
    state = experiment(return_state=True)
    assert state.is_failed()
    assert state.message is not None
    assert state.message.startswith("stage place failed: ")
    assert (root / "data" / "round-3").exists()
    assert not (root / "data" / "shipped").exists()


def test_rounds_go_on_until_the_collision_rate_stops_rising(root):
    from flows.iterate import iterate

    assert iterate() == [0.1, 0.3, 0.3]
    assert not (root / "data" / "round-3").exists()
    assert iterate(min_gain=0.25) == [0.1, 0.3]


def test_a_version_has_its_own_seed_and_a_manifest_and_is_never_overwritten(root):
    from flows.experiment import experiment
    from flows.regenerate import regenerate, seed_of

    experiment()
    assert regenerate(version="first") == "data/versions/first"
    version = root / "data" / "versions" / "first"
    manifest = json.loads((version / "manifest.json").read_text())
    assert manifest["seed"] == seed_of("first")
    assert (version / "data" / "shipped" / "shard").read_text() == f"seed: {seed_of('first')}\nlogs\n"
    assert set(manifest["files"]) == {"data/maps", "data/placed", "data/shipped/shard", "data/ship.json", "dvc.lock"}
    assert (root / "data" / "shipped" / "shard").read_text() == "seed: 7\nlogs\n"
    assert list((root / ".drivegen" / "regenerate").iterdir()) == []
    state = regenerate(version="first", return_state=True)
    assert state.is_failed()
    assert "never overwritten" in str(state.message)


def test_without_models_nothing_is_published(root):
    from flows.regenerate import regenerate

    state = regenerate(version="early", seed=1, return_state=True)
    assert state.is_failed()
    assert "run `make run` first" in str(state.message)
    assert not (root / "data" / "versions").exists()
