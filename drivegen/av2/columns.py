"""Tables of others: every column that is read is proved to be what it should be before anything is made of it."""

from collections.abc import Sequence

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput

LONGEST_WORD = 200
"""Bytes of an id or another word; NumPy gives every word of an array as much room as the longest takes."""


def checked(table: pa.Table, expected: pa.Schema, place: object, optional: Sequence[str] = ()) -> pa.Table:
    """The `expected` columns: there once, of their type, without empty cells, finite, their words short; `optional` ones follow.

    Whole numbers of any width become those of the schema. Raises UnusableInput with reason `missing-columns`,
    `duplicate-columns`, `no-rows`, `not-a-number`, `out-of-range` or `bad-id`, naming `place`.
    """
    names = table.column_names
    if missing := [name for name in expected.names if name not in names]:
        raise UnusableInput(f"{place} lacks the column {', '.join(missing)}", reason="missing-columns")
    if twice := [name for name in (*expected.names, *optional) if names.count(name) > 1]:
        raise UnusableInput(f"{place} has more than one column {twice[0]}: remove the others", reason="duplicate-columns")
    if table.num_rows == 0:
        raise UnusableInput(f"{place} has no rows", reason="no-rows")
    columns = {field.name: _column(table[field.name], field, place) for field in expected}
    return pa.table(columns | {name: table[name] for name in optional if name in names})


def _column(column: pa.ChunkedArray, field: pa.Field, place: object) -> pa.ChunkedArray:
    if column.null_count:
        raise UnusableInput(f"{place}: column {field.name} has empty cells", reason="not-a-number")
    kind = column.type.value_type if pa.types.is_dictionary(column.type) else column.type
    wanted = is_word if is_word(field.type) else pa.types.is_integer if pa.types.is_integer(field.type) else is_number
    if not wanted(kind if wanted is is_word else column.type):
        raise UnusableInput(f"{place}: column {field.name} holds {column.type}, not {field.type}", reason="missing-columns")
    if wanted is is_word:
        _expect_short(column, field.name, place)
    elif wanted is is_number:
        _expect_finite(column.to_numpy(), field.name, place)
    else:
        return _whole(column, field, place)
    return column


def _whole(column: pa.ChunkedArray, field: pa.Field, place: object) -> pa.ChunkedArray:
    try:
        return column.cast(field.type)
    except pa.ArrowInvalid as error:
        raise UnusableInput(f"{place}: column {field.name}: {error}", reason="out-of-range") from None


def _expect_short(column: pa.ChunkedArray, name: str, place: object) -> None:
    words = (chunk.dictionary if pa.types.is_dictionary(chunk.type) else chunk for chunk in column.chunks)
    if any((pc.max(pc.binary_length(some)).as_py() or 0) > LONGEST_WORD for some in words):
        raise UnusableInput(f"{place}: column {name} has a word of more than {LONGEST_WORD} letters", reason="bad-id")


def _expect_finite(values: NDArray[np.number], name: str, place: object) -> None:
    if len(bad := np.flatnonzero(~np.isfinite(values))):
        others = f", nor are {len(bad) - 1} others" if len(bad) > 1 else ""
        where = f"column {name}, row {bad[0]}: {values[bad[0]]} is no number{others}"
        raise UnusableInput(f"{place}, {where}", reason="not-a-number")


def is_word(kind: pa.DataType) -> bool:
    """Whether these are texts."""
    return bool(pa.types.is_string(kind) or pa.types.is_large_string(kind))


def is_number(kind: pa.DataType) -> bool:
    """Whether these are whole or other numbers."""
    return bool(pa.types.is_floating(kind) or pa.types.is_integer(kind))


def encoded(column: pa.ChunkedArray) -> tuple[NDArray[np.str_], NDArray[np.int64]]:
    """Different words in order of appearance, and each row's number of them."""
    array = column.combine_chunks() if column.num_chunks != 1 else column.chunk(0)
    if not pa.types.is_dictionary(array.type):
        array = array.dictionary_encode()
    return np.array(array.dictionary.to_pylist(), np.str_), array.indices.to_numpy().astype(np.int64)
