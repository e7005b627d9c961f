"""What can be driven of a folder: shards, samples and Argoverse 2 scenarios; what cannot is counted or refused."""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from drivegen.av2.export import export_scenario
from drivegen.core.errors import UnusableInput
from drivegen.gym.folders import read_traffic
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import write_shard
from tests.scenes import busy_crossing, noisy_samples


@pytest.fixture
def folder(tmp_path):
    scenes = [busy_crossing(61, f"scene-{letter}") for letter in "abc"]
    write_shard(tmp_path / "scenarios" / "shard-00000.parquet", scenes)
    write_samples(tmp_path / "generated" / "shard-00000.parquet", [noisy_samples(s, 2, seed=i) for i, s in enumerate(scenes)])
    return tmp_path


def test_folders_of_samples_and_of_argoverse_scenarios_are_read_too(folder):
    assert len(read_traffic(folder / "scenarios")) == 3
    assert len(read_traffic(folder / "generated", of=folder / "scenarios")) == 6
    with pytest.raises(UnusableInput, match="name their folder"):
        read_traffic(folder / "generated", of=folder)
    with pytest.raises(UnusableInput, match="no folder"):
        read_traffic(folder / "nothing")
    scene = busy_crossing(110, "recorded")
    for name in ("one", "two"):
        export_scenario(scene, scene.log, folder / "argoverse2", name)
    assert [s.steps for s, _ in read_traffic(folder / "argoverse2")] == [110, 110]
    [(one, _)] = read_traffic(folder / "argoverse2" / "one")
    assert len(one.vehicles) == len(scene.vehicles)
    broken = folder / "argoverse2" / "three"
    shutil.copytree(folder / "argoverse2" / "one", broken)
    next(broken.glob("*.parquet")).write_bytes(b"PAR1")
    with pytest.warns(
        UserWarning, match=r"scenarios left out: 1 truncated \(.*/three/scenario_.*\.parquet is no whole Parquet file"
    ):
        assert len(read_traffic(folder / "argoverse2")) == 2
    with pytest.raises(UnusableInput, match=r"no scenario with traffic and a target to drive \(1 truncated \(.*/three/"):
        read_traffic(broken)
    gone = busy_crossing(110, "gone")
    gone.log.valid[0] = False
    write_shard(folder / "empty" / "shard-00000.parquet", [gone])
    with pytest.raises(UnusableInput, match=r"target to drive \(1 no-target \(gone\)\)"):
        read_traffic(folder / "empty")
    write_shard(folder / "half" / "shard-00000.parquet", [replace(gone, log=None), busy_crossing(110, "there")])
    with pytest.warns(UserWarning, match=r"half: scenarios left out: 1 no-motion \(gone\)"):
        assert len(read_traffic(folder / "half")) == 1
    with pytest.raises(UnusableInput, match="data/scenarios/none is no folder: run `make run` first"):
        read_traffic(Path("data/scenarios/none"))


def test_the_cases_of_an_attack_are_read_and_a_folder_above_them_names_them(folder):
    attack, scene = folder / "attack/idm/cat.legal.10", busy_crossing(61, "scene-b")
    write_samples(attack / "samples.parquet", [noisy_samples(scene, 1)])
    [(found, _)] = read_traffic(attack, of=folder / "scenarios")
    assert found.scenario_id == "scene-b"
    corner_round = folder / "corner/0"
    write_samples(corner_round / "samples/shard-00000.parquet", [])
    (corner_round / "driven").mkdir()
    for above, one in ((attack.parent, attack), (corner_round.parent, corner_round), (folder, folder / "generated")):
        with pytest.raises(UnusableInput, match=f"is there\\): give a folder in it, as {one}$"):
            read_traffic(above)


def test_two_scenarios_of_one_id_are_refused_by_both_places(tmp_path):
    scene = busy_crossing(110, "map-7-0000")
    for place in ("here", "there"):
        export_scenario(scene, scene.log, tmp_path / place, "map-7-0000-s00")
    said = r"here/map-7-0000-s00 and .*there/map-7-0000-s00 both hold scenario map-7-0000-s00: take one away, or generate it"
    with pytest.raises(UnusableInput, match=said):
        read_traffic(tmp_path)
    for number in range(2):
        write_shard(tmp_path / "shards" / f"shard-0000{number}.parquet", [scene])
    with pytest.raises(UnusableInput, match=r"shard-00000.parquet and .*shard-00001.parquet both hold scenario map-7-0000:"):
        read_traffic(tmp_path / "shards")
    write_shard(tmp_path / "shard" / "shard-00000.parquet", [scene, scene])
    with pytest.raises(UnusableInput, match=r"shard-00000.parquet holds scenario map-7-0000 twice: take one away"):
        read_traffic(tmp_path / "shard")
