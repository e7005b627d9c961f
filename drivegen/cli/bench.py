"""`drivegen bench`: speed, each row beside a reference measured in the same run."""

from pathlib import Path
from typing import Annotated

from rich.console import Console
from rich.table import Table
from typer import Exit, Option

from drivegen.bench import measure
from drivegen.store.files import write_json


def command(
    json: Annotated[Path | None, Option(help="Also write the rows to this JSON file.")] = None,
    only: Annotated[str, Option(help="Only the rows of one part, e.g. raster.")] = "",
) -> None:
    """Print rows {name, value, unit, reference, ratio, target, pass}; exits 1 if a row misses its target."""
    with Console(stderr=True).status("measuring ..."):
        rows = list(measure(only))
    table = Table("name", "value", "unit", "reference", "ratio", "target", "", box=None, pad_edge=False)
    for row in rows:
        target = "" if row.target is None else f"{'<=' if row.smaller_is_better else '>='} {row.target:g}"
        reference = "" if row.reference is None else f"{row.reference:.4g} ({row.reference_name})"
        ratio = "" if row.ratio is None else f"{row.ratio:.1f}x"
        verdict = "" if row.target is None else "pass" if row.passed else "MISS"
        table.add_row(row.name, f"{row.value:.4g}", row.unit, reference, ratio, target, verdict)
    Console().print(table)
    if json is not None:
        write_json(json, [row.as_json() for row in rows])
    if not all(row.passed for row in rows):
        raise Exit(1)
