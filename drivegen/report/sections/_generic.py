"""Tables from a stage's JSON whose exact names the report need not know.

Scalars become one table of names and values, a mapping (or list) of mappings of scalars a matrix with one row each, and
what is nested deeper becomes tables of its own. `x`, `x.low` and `x.high` become one cell with an interval; a list of
scalars is one cell, and mappings of a list are named by their "name".
"""

from collections.abc import Mapping
from typing import Any

from drivegen.report.table import Cell, Table, measured, number, row

_INTERVAL = (".low", ".high")


def words(name: str) -> str:
    """A key as words: "min_gap" -> "min gap"."""
    return name.replace("_", " ").replace(".", ": ")


def tables(name: str, title: str, value: Any) -> tuple[Table, ...]:
    """All tables that `value` gives rise to, none for an empty one."""
    value = _named({"": value} if isinstance(value, list) else value)
    if not isinstance(value, Mapping):
        return ()
    plain = {key: item for key, item in value.items() if _scalar(item)}
    parts = [_pairs(name, title, plain)] if plain else []
    for key, item in value.items():
        label, inner = f"{name}-{_slug(key)}".rstrip("-"), f"{title}: {words(str(key))}" if key else title
        if isinstance(item, Mapping) and item:
            if all(isinstance(entry, Mapping) and any(map(_scalar, entry.values())) for entry in item.values()):
                parts.append(matrix(label, inner, item))
            else:
                parts += tables(label, inner, item)
    return tuple(parts)


def matrix(name: str, title: str, rows: Mapping[str, Mapping[str, Any]], first: str = "") -> Table:
    """One row a mapping, one column a name that any of them has; nested values are left out."""
    keys = list(dict.fromkeys(key for entry in rows.values() for key, item in entry.items() if _scalar(item)))
    keys = [key for key in keys if not _is_bound(key, keys)]
    lines = [row(words(str(label)), *(_cell(dict(entry), key) for key in keys)) for label, entry in rows.items()]
    return Table(name, title, (first, *map(words, keys)), tuple(lines))


def _pairs(name: str, title: str, values: Mapping[str, Any]) -> Table:
    keys = [key for key in values if not _is_bound(key, list(values))]
    lines = [row(words(key), _cell(dict(values), key)) for key in keys]
    return Table(name, title, ("", "value"), tuple(lines))


def _cell(values: dict[str, Any], key: str) -> Cell:
    value = values.get(key)
    if isinstance(value, float) and f"{key}.low" in values:
        return measured(values, key, 3)
    if key not in values:
        return Cell("\u2013")
    return Cell(number(value, 3))


def _named(value: Any) -> Any:
    """`value` with lists of scalars as text and lists of mappings as mappings, at any depth."""
    if isinstance(value, Mapping):
        return {key: _named(item) for key, item in value.items()}
    if not isinstance(value, list):
        return value
    if all(_scalar(item) for item in value):
        return ", ".join(map(number, value))
    entries = [dict(item) if isinstance(item, Mapping) else {"": item} for item in value]
    return {str(entry.pop("name", i + 1)): _named(entry) for i, entry in enumerate(entries)}


def _is_bound(key: str, keys: list[str]) -> bool:
    return any(key.endswith(end) and key.removesuffix(end) in keys for end in _INTERVAL)


def _scalar(value: Any) -> bool:
    return value is None or isinstance(value, str | int | float)


def _slug(key: Any) -> str:
    return "".join(c if c.isalnum() else "-" for c in str(key)).strip("-").lower()
