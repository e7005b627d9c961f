"""First frames: what is measured of them, and how far two sets of them are apart."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.core.scenario import Scenario
from drivegen.metrics.distributions import BINS
from drivegen.placement.beginnings import RANGES, Beginning, compared, without_parked
from drivegen.roads.graph import LaneGraph
from tests.scenes import busy_crossing, drive, scenario, stack, straight_road


def lane_of(count: int) -> Scenario:
    """`count` cars 20 m apart on one straight lane, each at 10 m/s, the target last in the row."""
    lane = np.stack([np.arange(0, 401, 10.0), np.zeros(41)], axis=1)
    return scenario(straight_road(400.0, 1), stack([drive(lane, 20.0 * (n + 1), 10.0, 11) for n in range(count)]))


def beginning(scene: Scenario, **changes: np.ndarray) -> Beginning:
    return Beginning.of(scene, replace(scene.vehicles, **changes), LaneGraph.of(scene.map))


def middle(found: Beginning, name: str) -> float:
    """The mean of what was counted, by the middle of its bins."""
    (low, high), counts = RANGES[name], found.counts[list(RANGES).index(name)]
    return float((counts * (low + (np.arange(BINS) + 0.5) * (high - low) / BINS)).sum() / counts.sum())


def test_everybody_but_the_target_is_measured():
    scene = lane_of(4)
    found = beginning(scene)
    assert found.vehicles == 4
    assert found.counts.sum(axis=1).tolist() == [3, 2, 3, 3]  # the first of the row has no leader
    assert middle(found, "speed") == pytest.approx(10.0, abs=0.11)
    length = scene.vehicles.size[0, 0]
    assert middle(found, "gap") == pytest.approx(20.0 - length, abs=0.3)
    assert found.rates.tolist() == [0.0, 0.0]


def test_offsets_and_headings_are_against_the_lane():
    scene = lane_of(4)
    position, heading = scene.vehicles.position.copy(), scene.vehicles.heading.copy()
    position[:, 1] += 0.7
    heading += np.float32(np.radians(20.0))
    found = beginning(scene, position=position, heading=heading)
    assert middle(found, "offset") == pytest.approx(0.7, abs=0.03)
    assert middle(found, "heading") == pytest.approx(20.0, abs=0.4)
    assert middle(beginning(scene, heading=heading + np.float32(np.pi)), "heading") > 89  # the wrong way


def test_who_overlaps_and_who_is_on_no_lane_is_counted():
    scene = lane_of(5)
    position = scene.vehicles.position.copy()
    position[2] = position[1] + 1.0
    position[4, 1] += 30.0
    assert beginning(scene, position=position).rates.tolist() == [0.5, 0.25]


def test_a_target_alone_has_no_rates():
    assert np.isnan(beginning(lane_of(1)).rates).all()


def test_logs_are_at_no_distance_from_themselves_and_farther_from_what_is_faster():
    logs = [beginning(lane_of(4)), beginning(replace(busy_crossing(), scenario_id="another"))]
    rng = np.random.default_rng
    assert all(compared(logs, logs, 50, rng(0))[name].value == 0 for name in RANGES)
    faster = [replace(log, counts=np.roll(log.counts, 10, axis=1)) for log in logs]
    found = compared(logs, faster, 50, rng(0))["speed"]
    assert found.value == pytest.approx(10 * 48.0 / BINS, rel=1e-6)
    assert found.low <= found.value <= found.high


def test_whoever_is_parked_is_left_out_but_a_target():
    scene = lane_of(4)
    beside = scene.vehicles.position + np.float32([0, -4]) * np.array([[1], [0], [1], [1]], np.float32)
    speed = np.array([0, 0, 0, 10], np.float32)
    kept = without_parked(replace(scene, vehicles=replace(scene.vehicles, position=beside, speed=speed)))
    kept.validate()
    assert kept.vehicles.track_id.tolist() == scene.vehicles.track_id[[0, 1, 3]].tolist()


def test_first_frames_are_drawn_by_recording():
    rng = np.random.default_rng
    logs = [beginning(replace(scene, scenario_id=f"a-{n:03d}")) for n, scene in enumerate((lane_of(4), busy_crossing()))]
    assert [log.recording for log in logs] == ["a", "a"]
    alone = compared(logs, logs, 50, rng(0))["off_lane"]
    assert np.isnan([alone.low, alone.high]).all()  # one recording says nothing about others
