"""The door `publish_maps`: tables of single pieces, read from the run of `make tables PART=maps`. It is in no dvc.yaml.

argv: the run's workspace, the folder of published tables (gets maps-<table>.md, maps.md and provenance-maps.json).
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import orjson

from drivegen.report import Evidence
from drivegen.report.published.files import write_part
from drivegen.report.sections import data, maps, models, planners, vehicles
from drivegen.warehouse.provenance import describe_runs
from drivegen.warehouse.runs import METRICS, PIECES
from stages._door import require

SECTIONS = (maps.suites, data.likeness, vehicles.section, planners.section, models.selector)


SECTION = "tables.maps"


@dataclass(frozen=True)
class Params:
    """`params`: by what the run differs from params.yaml; the flow `tables` reads it. Each piece has its stage's own section."""

    params: dict[str, Any]


def main(_: Params, run: Path, published: Path) -> None:
    """One Markdown file a table, their index and provenance."""
    folders = [require(run, "run `make tables PART=maps`") / part for part in (METRICS, PIECES)]
    files = {file.relative_to(folder).with_suffix("").as_posix(): file for folder in folders for file in folder.rglob("*.json")}
    evidence = Evidence(results={name: orjson.loads(file.read_bytes()) for name, file in files.items()})
    tables = [table for section in SECTIONS for table in section(evidence).tables if table.repeatable]
    provenance = describe_runs(run.parent, [run.name], (METRICS, PIECES))
    write_part(published, "maps", "Single pieces", [replace(table, name=f"maps-{table.name}") for table in tables], provenance)
