"""Models that were trained for seconds on hand-made scenes: good enough to run everything that needs some, and no better."""

from pathlib import Path

import numpy as np

from drivegen.checker.verdicts import write_limits_file
from drivegen.core import plugins
from drivegen.core.scenario import Scenario
from drivegen.core.settings import build
from drivegen.goals.candidates import Settings as CandidateSettings
from drivegen.goals.candidates import candidates
from drivegen.goals.lists import Lists
from drivegen.goals.packing import pack
from drivegen.planners.base import Planner
from drivegen.planners.shared.requests import examples_from_logs
from drivegen.roads.graph import LaneGraph
from drivegen.rollout.choices import choose
from drivegen.selectors.learned import Plugin as Learned
from drivegen.selectors.learned import Settings as LearnedSettings
from drivegen.selectors.random import Plugin as Random
from drivegen.store.columns import joined as end_to_end
from drivegen.store.goals import write_goals
from stages import train_selector
from stages._door import read_params, read_section
from tests.checking import LIMITS
from tests.scenes import busy_crossing, drive, joined, scenario, stack, straight_road

ROOT = Path(__file__).parents[1]


def write_models(folder: Path) -> Path:
    """`folder` with all that `Equipment.open` reads: planner route_fm, the learned selector, the checker's limits."""
    scenes = [busy_crossing(101, "taught-crossing"), *(two_lanes(speed) for speed in (4.0, 8.0, 12.0))]
    planner(scenes).save(folder / "planners" / "route_fm")
    selector(scenes).save(folder / "selector")
    write_limits_file(folder / "limits.json", LIMITS)
    return folder


def planner(scenes: list[Scenario]) -> Planner:
    """A small route_fm after a few steps."""
    params = read_section("train_planner.planners.route_fm", ROOT / "params.yaml")
    training = params["training"] | {"steps": 40, "batch": 16, "warmup": 5, "average": 0.9, "report_every": 20}
    plugin = plugins.load("planners", "route_fm")
    small = params | {"width": 32, "blocks": 1, "euler_steps": 2, "training": training}
    made: Planner = plugin(build(plugin.Settings, small, "tests/models.py"))
    logs = examples_from_logs(scenes, [LaneGraph.of(s.map) for s in scenes], 0.8, 7)
    made.fit([logs], logs, 7, None, lambda _: None)
    return made


def selector(scenes: list[Scenario]) -> Learned:
    """A small learned selector after a few steps."""
    params = read_section("train_selector.learned", ROOT / "params.yaml")
    training = params["training"] | {"steps": 40, "batch": 16, "warmup": 5, "report_every": 20, "checkpoint_every": 20}
    settings = build(LearnedSettings, params | {"width": 16, "training": training}, "tests/models.py")
    offered = candidate_settings()
    each = (Lists.of(s, [candidates(LaneGraph.of(s.map), s, n, offered) for n in range(len(s.vehicles))]) for s in scenes)
    lists = end_to_end(Lists, each)
    made, _ = Learned.fit(lists, lists, settings, 7, None, lambda _: None)
    return made


def candidate_settings() -> CandidateSettings:
    """The pipeline's own."""
    return read_params("train_selector", train_selector.Params, ROOT / "params.yaml").candidates


def write_random_goals(shard: Path, scenes: list[Scenario]) -> None:
    """The goals of `scenes` as the stage `goals` leaves them, of a selector to whom all are equally likely."""
    choices = choose(scenes, Random(), candidate_settings(), 1.0)
    write_goals(shard, [pack(c.scenario, "random", c.candidates, c.natural) for c in choices])


def two_lanes(speed: float = 8.0, scenario_id: str | None = None, steps: int = 101) -> Scenario:
    """Two queues of three cars side by side, the left one faster."""
    roads = straight_road(500, 2)
    starts = np.array([[10, 40, 70], [15, 45, 75]])
    logs = [drive(joined(roads, lane), starts[lane, i], speed + lane, steps) for i in (0, 1, 2) for lane in (0, 1)]
    return scenario(roads, stack(logs), scenario_id or f"taught-{speed:g}")
