"""A project's folder as `make run` leaves it, in a second: models that learnt a few steps from one busy crossing."""

from dataclasses import replace
from pathlib import Path

import yaml

from drivegen.assets.table import build_table
from drivegen.checker.limits import Limits
from drivegen.goals.candidates import Settings as CandidateSettings
from drivegen.goals.candidates import candidates
from drivegen.lanes.graph import LaneGraph
from drivegen.planners._requests import examples_from_logs
from drivegen.planners.route_fm import Plugin as Planner
from drivegen.scenario import Scenario
from drivegen.selectors.learned import Lists
from drivegen.selectors.learned import Plugin as Selector
from drivegen.selectors.learned import Settings as SelectorSettings
from drivegen.settings import build, read_section
from drivegen.store.assets import write_assets
from drivegen.store.files import write_json
from tests.scenes import busy_crossing

PARAMS = Path(__file__).parents[1] / "params.yaml"
SHORT = {"steps": 6, "batch": 8, "report_every": 3, "checkpoint_every": 6}


def make_project(folder: Path) -> Path:
    """`folder` with params.yaml, data/assets.parquet and data/models."""
    tree = yaml.safe_load(PARAMS.read_text())
    for section in ("rollout", "ship"):
        tree[section]["generation"]["rollout"] |= {"attempts": 2, "rounds": 2}
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "params.yaml").write_text(yaml.safe_dump(tree))
    scenes = [busy_crossing(scenario_id=f"learnt-{i}") for i in range(2)]
    models = folder / "data" / "models"
    _planner(scenes, models / "planners" / "route_fm")
    _selector(scenes, models / "selector")
    write_json(models / "limits.json", build(Limits, read_section("calibrate.floors", PARAMS), "floors").to_json())
    write_assets(folder / "data" / "assets.parquet", build_table(scenes).to_arrow())
    return folder


def _planner(scenes: list[Scenario], folder: Path) -> None:
    values = read_section("train_planner.planners.route_fm", PARAMS)
    small = values | {"width": 32, "blocks": 1, "euler_steps": 2, "training": values["training"] | SHORT}
    planner = Planner(build(Planner.Settings, small, "small"))
    logs = examples_from_logs(scenes, [LaneGraph.of(s.map) for s in scenes], 0.8, 7)
    planner.fit(logs, logs[:4], 7, None, lambda _: None)
    planner.save(folder)


def _selector(scenes: list[Scenario], folder: Path) -> None:
    settings = build(SelectorSettings, read_section("train_selector.learned", PARAMS), "learned")
    settings = replace(settings, width=16, training=replace(settings.training, **SHORT))
    offered = build(CandidateSettings, read_section("train_selector.candidates", PARAMS), "candidates")
    lists = Lists.joined(
        [Lists.of(s, [candidates(LaneGraph.of(s.map), s, n, offered) for n in range(len(s.vehicles))]) for s in scenes]
    )
    Selector.fit(lists, lists, settings, 7, None, lambda _: None)[0].save(folder)
