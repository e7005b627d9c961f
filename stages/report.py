"""Stage report: one HTML page and a folder of Markdown tables from whatever has been measured.

argv: folder of results (JSON), folder of curves (CSV), test scenarios, samples (a folder a method), what was turned down on the
way to them (a file a method), recorded goals (a folder a selector), folder of maps, costs, the page to write, the folder of
tables to write. Where a folder is absent its section reads "not measured".
"""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import orjson

from drivegen.errors import UnusableInput
from drivegen.rejected import Rejected
from drivegen.render.contact_sheet import contact_sheet
from drivegen.render.png import png, shrunk
from drivegen.render.scene_picture import scene_picture, view_of
from drivegen.report import Curve, Evidence, Link, Picture, all_sections, build_page
from drivegen.report.published import METHODS
from drivegen.samples import Samples
from drivegen.settings import Index
from drivegen.store.draw import Drawn, by_method, draw_scenes, followed_goals
from drivegen.store.files import whole
from drivegen.store.rejected import rejected_by_method, rejected_of
from drivegen.store.results import run_id
from drivegen.store.runs import read_costs, read_curve, read_param
from stages._door import enter

_PINNED = ("drivegen", "numpy", "torch", "libsumo", "pyarrow", "duckdb", "opencv-python-headless")


SCENE_WIDTH, PANEL_WIDTH, MAP_WIDTH = 700, 330, 640
"""Widths of pictures in the page [pixels]; a panel is one method of several on one scene."""

PANELS = 3
"""Methods in a row."""

METHOD = "drivegen"
"""Whose samples are shown large."""

NO_TRAFFIC = "random_agent"
"""An anchor of the measures; there is nothing to see."""


@dataclass(frozen=True)
class Params:
    """`scenes` pictures of test scenes, `maps` pictures of maps at most."""

    seed: int
    scenes: Index
    maps: Index


def main(
    params: Params,
    metrics: Path,
    curves: Path,
    scenarios: Path,
    generated: Path,
    rejected: Path,
    goals: Path,
    maps: Path,
    costs: Path,
    page: Path,
    tables: Path,
) -> None:
    """Gather, write the page and the tables."""
    results = _results(metrics)
    there = scenarios.exists() and (generated / METHOD).exists()
    drawn = draw_scenes(params.seed, scenarios, generated / METHOD, params.scenes) if there else []
    found = rejected_by_method(rejected)
    turned_down = [rejected_of(one.scenario.scenario_id, found) for one in drawn]
    evidence = Evidence(
        results=results,
        source=drawn[0].scenario.source if drawn else "",
        samples=read_param(Path(), "rollout.samples"),
        scenes=tuple(_scene(one, down.get(METHOD)) for one, down in zip(drawn, turned_down, strict=True)),
        comparisons=tuple(
            _comparison(one, methods, down, goals)
            for one, methods, down in zip(drawn, by_method(drawn, generated), turned_down, strict=True)
        )
        if drawn
        else (),
        maps=tuple(_map(folder) for folder in sorted(maps.glob("*/map.png"))[: params.maps]),
        curves=tuple(_curve(curves, file) for file in sorted(curves.rglob("*.csv"))),
        costs=read_costs(costs),
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
            if table.repeatable:
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


def _scene(drawn: Drawn, rejected: Rejected | None) -> Picture:
    scenario, samples = drawn.scenario, drawn.samples
    image = scene_picture(scenario, samples.motion, ~samples.legal, pixels=SCENE_WIDTH, rejected=rejected)
    title = f"{scenario.scenario_id} ({scenario.city})"
    said = f"{len(scenario.vehicles)} vehicles, {len(samples.violation)} samples"
    return Picture(title, said if rejected is None else f"{said}; {rejected.summary}", png(image))


def _comparison(drawn: Drawn, methods: Mapping[str, Samples], rejected: Mapping[str, Rejected], goals: Path) -> Picture:
    """One scene by every method, in the window that the log (or the first method) needs."""
    scenario = drawn.scenario
    moving = scenario.log if scenario.log is not None else drawn.samples.motion
    view = view_of(moving, PANEL_WIDTH)
    panels = []
    order = [*(m for m in METHODS if m in methods), *(m for m in methods if m not in METHODS)]
    for name in [m for m in order if m != NO_TRAFFIC]:
        samples = methods[name]
        places = followed_goals(samples, goals, drawn.shard)
        image = scene_picture(scenario, samples.motion, ~samples.legal, places, view=view, rejected=rejected.get(name))
        panels.append((METHODS.get(name, name), image))
    title = f"{scenario.scenario_id} ({scenario.city})"
    counts = [f"{METHODS.get(name, name)}: {rejected[name].summary}" for name in order if name in rejected]
    said = ". ".join([f"{len(scenario.vehicles)} vehicles", *counts])
    return Picture(title, said, png(contact_sheet(panels, PANELS)))


def _map(file: Path) -> Picture:
    about = file.with_suffix(".json")
    words = orjson.loads(about.read_bytes()) if about.exists() else {}
    return Picture(file.parent.name.replace("_", " "), str(words.get("text", "")), shrunk(file.read_bytes(), MAP_WIDTH))


def _curve(folder: Path, file: Path) -> Curve:
    return Curve(file.relative_to(folder).with_suffix("").as_posix(), read_curve(file))


def _write(path: Path, text: str) -> None:
    with whole(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    enter("report", Params, main)
