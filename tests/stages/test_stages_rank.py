"""The stage `rank` on a hand-made scene, and the door `publish_drivers` on what such runs leave."""

from pathlib import Path

import numpy as np
import orjson
import pyarrow.parquet as pq
import pytest

from drivegen.drivers.mutants.table import MUTATIONS
from drivegen.store.results import Run, result_rows, write_results
from drivegen.store.scenarios import write_shard
from stages import publish_drivers, rank
from stages._door import read_section
from tests.drivers.taught import PARAMS
from tests.scenes import busy_crossing, drive, scenario, stack, straight_road

LINE = straight_road().centreline[0].astype(np.float64)


def test_every_driver_is_measured_in_every_scene(tmp_path: Path):
    parked = scenario(straight_road(), stack([drive(LINE, 10, 10, 101), drive(LINE, 80, 0, 101)]), "parked-0")
    write_shard(tmp_path / "test/shard-00000.parquet", [parked, busy_crossing(101, "crossing-0")])
    (tmp_path / "weights").mkdir()
    params = rank.Params(7, 1, (), 2, {"idm": read_section("rank.drivers.idm", PARAMS)})
    told = rank.main(params, tmp_path / "test", tmp_path / "generated", tmp_path / "weights", tmp_path / "rank.parquet")
    rows = pq.read_table(tmp_path / "rank.parquet").to_pylist()
    mine = [name for name in MUTATIONS if name.startswith("idm.")]
    assert {row["driver"] for row in rows} == {"idm", *mine}
    value = {(row["driver"], row["scenario"], row["metric"]): row["value"] for row in rows}
    assert len(value) == (1 + len(mine)) * 2 * 3
    assert told == {"runs": (1 + len(mine)) * 2}
    assert value["idm", "parked-0", "counted"] == 0
    assert value["idm.ignores_standing", "parked-0", "counted"] == 1
    assert value["idm.ignores_standing", "parked-0", "near_miss"] == 1


def left_behind(place: Path, skills: dict[str, list[float]]) -> None:
    """What a run leaves in which driver i fails in the share `skills[method][i]` of 20 scenes of ten recordings."""
    scenes = [f"file{n // 2}-{n % 2}" for n in range(20)]
    parts = []
    for method, skill in skills.items():
        for number, share in enumerate(skill):
            failed = (np.arange(20) * 7 % 20 < 20 * share).astype(float)
            run = Run("x", "rank", method, f"driver{number}", 7, "batch")
            parts.append(result_rows(run, scenes, {"counted": failed, "near_miss": 1 - failed}))
    write_results(place / publish_drivers.RANK, parts)


@pytest.fixture
def published(tmp_path: Path) -> Path:
    better, worse = [0.1, 0.2, 0.4, 0.8], [0.8, 0.4, 0.2, 0.1]
    left_behind(tmp_path / "runs/sumo_corpus", {"log": better, "drivegen": better, "bits": worse})
    left_behind(tmp_path / "runs/ngsim", {"log": better, "drivegen": better})
    params = publish_drivers.Params(
        7, 50, {}, {name: {"protocol": "", "title": name} for name in ("sumo_corpus", "ngsim", "absent")}
    )
    publish_drivers.main(params, tmp_path / "runs", tmp_path / "out")
    return tmp_path / "out"


def test_orders_are_compared_with_that_of_real_roads(published: Path):
    rows = {
        (row["made_from"], row["method"]): row
        for row in orjson.loads((published / "ranking.json").read_bytes())
        if row["measure"] == "counted"
    }
    value = {kind: row["value"] for kind, row in rows.items()}
    assert value == {
        ("ngsim", "half_of_log"): pytest.approx(1.0, abs=0.3),
        ("ngsim", "drivegen"): 1.0,
        ("sumo_corpus", "log"): 1.0,
        ("sumo_corpus", "drivegen"): 1.0,
        ("sumo_corpus", "bits"): -1.0,
    }
    rival = rows["sumo_corpus", "bits"]
    assert (rival["drivegen_ahead"], rival["drivers"], rival["real_recordings"]) == (2.0, 4, 10)
    table = (published / "drivers-ranking.md").read_text()
    assert "| ngsim | BITS | sumo_corpus | counted collisions | -1.00" in table
    assert "Real roads of ngsim: 20 scenes. Intervals (95 %) are over 10 recordings, which are few" in table


def test_the_index_links_the_tables_and_says_what_is_missing(published: Path):
    index = (published / "drivers.md").read_text()
    assert "INCOMPLETE, not there: absent. Runs: ngsim, sumo_corpus; of code None." in index
    assert "* [Does traffic rank drivers as real roads do?](drivers-ranking.md)" in index
    provenance = orjson.loads((published / "provenance-drivers.json").read_bytes())
    assert (set(provenance["runs"]), provenance["runs_missing"], provenance["seed"]) == ({"ngsim", "sumo_corpus"}, ["absent"], 7)
