from dataclasses import replace

import numpy as np
import pytest

from drivegen.core import seeds
from drivegen.core.crop import Cropper
from drivegen.core.first_frame import first_frame
from drivegen.core.geometry import resample
from drivegen.core.roadmap import RoadMap
from drivegen.core.scenario import Scenario
from drivegen.layouts.compile import compile_map
from drivegen.layouts.spec import MapSpec
from drivegen.sumo.demand import Demand, draw_demand
from drivegen.sumo.network import Network
from drivegen.sumo.traffic import Run, simulate
from drivegen.sumo.windows import EGO, Recording, WindowSettings, cut_windows
from tests.futures import bytes_of

STEPS = 40
WINDOWS = WindowSettings(steps=STEPS, radius=60.0, map_radius=5.0, apart=10.0, focal_travel=2.0, fewest=1, moving_share=0.0)


@pytest.fixture(scope="module")
def recording() -> Recording:
    """Four seconds of light traffic on a grid."""
    raw = compile_map(MapSpec.model_validate({"road": {"kind": "grid", "rows": 2, "columns": 3, "control": "signals"}}))
    network = Network.read(raw, "grid")
    demand = draw_demand(network, Demand(25, 14.0, 20.0), seeds.rng(3, "windows"))
    traffic = simulate(raw, demand, network.map.origin, Run(3, 15.0, STEPS * 0.1, 0.8, 60.0))
    return Recording(network, traffic, Cropper(network.map), "grid")


def windows(recording: Recording) -> list[Scenario]:
    return [window for _, window in cut_windows(recording, "w", WINDOWS, np.random.default_rng(1))]


def shown_otherwise(recording: Recording) -> Recording:
    """The same first frame; then all are pushed aside gently and every light is switched."""
    traffic, motion = recording.traffic, recording.traffic.motion
    time = np.arange(STEPS, dtype=np.float32)[:, None] * np.float32(0.1)
    push = np.float32([0.4, -0.3])
    moved = replace(motion, position=motion.position + push * time**2, velocity=motion.velocity + 2 * push * time)
    lights = {name: np.concatenate([state[:, :1], 4 - state[:, 1:]], axis=1) for name, state in traffic.lights.items()}
    return replace(recording, traffic=replace(traffic, motion=moved, lights=lights))


def test_windows_that_begin_alike_are_scenarios_of_equal_first_frames(recording):
    both = {s.scenario_id: s for s in windows(recording)}, {s.scenario_id: s for s in windows(shown_otherwise(recording))}
    alike = sorted(both[0].keys() & both[1].keys())
    assert len(alike) >= 3
    for name in alike:
        one, other = (_at_start(scenarios[name]) for scenarios in both)
        assert len(one.map) < len(recording.network.map)
        assert bytes_of(one) == bytes_of(other)


def test_the_recording_vehicle_is_nearest_to_the_target_at_first(recording):
    names = [scenario.vehicles.track_id.tolist() for scenario in windows(recording)]
    places = [found.index(EGO) for found in names if EGO in found]
    assert set(places) == {1}


def test_the_map_holds_what_is_in_reach_of_whoever_is_there_at_first(recording):
    found = windows(recording)
    assert found
    for scenario in found:
        v = scenario.vehicles
        assert scenario.log is not None
        first = scenario.log.valid[:, 0]
        _covers(recording.network.map, scenario.map, v.position[first] + scenario.map.origin, v.speed[first] * 3.9 + 5.0)


def _at_start(scenario: Scenario) -> Scenario:
    """Without who comes later, as ingest leaves them out."""
    assert scenario.log is not None
    return first_frame(replace(scenario, vehicles=scenario.vehicles[scenario.log.valid[:, 0]]))


def _covers(whole: RoadMap, cut: RoadMap, points: np.ndarray, radius: np.ndarray) -> None:
    """Every lane with a point within the radius of a vehicle is kept, none without (lines are tested every 10 m)."""
    assert len(set(cut.lane_id.tolist())) == len(cut)
    for lane, line in zip(whole.lane_id.tolist(), whole.centreline.lines(), strict=True):
        gap = (np.hypot(*(resample(line, 1.0)[:, None] + whole.origin - points).T).T - radius).min()
        if not -6 < gap < 1:
            assert (lane in cut.lane_id) == (gap < 0), (lane, gap)
