"""Stages assets and place: from logs to vehicles on maps made from words."""

from pathlib import Path

import numpy as np
import orjson
import pytest

from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.signals import SignalState
from drivegen.layouts.compile import compile_map
from drivegen.layouts.spec import MapSpec
from drivegen.placement.place import PlaceSettings
from drivegen.placement.scenes import Settings
from drivegen.placement.table import Table
from drivegen.store.assets import read_assets
from drivegen.store.scenarios import read_shard, shards, write_shard
from stages import assets, place
from tests.scenes import busy_crossing

PARAMS = place.Params(
    seed=7,
    per_map=3,
    per_shard=2,
    compared=2,
    initial=Settings(
        vehicles=8,
        horizon=50,
        shares={"car": 0.9, "bus": 0.1},
        map_radius=200.0,
        placement=PlaceSettings(
            mode="paper", road_ahead=120.0, radius=80.0, speed_spread=0.15, least_time_gap=0.8, standstill_gap=2.0, attempts=24
        ),
    ),
)
ARMS = [{"angle": angle, "lanes_in": 2, "lanes_out": 2} for angle in (0, 90, 180, 270)]


def _inputs(folder: Path, **others: Path) -> list[Path]:
    """Maps, assets, gaps and held-out logs of the stage, some of them replaced."""
    own = {"maps": folder / "maps", "assets": folder / "assets.parquet", "gaps": folder / "gaps.parquet"}
    return [*(own | others).values(), folder / "scenarios" / "train"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("place")
    write_shard(path / "scenarios" / "train" / "shard-00000.parquet", [busy_crossing()])
    assets.main(assets.Params(gap_scenarios=1), path / "scenarios", path / "assets.parquet", path / "gaps.parquet")
    (path / "maps" / "cross").mkdir(parents=True)
    spec = MapSpec.model_validate({"road": {"kind": "crossing", "control": "signals", "arms": ARMS}})
    (path / "maps" / "cross" / "map.net.xml").write_bytes(compile_map(spec))
    place.main(PARAMS, *_inputs(path), path / "new", path / "place.json")
    return path


def test_the_table_holds_the_cars_of_the_train_split_and_documented_others(folder):
    table = Table.from_arrow(read_assets(folder / "assets.parquet"), "assets")
    assert table.count.tolist() == [8, 1, 1]


def test_new_scenarios_have_no_log_but_vehicles_a_map_and_lights_that_change(folder):
    scenarios = [scenario for shard in shards(folder / "new") for scenario in read_shard(shard)]
    assert [scenario.scenario_id for scenario in scenarios] == ["cross-7-0000", "cross-7-0001", "cross-7-0002"]
    for scenario in scenarios:
        scenario.validate()
        assert scenario.log is None
        assert scenario.source == "DriveGen (map from words)"
        assert np.abs(scenario.vehicles.position[0]).max() <= 0.51  # the origin is the target's place, rounded to metres
        assert scenario.signals.state.shape == (len(scenario.signals), 51)
        assert len(scenario.signals) > 0
    shown = np.concatenate([scenario.signals.state.ravel() for scenario in scenarios])
    assert {SignalState.GREEN, SignalState.RED} <= set(shown.tolist())
    first = [scenario.signals.state[:, 0].tolist() for scenario in scenarios]
    assert first[0] != first[1] or first[1] != first[2]  # each begins at its own time


def test_asked_is_placed_plus_rejected(folder):
    counts = orjson.loads((folder / "place.json").read_bytes())
    assert counts["asked"] == 24 == counts["placed"] + sum(counts["rejected"].values())
    assert counts["scenarios"] == 3


def test_the_same_seed_writes_the_same_bytes(folder, tmp_path):
    place.main(PARAMS, *_inputs(folder), tmp_path / "new", tmp_path / "place.json")
    for shard in shards(folder / "new"):
        assert shard.read_bytes() == (tmp_path / "new" / shard.name).read_bytes()


def test_missing_and_damaged_inputs_are_named(folder, tmp_path):
    with pytest.raises(MissingTool, match="run the assets stage"):
        place.main(PARAMS, *_inputs(folder, assets=tmp_path / "none.parquet"), tmp_path, tmp_path / "c.json")
    (tmp_path / "empty").mkdir()
    with pytest.raises(MissingTool, match="run the maps stage"):
        place.main(PARAMS, *_inputs(folder, maps=tmp_path / "empty"), tmp_path, tmp_path / "c.json")
    whole = (folder / "assets.parquet").read_bytes()
    (tmp_path / "cut.parquet").write_bytes(whole[:100])
    with pytest.raises(UnusableInput, match=r"cut\.parquet"):
        place.main(PARAMS, *_inputs(folder, assets=tmp_path / "cut.parquet"), tmp_path, tmp_path / "c.json")
    (tmp_path / "flipped.parquet").write_bytes(whole[:60] + bytes([whole[60] ^ 1]) + whole[61:])
    with pytest.raises(UnusableInput, match=r"flipped\.parquet is not what was written"):
        place.main(PARAMS, *_inputs(folder, gaps=tmp_path / "flipped.parquet"), tmp_path, tmp_path / "c.json")
