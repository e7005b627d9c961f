"""Stage record: Rerun recordings of a few scenes drawn by seed, of all methods and of all drivers in them, and of pictured
collisions (a leaf).

argv: scenarios of one split, samples (a folder a method), what was turned down on the way to them (a file a method),
recorded goals (a folder a selector), rounds of corner cases, drivers' runs through logs (a file a driver), the folder of
recordings, the list of recordings (JSON, for the report: .rrd files differ in bytes at every write, their list does not).
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drivegen.core.methods import read_methods
from drivegen.core.scenario import TARGET, Scenario
from drivegen.core.settings import Index
from drivegen.recording import LOG, record_comparison
from drivegen.recording.collision import record_collision
from drivegen.recording.drivers import LOGGED, record_drivers, speeds
from drivegen.recording.sample import record_sample
from drivegen.store.collisions import read_pictured
from drivegen.store.draw import by_method, draw_scenes, followed_goals, goals_of
from drivegen.store.files import write_json
from drivegen.store.lookup import DRIVEN, SAMPLES, samples_in, scenario_in
from drivegen.store.rejected import rejected_by_method, rejected_of
from stages._door import require

METHOD = "drivegen"
"""Whose samples are recorded with goals, verdicts and plots."""


@dataclass(frozen=True)
class Params:
    """`scenes` recordings of DriveGen's traffic, `compared` ones of all methods, `driven` of all drivers: the report's first."""

    seed: int
    scenes: Index
    compared: Index
    driven: Index


def main(
    params: Params,
    scenarios: Path,
    generated: Path,
    rejected: Path,
    goals: Path,
    corner: Path,
    driven: Path,
    out: Path,
    listing: Path,
) -> dict[str, float]:
    """Record sample 0 of each drawn scene, and every collision that the rounds pictured."""
    drawn_from = require(generated / METHOD, "run the rollout stage")
    scenes = draw_scenes(params.seed, scenarios, drawn_from, max(params.scenes, params.compared, params.driven))
    turned_down = rejected_by_method(rejected)
    selectors = {name: method.goals for name, method in read_methods().items()}
    links = []
    for scene in scenes[: params.scenes]:
        scenario, samples = scene.scenario, scene.samples
        file = out / f"{scenario.scenario_id}.rrd"
        mine = rejected_of(scenario.scenario_id, turned_down).get(METHOD)
        offered = goals_of(scenario.scenario_id, require(goals / str(selectors[METHOD]) / scene.shard, "run the goals stage"))
        record_sample(file, scenario, samples, 0, offered, mine)
        text = f"{scenario.scenario_id}, {scenario.city}: {samples.method} against the log"
        links.append(_entry(file, text, scenario.scenario_id, 0, "rollout", METHOD))
    compared = scenes[: params.compared]
    for scene, methods in zip(compared, by_method(compared, generated), strict=True):
        scenario = scene.scenario
        file = out / f"{scenario.scenario_id}-methods.rrd"
        ours_first = sorted(methods.keys() - {LOG}, key=lambda name: (not name.startswith(METHOD), name))
        shown = {name: methods[name] for name in ours_first}
        places = {name: followed_goals(one, selectors.get(name), goals, scene.shard) for name, one in shown.items()}
        recorded = {name: place for name, place in places.items() if place is not None}
        record_comparison(file, scenario, shown, recorded, rejected_of(scenario.scenario_id, turned_down))
        text = f"{scenario.scenario_id}, {scenario.city}: {len(methods)} methods side by side"
        links.append(_entry(file, text, scenario.scenario_id, 0))
    links += [_drivers(scene.scenario, driven, out) for scene in scenes[: params.driven] if scene.scenario.log is not None]
    links += _collisions(scenarios, corner, out)
    write_json(listing, links)
    return {"scenarios": float(len(scenes))}


def _collisions(scenarios: Path, corner: Path, out: Path) -> list[dict[str, Any]]:
    """A recording of each pictured collision; its name is the picture's."""
    links = []
    for one in read_pictured(corner):
        where, played = one.where, one.path.parents[1]
        scenario = scenario_in(scenarios / where.shard, where.scenario_id)
        planned, driven = (samples_in(played / part / where.shard, where.scenario_id) for part in (SAMPLES, DRIVEN))
        file = out / f"{one.name}.rrd"
        record_collision(file, scenario, planned, driven.motion[:, 0], where, one.title, one.words)
        links.append(_entry(file, f"{one.title}: {where.scenario_id}", where.scenario_id, where.sample, "corner", played.name))
    return links


def _drivers(scenario: Scenario, driven: Path, out: Path) -> dict[str, Any]:
    """All drivers in the logged traffic of a scene, their speeds in the list."""
    assert scenario.log is not None, scenario.scenario_id
    files = sorted(require(driven, "run the drive stages").iterdir())
    runs = {file.stem: samples_in(file, scenario.scenario_id) for file in files}
    motion = {name: run.motion[0, TARGET] for name, run in runs.items()}
    collided = [name for name, run in runs.items() if not run.legal.all()]
    file = out / f"{scenario.scenario_id}-drivers.rrd"
    record_drivers(file, scenario, motion, collided)
    text = f"{scenario.scenario_id}, {scenario.city}: {len(runs)} drivers and the log"
    speed = {name: speeds(one) for name, one in {LOGGED: scenario.log[TARGET], **motion}.items()}
    return _entry(file, text, scenario.scenario_id, 0) | {"speed": speed, "collided": collided}


def _entry(file: Path, text: str, scenario_id: str, sample: int, stage: str = "", item: str = "") -> dict[str, Any]:
    """A recording of the list: what it shows, and of which stage's item; of none where it compares methods or drivers."""
    href = f"{file.parent.name}/{file.name}"
    return {"text": text, "href": href, "scenario": scenario_id, "sample": sample, "stage": stage, "item": item}
