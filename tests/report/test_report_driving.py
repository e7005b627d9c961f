"""The section on drivers: who learned in few scenes is called under-trained."""

import pytest

from drivegen.report.evidence import Evidence
from drivegen.report.sections.driving import section

TAUGHT = {"validation_round": 4, "validation_collision": 0.125, "validation_scenes": 120}


@pytest.mark.parametrize(
    ("scenes", "said"),
    [(600, "600 logged scenes, so under-trained: the weights of round 4"), (6000, "logged scenes: the weights")],
)
def test_who_was_taught_in_few_scenes_is_under_trained(scenes: int, said: str) -> None:
    driven = {"log.collision": 0.1, "log.recordings": 14}
    results = {"driving/gail": driven, "driving/idm": driven, "train_driver/gail": TAUGHT | {"train_scenes": scenes}}
    gail, idm = section(Evidence(results=results)).tables
    assert said in gail.notes[0]
    assert "collide in 12.5 % of 120 validation scenes" in gail.notes[0]
    assert not any("Taught" in note for note in idm.notes)
