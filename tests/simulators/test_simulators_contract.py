"""Every simulator plugin keeps the promises of `simulators/base.py`, and agrees with the others on car-following."""

import numpy as np
import pytest

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import Trajectories
from drivegen.drivers import idm
from drivegen.world.outcome import NO_PARTNER, CollisionKind
from drivegen.world.paths import target_paths
from tests.checking import IDM
from tests.scenes import busy_crossing, drive, road_map, scenario, stack, straight_road

NAMES = plugins.names("simulators")
DRIVER = idm.Plugin(IDM)
ROAD = straight_road(900)
LINE = ROAD.centreline[0].astype(np.float64)
ANGLES = np.linspace(0, 2.5, 120)
BEND = road_map([np.stack([120 * np.sin(ANGLES), 120 * (1 - np.cos(ANGLES))], axis=1)])


def following(roads, seed):
    """A target behind one or two leaders that keep their distance from one another: the only conflict is ahead."""
    random = np.random.default_rng(seed)
    line = roads.centreline[0].astype(np.float64)
    speed, pull = random.uniform(4, 12), random.choice([-1.0, 0.0, 0.4])
    gap, spacing = random.uniform(12, 40), random.uniform(10, 25)
    leaders = [drive(line, 25 + gap + spacing * n, speed, 101, pull) for n in range(int(random.integers(1, 3)))]
    return scenario(roads, stack([drive(line, 25, random.uniform(4, 13), 101), *leaders]), f"following-{seed}")


FOLLOWING = [following(roads, seed) for seed in range(12) for roads in (ROAD, BEND)]


@pytest.fixture(scope="module")
def outcomes():
    logs = [scene.log for scene in FOLLOWING]
    paths = target_paths(FOLLOWING, logs)
    return {name: plugins.load("simulators", name)().run(DRIVER, FOLLOWING, logs, paths) for name in NAMES}


@pytest.mark.parametrize("name", NAMES)
def test_targets_start_as_logged_drive_forward_and_nobody_is_lost(name, outcomes):
    outcome = outcomes[name]
    motion = outcome.motion
    motion.validate()
    assert motion.valid.shape == (len(FOLLOWING), 101)
    assert (motion.valid.all(axis=1) | outcome.collided).all()
    start = np.stack([scene.log.position[0, 0] for scene in FOLLOWING])
    assert np.allclose(motion.position[:, 0], start, atol=1e-4)
    assert np.allclose(motion.speed[:, 0], [scene.log.speed[0, 0] for scene in FOLLOWING], atol=1e-3)
    moved = np.hypot(*np.moveaxis(np.diff(motion.position, axis=1), -1, 0))
    assert np.allclose(moved[:, 1:], motion.speed[:, 2:] * 0.1, atol=0.05)


@pytest.mark.parametrize("name", NAMES)
def test_idm_does_not_run_into_a_leader_that_drives_sensibly(name, outcomes):
    assert not outcomes[name].collided.any()
    assert (outcomes[name].partner == NO_PARTNER).all()
    assert (outcomes[name].step == -1).all()


@pytest.mark.parametrize("name", [name for name in NAMES if name != "batch"])
def test_in_car_following_end_positions_agree_with_the_batch_simulator(name, outcomes):
    gap = np.hypot(*(outcomes[name].end - outcomes["batch"].end).T)
    assert np.median(gap) < 1.0
    assert np.quantile(gap, 0.95) < 3.0
    driven = np.hypot(*(outcomes["batch"].end - outcomes["batch"].motion.position[:, 0]).T)
    assert np.median(driven) > 40


@pytest.mark.parametrize("name", NAMES)
def test_each_scenario_is_driven_alone(name):
    """Neither the company nor its length changes a result."""
    simulator = plugins.load("simulators", name)()
    short = scenario(ROAD, FOLLOWING[0].log.until(60), "short")
    scenes = [FOLLOWING[2], short, busy_crossing()]
    together = simulator.run(DRIVER, scenes, [scene.log for scene in scenes])
    for i, scene in enumerate(scenes):
        alone = simulator.run(DRIVER, [scene], [scene.log])
        steps = scene.steps
        assert np.array_equal(alone.motion.position[0, :steps], together.motion.position[i, :steps])
        assert not together.motion.valid[i, steps:].any()


@pytest.mark.parametrize("name", NAMES)
def test_who_appears_later_and_who_vanishes_is_met_while_there(name):
    ahead = drive(LINE, 80, 0, 101)
    late = Trajectories(ahead.position, ahead.heading, ahead.velocity, np.arange(101) >= 30)
    early = Trajectories(ahead.position, ahead.heading, ahead.velocity, np.arange(101) < 20)
    scenes = [scenario(ROAD, stack([drive(LINE, 20, 10, 101), other])) for other in (ahead, late, early)]
    end = plugins.load("simulators", name)().run(DRIVER, scenes, [scene.log for scene in scenes]).end[:, 0]
    assert end[0] < 76
    assert end[1] == pytest.approx(end[0], abs=2.0)
    assert end[2] > 100


@pytest.mark.parametrize("name", NAMES)
def test_collisions_are_found_by_boxes_whoever_simulates(name):
    """A car that cuts across 12 m ahead at a right angle can't be avoided by a driver that sees no crossing traffic."""
    across = np.stack([np.full(40, 45.0), np.linspace(-60, 60, 40)], axis=1)
    scene = scenario(ROAD, stack([drive(LINE, 10, 12, 101), drive(across, 29, 11, 101)]))
    outcome = plugins.load("simulators", name)().run(DRIVER, [scene], [scene.log])
    assert outcome.collided[0]
    assert outcome.partner[0] == 1
    assert outcome.kind[0] in (CollisionKind.FRONT, CollisionKind.HIT_IN_SIDE)
    assert outcome.motion.valid[0].sum() == outcome.step[0] + 1


@pytest.mark.parametrize("name", NAMES)
def test_a_target_that_is_not_there_is_refused(name):
    log = stack([drive(LINE, 10, 10, 101)])
    log.valid[0, 0] = False
    with pytest.raises(UnusableInput, match="not there at step 0"):
        plugins.load("simulators", name)().run(DRIVER, [scenario(ROAD, log)], [log])


def test_sumo_refuses_a_driver_that_it_cannot_play():
    class Own:
        name = "own"

        def act(self, observation):
            raise AssertionError

    with pytest.raises(UnusableInput, match="no model of the driver own"):
        plugins.load("simulators", "sumo")().run(Own(), FOLLOWING[:1], [FOLLOWING[0].log])


@pytest.mark.parametrize("name", NAMES)
def test_a_target_that_leaves_the_map_has_finished_its_run(name):
    logs = [stack([drive(LINE, 850, 10, 101), drive(LINE, 880, 0, 101)]), stack([drive(LINE, 850, 10, 101)])]
    scenes = [scenario(straight_road(900, whole=whole), log) for log in logs for whole in (False, True)]
    outcome = plugins.load("simulators", name)().run(DRIVER, scenes, [log for log in logs for _ in range(2)])
    assert outcome.left_map.tolist() == [False, False, False, True]
    assert not outcome.collided[3]
    seen = outcome.motion.valid[3]
    assert 40 < seen.sum() < 60
    assert not seen[seen.sum() :].any()
    assert outcome.motion.position[3, seen.sum() - 1, 0] + 2.3 < 900
    assert outcome.motion.valid[2].all()
