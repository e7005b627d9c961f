"""From a result to its files: scenarios, samples, recordings and parameters in the warehouse, and the queries of the docs."""

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.samples import Violation
from drivegen.core.settings import read_tree
from drivegen.lm.ledger import CALLS
from drivegen.store.files import write_json
from drivegen.store.results import Run, result_rows
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import write_shard
from drivegen.warehouse.database import TABLES, build, query
from drivegen.warehouse.tables import parameter_table, read_recordings, read_sample_table, read_scenarios
from tests.scenes import busy_crossing, noisy_samples

ROOT = Path(__file__).parents[2]
SHARD = "shard-00000.parquet"
SCENES = ("a-00000-1", "a-00040-2")
DRIVE = Run("ba9876543210", "drive", "drivegen", "gail", 7, "batch", "gail", "data/scenarios/test")
CORNER = Run("0123456789ab", "corner", "drivegen_cs", "idm", 7, "batch", "1", "data/scenarios/test")
FENCED = re.compile(r"^```(sql|text)\n(.*?)^```", re.DOTALL | re.MULTILINE)


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """A folder with two scenarios, three futures of each by a method and two in a round, one of which ended in a collision."""
    root = tmp_path_factory.mktemp("warehouse")
    scenes = [busy_crossing(60, name) for name in SCENES]
    write_shard(root / "test" / SHARD, scenes)
    for folder, method, count in (("generated", "drivegen", 3), ("corner", "drivegen_cs", 2)):
        samples = [noisy_samples(scene, count, method=method) for scene in scenes]
        for one in samples:
            one.violation[:] = 0
        samples[1].violation[1, 4:6] = Violation.SPEED
        samples[0].dropped[0, 2] = True
        write_samples(root / folder / SHARD, samples)
    about = {"stage": "corner", "item": "1", "scenario": SCENES[1], "sample": 1}
    traffic = {"stage": "rollout", "item": "drivegen", "scenario": SCENES[0], "sample": 0}
    recorded = [{"text": "the collision", "href": "recordings/corner-1-0.rrd", **about}]
    write_json(root / "recordings.json", [*recorded, {"text": "its traffic", "href": "recordings/a-00000-1.rrd", **traffic}])
    runs = {"collision": [0, 0, 0, 1], "collision.at_fault": [0, 0, 0, 1], "collision.counted": [0, 0, 0, 1]}
    runs |= {"impact.kind.front": [np.nan] * 3 + [1], "impact.step": [np.nan] * 3 + [37], "impact.partner": [np.nan] * 3 + [5]}
    runs |= {"distance": [50, 60, 70, 20], "left_map": [0, 0, 1, 0], "absolute_acceleration": [0.5, 0.5, 0.5, 3.0]}
    runs |= {"reactive.collision": [0, 0, 0, 0], "reactive.distance": [49, 59, 69, 19]}
    values = {name: np.array(each, float) for name, each in runs.items()}
    driven = {"collision": np.array([1.0, 1.0, 0.0]), "collision.artefact": np.array([0.0, 1.0, 0.0])}
    tables = {
        "results": pa.concat_tables(
            [
                result_rows(CORNER, np.repeat(SCENES, 2).tolist(), values, np.array([0, 1, 0, 1])),
                result_rows(CORNER, SCENES, {"collision": np.array([0.0, 0.5])}),
                result_rows(DRIVE, [SCENES[0]] * 3, driven, np.arange(3)),
            ]
        ),
        "scenarios": read_scenarios({"test": root / "test", "train": root / "nowhere"}),
        "samples": pa.concat_tables(
            [
                read_sample_table("rollout", "drivegen", root / "generated"),
                read_sample_table("corner", "1", root / "corner"),
                read_sample_table("corner", "2", root / "nowhere"),
            ]
        ),
        "recordings": read_recordings(root / "recordings.json"),
        "parameters": parameter_table(read_tree(ROOT / "params.yaml")),
        "calls": CALLS.empty_table(),
    }
    build(root / "drivegen.duckdb", tables)
    return root


@pytest.fixture
def ask(made):
    return lambda sql: query(made / "drivegen.duckdb", sql).to_pylist()


def test_every_scenario_has_a_row_that_leads_to_its_file(ask, made):
    rows = ask("from scenarios")
    assert [row["scenario"] for row in rows] == list(SCENES)
    assert {(row["split"], row["log"], row["vehicles"], row["steps"]) for row in rows} == {("test", "a", 8, 60)}
    assert {row["shard"] for row in rows} == {str(made / "test" / SHARD)}


def test_every_sample_has_a_row_with_what_is_wrong_with_it(ask, made):
    rows = ask("from samples where stage = 'rollout'")
    assert [(row["scenario"], row["sample"]) for row in rows] == [(scene, k) for scene in SCENES for k in range(3)]
    assert [row["illegal"] for row in rows] == [0, 0, 0, 0, 2, 0]
    assert [row["dropped"] for row in rows] == [1, 0, 0, 0, 0, 0]
    assert {(row["item"], row["method"], row["vehicles"]) for row in rows} == {("drivegen", "drivegen", 8)}
    assert {row["shard"] for row in rows} == {str(made / "generated" / SHARD)}


