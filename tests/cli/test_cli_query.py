"""`drivegen query`: what it prints of an answer, and what it says where there is none."""

import re

import duckdb
import numpy as np
import pytest

from drivegen.lm.ledger import CALLS
from drivegen.store.results import Run, result_rows
from drivegen.warehouse import database as warehouse
from tests.cli.test_cli_commands import run


def test_query_prints_a_table_as_wide_as_its_ids_or_csv(tmp_path):
    long = "a-recording-with-a-name-that-is-longer-than-a-line-of-a-terminal-of-eighty-characters-00000-12"
    tables = {"results": result_rows(Run("x", "drive", "log", "idm", 7, "batch"), [long], {"collision": np.array([0.25])})}
    warehouse.build(tmp_path / "reports/drivegen.duckdb", {**tables, "calls": CALLS.empty_table()})
    listed = run("query", cwd=tmp_path)
    assert re.search(r"^parameters +stage, name, value *$", listed.stdout, re.MULTILINE), listed.stderr
    done = run("query", "select scenario, value from results", cwd=tmp_path)
    assert done.stdout.split() == ["scenario", "value", long, "0.25"]
    csv = run("query", "from results select value, sample", "--csv", cwd=tmp_path)
    assert csv.stdout.splitlines() == ['"value","sample"', "0.25,-1"]
    done = run("query", "select a.sample, b.value as sample, a.stage from results a, results b", cwd=tmp_path)
    assert done.stdout.split() == ["sample", "sample", "stage", "-1", "0.25", "drive"]
    done = run(
        "query", "select 136105.0::double as a, 2.5::double as b, 1.0 / 3 as c, 1e15 as d, 'nan'::double as e", cwd=tmp_path
    )
    assert done.stdout.split()[5:] == ["136105", "2.5", "0.333333", "1e+15", "nan"]
    csv = run("query", "select [sample, 2] as both from results", "--csv", cwd=tmp_path)
    assert csv.stdout.splitlines() == ['"both"', '"[-1, 2]"']
    csv = run("query", "select unnest([null, [sample]]) as one from results", "--csv", cwd=tmp_path)
    assert csv.stdout.splitlines() == ['"one"', "", '"[-1]"']
    csv = run("query", "select interval 1 day as time", "--csv", cwd=tmp_path)
    assert (csv.returncode, csv.stdout.splitlines()[0]) == (0, '"time"'), csv.stderr
    assert "select" not in run("query", "--help", cwd=tmp_path).stdout


def test_query_without_results_or_with_no_sql_is_one_sentence(tmp_path):
    done = run("query", "from results", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (1, "")
    assert "reports/drivegen.duckdb is not here: `make run` makes it, in the project's folder: change into it" in done.stderr
    warehouse.build(tmp_path / "reports/drivegen.duckdb", {"calls": CALLS.empty_table()})
    for sql, why in {
        "selct 1": "Parser Error",
        "": "one statement of SQL is answered at a time, not 0: say one",
    }.items():
        done = run("query", sql, cwd=tmp_path)
        assert done.returncode == 2
        assert len(done.stderr.splitlines()) == 1
        assert why in done.stderr


def test_a_file_that_is_no_warehouse_is_named(tmp_path):
    warehouse.build(tmp_path / "whole.duckdb", {"calls": CALLS.empty_table()})
    raw = (tmp_path / "whole.duckdb").read_bytes()
    contents = {"empty": b"", "text": b"text\n" * 5000, "cut": raw[:20_000], "changed": raw[:20_000] + b"?" * 9 + raw[20_009:]}
    for name, content in contents.items():
        (tmp_path / name).write_bytes(content)
    duckdb.connect(tmp_path / "foreign").execute("create table cars (name text)").close()
    (tmp_path / "folder").mkdir()
    for name in (*contents, "foreign"):
        done = run("query", "from results", "--warehouse", name, cwd=tmp_path)
        assert (done.returncode, done.stderr) == (2, f"drivegen: {warehouse._no_warehouse(name)}\n")
    for name in ("folder", "nowhere"):
        done = run("query", "from results", "--warehouse", name, cwd=tmp_path)
        assert (done.returncode, len(done.stderr.splitlines())) == (2, 1)
        assert f"{name} is no file: name the warehouse" in done.stderr


@pytest.mark.parametrize(
    ("sql", "more"),
    [
        ("select 'infinity'::timestamp as t", ()),
        ("select timestamp_ns '2020-01-01 10:00:00.123456789' as t", ()),
        ("select '\\xFF'::blob as b", ("--csv",)),
        ("select '\udcff' as a", ()),
    ],
)
def test_what_cannot_be_printed_or_read_is_one_sentence(tmp_path, sql, more):
    warehouse.build(tmp_path / "reports/drivegen.duckdb", {"calls": CALLS.empty_table()})
    done = run("query", sql, *more, cwd=tmp_path)
    assert (done.returncode, done.stdout, len(done.stderr.splitlines())) == (2, "", 1), done.stderr
