"""One DuckDB file over all Parquet parts of results and costs, with the views of sql/schema.sql.

The parts are the record, the file is a convenience: it can be deleted and made again at any time. DuckDB lets one
process write and then nobody read, so the file is made under a temporary name and renamed.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from importlib.resources import files
from pathlib import Path

import duckdb
import pyarrow as pa
import pyarrow.parquet as pq

from drivegen.core.errors import UnusableInput
from drivegen.core.methods import read_methods
from drivegen.store.files import whole
from drivegen.store.results import RESULT


def read_parts(parts: Sequence[Path], schema: pa.Schema) -> pa.Table:
    """All rows of `parts` in the given order. Raises UnusableInput for a part that is no Parquet or has other columns."""
    tables = [schema.empty_table()]
    for part in parts:
        with _naming(part):
            table = pq.read_table(part, partitioning=None)
        if table.schema.remove_metadata() != schema:
            wanted, found = ", ".join(schema.names), ", ".join(table.column_names)
            raise UnusableInput(f"{part} has columns {found}; wanted {wanted}: run its stage again", reason="columns")
        tables.append(table.replace_schema_metadata(None))
    return pa.concat_tables(tables)


def result_parts(folder: Path) -> list[Path]:
    """Parquet files below `folder` that hold results (others have columns of their own and are left alone), sorted.

    Raises UnusableInput for a file that is no Parquet.
    """
    found = []
    for part in sorted(folder.rglob("*.parquet")):
        with _naming(part):
            columns = pq.read_schema(part).names
        if columns == RESULT.names:
            found.append(part)
    return found


@contextmanager
def _naming(part: Path) -> Iterator[None]:
    try:
        yield
    except pa.ArrowException as error:
        raise UnusableInput(f"{part} is not a Parquet file: remove it and run its stage again", reason="truncated") from error


def build(path: Path, results: pa.Table, costs: pa.Table, calls: pa.Table) -> None:
    """Write `path` with the tables `results`, `costs`, `calls` (of language models) and `methods`, and all views."""
    with whole(path) as temporary, duckdb.connect(str(temporary)) as connection:
        for name, table in {"results": results, "costs": costs, "calls": calls, "methods": _methods()}.items():
            connection.register("incoming", table)
            connection.execute(f"create table {name} as from incoming").fetchall()
            connection.unregister("incoming")
        for statement in duckdb.extract_statements(files("drivegen.warehouse").joinpath("sql/schema.sql").read_text()):
            connection.execute(statement).fetchall()


def _methods() -> pa.Table:
    """What every generator says of itself: one row a method."""
    return pa.Table.from_pylist([{"method": name, **asdict(method)} for name, method in read_methods().items()])


def query(path: Path, sql: str) -> pa.Table:
    """The answer to one SELECT over a warehouse file, opened read-only."""
    with duckdb.connect(str(path), read_only=True) as connection:
        return connection.sql(sql).to_arrow_table()