def test_one_query_says_what_crashed_how_where_it_is_recorded_and_with_which_parameters_it_was_made(ask, made):
    [row] = ask("select c.*, p.value from crashes c join parameters p on p.stage = c.made_by and p.name = 'pressure.strength'")
    assert (row["driver"], row["scenario"], row["sample"], row["partner"]) == ("idm", SCENES[1], 1, 5)
    assert (row["kind"], row["seconds"], row["at_fault"], row["counted"]) == ("front", 3.7, True, True)
    assert (row["recording"], row["shard"]) == ("recordings/corner-1-0.rrd", str(made / "corner" / SHARD))
    assert float(row["value"]) == read_tree(ROOT / "params.yaml")["corner"]["pressure"]["strength"]


def test_every_run_of_a_driver_has_one_row(ask):
    rows = ask("from drives where stage = 'corner' and not reactive order by scenario, sample")
    assert [(row["collision"], row["left_map"], row["kind"]) for row in rows] == [
        (False, False, None),
        (False, False, None),
        (False, True, None),
        (True, False, "front"),
    ]


def test_a_run_is_counted_by_its_stage_and_recorded_only_where_its_driver_is_seen(ask):
    rows = ask("from drives where stage = 'drive' order by sample")
    assert [(row["collision"], row["counted"], row["recording"]) for row in rows] == [
        (True, True, None),
        (True, False, None),
        (False, False, None),
    ]


def test_a_run_among_neighbours_that_react_is_a_row_of_its_own(ask):
    sql = (
        f"select reactive, collision, kind, distance from drives where scenario = '{SCENES[1]}' and sample = 1 order by reactive"
    )
    assert ask(sql) == [
        {"reactive": False, "collision": True, "kind": "front", "distance": 20},
        {"reactive": True, "collision": False, "kind": None, "distance": 19},
    ]


def test_numbers_of_samples_do_not_weigh_in_means_over_scenes(ask):
    [row] = ask("from metrics where metric = 'collision'")
    assert (row["scenarios"], row["mean"]) == (2, 0.25)
    [run] = ask("from runs where stage = 'corner'")
    assert (run["run"], run["item"], run["inputs"]) == (CORNER.run, "1", "data/scenarios/test")


def test_parameters_have_dotted_names_and_what_training_has_for_all(ask):
    names = {(row["stage"], row["name"]): row["value"] for row in ask("from parameters")}
    assert names["run", "seed"] == "7"
    assert names["run", "own"].startswith('["drivegen"')
    assert names["train_selector", "learned.training.batch"] == names["training", "batch"]
    assert names["ingest", "source"] == "sumo_corpus"


@pytest.mark.parametrize(
    ("sql", "words"),
    [
        ("select nope from results", 'column "nope" not found'),
        ("select 1; select 2", "one statement of SQL is answered at a time, not 2"),
        ("", "not 0"),
        ("selct 1", "syntax error"),
        ("drop table results", "read-only"),
        ("copy results to 'stolen.csv'", "disabled by configuration"),
        ("from read_text('params.yaml')", "disabled by configuration"),
        ("set memory_limit = '1GB'", "locked"),
    ],
)
def test_what_is_no_question_is_one_sentence_and_does_nothing(made, sql, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    before = (made / "drivegen.duckdb").read_bytes()
    with pytest.raises(UnusableInput, match=words) as raised:
        query(made / "drivegen.duckdb", sql)
    assert "\n" not in str(raised.value)
    assert (made / "drivegen.duckdb").read_bytes() == before
    assert not list(tmp_path.iterdir())


def test_what_is_no_warehouse_is_named(tmp_path):
    with pytest.raises(MissingTool, match="make run"):
        query(tmp_path / "none.duckdb", "from results")
    (tmp_path / "other.duckdb").write_bytes(b"text" * 2000)
    with pytest.raises(UnusableInput, match=r"other\.duckdb"):
        query(tmp_path / "other.duckdb", "from results")


def test_a_shard_that_is_cut_short_is_named(made, tmp_path):
    (tmp_path / SHARD).write_bytes((made / "test" / SHARD).read_bytes()[:-30])
    with pytest.raises(UnusableInput, match=r"shard-00000\.parquet is not what was written"):
        read_scenarios({"test": tmp_path})
    with pytest.raises(UnusableInput, match=r"shard-00000\.parquet is not what was written"):
        read_sample_table("rollout", "drivegen", tmp_path)


def questions() -> list[tuple[str, list[str]]]:
    """Every query of docs/store.md with the columns of the answer that stands below it."""
    blocks = FENCED.findall((ROOT / "docs/store.md").read_text())
    return [
        (sql, answer.splitlines()[0].split())
        for (kind, sql), (after, answer) in pairwise(blocks)
        if (kind, after) == ("sql", "text")
    ]


def test_there_are_questions_in_the_docs():
    assert len(questions()) >= 3


@pytest.mark.parametrize(("sql", "columns"), questions(), ids=lambda part: part[:30] if isinstance(part, str) else "")
def test_a_question_of_the_docs_has_the_answer_that_stands_there(made, sql, columns):
    assert query(made / "drivegen.duckdb", sql).column_names == columns


def test_tables_and_columns_of_the_docs_are_those_of_the_warehouse(ask):
    told = re.findall(r"^\| `(\w+)` \| .* \| ([^|]+) \|$", (ROOT / "docs/store.md").read_text(), re.MULTILINE)
    columns = {}
    for row in ask("select table_name as t, column_name as c from information_schema.columns order by ordinal_position"):
        columns.setdefault(row["t"], []).append(row["c"])
    assert {name: re.findall(r"`(\w+)`", words) for name, words in told} == {name: columns[name] for name, _ in told}
    assert set(TABLES) <= {name for name, _ in told}
