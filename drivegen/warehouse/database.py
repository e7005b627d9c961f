"""One DuckDB file over all Parquet parts of results and costs, with what they lead to and the views of sql/schema.sql.

The parts are the record, the file is a convenience: it can be deleted and made again at any time. DuckDB lets one
process write and then nobody read, so the file is made under a temporary name and renamed.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from importlib.resources import files
from pathlib import Path

import duckdb
import pyarrow as pa
import pyarrow.parquet as pq

from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.methods import read_methods
from drivegen.store.costs import COST
from drivegen.store.files import whole
from drivegen.store.results import RESULT
from drivegen.warehouse.tables import PARAMETERS, RECORDINGS, SAMPLES, SCENARIOS

TABLES = {
    "results": RESULT,
    "scenarios": SCENARIOS,
    "samples": SAMPLES,
    "recordings": RECORDINGS,
    "parameters": PARAMETERS,
    "costs": COST,
}
"""Tables of a warehouse and their columns; beside them `calls` of language models, and `methods`, of generators in words."""


def read_parts(parts: Sequence[Path], schema: pa.Schema) -> pa.Table:
    """All rows of `parts` in the given order. Raises UnusableInput for a part that is no Parquet or has other columns."""
    tables = [schema.empty_table()]
    for part in parts:
        with _naming(part):
            table = pq.read_table(part, partitioning=None)
        if table.schema.remove_metadata() != schema:
            expected, there = ", ".join(schema.names), ", ".join(table.column_names)
            raise UnusableInput(f"{part} has columns {there}; wanted {expected}: run its stage again", reason="columns")
        tables.append(table.replace_schema_metadata(None))
    return pa.concat_tables(tables)


def result_parts(folder: Path) -> list[Path]:
    """Parquet files below `folder` that hold results (others have columns of their own and are left alone), sorted.

    Raises UnusableInput for a file that is no Parquet.
    """
    parts = []
    for part in sorted(folder.rglob("*.parquet")):
        with _naming(part):
            columns = pq.read_schema(part).names
        if columns == RESULT.names:
            parts.append(part)
    return parts


@contextmanager
def _naming(part: Path) -> Iterator[None]:
    try:
        yield
    except pa.ArrowException as error:
        raise UnusableInput(f"{part} is not a Parquet file: remove it and run its stage again", reason="truncated") from error


def build(path: Path, tables: Mapping[str, pa.Table]) -> None:
    """Write `path` with `tables`, `calls` among them (of TABLES one that is not given is empty), the methods and all views."""
    contents = {name: schema.empty_table() for name, schema in TABLES.items()} | dict(tables) | {"methods": _methods()}
    with whole(path) as temporary, duckdb.connect(str(temporary)) as connection:
        for name, table in contents.items():
            connection.register("incoming", table)
            connection.execute(f"create table {name} as from incoming").fetchall()
            connection.unregister("incoming")
        for statement in duckdb.extract_statements(files("drivegen.warehouse").joinpath("sql/schema.sql").read_text()):
            connection.execute(statement).fetchall()


def _methods() -> pa.Table:
    """What every generator says of itself: one row a method."""
    return pa.Table.from_pylist([{"method": name, **asdict(method)} for name, method in read_methods().items()])


def query(path: Path, sql: str) -> pa.Table:
    """The answer to one statement over a warehouse file, which is only read, as is nothing else on this machine.

    Raises MissingTool where there is no such file, UnusableInput where it is no warehouse or DuckDB refuses the statement.
    """
    if not path.is_file():
        raise MissingTool(f"{path} is not here: `make run` makes it, in the project's folder: change into it")
    with _opened(path) as connection:
        try:
            if len(statements := duckdb.extract_statements(sql)) != 1:
                raise UnusableInput(
                    f"one statement of SQL is answered at a time, not {len(statements)}: say one, as `from results`"
                )
            return connection.sql(sql).to_arrow_table()
        except (duckdb.Error, UnicodeError, TypeError) as error:  # the last two where the statement is no UTF-8
            damaged = type(error) in (duckdb.Error, duckdb.IOException)  # what is wrong with a statement has kinds of its own
            raise UnusableInput(_no_warehouse(path) if damaged else _one_line(str(error)), reason="sql") from None


def _opened(path: Path) -> duckdb.DuckDBPyConnection:
    try:
        connection = duckdb.connect(str(path), read_only=True, config=_CLOSED)
        there = {name for (name,) in connection.sql("show tables").fetchall()}
    except duckdb.Error:
        raise UnusableInput(_no_warehouse(path), reason="no-warehouse") from None
    if not there >= TABLES.keys():
        raise UnusableInput(_no_warehouse(path), reason="no-warehouse")
    return connection


def _no_warehouse(path: Path) -> str:
    return f"{path} is no warehouse of results, or damaged: name the one that the stage collect writes, `make run` makes it anew"


_CLOSED: dict[str, str | bool | int | float | list[str]] = {
    "enable_external_access": "false",
    "autoload_known_extensions": "false",
    "lock_configuration": "true",
}
"""No statement may open, write or fetch another file."""


def _one_line(message: str) -> str:
    """DuckDB's message up to its picture of the statement, in one line."""
    return " ".join(message.split("LINE 1:")[0].split())
