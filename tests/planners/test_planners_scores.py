"""The figures of a planner, where they can be said by hand."""

from collections.abc import Sequence

import numpy as np
import pytest

from drivegen.core.scenario import Scenario, Trajectories
from drivegen.planners.base import Examples, PlanRequests
from drivegen.planners.shared.requests import examples_from_logs
from drivegen.planners.shared.scores import MISSED, Sample, drawn_tracks, probe, score
from drivegen.roads.graph import LaneGraph
from tests.scenes import drive, scenario, stack, straight_road

ROAD = straight_road(300)
LINE = ROAD.centreline[0].astype(np.float64)


@pytest.fixture(scope="module")
def logs() -> Examples:
    """Two cars that slow down by half a metre per second squared, and a parked one."""
    tracks = [drive(LINE, 100, 12, 101, -0.5), drive(LINE, 20, 10, 101, -0.5), drive(LINE, 280, 0, 101)]
    return examples_from_logs([scenario(ROAD, stack(tracks))], [LaneGraph.of(ROAD)], 0.8, 7)


def aside(*offsets: float) -> Sample:
    """Drives every track as its log did, but so far to the left [m], sample by sample; the first frame is nonsense."""

    def sample(scenes: Sequence[Scenario], requests: PlanRequests) -> Trajectories:
        tracks = zip(requests.scenario.tolist(), requests.vehicle.tolist(), strict=True)
        motion = Trajectories.joined([scenes[s].log[[v]] for s, v in tracks])
        motion.position[..., 1] += np.resize(offsets, len(requests))[:, None].astype(np.float32)
        motion.position[:, 0] += 100.0
        return motion

    return sample


def figures(logs: Examples, *offsets: float) -> dict[str, float]:
    drawn = drawn_tracks(logs, 10, None, 7)
    return score(
        aside(*offsets), logs, drawn, len(offsets), 7, lambda scenes, asked, motion: {"illegal": motion.position[:, 5, 1] > 1}
    )


def test_parked_tracks_are_not_scored(logs: Examples) -> None:
    assert logs.requests.parked.tolist() == [False, False, True]
    assert drawn_tracks(logs, 10, None, 7).tolist() == [0, 1]
    assert len(drawn_tracks(logs, 1, None, 7)) == 1


def test_errors_are_the_best_and_the_mean_of_samples_from_the_second_frame_on(logs: Examples) -> None:
    found = figures(logs, 0.0, 3.0)
    assert (found["scored_tracks"], found["scored_scenes"]) == (2, 1)
    assert found["ade_best"] == pytest.approx(0.0, abs=1e-4)
    assert found["ade_mean"] == pytest.approx(1.5, abs=1e-4)
    assert found["goal_error"] == pytest.approx(1.5, abs=1e-4)
    assert found["illegal"] == 0.5
    assert found["hidden.ade_mean"] == found["ade_mean"]


def test_a_track_is_missed_if_no_sample_ends_near_its_goal(logs: Examples) -> None:
    assert figures(logs, 0.0, MISSED + 1)["miss_rate"] == 0
    assert figures(logs, MISSED + 0.1, MISSED + 1)["miss_rate"] == 1


def test_a_steady_slowing_down_has_no_jerk_and_lies_at_no_distance_from_itself(logs: Examples) -> None:
    found = figures(logs, 0.0)
    for prefix in ("", "log."):
        assert found[f"{prefix}acceleration"] == pytest.approx(0.5, abs=1e-3)
        assert found[f"{prefix}jerk"] == pytest.approx(0.0, abs=1e-2)
        assert found[f"{prefix}acceleration_distance"] == 0
    assert found["base.goal_error"] == pytest.approx(0.0, abs=1e-3)


def test_the_probe_is_the_mean_error_of_what_is_drawn(logs: Examples) -> None:
    assert probe(aside(1.0, 2.0), logs, drawn_tracks(logs, 10, None, 7), 7) == pytest.approx(1.5, abs=1e-4)
    assert np.isnan(probe(aside(1.0), logs, np.zeros(0, np.intp), 7))


def test_tracks_are_scored_where_those_of_the_longest_scene_are_parked():
    short = scenario(ROAD, stack([drive(LINE, 20, 8, 71), drive(LINE, 60, 9, 71)]), "short")
    parked = scenario(ROAD, stack([drive(LINE, 20, 0, 101)]), "parked")
    mixed = examples_from_logs([short, parked], [LaneGraph.of(ROAD)] * 2, 0.8, 7)
    assert figures(mixed, 0.0)["scored_tracks"] == 2
