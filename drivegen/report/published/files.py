"""The folder of published tables: every figure, every table with its picture, what they were made from, a table of contents."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from drivegen.report.published.index import index, part_index
from drivegen.report.table import Table
from drivegen.store.files import write_bytes, write_json


def write_published(
    out: Path,
    rows: Sequence[Mapping[str, Any]],
    tables: Sequence[Table],
    titles: Mapping[str, str],
    provenance: Mapping[str, Any],
) -> None:
    """Write scenario_quality.json (`rows`), provenance.json, a Markdown file a table, its picture as SVG, and README.md.

    `titles` are of the data sets in words, by name, in the order of the table of contents.
    """
    write_json(out / "scenario_quality.json", list(rows))
    write_json(out / "provenance.json", dict(provenance))
    parts = [name.removeprefix("provenance-") for name in sorted(file.stem for file in out.glob("provenance-*.json"))]
    _write(out, tables, {"README.md": index(tables, titles, provenance, parts)})


def write_part(out: Path, part: str, title: str, tables: Sequence[Table], provenance: Mapping[str, Any]) -> None:
    """Write the tables of a part beside the first table's: files as there, provenance-<part>.json and <part>.md, their index."""
    write_json(out / f"provenance-{part}.json", dict(provenance))
    _write(out, tables, {f"{part}.md": part_index(part, title, tables, provenance)})


def _write(out: Path, tables: Sequence[Table], texts: Mapping[str, str]) -> None:
    contents = {f"{table.name}.md": table.markdown() for table in tables} | dict(texts)
    pictures = {f"{table.name}.svg": table.picture for table in tables if table.picture}
    for name, content in {**{name: text.encode() for name, text in contents.items()}, **pictures}.items():
        write_bytes(out / name, content)
