"""The rollout on the real scene 0a1e6f0a: what overlaps in its log is listed, and vehicles that are generated overlap nobody."""

import os
from pathlib import Path

import numpy as np
import pytest

from drivegen.core.first_frame import first_frame
from drivegen.core.scenario import Scenario, Trajectories, VehicleKind
from drivegen.datasets import argoverse2
from drivegen.ingest.selection import Settings, select
from drivegen.rollout.batch import roll_out
from drivegen.rollout.choices import choose
from drivegen.rollout.models import Equipment
from drivegen.sumo.windows import overlapping_pairs
from stages import rollout
from stages._door import read_params

REAL = Path(os.environ.get("DRIVEGEN_REAL_DATA", Path(__file__).parents[2].parent / "shared" / "data")) / "argoverse2"
SCENE = "0a1e6f0a-1817-4a98-b02e-db8c9327d151"
SETTINGS = Settings(target="focal", max_vehicles=16, first_step=0, horizon=100, map_radius=100.0, smallest_shrink=0.8)
INHERITED = {("139344", "139522"), ("139344", "139605")}
"""Tracks of two people that appear, for 1.9 s each, inside the box of a car that waits: 0.01 m and 1.1 m from its middle."""

pytestmark = pytest.mark.skipif(not REAL.is_dir(), reason=f"no real Argoverse 2 data in {REAL}")


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return select(argoverse2.Plugin(REAL / "motion-forecasting").read("train", SCENE), SETTINGS)


def overlaps(scenario: Scenario, motion: Trajectories) -> set[tuple[str, str]]:
    """Track ids of the pairs that overlap at any step when the vehicles move so; of two context actors nothing is told."""
    actors, vehicles = scenario.context, scenario.vehicles
    names = np.concatenate([vehicles.track_id, actors.track_id])
    both = Trajectories.joined([motion, actors.motion])
    pairs = overlapping_pairs(both, np.concatenate([vehicles.size, actors.size]))
    return {(str(names[a]), str(names[b])) for a, b in pairs if a < len(vehicles)}


def test_what_the_log_overlaps_is_two_people_tracked_inside_a_car(scenario: Scenario) -> None:
    assert scenario.log is not None
    assert overlaps(scenario, scenario.log) == INHERITED
    inside = np.isin(scenario.context.track_id, [person for _, person in INHERITED])
    assert (scenario.context.kind[inside] == VehicleKind.PEDESTRIAN).all()
    assert not scenario.context.motion.valid[inside, 0].any()


def test_generated_vehicles_overlap_nobody_whom_the_first_frame_shows(scenario: Scenario, models: Path) -> None:
    generation = read_params("rollout", rollout.Params).generation
    tools = Equipment.open(models, generation.planner, "learned")
    scene = first_frame(scenario)
    choices = choose([scene], tools.selector, generation.candidates, generation.temperature)
    (samples,) = roll_out(choices, tools.planner, tools.limits, generation.rollout, 10, 7, "drivegen")
    for k in range(10):
        assert overlaps(scene, samples.motion[k]) == set()
