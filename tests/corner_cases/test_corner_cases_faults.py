"""Drivers with one planted fault each, on scenes of many kinds: the cases of a faulty driver are of its own kind."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from drivegen.corner_cases.kinds import Kind, kind_of
from drivegen.drivers.idm import Plugin as IDM
from drivegen.simulators.batch import Plugin as Batch
from tests.checking import IDM as SETTINGS
from tests.corner_cases.handmade import ROAD, case_of
from tests.corner_cases.test_corner_cases_kinds import CROSSING, SCENES
from tests.scenes import scenario, stack

SOUND = IDM(replace(SETTINGS, look_ahead=2.0, side_margin=0.3))
SHOWN = (Kind.CUT_IN, Kind.REAR, Kind.STANDING, Kind.ONCOMING_TURN, Kind.CROSSING_LEFT, Kind.CROSSING_RIGHT)


class Faulty:
    """The sound driver, which does not see those for whom `missed` holds."""

    def __init__(self, name, missed):
        self.name, self.missed = name, missed

    def act(self, seen):
        return SOUND.act(replace(seen, present=seen.present & ~self.missed(seen)))


def beside(seen):
    return seen.left - seen.offset[:, None]


FAULTS = {
    Kind.STANDING: Faulty("misses who stands", lambda s: torch.hypot(s.speed_along, s.speed_across) < 0.5),
    Kind.CROSSING_RIGHT: Faulty("misses who comes from the right", lambda s: (beside(s) < -0.5) | (s.speed_across > 2.0)),
    Kind.REAR: Faulty("misses who drives ahead", lambda s: (beside(s).abs() < 0.5) & (s.speed_along > 1.0)),
}


def scenes():
    """Each kind three times, everybody but the target a little later each time."""
    for kind in SHOWN:
        for later in range(3):
            own, other = SCENES[kind]
            moved = replace(other, position=other.position - np.float32(0.1 * later) * other.velocity)
            roads = CROSSING if kind in list(SCENES)[5:] else ROAD
            yield scenario(roads, stack([own, moved]), f"{kind} {later}")


def cases(driver):
    where = list(scenes())
    run = Batch().run(driver, where, [scene.log for scene in where])
    return [case_of(where[i], where[i].log, run, i, driver.name) for i in np.flatnonzero(run.counted)]


@pytest.mark.parametrize("kind", FAULTS)
def test_each_planted_fault_is_named_by_its_own_kind(kind):
    assert {kind_of(case) for case in cases(FAULTS[kind])[:10]} == {kind}


def test_the_sound_driver_has_no_case():
    assert cases(SOUND) == []
