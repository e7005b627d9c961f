"""The flows under a local Prefect server, on a pipeline of shell commands."""

import json
import os
import time
from pathlib import Path

import pytest
import yaml

from flows import server
from tests.flows import toy


@pytest.fixture(scope="module", autouse=True)
def _running(tmp_path_factory):
    """A server of our own for this file, and no trace of it afterwards; said again for a Prefect that was imported before."""
    before = dict(os.environ)
    with server.local_server(tmp_path_factory.mktemp("prefect")) as url:
        from prefect.settings import PREFECT_API_URL, temporary_settings

        with temporary_settings({PREFECT_API_URL: url}):
            yield
    os.environ.clear()
    os.environ.update(before)


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
    toy.keep_rounds(root, 1)
    state = experiment(return_state=True)
    assert state.is_failed()
    assert state.message is not None
    assert state.message.startswith("stage place failed: ")
    assert (root / "data" / "round-0").exists()
    assert not (root / "data" / "shipped").exists()


def test_rounds_go_on_until_the_collision_rate_stops_rising(root):
    from flows.iterate import iterate

    assert iterate() == [0.1, 0.3, 0.3]
    assert not (root / "data" / "round-3").exists()
    assert iterate(min_gain=0.25) == [0.1, 0.3]


@pytest.mark.parametrize(("finding", "passes"), [("better", True), ("not told apart", True), ("worse", False)])
def test_the_gate_makes_what_it_needs_and_fails_where_the_new_driver_is_worse(root, finding, passes):
    from flows.gate import gate

    (root / "stages").mkdir()
    (root / "stages" / "dvc.yaml").write_text(toy.GATE.replace("FINDING", finding))
    state = gate(return_state=True)
    assert (root / "data" / "scenarios").read_text() == "logs\n"
    assert not (root / "data" / "maps").exists()
    assert state.is_completed() == passes
    assert state.message == f"{finding}: in 3 runs"


def test_a_version_has_its_own_seed_and_a_manifest_and_is_never_overwritten(done):
    from flows.regenerate import regenerate, seed_of

    assert regenerate(version="first") == "data/versions/first"
    version = done / "data" / "versions" / "first"
    manifest = json.loads((version / "manifest.json").read_text())
    assert manifest["seed"] == seed_of("first")
    assert (version / "data" / "shipped" / "shard").read_text() == f"seed: {seed_of('first')}\nlogs\n"
    assert set(manifest["files"]) == {"data/maps", "data/placed", "data/shipped/shard", "data/ship.json", "dvc.lock"}
    assert (done / "data" / "shipped" / "shard").read_text() == "seed: 7\nlogs\n"
    assert list((done / ".drivegen" / "regenerate").iterdir()) == []
    state = regenerate(version="first", return_state=True)
    assert state.is_failed()
    assert "never overwritten" in str(state.message)


def test_where_a_stage_fails_nothing_is_published_and_no_round_follows(done):
    from flows.iterate import iterate
    from flows.regenerate import regenerate

    broken = toy.DVC.replace("cat data/maps", "echo no map here; cat data/map").replace("cp ${item.before}", "cp no/${item.k}")
    asking = "mkdir -p lm_store/aa && echo paid > lm_store/aa/maps.json; grep -o"
    (done / "dvc.yaml").write_text(broken.replace("grep -o", asking))
    state = regenerate(version="broken", return_state=True)
    assert state.is_failed()
    assert str(state.message).startswith("stage place failed: cat: ")
    assert (done / "lm_store/aa/maps.json").read_text() == "paid\n"
    assert not (done / "data" / "versions").exists()
    state = iterate(return_state=True)
    assert state.is_failed()
    assert str(state.message).startswith("stage corner@0 failed: cp: ")


def test_without_models_nothing_is_published(root):
    from flows.regenerate import regenerate

    state = regenerate(version="early", seed=1, return_state=True)
    assert state.is_failed()
    assert "run `make run` first" in str(state.message)
    assert not (root / "data" / "versions").exists()


