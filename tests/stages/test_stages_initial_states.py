"""Stage initial_states: where generators place vehicles on the maps of held-out logs."""

import shutil
from dataclasses import replace
from pathlib import Path

import orjson
import pytest

from drivegen.core.errors import MissingTool
from drivegen.store.scenarios import write_shard
from stages import assets, initial_states
from tests.generators.rivals import trained
from tests.scenes import busy_crossing

PARAMS = initial_states.Params(seed=7, scenes=2, draws=50)
FILES = ("scenarios", "assets.parquet", "gaps.parquet", "models")

MODES = [f"DriveGen, mode {mode}{own}" for mode in ("paper", "data") for own in (", a target of its own", "")]
OURS = ["held-out logs", *MODES]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("initial_states")
    for split in ("train", "test"):
        scenes = [busy_crossing(101, f"{split}-{letter}") for letter in "abc"]
        write_shard(path / "scenarios" / split / "shard-00000.parquet", scenes)
    assets.main(assets.Params(gap_scenarios=3), path / "scenarios", path / "assets.parquet", path / "gaps.parquet")
    for name in ("trafficgen", "lctgen"):
        trained(name)[0].save(path / "models" / "generators" / name)
    return path


def run(folder: Path, out: Path) -> dict:
    initial_states.main(PARAMS, *(folder / name for name in FILES), out)
    return orjson.loads(out.read_bytes())


def test_every_method_places_as_many_as_the_logs_have(folder, tmp_path):
    found = run(folder, tmp_path / "a.json")
    assert found["scenes"] == 2
    methods = {one["name"]: one for one in found["methods"]}
    lctgen = ["LCTGen, code of a training log", "LCTGen, code from the log (a bound, no method)"]
    assert list(methods) == [*OURS, *lctgen, "TrafficGen"]
    count = 2 * len(busy_crossing().vehicles)
    for name, values in methods.items():
        assert values["asked"] == count
        assert 2 <= values["placed"] <= count
        assert 0 <= values["off_lane.low"] <= values["off_lane"] <= values["off_lane.high"] <= 1
        if name != "held-out logs":
            assert values["overlap"] == 0
            assert 0 < values["speed.low"] <= values["speed"] <= values["speed.high"]


def test_the_same_seed_writes_the_same_bytes(folder, tmp_path):
    run(folder, tmp_path / "a.json")
    run(folder, tmp_path / "b.json")
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()


def test_who_was_not_trained_has_no_row(folder, tmp_path):
    alone = [folder / name for name in FILES[:3]]
    initial_states.main(PARAMS, *alone, tmp_path / "nothing", tmp_path / "a.json")
    methods = orjson.loads((tmp_path / "a.json").read_bytes())["methods"]
    assert [one["name"] for one in methods] == OURS


def test_a_row_does_not_depend_on_who_has_another(folder, tmp_path):
    params = replace(PARAMS, scenes=3, draws=5)  # so few draws that other ones have other ends
    alone = tmp_path / "models"
    shutil.copytree(folder / "models/generators/trafficgen", alone / "generators/trafficgen")
    rows = []
    for models in (folder / "models", alone):
        initial_states.main(params, *(folder / name for name in FILES[:3]), models, tmp_path / "a.json")
        rows.append({one["name"]: one for one in orjson.loads((tmp_path / "a.json").read_bytes())["methods"]})
    assert len(rows[0]) > len(rows[1])
    assert rows[1].items() <= rows[0].items()


def test_missing_logs_are_named(folder, tmp_path):
    with pytest.raises(MissingTool, match="run the ingest stage"):
        initial_states.main(PARAMS, tmp_path, *(folder / name for name in FILES[1:]), tmp_path / "a.json")
