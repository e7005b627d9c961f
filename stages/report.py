"""Stage report: one HTML page and a folder of Markdown tables from whatever has been measured.

argv: folder of results (JSON), folder of curves (CSV), test scenarios, samples (a folder a method), what was turned down on the
way to them (a file a method), recorded goals (a folder a selector), rounds of corner cases, folder of maps, costs, the page to
write, the folder of tables to write. Where a folder is absent its section reads "not measured".
"""

from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from drivegen.core import plugins
from drivegen.core.methods import Method, read_methods
from drivegen.core.settings import Index
from drivegen.report import Evidence, Link, Picture, all_sections, build_page
from drivegen.report.measured import read_curves, read_results
from drivegen.report.pictures import compare_methods, picture_scene, read_collision_pictures, read_map_pictures
from drivegen.store.draw import by_method, draw_scenes
from drivegen.store.files import whole
from drivegen.store.rejected import rejected_by_method, rejected_of
from drivegen.store.results import run_id
from drivegen.warehouse.runs import read_costs, read_param

_PINNED = ("drivegen", "numpy", "torch", "libsumo", "pyarrow", "duckdb", "opencv-python-headless")

METHOD = "drivegen"
"""Whose samples are shown large."""


@dataclass(frozen=True)
class Params:
    """`scenes` pictures of test scenes, `maps` pictures of maps at most; names that give the rows of tables their order."""

    seed: int
    own: tuple[str, ...]
    rivals: tuple[str, ...]
    baselines: tuple[str, ...]
    selectors: tuple[str, ...]
    planners: tuple[str, ...]
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
    corner: Path,
    maps: Path,
    costs: Path,
    page: Path,
    tables: Path,
) -> None:
    """Gather, write the page and the tables."""
    results = read_results(metrics)
    methods = read_methods([*params.own, *params.rivals, *params.baselines])
    recordings = tuple(Link(link["text"], link["href"]) for link in results.get("recordings", []))
    source, scenes, comparisons = _scenes(params, methods, scenarios, generated, rejected, goals)
    evidence = Evidence(
        results=results,
        source=source,
        methods=methods,
        selectors=tuple(plugins.names("selectors", params.selectors)),
        planners=tuple(plugins.names("planners", params.planners)),
        samples=read_param(Path(), "rollout.samples"),
        scenes=scenes,
        comparisons=comparisons,
        maps=read_map_pictures(maps, params.maps),
        collisions=read_collision_pictures(corner, recordings),
        curves=read_curves(curves),
        costs=read_costs(costs),
        recordings=recordings,
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


def _scenes(
    params: Params, methods: dict[str, Method], scenarios: Path, generated: Path, rejected: Path, goals: Path
) -> tuple[str, tuple[Picture, ...], tuple[Picture, ...]]:
    """The data set in words, pictures of test scenes drawn by seed, and the same scenes by every method; empty without any."""
    complete = scenarios.exists() and (generated / METHOD).exists()
    scenes_drawn = draw_scenes(params.seed, scenarios, generated / METHOD, params.scenes) if complete else []
    if not scenes_drawn:
        return "", (), ()
    rejected_scenes = rejected_by_method(rejected)
    rejections = [rejected_of(one.scenario.scenario_id, rejected_scenes) for one in scenes_drawn]
    large = [picture_scene(one, of_scene.get(METHOD)) for one, of_scene in zip(scenes_drawn, rejections, strict=True)]
    each = zip(scenes_drawn, by_method(scenes_drawn, generated), rejections, strict=True)
    small = [compare_methods(one, samples, methods, of_scene, goals) for one, samples, of_scene in each]
    return scenes_drawn[0].scenario.source, tuple(large), tuple(small)


def _write(path: Path, text: str) -> None:
    with whole(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
