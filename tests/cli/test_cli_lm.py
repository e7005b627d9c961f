"""Language models from the command line: estimates, the doctor's tiny call, a map by a model's hand."""

import json
import re
from pathlib import Path

import pyarrow.parquet as pq
import pytest
import yaml
from typer.testing import CliRunner

from drivegen import cli
from drivegen.cli import doctor
from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.lm.ledger import FOLDER
from drivegen.lm.prices import price
from drivegen.lm.prompt import OverBudget
from drivegen.store.scenarios import write_shard
from tests.lm.asking import settings
from tests.lm.chat_server import Says, serving
from tests.projects import PARAMS
from tests.scenes import busy_crossing

CROSSING = {"kind": "crossing", "control": "signals", "arms": [{"angle": a} for a in (0, 90, 180, 270)]}


@pytest.fixture
def project(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def write(**role):
        values = vars(settings(**{"prompt": "roads-3", "output": "prompted", "retries": 0, **role}))
        off = vars(settings(backend="offline", model=""))
        goals, records = {**values, "prompt": "goals-2"}, {"mode": "replay", "folder": "records"}
        lm = {"maps": values, "goals": goals, "corner_cases": off, "records": records}
        maps = {"prompts": {"a": "a crossing", "b": "a roundabout"}}
        (tmp_path / "params.yaml").write_text(yaml.safe_dump({"lm": lm, "maps": maps}))

    write()
    return write


def drivegen(*words: str):
    return CliRunner().invoke(cli.build(list(words)), list(words), catch_exceptions=False)


def calls_of(command: str) -> list[dict]:
    """The rows that `collect` will read of a command's runs, with a look at whether they hold the key."""
    files = sorted(FOLDER.glob(f"{command}*.parquet"))
    assert not any(b"sk-very-secret" in file.read_bytes() for file in files)
    return [row for file in files for row in pq.read_table(file).to_pylist()]


def estimated(*lm: str, lacks: str) -> str:
    """What is estimated of maps in a project without scenes, which is told of the roles that it `lacks` them for."""
    told = CliRunner().invoke(cli.build(["estimate"]), ["estimate", *(["--lm"] if lm else []), *lm])
    assert (
        str(told.exception) == f"{lacks} not estimated: no scenes in data/scenarios/test to be asked about, `make run` makes them"
    )
    assert isinstance(told.exception, MissingTool)
    return told.output


def test_estimate_prints_calls_tokens_and_dollars_and_asks_nobody(project):
    told = estimated("openai:gpt-4o", "--max-usd", "0.5", lacks="goals and corner_cases")
    assert "calls       2" in told
    assert "gpt-4o" in told
    assert "stops at 0.5000" in told
    assert "unknown" not in told
    assert "dollars     unknown" in estimated(lacks="goals")
    assert "nothing is spent" in drivegen("estimate", "--lm", "offline").output


def test_estimate_covers_every_role_and_both_layouts_of_goals(project, tmp_path):
    own = yaml.safe_load((tmp_path / "params.yaml").read_text())
    whole = yaml.safe_load(PARAMS.read_text())
    (tmp_path / "params.yaml").write_text(yaml.safe_dump(own | {name: whole[name] for name in ("goals", "corner", "run")}))
    scenes = [busy_crossing(101, f"crossing-{i}") for i in range(4)]
    write_shard(tmp_path / "data" / "scenarios" / "test" / "shard-00000.parquet", scenes)
    told = drivegen("estimate", "--lm", "openai:gpt-4o").output
    whole["goals"]["vlm"]["knowledge"] = "Drivers here are patient. " * 100
    (tmp_path / "params.yaml").write_text(yaml.safe_dump(own | {name: whole[name] for name in ("goals", "corner", "run")}))
    knowing = drivegen("estimate", "--lm", "openai:gpt-4o").output
    (tmp_path / "data" / "scenarios" / "test" / "shard-00001.parquet").write_bytes(b"PAR1")
    with pytest.raises(UnusableInput, match=r"shard-00001\.parquet is no whole shard"):
        drivegen("estimate", "--lm", "openai:gpt-4o")
    vehicles, scenario = (told.split(f"for goals, {layout}")[1].split() for layout in ("per_vehicle", "per_scenario"))
    assert 4 < int(vehicles[1]) <= 32  # a call a vehicle
    assert int(scenario[1]) == 4  # a call a scene
    assert int(vehicles[4]) > int(scenario[4]) > 0
    assert int(knowing.split("for goals, per_vehicle")[1].split()[4]) > int(vehicles[4]) + 500 * int(vehicles[1])
    rounds = told.split("for corner_cases; not asked as params.yaml is (corner.goals: reweighting)")[1].split()
    assert 0 < int(rounds[1]) <= 2 * 4 * 7  # two rounds with knowledge, a call a social vehicle
    assert int(rounds[4]) / int(rounds[1]) > int(vehicles[4]) / int(vehicles[1])  # each with pictures of collisions
    dollars, batch = (
        float(vehicles[vehicles.index("dollars") + 1].strip(",;")),
        float(vehicles[vehicles.index("batches") + 1].strip(",;")),
    )
    assert batch == pytest.approx(dollars / 2, rel=0.01)


def test_the_doctor_tries_each_configured_model_once(project):
    with serving([Says('{"sum": 2}')]) as server:
        project(base_url=server.url)
        found = list(doctor.language_models())
    assert [finding.ok for finding in found] == [True, True, None]
    assert "150 tokens" in found[0].found
    assert len(server.requests) == 1  # two roles share the model
    assert [row["outcome"] for row in calls_of("doctor")] == ["answered"]
    with serving([Says("key revoked", status=401)]) as server:
        project(base_url=server.url)
        assert [finding.ok for finding in doctor.language_models()] == [False, False, None]
    assert sorted(row["outcome"] for row in calls_of("doctor")) == ["answered", "refused"]


def test_the_doctor_asks_again_where_a_role_has_another_key(project, tmp_path, monkeypatch):
    for name in ("ONE_KEY", "OTHER_KEY"):
        monkeypatch.setenv(name, f"sk-{name}")
    with serving([Says('{"sum": 2}')]) as server:
        project(base_url=server.url, key="ONE_KEY")
        values = yaml.safe_load((tmp_path / "params.yaml").read_text())
        values["lm"]["goals"]["key"] = "OTHER_KEY"
        (tmp_path / "params.yaml").write_text(yaml.safe_dump(values))
        assert [finding.ok for finding in doctor.language_models()] == [True, True, None]
    assert {headers["authorization"] for headers in server.headers} == {"Bearer sk-ONE_KEY", "Bearer sk-OTHER_KEY"}


def test_a_map_by_a_model_is_kept_and_drawn_again_without_it(project, tmp_path):
    answer = json.dumps({"map": {"road": CROSSING}})
    with serving([Says(answer)]) as server:
        model = f"openai:little-model@{server.url}"
        for folder in "ab":
            told = drivegen("map", "a crossing", "--out", folder, "--lm", model)
            assert "written by  language model little-model" in told.output
            [estimate] = [line for line in told.stderr.splitlines() if line.startswith("estimate")]
            assert "about 1 calls" in estimate
            assert "dollars unknown" in estimate
            assert "stops at 1 dollars" in estimate
        assert len(server.requests) == 1
    assert sorted(row["replayed"] for row in calls_of("map")) == [False, True]  # a table for each run of the command
    assert (tmp_path / "a" / "map.net.xml").read_bytes() == (tmp_path / "b" / "map.net.xml").read_bytes()
    with pytest.raises(UnusableInput, match="no backend"):
        drivegen("map", "a crossing", "--out", "c", "--lm", "nobody:x")


def test_the_estimate_stands_before_a_call_that_would_cost_too_much_and_is_not_made(project, tmp_path, monkeypatch):
    monkeypatch.setenv("OPENAI_API_KEY", "sk-very-secret")
    refused = CliRunner().invoke(
        cli.build(["map"]), ["map", "a crossing", "--out", "a", "--lm", "openai:gpt-4o", "--max-usd", "1e-9"]
    )
    assert isinstance(refused.exception, OverBudget)
    [estimate] = [line for line in refused.stderr.splitlines() if line.startswith("estimate")]
    told = re.search(r"about 1 calls, (\d+) tokens in, 500 out, dollars 0\.\d+, at most (0\.\d+);.*stops at 1e-09 doll", estimate)
    longest = settings().max_tokens
    assert float(told[2]) > 4 * 3 * price(
        "gpt-4o", "openai", int(told[1]), longest
    )  # repaired thrice, each asked for twice again
    assert not (tmp_path / "a").exists()
    assert calls_of("map") == []


def test_a_model_may_write_the_xml_itself_and_is_measured_beside_the_offline_rules(project, tmp_path, monkeypatch):
    monkeypatch.delenv("DRIVEGEN_REAL_DATA", raising=False)
    nodes = '<nodes><node id="a" x="0" y="0"/><node id="b" x="300" y="0"/></nodes>'
    edges = '<edges><edge id="ab" from="a" to="b" numLanes="2" speed="13.9"/></edges>'
    with serving([Says(json.dumps({"nodes": nodes, "edges": edges, "asked": {"lanes": 2}}))]) as server:
        model = f"openai:little-model@{server.url}"
        told = drivegen("map", "words", "a street", "--out", "a", "--lm", model, "--map-mode", "xml").output
        assert "written by  language model little-model, writing XML" in told
        drivegen("bench", "maps", "--every", "150", "--json", "t.json", "--lm", model, "--map-mode", "xml")
    assert b'id="ab"' in (tmp_path / "a" / "map.net.xml").read_bytes()
    offline, asked = json.loads((tmp_path / "t.json").read_text())["writers"]
    assert offline["written_by"].startswith("phrase table")
    assert asked["written_by"] == "language model little-model, writing XML"
    assert sum(counts["lines"] for counts in asked["groups"].values()) > 0
    assert len(calls_of("bench-maps")) >= len(server.requests) - 1 > 0


def test_rows_of_calls_hold_no_key_whatever_a_server_repeats(project, monkeypatch):
    monkeypatch.setenv("LITTLE_KEY", "sk-very-secret")
    with serving([Says("sk-very-secret", status=500), Says('{"sum": 3, "sk-very-secret": 1}')]) as server:
        project(base_url=server.url, key="LITTLE_KEY")
        told = [*doctor.language_models(), *doctor.language_models()]
        assert "sk-very-secret" in server.headers[0]["authorization"]
    assert "sk-very-secret" not in str(told)
    assert {row["outcome"] for row in calls_of("doctor")} == {"server-error", "asked again", "invalid-answer"}
    assert not any(b"sk-very-secret" in file.read_bytes() for file in Path().rglob("*") if file.is_file())
