"""Scenes drawn by seed for pictures and recordings, so that nobody chose the good ones."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.samples import NO_GOAL, Samples
from drivegen.core.scenario import Scenario
from drivegen.core.seeds import rng
from drivegen.store.goals import GoalColumns, read_goals
from drivegen.store.samples import read_samples
from drivegen.store.scenarios import count as count_rows
from drivegen.store.scenarios import read_shard, shards


@dataclass(frozen=True)
class Drawn:
    """A scene with its samples, and the shard that both are in (its file name)."""

    shard: str
    scenario: Scenario
    samples: Samples


def draw_places(seed: int, scenarios: Path, count: int) -> list[tuple[Path, int]]:
    """The shards and rows of `count` scenes of all shards below `scenarios` (fewer if there are fewer); in a random order.

    The first scenes are the same whatever the count.
    """
    places = [(file, row) for file in shards(scenarios) for row in range(count_rows(file))]
    order = rng(seed, "draw").permutation(len(places))[:count]
    return [places[int(place)] for place in order]


def draw_scenes(seed: int, scenarios: Path, generated: Path, count: int) -> list[Drawn]:
    """The scenes at `draw_places` with their samples, in that order; reads only the shards that they are in.

    Raises UnusableInput where `generated` lacks one.
    """
    read: dict[Path, tuple[list[Scenario], dict[str, Samples]]] = {}
    scenes_drawn = []
    for file, row in draw_places(seed, scenarios, count):
        if file not in read:
            read[file] = read_shard(file), {s.scenario_id: s for s in read_samples(generated / file.name)}
        scenes, samples = read[file]
        scenes_drawn.append(Drawn(file.name, scenes[row], _of(scenes[row], samples, generated / file.name)))
    return scenes_drawn


def by_method(scenes: list[Drawn], generated: Path) -> list[dict[str, Samples]]:
    """The samples of each drawn scene by every method that has a folder below `generated`, by the folder's name.

    Raises UnusableInput where one lacks a scene.
    """
    by_scene: list[dict[str, Samples]] = [{} for _ in scenes]
    for folder in sorted(place for place in generated.iterdir() if place.is_dir()):
        for shard in sorted({one.shard for one in scenes}):
            samples = {s.scenario_id: s for s in read_samples(folder / shard)}
            for one, methods in zip(scenes, by_scene, strict=True):
                if one.shard == shard:
                    methods[folder.name] = _of(one.scenario, samples, folder / shard)
    return by_scene


def goals_of(scenario_id: str, shard: Path) -> GoalColumns:
    """What a selector recorded for a scene; raises UnusableInput where its shard lacks it."""
    columns = [one for one in read_goals(shard) if one.scenario_id == scenario_id]
    if not columns:
        raise UnusableInput(f"{shard} lacks scenario {scenario_id}: run the goals stage again")
    return columns[0]


def followed_goals(samples: Samples, selector: str | None, goals: Path, shard: str) -> NDArray[np.float32] | None:
    """The places (C, 2) [m] of the goals that the samples follow, each once, those beyond an exit at the exit.

    None where there are none.

    `selector` recorded them, None where the method follows none. `goals` is the folder of what selectors recorded (a folder
    each), `shard` the file in it. Raises UnusableInput where that lacks the scene.
    """
    if selector is None or not (file := goals / selector / shard).is_file():
        return None
    columns = goals_of(samples.scenario_id, file).columns
    first = np.concatenate([[0], np.cumsum(columns["candidates"])[:-1]])
    rows = np.unique((samples.goal + first)[samples.goal != NO_GOAL])
    places: NDArray[np.float32] = columns["place"].reshape(-1, 2)[rows]
    return places


def _of(scenario: Scenario, samples: dict[str, Samples], place: Path) -> Samples:
    if scenario.scenario_id not in samples:
        raise UnusableInput(f"{place} lacks scenario {scenario.scenario_id}: run the rollout stage again")
    return samples[scenario.scenario_id]
