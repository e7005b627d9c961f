"""A kind of corner cases as a folder: the scenario in every format that is exported, a picture, a recording, a sentence."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from drivegen.core import plugins
from drivegen.core.samples import Samples
from drivegen.corner_cases.case import Case
from drivegen.corner_cases.collisions import Collision, picture
from drivegen.corner_cases.judgement import Judgement
from drivegen.recording.collision import record_collision
from drivegen.store.collisions import Where
from drivegen.store.files import write_bytes

PICTURE, RECORDING, WORDS = "picture.png", "recording.rrd", "sentence.txt"


def write_kind(folder: Path, judgement: Judgement) -> None:
    """Write the case of `judgement` to `folder`, which is made; its scenario is called as the folder is."""
    folder.mkdir(parents=True)
    case = judgement.case
    present = np.flatnonzero(case.motion.valid.any(-1))
    scenario = replace(case.scenario, scenario_id=folder.name, vehicles=case.scenario.vehicles[present], log=case.motion[present])
    for name in plugins.names("exporters"):
        plugins.load("exporters", name)().write(scenario, case.motion[present], folder, folder.name)
    planned, driven = Samples.without_goals(case.scenario_id, case.method, case.traffic[np.newaxis]), case.driven[np.newaxis]
    for name, raw in ((PICTURE, _picture(case, planned)), (WORDS, f"{judgement.sentence}\n".encode())):
        write_bytes(folder / name, raw)
    where = Where(case.scenario_id, "", 0, case.partner, case.step)
    record_collision(folder / RECORDING, case.scenario, planned, driven, where, judgement.kind, judgement.sentence)


def _picture(case: Case, planned: Samples) -> bytes:
    collision = Collision(case.scenario_id, 0, case.partner, case.step, case.kind, (0, 0, 0))
    return picture(collision, case.scenario, planned, case.driven[np.newaxis])
