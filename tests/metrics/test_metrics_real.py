"""All measures on real driving: the anchors stand in their order, the log has no distance from itself, nothing breaks."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivegen.core.errors import UnusableInput
from drivegen.core.seeds import rng
from drivegen.datasets import argoverse2, commonroad
from drivegen.generators import constant_velocity, random_agent
from drivegen.generators import log as recorded
from drivegen.ingest.selection import Settings as Selection
from drivegen.ingest.selection import select
from drivegen.metrics.road_edge import RoadEdges
from drivegen.metrics.scene import Settings, score
from drivegen.metrics.whole import Scenes, columns, summary
from drivegen.roads.drivable import CELL, road_field

REAL = Path(os.environ.get("DRIVEGEN_REAL_DATA", Path(__file__).parents[2].parent / "shared" / "data"))
SELECTION = Selection(target="focal", max_vehicles=16, first_step=0, horizon=100, map_radius=None, smallest_shrink=0.8)
MEASURED = Settings(horizons=(1.0, 5.0, 8.0), bandwidths=(0.25, 1.0, 4.0, 16.0, 45.0), box_scales=(0.9, 1.0, 1.1))
SOURCES = {
    "argoverse2": (argoverse2, "argoverse2/motion-forecasting", "train", 100),
    "commonroad": (commonroad, "commonroad", "val", 80),
}
MOST = 3


@pytest.fixture(scope="module", params=SOURCES)
def scenes(request):
    module, folder, split, horizon = SOURCES[request.param]
    if not (REAL / folder).is_dir():
        pytest.skip(f"no real data in {REAL / folder}")
    plugin = module.Plugin(REAL / folder)
    found = []
    for name in plugin.scenes(split):
        try:
            found.append(select(plugin.read(split, name), replace(SELECTION, horizon=horizon)))
        except UnusableInput:
            continue
    return found[:: max(1, len(found) // MOST)][:MOST]


def measured(scenes, module):
    made = module.Plugin(Path(), None).generate(scenes, 4, 7)
    parts = []
    for scene, samples in zip(scenes, made, strict=True):
        field = road_field(scene.map)
        parts.append(
            score(
                scene,
                scene.log,
                samples,
                RoadEdges(field.outside, field.origin, CELL, field.beyond_rim),
                MEASURED,
                rng(7, "test"),
            )
        )
    scenes = Scenes.of(parts)
    return summary(scenes, columns(scenes, MEASURED), 7, 20, 4)


def test_anchors_and_distances_on_real_driving(scenes):
    log, straight, chance = (measured(scenes, module) for module in (recorded, constant_velocity, random_agent))
    assert log["scenarios"] >= 2
    assert 1 > log["realism"] > straight["realism"] > chance["realism"] > 0
    assert log["auc"] == 0.5
    for name in ("speed", "acceleration", "jerk", "headway", "manoeuvres"):
        assert log[f"distance.{name}"] == pytest.approx(0, abs=1e-9)
        assert straight[f"distance.{name}"] > 0
    for name in ("energy_final", "energy_trajectory", "energy_joint", "energy_joint_final"):
        assert log[name] == 0 < straight[name] < chance[name]
    assert log["nll_5s"] < straight["nll_5s"]
    assert np.isfinite(straight["nll_joint_5s"])
    assert 0 <= log["boxes_90_collision"] <= log["boxes_100_collision"] <= log["boxes_110_collision"]
