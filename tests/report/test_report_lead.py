"""By how much DriveGen-CS leads others: hand cases, and the files that the published table is made of."""

import numpy as np
import orjson
import pytest

from drivegen.report.published.lead import lead_rows, lead_table
from drivegen.store.files import write_json
from drivegen.store.results import Run, read_values, result_rows, write_results
from stages import publish_corner

SCENES = ["a-0", "a-1", "b-0", "b-1"]


def values(counted, avoidable):
    return {"counted": dict(zip(SCENES, counted, strict=True)), "avoidable": dict(zip(SCENES, avoidable, strict=True))}


ATTACKS = {
    "drivegen_cs.legal.10": values([1, 1, 1, 0], [1, 0, 0, 0]),
    "cat.legal.10": values([1, 0, 0, 0], [1, 0, 0, 0]),
    "cat.physical.10": values([1, 1, 1, 1], [1, 1, 1, 1]),
}


def test_a_lead_is_the_mean_difference_in_the_same_scenes_under_the_same_rule():
    counted, avoidable = lead_rows("idm", ATTACKS, 200, 7)  # nothing of DriveGen-CS is physical
    about = {"driver": "idm", "method": "cat", "allowed": "legal", "queries": 10, "metric": "counted", "value": 0.5, "n": 4}
    assert {name: counted[name] for name in about} == about
    assert counted["low"] == counted["high"] == 0.5  # each recording has a lead of one in two
    assert (avoidable["value"], avoidable["low"], avoidable["high"]) == (0.0, 0.0, 0.0)
    assert "| idm | CAT | legal | 10 | 0.500 | 0.000 |" in lead_table([counted, avoidable]).markdown()


def test_a_lead_in_one_recording_has_no_interval():
    here = {key: {metric: {"a-0": of["a-0"], "a-1": of["a-1"]} for metric, of in own.items()} for key, own in ATTACKS.items()}
    rows = list(lead_rows("idm", here, 200, 7))
    assert [(row["low"], row["high"]) for row in rows] == [(None, None)] * 2
    assert "| idm | CAT | legal | 10 | 0.500 | 0.000 |" in lead_table(rows).markdown()


def test_the_published_table_is_made_of_the_results_of_the_first_run(tmp_path):
    place, parts = tmp_path / "runs/7/reports/metrics/attack", []
    for key, of_metric in ATTACKS.items():
        run = Run.of("attack", key, {"seed": 7}, [], method=key.split(".")[0], driver="idm", backend="legal")
        parts.append(result_rows(run, SCENES, {name: np.array(list(of.values()), float) for name, of in of_metric.items()}))
    write_results(place / "idm.parquet", parts)
    write_json(place / "idm.json", {})
    assert read_values(place / "idm.parquet", ["counted", "avoidable"]) == ATTACKS
    assert read_values(place / "gail.parquet", ["counted"]) == {}
    publish_corner.main(publish_corner.Params(7, [7], {}, 20), tmp_path / "runs", tmp_path / "out")
    counted, _ = orjson.loads((tmp_path / "out/lead.json").read_bytes())
    assert counted["value"] == pytest.approx(0.5)
    assert "| idm | CAT | legal |" in (tmp_path / "out/lead.md").read_text()
