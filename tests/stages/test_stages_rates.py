"""The stage `rates` on hand-made scenes, and its published table."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import orjson
import pyarrow.parquet as pq
import pytest

from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.exposure.rates import Trial
from drivegen.report.published.rates import METRICS, rate_rows, rate_table
from stages import publish_rates, rates
from stages._door import read_params, read_section
from tests.drivers.taught import PARAMS
from tests.stages.queues import write_queues

DRAWS = 40


@pytest.fixture(scope="module")
def made(tmp_path_factory, models: Path) -> Path:
    """See `queues`."""
    write_queues(root := tmp_path_factory.mktemp("rates"), models)
    return root


def run(made: Path, out: Path, **changes: object) -> dict[str, object]:
    drivers = {"idm": read_section("rates.drivers.idm", PARAMS)}
    small = {"workers": 1, "drivers": drivers, "tested": ("idm.slow_brakes", "idm"), "scenes": 3, "draws": DRAWS}
    more = {"tries": 4096, "trial": Trial(30, 60, 50)}
    params = replace(read_params("rates", rates.Params, PARAMS), **{**small, **more, **changes})
    places = (made / "test", made / "models", made / "goals", made / "round", out / "rates.parquet", out / publish_rates.RATES)
    rates.main(params, *places)
    return orjson.loads((out / publish_rates.RATES).read_bytes())


@pytest.fixture(scope="module")
def once(made, tmp_path_factory) -> tuple[Path, dict[str, object]]:
    """A folder with what a run in one process writes, and what it found."""
    folder = tmp_path_factory.mktemp("once")
    return folder, run(made, folder / "runs/7")


def test_every_draw_is_a_row_and_the_rate_is_the_share_of_those_that_failed(once):
    folder, found = once
    table = pq.read_table(folder / "runs/7/rates.parquet")
    assert table.column_names == ["scenario", "draw", "idm.slow_brakes", "idm", "idm.slow_brakes.near", "idm.near"]
    assert found["scenes"] + found["left_out"] == 3
    assert len(table) == found["scenes"] * DRAWS
    assert found["drivers"]["idm.slow_brakes"]["rate"] == np.mean(table["idm.slow_brakes"].to_numpy())
    assert found["seconds"] == pytest.approx(10.0)


def test_workers_and_order_do_not_change_a_byte(made, once, tmp_path):
    run(made, tmp_path, workers=2)
    for name in ("rates.parquet", publish_rates.RATES):
        assert (tmp_path / name).read_bytes() == (once[0] / "runs/7" / name).read_bytes()


def test_what_cannot_be_done_is_one_sentence(made, tmp_path):
    with pytest.raises(UnusableInput, match=r"rates\.tested names idm\.asleep, which is none of idm, "):
        run(made, tmp_path, tested=("idm.asleep",))
    with pytest.raises(UnusableInput, match=r"rates\.tested: name at least one driver"):
        run(made, tmp_path, tested=())
    with pytest.raises(UnusableInput, match=r"in all 3 scenes: raise rates\.tries"):
        run(made, tmp_path, tries=1, draws=100_000)
    assert not (tmp_path / "rates.parquet").exists()


def one(rate: float) -> dict[str, object]:
    own = {"rate": rate, "rate.low": 0.5 * rate, "rate.high": 2 * rate, "runs": 100, "plain": 2000, "covered": 0.95}
    own |= {
        "covered_plain": 0.94,
        "width": 0.001,
        "width_plain": 0.002,
        "bias": 0.0,
        "saves": 5.0 if rate else None,
        "strata": [],
    }
    about = {"scenes": 3, "recordings": 2, "left_out": 1, "draws": 40, "repetitions": 200, "seconds": 8.0}
    return {**about, "drivers": {"idm": own, "gail": {**own, "rate": 2 * rate}}}


def test_rows_are_means_over_seeds_and_the_table_names_who_fails_most_first():
    rows = list(rate_rows("corpus", [one(0.01), one(0.02)]))
    assert len(rows) == 2 * (len(METRICS) + 1)
    of = {(line["driver"], line["metric"]): line for line in rows}
    about = {"data": "corpus", "driver": "idm", "n": 3, "seeds": 2}
    assert of["idm", "rate"] == {**about, "metric": "rate", "value": 0.015, "low": 0.0075, "high": 0.03}
    assert of["idm", "per_hour"]["value"] == pytest.approx(0.015 * 450)
    assert of["idm", "runs"]["low"] is None
    text = rate_table(one(0.01)).markdown()
    assert text.index("gail") < text.index("idm")
    assert "10000 (5000 to 20000)" in text
    assert "who stayed illegal in the one future that says who is there is in no draw" in text
    assert {(r["driver"], r["metric"]): r for r in rate_rows("corpus", [one(0.0)])}["idm", "saves"]["value"] is None


def test_the_door_publishes_rows_and_a_table_with_where_they_are_from(once, tmp_path):
    publish_rates.main(publish_rates.Params(7, [7], {}), once[0] / "runs", tmp_path / "out")
    rows = orjson.loads((tmp_path / "out/rates.json").read_bytes())
    assert {row["driver"] for row in rows} == {"idm", "idm.slow_brakes"}
    assert "idm.slow_brakes" in (tmp_path / "out/failure-rates.md").read_text()
    assert "failure-rates.md" in (tmp_path / "out/rates.md").read_text()
    with pytest.raises(MissingTool, match="PART=rates"):
        publish_rates.main(publish_rates.Params(7, [8], {}), once[0] / "runs", tmp_path / "out")