def test_a_stage_killed_in_the_middle_is_never_taken_as_done(root):
    from flows.experiment import experiment

    sound = "cat data/maps data/scenarios > data/placed"
    (root / "dvc.yaml").write_text(toy.DVC.replace(sound, "cat data/maps > data/placed; kill -9 $$"))
    toy.keep_rounds(root, 1)
    state = experiment(return_state=True)
    assert state.is_failed()
    assert str(state.message).startswith("stage place failed: ")
    assert (root / "data" / "placed").read_text() == "seed: 7\n"  # half of it is there ...
    assert not (root / "data" / "shipped").exists()  # ... and nobody used it
    (root / "dvc.yaml").write_text(toy.DVC)
    after = states(experiment())
    assert (after["place"], after["ship"], after["maps"]) == ("Completed", "Completed", "Cached")
    assert (root / "data" / "shipped" / "shard").read_text() == "seed: 7\nlogs\n"


@pytest.fixture
def runs(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(toy.build_tables(tmp_path))
    return tmp_path


def test_tables_are_pooled_from_runs_that_share_what_they_have_in_common(runs):
    from flows.tables import tables

    asking = "> data/table-${item} && mkdir -p lm_store/aa && echo ${item} > lm_store/aa/${item}.json"
    (runs / "dvc.yaml").write_text((runs / "dvc.yaml").read_text().replace("> data/table-${item}", asking))
    before = runs / ".drivegen/tables/absent/7-7"  # made when this data set was there
    for name in ("reports/metrics", "data"):
        (before / name).mkdir(parents=True)
    state = tables(real=runs, return_state=True)
    assert state.is_completed(), state.message
    assert [folder.name for folder in before.iterdir()] == ["data"]
    assert state.message == "reports/published from 3 runs"
    assert (runs / "reports" / "published" / "pooled").read_text().splitlines() == [
        "toy/7-7/data/table-drivegen drivegen 7 1.0",
        "toy/7-7/data/table-log log 7 1.0",
        "toy/8-7/data/table-drivegen drivegen 8 1.0",
        "toy/8-7/data/table-log log 8 1.0",
        "toy/t0.5/data/table-drivegen drivegen 7 0.5",
    ]
    assert (runs / "ingested").read_text() == "once\n"  # the first run computed it, the others took it from the cache
    assert not list(runs.glob(".drivegen/tables/*/*/data/round-*"))  # no table asks for it
    assert not (runs / "data").exists()
    assert sorted(file.read_text() for file in runs.glob("lm_store/*/*")) == ["drivegen\n", "log\n"]
    assert len(list(runs.glob(".drivegen/tables/toy/*/.drivegen/code.json"))) == 3


def test_a_run_that_fails_ends_the_tables_by_name_and_keeps_the_old_ones(runs):
    from flows.tables import tables

    (runs / "dvc.yaml").write_text((runs / "dvc.yaml").read_text().replace("> data/table-${item}", "> no/such/folder"))
    state = tables(real=runs, return_state=True)
    assert state.is_failed()
    assert str(state.message).startswith("toy/7-7: stage evaluate@drivegen failed: ")
    assert not (runs / ".drivegen" / "tables" / "toy" / "8-7").exists()
    assert not (runs / "reports").exists()


def test_the_deployments_schedule_makes_runs_for_the_sundays_to_come():
    from prefect.client.orchestration import get_client
    from prefect.client.schemas.actions import DeploymentScheduleCreate
    from prefect.client.schemas.filters import DeploymentFilter, DeploymentFilterId
    from prefect.client.schemas.schedules import CronSchedule

    from flows.regenerate import regenerate

    (deployment,) = yaml.safe_load((Path(__file__).parents[2] / "prefect.yaml").read_text())["deployments"]
    assert deployment["entrypoint"] == "flows/regenerate.py:regenerate"
    schedules = [DeploymentScheduleCreate(schedule=CronSchedule(**wanted)) for wanted in deployment["schedules"]]
    with get_client(sync_client=True) as client:
        number = client.create_deployment(client.create_flow(regenerate), name=deployment["name"], schedules=schedules)
        wanted = DeploymentFilter(id=DeploymentFilterId(any_=[number]))
        deadline = time.monotonic() + 30
        while not (made := client.read_flow_runs(deployment_filter=wanted)) and time.monotonic() < deadline:
            time.sleep(0.5)
        client.delete_deployment(number)
    assert made, "the server's scheduler made no run"
    assert all(run.auto_scheduled for run in made)
    assert {(run.expected_start_time.isoweekday(), run.expected_start_time.hour) for run in made} == {(7, 3)}
