"""`drivegen query`: a question in SQL to all results, scenarios, samples, recordings and parameters of the pipeline."""

import sys
from pathlib import Path
from typing import Annotated, Any

import pyarrow as pa
import pyarrow.csv
from rich.console import Console
from rich.table import Table
from typer import Argument, Option

from drivegen.core.errors import UnusableInput
from drivegen.warehouse.database import query

WAREHOUSE = Path("reports/drivegen.duckdb")

_CONTENTS = """
    select table_name as "table", string_agg(column_name, ', ' order by ordinal_position) as columns
    from information_schema.columns group by all order by "table"
"""
_SHOWN, _WIDEST = 40, 10_000
_EXACT = 1e15
"""Whole doubles below it are counts, with all their digits."""


def command(
    sql: Annotated[
        str, Argument(help="One statement of SQL, as DuckDB has it; without one the tables are listed.", show_default=False)
    ] = _CONTENTS,
    warehouse: Annotated[Path, Option(help="The file that the stage collect writes.")] = WAREHOUSE,
    csv: Annotated[bool, Option("--csv", help="Print all rows as CSV.")] = False,
) -> None:
    """Answer SQL over the results; nothing is changed, and no other file is read. `docs/store.md` has the tables."""
    if warehouse != WAREHOUSE and not warehouse.is_file():
        raise UnusableInput(f"{warehouse} is no file: name the warehouse that the stage collect writes, as {WAREHOUSE}")
    answer = query(warehouse, sql)
    try:
        if csv:
            whole = pa.BufferOutputStream()
            pyarrow.csv.write_csv(_flat(answer), whole)
            sys.stdout.buffer.write(whole.getvalue())
        else:
            _show(answer)
    except (OverflowError, ValueError, pa.ArrowException) as error:  # a time without end, bytes that are no text, ...
        raise UnusableInput(f"a value of the answer cannot be printed ({error}): cast it to text, `column::text`") from None


def _flat(answer: pa.Table) -> pa.Table:
    """With lists, structs and intervals as text, for CSV has no such thing."""
    strange = [pa.types.is_nested(kind) or pa.types.is_interval(kind) for kind in answer.schema.types]
    columns = [
        pa.array([None if v is None else str(v) for v in c.to_pylist()], pa.string()) if odd else c
        for odd, c in zip(strange, answer.columns, strict=True)
    ]
    return pa.table(columns, names=answer.column_names)


def _show(answer: pa.Table) -> None:
    """The first rows; where no screen is each in one line, for ids must not be cut."""
    console = Console(highlight=False, markup=False, width=None if sys.stdout.isatty() else _WIDEST)
    table = Table(*answer.column_names, box=None, pad_edge=False, header_style="bold")
    for row in zip(*(column.to_pylist() for column in answer.slice(0, _SHOWN).columns), strict=True):  # names may repeat
        table.add_row(*map(_cell, row))
    for column in table.columns:
        column.overflow = "fold"
    console.print(table)
    if answer.num_rows > _SHOWN:
        console.print(f"{_SHOWN} of {answer.num_rows} rows: --csv prints all, LIMIT chooses", style="dim")


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if not isinstance(value, float):
        return str(value)
    return f"{value:.0f}" if value.is_integer() and abs(value) < _EXACT else f"{value:.6g}"
