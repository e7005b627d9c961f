"""The stage `beset` on a small map, and its published table."""

from dataclasses import replace
from pathlib import Path

import orjson
import pyarrow.parquet as pq
import pytest

from drivegen.adversaries.shared.besetting import METRICS, PLACED
from drivegen.core.errors import MissingTool
from drivegen.gym.folders import read_traffic
from drivegen.layouts.compile import compile_map
from drivegen.layouts.spec import MapSpec
from drivegen.store.files import write_json
from drivegen.store.scenarios import read_shard, write_shard
from stages import asked, assets, beset, publish_corner
from stages._door import read_params, read_section
from tests.drivers.taught import PARAMS
from tests.scenes import busy_crossing

ARMS = [{"angle": angle, "lanes_in": 2, "lanes_out": 2} for angle in (0, 90, 180, 270)]
SHARD = "shard-00000.parquet"


@pytest.fixture(scope="module")
def made(tmp_path_factory, models: Path) -> Path:
    """A crossing in words' place, assets, models; one scene placed in each way, attacked by two."""
    root = tmp_path_factory.mktemp("beset")
    write_shard(root / "scenarios/train" / SHARD, [busy_crossing()])
    assets.main(assets.Params(gap_scenarios=1), root / "scenarios", root / "assets.parquet", root / "gaps.parquet")
    (root / "maps/cross").mkdir(parents=True)
    spec = MapSpec.model_validate({"road": {"kind": "crossing", "control": "yield", "arms": ARMS}})
    (root / "maps/cross/map.net.xml").write_bytes(compile_map(spec))
    (root / "models").symlink_to(models)
    run(root, root)
    return root


def run(root: Path, out: Path, maps: str = "maps") -> None:
    cs = read_section("attack.adversaries.drivegen_cs", PARAMS)
    few = {**cs, "goals": {"draws": 1, "variation": {**cs["goals"]["variation"], "best": 3, "times": 4}}}
    params = replace(
        read_params("beset", beset.Params, PARAMS),
        workers=1,
        per_map=1,
        queries=3,
        draws=20,
        adversaries={"untouched": {}, "drivegen_cs": few},
        drivers={"idm": read_section("beset.drivers.idm", PARAMS)},
    )
    places = (root / maps, root / "assets.parquet", root / "gaps.parquet", root / "models")
    beset.main(params, *places, out / "scenes", out / publish_corner.BESET)


def test_what_is_asked_in_words_is_placed_by_the_gaps_of_logs_where_scenes_are(made, tmp_path, monkeypatch):
    initial = read_params("place.initial", asked.InitialSettings, PARAMS)
    as_logs = replace(initial, placement=replace(initial.placement, mode="data"))
    own = {"place.initial": as_logs, "ship.generation": read_params("ship.generation", asked.GeneratorSettings, PARAMS)}
    monkeypatch.setattr(asked, "read_params", lambda section, _: own[section])
    params = replace(read_params("asked", asked.Params, PARAMS), maps=["cross"], requests=1, per_request=1)
    places = (made / "maps", made / "assets.parquet", made / "gaps.parquet", made / "models")
    asked.main(params, *places, tmp_path / "asked.parquet", tmp_path / "asked.json")
    assert orjson.loads((tmp_path / "asked.json").read_bytes())["requests"] == 1
    [read] = set(pq.read_table(tmp_path / "asked.parquet")["inputs"].to_pylist())
    assert {str(made / name) for name in ("gaps.parquet", "models/selector", "models/limits.json")} < set(read.split())


def test_every_driver_adversary_and_way_of_placing_has_its_shares(made):
    rows = orjson.loads((made / publish_corner.BESET).read_bytes())
    keys = {(row["placed"], row["method"], row["metric"]) for row in rows}
    metrics = (*METRICS, "kinds")
    assert keys == {(p, m, x) for p in PLACED for m in ("untouched", "drivegen_cs") for x in metrics}
    assert {row["n"] for row in rows} == {1}
    assert all(row["low"] is None for row in rows)  # one map says nothing of others
    assert all(0 <= row["value"] <= 1 for row in rows if row["metric"] == "counted")


def test_besetting_scenes_can_be_driven_and_looked_at(made):
    [scene] = read_shard(made / "scenes" / SHARD)
    scene.validate()
    assert scene.log is not None
    assert len(scene.log.valid) == len(scene.vehicles) >= 2
    assert [one.scenario_id for one, _ in read_traffic(made / "scenes")] == [scene.scenario_id]


def test_the_same_seed_gives_the_same_bytes(made, tmp_path):
    run(made, tmp_path)
    for name in ("scenes/" + SHARD, publish_corner.BESET):
        assert (tmp_path / name).read_bytes() == (made / name).read_bytes()


def test_no_map_is_one_sentence(made, tmp_path):
    (made / "empty").mkdir(exist_ok=True)
    with pytest.raises(MissingTool, match="holds no map: run the maps stage"):
        run(made, tmp_path, "empty")


def test_the_table_has_a_line_for_each_way_of_placing(made, tmp_path):
    place = tmp_path / "runs/7"
    write_json(place / publish_corner.BESET, orjson.loads((made / publish_corner.BESET).read_bytes()))
    write_json(place / "reports/metrics/attack/idm.json", {})
    publish_corner.main(publish_corner.Params(7, [7], {}, 20), tmp_path / "runs", tmp_path / "out")
    text = (tmp_path / "out/beset.md").read_text()
    assert [line.split(" | ")[1:3] for line in text.splitlines() if line.startswith("| idm |")] == [
        ["DriveGen-CS", "as always"],
        ["DriveGen-CS", "besetting"],
        ["generated, as it is", "as always"],
        ["generated, as it is", "besetting"],
    ]
    assert "1 placed as always, 1 placed besetting" in text
