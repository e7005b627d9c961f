"""A recording of generated traffic together with the goals that it follows and the target's candidates from above."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from drivegen.core.rejections import Rejected
from drivegen.core.samples import Samples
from drivegen.core.scenario import TARGET, Scenario
from drivegen.recording import GoalMarks, record_scenario
from drivegen.render.bird_eye import draw_bird_eye
from drivegen.store.goals import GoalColumns

IMAGE = 640
"""Side of the target's bird-eye image in a recording [pixels]."""


def record_sample(
    path: Path, scenario: Scenario, samples: Samples, sample: int, goals: GoalColumns, rejected: Rejected | None = None
) -> None:
    """Write the recording of sample number `sample`, whose goals were drawn from `goals`, with what was `rejected` for it."""
    marks, lane = _marks(goals, samples, sample)
    of_target = marks.vehicle == TARGET
    image, _ = draw_bird_eye(scenario, TARGET, marks.position[of_target], lane[of_target], IMAGE)
    record_scenario(path, scenario, samples, sample, marks, image, rejected)


def _marks(goals: GoalColumns, samples: Samples, sample: int) -> tuple[GoalMarks, NDArray[np.int32]]:
    """All vehicles' candidates, those chosen that `sample` follows, and the lanes that they are on."""
    count = goals.columns["candidates"]
    vehicle = np.repeat(np.arange(len(count), dtype=np.int32), count)
    number = np.arange(len(vehicle), dtype=np.int32) - np.repeat(np.cumsum(count) - count, count).astype(np.int32)
    marks = GoalMarks(
        position=goals.columns["place"].reshape(-1, 2),
        vehicle=vehicle,
        number=number,
        probability=goals.columns["probability"],
        leaves_after=goals.columns["leaves_after"],
        chosen=samples.goal[sample][vehicle] == number,
    )
    return marks, goals.columns["lane"]
