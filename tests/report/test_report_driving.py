"""The section on drivers: who learned in few scenes is called under-trained."""

import pytest

from drivegen.recording.drivers import speeds
from drivegen.report.evidence import Evidence
from drivegen.report.sections.driving import section
from tests.scenes import drive, straight_road

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


def test_where_nobody_saw_it_a_target_has_no_speed_and_the_line_a_gap() -> None:
    seen = drive(straight_road().centreline[0], 20, 5, 11)
    seen.valid[4:7], seen.velocity[4:7] = False, 0.0
    assert speeds(seen) == [*[5.0] * 4, *[None] * 3, *[5.0] * 4]
    driven = [{"scenario": "s", "speed": {"logged": speeds(seen)}, "collided": []}]
    (figure,) = section(Evidence(results={"recordings": driven})).figures
    (line,) = (part for part in figure.data.decode().split("<path ") if "stroke-width: 1.2" in part and "clip-path" in part)
    assert line.count("M ") == 2
