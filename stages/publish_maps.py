"""The door `publish_maps`: tables of single pieces, read from the run of `make tables PART=maps`. It is in no dvc.yaml.

argv: the run's folder of reports, the folder of published tables (gets maps-<table>.md).
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import orjson

from drivegen.report import Evidence
from drivegen.report.sections import data, maps, models, planners, vehicles
from drivegen.store.files import whole

SECTIONS = (maps.suites, data.likeness, vehicles.section, planners.section, models.selector)


SECTION = "tables.maps"


@dataclass(frozen=True)
class Params:
    """`params`: by what the run differs from params.yaml; the flow `tables` reads it. Each piece has its stage's own section."""

    params: dict[str, Any]


def main(_: Params, reports: Path, published: Path) -> None:
    """One Markdown file a table."""
    folders = [reports / "metrics", reports / "pieces"]
    files = {file.relative_to(folder).with_suffix("").as_posix(): file for folder in folders for file in folder.rglob("*.json")}
    evidence = Evidence(results={name: orjson.loads(file.read_bytes()) for name, file in files.items()})
    for table in (table for section in SECTIONS for table in section(evidence).tables if table.repeatable):
        with whole(published / f"maps-{table.name}.md") as temporary:
            temporary.write_text(table.markdown(), encoding="utf-8")
