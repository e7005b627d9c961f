"""Stage report: one HTML page and a folder of Markdown tables from whatever has been measured.

argv: folder of results (JSON), folder of curves (CSV), test scenarios, generated samples of DriveGen, folder of maps,
the page to write, the folder of tables to write. A folder that is absent leaves its section "not measured".
"""

import csv
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import orjson

from drivegen.errors import UnusableInput
from drivegen.render.png import png, shrunk
from drivegen.render.scene_picture import scene_picture
from drivegen.report import Curve, Evidence, Link, Picture, all_sections, build_page
from drivegen.samples import Samples
from drivegen.scenario import Scenario
from drivegen.store.draw import draw_scenes
from drivegen.store.files import whole
from drivegen.store.results import run_id
from stages._door import enter

_PINNED = ("drivegen", "numpy", "torch", "libsumo", "pyarrow", "duckdb", "opencv-python-headless")


SCENE_WIDTH, MAP_WIDTH = 700, 640
"""Widths of pictures in the page [pixels]."""


@dataclass(frozen=True)
class Params:
    """`scenes` pictures of test scenes, `maps` pictures of maps at most."""

    seed: int
    scenes: int
    maps: int


def main(
    params: Params, metrics: Path, curves: Path, scenarios: Path, generated: Path, maps: Path, page: Path, tables: Path
) -> None:
    """Gather, write the page and the tables."""
    results = _results(metrics)
    drawn = draw_scenes(params.seed, scenarios, generated, params.scenes) if scenarios.exists() and generated.exists() else []
    evidence = Evidence(
        results=results,
        source=drawn[0].scenario.source if drawn else "",
        scenes=tuple(_scene(one.scenario, one.samples) for one in drawn),
        maps=tuple(_map(folder) for folder in sorted(maps.glob("*/map.png"))[: params.maps]),
        curves=tuple(_curve(curves, file) for file in sorted(curves.rglob("*.csv"))),
        recordings=tuple(Link(**link) for link in results.get("recordings", [])),
        provenance={
            "seed": str(params.seed),
            "results (hash of reports/metrics)": run_id({}, [metrics]) if results else "nothing yet",
            **{f"version of {name}": version(name) for name in _PINNED},
        },
    )
    sections = all_sections(evidence)
    _write(page, build_page(sections, evidence.source))
    for section in sections:
        for table in section.tables:
            _write(tables / f"{table.name}.md", table.markdown())
    print(f"report: {page.resolve().as_uri()}")


def _results(folder: Path) -> dict[str, Any]:
    found = {}
    for file in sorted(folder.rglob("*.json")):
        try:
            found[file.relative_to(folder).with_suffix("").as_posix()] = orjson.loads(file.read_bytes())
        except orjson.JSONDecodeError as error:
            raise UnusableInput(f"{file} is not JSON: remove it and run its stage again", reason="truncated") from error
    return found


def _scene(scenario: Scenario, samples: Samples) -> Picture:
    image = scene_picture(scenario, samples.motion, ~samples.legal, pixels=SCENE_WIDTH)
    title = f"{scenario.scenario_id} ({scenario.city})"
    return Picture(title, f"{len(scenario.vehicles)} vehicles, {len(samples.violation)} samples", png(image))


def _map(file: Path) -> Picture:
    about = file.with_suffix(".json")
    words = orjson.loads(about.read_bytes()) if about.exists() else {}
    return Picture(file.parent.name.replace("_", " "), str(words.get("text", "")), shrunk(file.read_bytes(), MAP_WIDTH))


def _curve(folder: Path, file: Path) -> Curve:
    with file.open(newline="") as lines:
        rows = list(csv.DictReader(lines))
    columns = {name: [float(row[name] or "nan") for row in rows] for name in (rows[0] if rows else {})}
    return Curve(file.relative_to(folder).with_suffix("").as_posix(), columns)


def _write(path: Path, text: str) -> None:
    with whole(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    enter("report", Params, main)
