"""Every driver plugin, whatever it is, keeps the promises of `drivers/base.py`."""

import pickle
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest
import torch

from drivegen.core import plugins
from drivegen.simulators.batch import Plugin as Batch
from tests.drivers.taught import make
from tests.scenes import busy_crossing, drive, scenario, stack, straight_road

LINE = straight_road().centreline[0].astype(np.float64)


@pytest.fixture(scope="module", params=plugins.names("drivers"))
def driver(request, tmp_path_factory):
    return make(request.param, tmp_path_factory.mktemp(request.param))


def test_it_has_its_name_and_typed_settings_without_defaults(driver):
    assert plugins.load("drivers", driver.name) is type(driver)
    assert is_dataclass(driver.settings_type)
    assert all(f.default is f.default_factory for f in fields(driver.settings_type))


def test_it_drives_forward_on_a_free_road_and_does_not_hit_a_parked_car(driver):
    road = straight_road()
    free, blocked = stack([drive(LINE, 10, 8, 101)]), stack([drive(LINE, 10, 8, 101), drive(LINE, 70, 0, 101)])
    outcome = Batch().run(driver, [scenario(road, free), scenario(road, blocked)], [free, blocked])
    assert outcome.end[0, 0] > 60
    assert not outcome.collided.any()


def test_what_it_does_depends_on_its_own_row_only(driver):
    seen = []

    class Spy:
        name = "spy"
        sees_rules = True

        def act(self, observation):
            seen.append(observation)
            return driver.act(observation)

    scene = busy_crossing()
    Batch().run(Spy(), [scene, scene], [scene.log, scene.log])
    whole = seen[20]
    shuffled = torch.arange(len(whole.speed)).flip(0)

    def turn(part):
        return replace(
            part, **{f.name: getattr(part, f.name)[shuffled] for f in fields(part) if f.name not in ("paths", "rules")}
        )

    turned = replace(turn(whole), paths=turn(whole.paths), rules=turn(whole.rules))
    assert torch.equal(driver.act(turned).acceleration, driver.act(whole).acceleration[shuffled])


def test_it_travels_to_other_processes(driver):
    assert pickle.loads(pickle.dumps(driver)).name == driver.name
