"""Stage `maps` with a language model as the writer: counted calls, the failure in the table, a replay without a server."""

import json
from datetime import timedelta

import pyarrow.parquet as pq
import pytest
import yaml

from drivegen.core.errors import UnusableInput
from drivegen.lm import batch
from drivegen.lm.ledger import FOLDER
from stages import maps
from tests.lm.asking import settings
from tests.lm.batch_server import serving_batches
from tests.lm.chat_server import Says, serving

CROSSING = {"kind": "crossing", "control": "signals", "arms": [{"angle": a} for a in (0, 90, 180, 270)]}
ANSWER = json.dumps({"map": {"road": CROSSING}})
PROMPTS = {"crossing": "a crossing with traffic lights"}


def last_calls():
    file = max(FOLDER.glob("maps*.parquet"), key=lambda file: file.stat().st_mtime_ns)
    return pq.read_table(file).to_pylist()


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def run_stage(mode, **role):
        values = vars(settings(**{"prompt": "roads-3", "output": "prompted", "retries": 0, **role}))
        lm = {"maps": values, "records": {"mode": mode, "folder": "records"}}
        (tmp_path / "params.yaml").write_text(yaml.safe_dump({"lm": lm}))
        maps.main(
            maps.Params(7, 2, "language_model", PROMPTS), tmp_path / "maps", tmp_path / "maps.parquet", tmp_path / "maps.json"
        )
        return json.loads((tmp_path / "maps.json").read_text())["maps"][0], last_calls()

    return run_stage


def test_a_models_maps_are_recorded_and_made_again_without_it(run):
    with serving([Says(ANSWER)]) as server:
        row, [call] = run("auto", base_url=server.url)
    assert row["writer"] == "language model little-model"
    record = pq.read_table("maps.parquet").to_pylist()
    assert {r["metric"]: r["value"] for r in record}["lanes"] == row["lanes"]
    assert {(r["stage"], r["scenario"], r["backend"]) for r in record} == {("maps", "crossing", "language_model")}
    assert (call["role"], call["outcome"], call["replayed"]) == ("maps", "answered", False)
    again, [replayed] = run("replay", base_url="http://127.0.0.1:9")
    assert again == row
    assert (replayed["replayed"], replayed["cost"]) == (True, "0.000000")


def test_without_a_model_nothing_is_drawn_and_the_calls_say_why(run, tmp_path):
    with pytest.raises(UnusableInput, match="none of the descriptions"):
        run("replay", backend="offline", model="")
    [row] = json.loads((tmp_path / "maps.json").read_text())["maps"]
    assert row["reason"] == "no-model"
    assert not row["understood"]
    assert [call["outcome"] for call in last_calls()] == ["no-model"]


def test_what_it_will_cost_is_told_before_the_first_call(run, capsys):
    with serving([Says(ANSWER)]) as server:
        run("auto", base_url=server.url, max_usd=0.5)
    told = capsys.readouterr().out
    assert "lm.maps: language model little-model, one by one: about 1 calls" in told.splitlines()[0]
    assert "stops at 0.5 dollars" in told
    run("replay", base_url="http://127.0.0.1:9")
    assert "nobody is asked" in capsys.readouterr().out


def test_first_questions_may_go_in_one_batch_and_are_recorded_as_if_asked_one_by_one(run, monkeypatch):
    for name in ("FIRST_LOOK", "LAST_LOOK"):
        monkeypatch.setattr(batch, name, timedelta(milliseconds=5))
    PROMPTS["hill"] = "a road"
    try:
        with serving_batches([ANSWER, ANSWER]) as server:
            row, calls = run("auto", base_url=server.url, batch=True)
        assert [len(job) for job in server.jobs] == [2]
        assert [call["outcome"] for call in calls] == ["answered", "answered"]
        assert run("replay", base_url="http://127.0.0.1:9")[0] == row
    finally:
        del PROMPTS["hill"]
