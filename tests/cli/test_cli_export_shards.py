"""The command `drivegen export` on shards, rounds of corner cases and attacks."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivegen.av2.folder import read_folder
from drivegen.core.scenario import Actors, Trajectories, VehicleKind
from drivegen.exporters.openscenario import Plugin as OpenScenario
from drivegen.store.samples import read_samples, write_samples
from drivegen.store.scenarios import read_shard, write_shard
from tests import scenes
from tests.cli.test_cli_commands import run


def test_what_the_pipeline_ships_is_exported_in_the_official_layout(tmp_path):
    scene = scenes.busy_crossing(20, "crossing-0000-s00")
    write_shard(tmp_path / "shipped" / "shard-00000.parquet", [scene, replace(scene, scenario_id="recording:3")])
    done = run("export", "shipped", "--out", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "2 scenarios" in done.stdout
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["crossing-0000-s00", "recording-3"]
    made = read_folder(tmp_path / "out" / "crossing-0000-s00", "made")
    assert made.track_id[made.focal] == scene.vehicles.track_id[0]
    there = scene.log.valid[0]
    at = made.motion.position[made.focal][there] + made.map.origin
    assert np.allclose(at, scene.log.position[0][there] + scene.map.origin, atol=0.01)
    done = run("export", "shipped/shard-00000.parquet", "--out", "one", "--most", "1", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, "one: 1 scenario of shipped/shard-00000.parquet\n"), done.stderr
    assert len(list((tmp_path / "one").iterdir())) == 1


def test_scenarios_are_exported_in_the_format_that_is_named(tmp_path):
    scene = scenes.busy_crossing(20, "recording:3")
    write_shard(tmp_path / "shipped" / "shard-00000.parquet", [scene])
    done = run("export", "shipped", "--out", "out", "--to", "openscenario", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, "out: 1 scenario of shipped\n"), done.stderr
    OpenScenario().write(scene, scene.log, tmp_path, "recording-3")
    for name in ("recording-3.xosc", "recording-3.xodr"):
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / name).read_bytes()
    done = run("export", "shipped", "--out", "other", "--to", "waymo", cwd=tmp_path)
    assert done.returncode == 2
    assert "choose one of argoverse2, openscenario" in done.stderr
    assert not (tmp_path / "other").exists()


@pytest.fixture
def corner_round(tmp_path) -> Path:
    """Three futures of one scene; in the second the driver collides at step 7, in front of where it was planned to be.

    In the third it leaves the map at step 9.
    """
    scene = scenes.busy_crossing(20, "recording:3")
    made = scenes.noisy_samples(scene, 3, seed=1, method="drivegen_cs")
    made.motion.valid[:, 2] = False  # left out of both
    drove = made.motion[:, :1]
    drove = replace(drove, valid=drove.valid.copy(), position=drove.position + np.float32([1.0, 0.0]))
    drove.valid[1, :, 8:] = drove.valid[2, :, 9:] = False
    columns = {name: getattr(made, name)[:, :1] for name in vars(made) if name not in ("scenario_id", "method", "motion")}
    columns["left_map"] = np.array([[False], [False], [True]])
    write_shard(tmp_path / "data" / "scenarios" / "test" / "shard-00000.parquet", [scene])
    write_samples(tmp_path / "round" / "samples" / "shard-00000.parquet", [made])
    write_samples(tmp_path / "round" / "driven" / "shard-00000.parquet", [replace(made, motion=drove, **columns)])
    return tmp_path


def exported(folder: Path, *words: str) -> dict[str, tuple[int, int, float]]:
    """Of each scenario folder: vehicles, frames of the target and where it first is, along x."""
    done = run("export", *words, "--out", "out", cwd=folder)
    assert done.returncode == 0, done.stderr
    made = {place.name: read_folder(place, "made") for place in (folder / "out").iterdir()}
    shutil.rmtree(folder / "out")
    focal = {name: (log.motion[log.focal], log.map.origin[0]) for name, log in made.items()}
    return {
        name: (len(made[name].track_id), int(target.valid.sum()), round(float(target.position[0, 0] + x), 1))
        for name, (target, x) in focal.items()
    }


def test_futures_are_exported_one_by_one_and_of_a_round_what_collided_as_it_was_driven(corner_round):
    planned = exported(corner_round, "round/samples")
    vehicles = len(scenes.busy_crossing(20).vehicles) - 1
    assert sorted(planned) == ["recording-3-s00", "recording-3-s01", "recording-3-s02"]
    assert {seen[:2] for seen in planned.values()} == {(vehicles, 20)}
    assert exported(corner_round, "round") == planned
    assert exported(corner_round, "round", "--collisions") == {"recording-3-s01": planned["recording-3-s01"]}
    x = round(planned["recording-3-s01"][2] + 1.0, 1)
    assert exported(corner_round, "round", "--collisions", "--driven") == {"recording-3-s01": (vehicles, 8, x)}


def test_cases_of_an_attack_are_exported_and_viewed(corner_round):
    test, attack = corner_round / "data/scenarios/test", corner_round / "attack/idm/cat.legal.10"
    write_shard(test / "shard-00001.parquet", [scenes.busy_crossing(20, "recording:4")])
    [made], [drove] = (read_samples(corner_round / "round" / part / "shard-00000.parquet") for part in ("samples", "driven"))
    case, own = (replace(one, scenario_id="recording:4") for one in (made, drove))
    write_samples(attack / "samples.parquet", [case])
    write_samples(attack / "driven.parquet", [own])
    planned = exported(corner_round, "attack/idm/cat.legal.10")
    assert sorted(planned) == ["recording-4-s00", "recording-4-s01", "recording-4-s02"]
    [driven] = exported(corner_round, "attack/idm/cat.legal.10", "--collisions", "--driven").items()
    assert driven == ("recording-4-s01", (planned["recording-4-s01"][0], 8, round(planned["recording-4-s01"][2] + 1.0, 1)))
    listed = run("view", "attack/idm/cat.legal.10", cwd=corner_round)
    assert listed.stderr.endswith("\n  drivegen view recording:4-s00 --futures attack/idm/cat.legal.10\n")
    for name, code in {"recording:4-s00": 0, "recording:3-s00": 2}.items():  # in the other scene nothing was found
        done = run("view", name, "--futures", "attack/idm/cat.legal.10", "--no-show", cwd=corner_round)
        assert done.returncode == code, done.stderr
    assert (corner_round / "recording-4-s00.rrd").exists()
    elsewhere = run("export", str(attack), "--of", "elsewhere", "--out", "o", cwd=corner_round)
    assert "recording:4, which is not in elsewhere: name" in elsewhere.stderr


@pytest.mark.parametrize("hit", ["a vehicle", "a pedestrian", "one that is not there"])
def test_a_collision_in_the_last_frame_is_one_too(corner_round, hit):
    path, shard = (corner_round / place / "shard-00000.parquet" for place in ("round/driven", "data/scenarios/test"))
    [drove], [scene] = read_samples(path), read_shard(shard)
    [made] = read_samples(corner_round / "round" / "samples" / "shard-00000.parquet")
    last = drove.motion.position[0, 0, -1]  # of the future whose driver came to the end
    last[:] = last + 1000 if hit == "a pedestrian" else made.motion.position[0, {"a vehicle": 1}.get(hit, 2), -1]
    write_samples(path, [drove])
    if hit == "a pedestrian":
        person = Trajectories.empty(1, scene.steps)
        person.position[0, -1], person.valid[0, -1] = last, True
        walking = Actors(np.array(["p"]), np.array([VehicleKind.PEDESTRIAN], np.uint8), np.float32([[0.6, 0.6, 1.8]]), person)
        write_shard(shard, [replace(scene, context=walking)])
    found = set(exported(corner_round, "round", "--collisions"))
    assert ("recording-3-s00" in found) == (hit in ("a vehicle", "a pedestrian"))
    assert "recording-3-s01" in found


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["data/scenarios"], "data/scenarios holds no shard-*.parquet: give a folder in it, as data/scenarios/test"),
        (["."], "holds no shard-*.parquet: give a folder in it, as round"),
        (["empty"], "empty holds no shard-*.parquet: give a folder of shards, as data/shipped"),
        (["recorded"], "recorded is in Argoverse 2's layout already: give a folder of shards"),
        (["recorded/one"], "recorded/one is in Argoverse 2's layout already"),
        (["round/samples", "--collisions"], "is no round of corner cases"),
        (["round", "--of", "elsewhere"], "elsewhere/shard-00000.parquet, which is not there: name their folder"),
        (["round", "--of", "round/other"], "holds futures of other scenarios than round/other/"),
    ],
)
def test_what_cannot_be_exported_is_said_with_the_folder_to_give(corner_round, words, sentence):
    (corner_round / "empty").mkdir()
    (corner_round / "recorded/one").mkdir(parents=True)
    (corner_round / "recorded/one/scenario_one.parquet").touch()
    write_shard(corner_round / "round/other" / "shard-00000.parquet", [scenes.busy_crossing(20, "another")])
    done = run("export", *words, "--out", "out", cwd=corner_round)
    assert done.returncode == 2
    assert sentence in done.stderr
    assert not (corner_round / "out").exists()


def test_what_never_drove_is_not_exported(tmp_path):
    write_shard(tmp_path / "new" / "shard-00000.parquet", [replace(scenes.busy_crossing(20), log=None)])
    done = run("export", "new", "--out", "out", cwd=tmp_path)
    assert done.returncode == 2
    assert "has no motion yet" in done.stderr
    assert not (tmp_path / "out").exists()
