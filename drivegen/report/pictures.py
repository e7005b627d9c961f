"""Pictures of the report: scenes large, the same scenes by every method side by side, generated maps."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import orjson

from drivegen.core.methods import NO_TRAFFIC, Method
from drivegen.core.rejections import Rejected
from drivegen.core.samples import Samples
from drivegen.render.contact_sheet import contact_sheet
from drivegen.render.png import png, shrunk
from drivegen.render.scene_picture import scene_picture, view_of
from drivegen.report.evidence import Link, Picture
from drivegen.store.collisions import read_pictured
from drivegen.store.draw import Drawn, followed_goals

SCENE_WIDTH, PANEL_WIDTH, MAP_WIDTH = 700, 330, 640
"""Widths of pictures in the page [pixels]; a panel is one method of several on one scene."""

PANELS = 3
"""Methods in a row."""


def picture_scene(scene: Drawn, rejected: Rejected | None) -> Picture:
    """A scene with all its samples, and what was turned down on the way to them; None where nothing was kept of that."""
    scenario, samples = scene.scenario, scene.samples
    image = scene_picture(scenario, samples.motion, ~samples.legal, pixels=SCENE_WIDTH, rejected=rejected)
    counts = f"{len(scenario.vehicles)} vehicles, {len(samples.violation)} samples"
    return Picture(_title(scene), counts if rejected is None else f"{counts}; {rejected.summary}", png(image))


def compare_methods(
    scene: Drawn, samples: Mapping[str, Samples], about: Mapping[str, Method], rejected: Mapping[str, Rejected], goals: Path
) -> Picture:
    """One scene by every generator that makes traffic to see, in the window that the log (or the first method) needs.

    `samples` and `rejected` of this scene by method; `about` is every generator in the tables' order; `goals` the folder of what
    selectors recorded. Raises UnusableInput where that lacks the scene.
    """
    scenario = scene.scenario
    moving = scenario.log if scenario.log is not None else scene.samples.motion
    view = view_of(moving, PANEL_WIDTH)
    panels = []
    visible = {name: method for name, method in about.items() if name in samples and method.kind != NO_TRAFFIC}
    for name, method in visible.items():
        mine = samples[name]
        places = followed_goals(mine, method.goals, goals, scene.shard)
        image = scene_picture(scenario, mine.motion, ~mine.legal, places, view=view, rejected=rejected.get(name))
        panels.append((method.title, image))
    counts = [f"{method.title}: {rejected[name].summary}" for name, method in visible.items() if name in rejected]
    caption = ". ".join([f"{len(scenario.vehicles)} vehicles", *counts])
    return Picture(_title(scene), caption, png(contact_sheet(panels, PANELS)))


def read_collision_pictures(corner: Path, recordings: Sequence[Link]) -> tuple[Picture, ...]:
    """The collisions that the rounds below `corner` pictured, each with its recording where there is one."""
    by_name = {Path(link.href).stem: link.href for link in recordings}
    return tuple(
        Picture(one.title, one.words, one.path.with_suffix(".png").read_bytes(), by_name.get(one.name, ""))
        for one in read_pictured(corner)
    )


def read_map_pictures(folder: Path, most: int) -> tuple[Picture, ...]:
    """The first `most` pictures <map>/map.png below `folder` by name, each with the words (map.json) that its map is from."""
    return tuple(_map(file) for file in sorted(folder.glob("*/map.png"))[:most])


def _map(file: Path) -> Picture:
    about = file.with_suffix(".json")
    words = orjson.loads(about.read_bytes()) if about.exists() else {}
    return Picture(file.parent.name.replace("_", " "), str(words.get("text", "")), shrunk(file.read_bytes(), MAP_WIDTH))


def _title(scene: Drawn) -> str:
    return f"{scene.scenario.scenario_id} ({scene.scenario.city})"
