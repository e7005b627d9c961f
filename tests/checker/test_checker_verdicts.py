"""Verdicts on what others made."""

from pathlib import Path

import numpy as np
import pytest

from drivegen.checker.dynamics import exceed
from drivegen.checker.verdicts import SingleJudge, read_limits_file, write_limits_file
from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.scenario import Trajectories
from tests.checking import LIMITS
from tests.scenes import drive, scenario, stack, straight_road

ROAD = straight_road()
LINE = ROAD.centreline[0].astype(np.float64)


def leaving_the_road() -> Trajectories:
    """Along the lane, from step 60 on 15 m beside it."""
    motion = drive(LINE, 10, 10, 101)
    motion.position[60:, 1] += 15
    return motion


def test_single_trajectories_of_several_scenarios_are_judged_without_the_others() -> None:
    lane, fast = drive(LINE, 10, 10, 101), drive(LINE, 10, 60, 101)  # the limit is 40 m/s
    scenes = [scenario(ROAD, stack([lane, lane]), "a"), scenario(ROAD, stack([lane]), "b"), scenario(ROAD, stack([lane]), "c")]
    motion = stack([lane, leaving_the_road(), fast, lane])
    verdicts = SingleJudge(LIMITS)(scenes, np.array([0, 0, 2, 0]), np.array([0, 1, 0, 1]), motion)
    assert verdicts["off_road"].tolist() == [False, True, False, False]
    assert verdicts["illegal"].tolist() == [False, True, True, False]


def test_steps_after_a_scenarios_last_are_not_judged() -> None:
    short, long = drive(LINE, 10, 10, 51), drive(LINE, 10, 10, 101)
    scenes = [scenario(ROAD, stack([short]), "short"), scenario(ROAD, stack([long]), "long")]
    motion = stack([leaving_the_road(), leaving_the_road()])
    verdicts = SingleJudge(LIMITS)(scenes, np.array([0, 1]), np.array([0, 0]), motion)
    assert verdicts["off_road"].tolist() == [False, True]


def test_limits_that_are_missing_or_broken_are_named(tmp_path: Path) -> None:
    with pytest.raises(MissingTool, match=r"limits\.json is not there"):
        read_limits_file(tmp_path / "limits.json")
    file = tmp_path / "limits.json"
    write_limits_file(file, LIMITS)
    assert read_limits_file(file) == LIMITS
    whole = file.read_bytes()
    for changed, sentence in ((b"{", "has no checksum"), (whole.replace(b"0", b"1", 1), "is not what was written")):
        file.write_bytes(changed)
        with pytest.raises(UnusableInput, match=rf"limits\.json {sentence}"):
            read_limits_file(file)


def test_the_first_step_beyond_a_limit_is_the_earliest_of_all():
    worst, first = np.zeros((1, 1)), np.full((1, 1), -1, np.int16)
    for value, step in ((5.0, 20), (3.0, 10), (0.5, 2)):
        exceed(worst, first, 0, 0, value, np.ones(1), step)
    assert (worst[0, 0], first[0, 0]) == (5.0, 10)
