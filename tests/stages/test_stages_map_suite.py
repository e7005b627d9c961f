"""Stage `map_suite`: a row per writer; a model that nobody configured is not measured, times stay apart, calls are counted."""

import json

import pyarrow.parquet as pq
import pytest
import yaml

from drivegen.lm.ledger import FOLDER
from drivegen.lm.prompt import DamagedRecord
from drivegen.maps.suite import cases
from stages import map_suite
from tests.lm.asking import settings
from tests.lm.chat_server import Says, serving

CROSSING = {"kind": "crossing", "control": "signals", "arms": [{"angle": a} for a in (0, 90, 180, 270)]}
ROAD = Says(json.dumps({"map": {"road": CROSSING}}))
NONE = Says(json.dumps({"map": None, "cannot": "no road"}))
SUITE = [
    cases.Case(cases.OWN, "plain", "a crossing with lights", {"arms": 4}),
    cases.Case(cases.OWN, cases.REFUSE, "a poem", None),
]


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(map_suite, "own_cases", lambda: SUITE)

    def run_stage(models, mode="auto", **role):
        values = vars(settings(**{"prompt": "roads-3", "output": "prompted", "retries": 0, **role}))
        lm = {"maps": values, "records": {"mode": mode, "folder": "records"}}
        (tmp_path / "params.yaml").write_text(yaml.safe_dump({"lm": lm}))
        costs = map_suite.main(map_suite.Params(7, ["offline"], models, 1, ""), tmp_path / "table.json")
        return (tmp_path / "table.json").read_bytes(), costs

    return run_stage


def test_a_model_that_nobody_configured_is_not_measured(run):
    table, costs = run(["language_model", "language_model_xml"], backend="offline", model="")
    writers = json.loads(table)["writers"]
    assert writers["language_model_xml"] == {"measured": False, "written_by": "language model xml"}
    assert writers["offline"]["groups"]["own, plain"]["right"] == 1
    assert costs["cpu_seconds of offline"] > 0
    assert b"seconds" not in table


def test_a_configured_model_is_measured_and_replayed_to_the_same_bytes(run):
    with serving([ROAD, NONE]) as server:
        table, _ = run(["language_model"], base_url=server.url)
    told = json.loads(table)["writers"]["language_model"]
    assert told["written_by"] == "language model little-model"
    assert [told["groups"][name]["right"] for name in ("own, plain", "own, refuse")] == [1, 1]
    calls = pq.read_table(next(FOLDER.glob("map_suite-language_model-*.parquet")))
    assert calls["outcome"].to_pylist() == ["answered", "answered"]
    assert run(["language_model"], mode="replay", base_url="http://127.0.0.1:9")[0] == table


def test_a_model_that_gives_no_answer_declines(run):
    with serving([Says("I would rather not.")]) as server:
        table, _ = run(["language_model"], base_url=server.url)
    counts = json.loads(table)["writers"]["language_model"]["groups"]["own, plain"]
    assert (counts["declined"], counts["right"], counts["wrong"]) == (1, 0, 0)


def test_a_damaged_record_is_no_figure(run, tmp_path):
    with serving([ROAD, NONE]) as server:
        run(["language_model"], base_url=server.url)
    (tmp_path / "table.json").unlink()
    record = min((tmp_path / "records").rglob("*.json"))
    record.write_bytes(record.read_bytes()[:-40])
    with pytest.raises(DamagedRecord, match=record.name):
        run(["language_model"], mode="replay", base_url="http://127.0.0.1:9")
    assert not (tmp_path / "table.json").exists()
