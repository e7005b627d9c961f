"""Whom targets touch is the same box by box and by tensors, here and on a GPU, and who hit whom is told for many at once."""

import numpy as np
import pytest
import torch

from drivegen.core.settings import read_params
from drivegen.drivers.shared.conditions import Settings
from drivegen.drivers.shared.environment import Environment
from drivegen.world.contact import kinds_of
from drivegen.world.ego import Ego
from drivegen.world.outcome import CollisionKind
from drivegen.world.scenes import Scenes
from drivegen.world.touch import all_at_once, touched
from drivegen.world.world import World
from tests.scenes import busy_crossing, crossing, drive, joined, scenario, stack

ROADS = crossing(arm=60.0)


def in_a_crowd(count=8, cars=60):
    """Worlds of `count` rows in which the targets overlap nobody, one, or several of the others."""
    random, line = np.random.default_rng(0), joined(ROADS, 0, 4)
    crowd = stack([drive(line, start, 5.0, 11) for start in random.uniform(0.0, 40.0, cars)])
    crowd.position[1:] += random.normal(0.0, 12.0, (cars - 1, 1, 2)).astype(np.float32)
    crowd.heading[1:] += random.uniform(-3.0, 3.0, (cars - 1, 1)).astype(np.float32)
    crowd.valid[1:] &= random.random((cars - 1, 11)) < 0.8
    return World(Scenes.of([scenario(ROADS, crowd)] * count, [crowd] * count), count)


def test_all_at_once_finds_whom_box_by_box_finds():
    world, found = in_a_crowd(), []
    random = np.random.default_rng(1)
    for step in range(10):
        world.step[:] = step
        ego = world.ego
        moved = torch.from_numpy(random.normal(0.0, 15.0, (len(world.scene), 2)).astype(np.float32))
        turned = torch.from_numpy(random.uniform(-3.0, 3.0, len(world.scene)).astype(np.float32))
        world.ego = Ego(ego.along, ego.offset, ego.course, ego.speed, ego.position + moved, turned, ego.wheel)
        boxes = world.neighbours.boxes(world)
        assert torch.equal(touched(world, boxes), all_at_once(world, boxes))
        found += touched(world, boxes).tolist()
    assert {-1} < set(found)
    assert len(set(found)) > 5


def test_who_appears_inside_the_target_is_at_spawn_for_the_environment_too():
    line = joined(ROADS, 0, 4)
    log = stack([drive(line, 10.0, 0.0, 60), drive(line, 12.0, 0.0, 60)])
    log.valid[1, :20] = False
    episodes = Environment([(scenario(ROADS, log), log)], 1, read_params("environment", Settings))
    episodes.reset(torch.zeros(1, dtype=torch.int64))
    kinds = [int(episodes.step(torch.tensor([[-1.0]])).kind[0]) for _ in range(20)]
    assert kinds == [CollisionKind.NONE] * 19 + [CollisionKind.AT_SPAWN]


def test_each_of_many_collisions_is_told_by_itself():
    """A target at (0, 0) facing along x, who is met from ahead, from behind and from its left, and one that stands."""
    own = [(np.zeros((4, 2)), np.zeros(4))] * 2
    before = np.array([[5.2, 0.0], [-5.2, 0.0], [0.0, 4.0], [5.2, 0.0]])
    after = np.array([[4.8, 0.0], [-4.8, 0.0], [0.0, 3.2], [4.8, 0.0]])
    heading = np.array([np.pi, 0.0, -np.pi / 2, np.pi])
    sizes = np.tile([5.0, 2.0], (4, 1))
    kinds = kinds_of(own, [(before, heading), (after, heading)], (sizes, sizes), np.array([5.0, 5.0, 5.0, 0.0]))
    expected = [CollisionKind.FRONT, CollisionKind.HIT_FROM_BEHIND, CollisionKind.HIT_IN_SIDE, CollisionKind.HIT_STANDING]
    assert kinds.tolist() == expected


@pytest.mark.skipif(not torch.cuda.is_available(), reason="no GPU here")
def test_environments_on_a_gpu_are_those_of_the_processor():
    line = joined(ROADS, 0, 4)
    log = stack([drive(line, 5, 8, 61), drive(line, 25, 0, 61)])
    scenes = [busy_crossing(61, "a"), busy_crossing(61, "b"), scenario(ROADS, log, "behind-one-that-stands")]
    traffic, settings = [(scene, scene.log) for scene in scenes], read_params("environment", Settings)
    here, there = (Environment(traffic, 12, settings, device) for device in ("cpu", "cuda"))
    random = torch.Generator().manual_seed(0)
    ended = False
    for _ in range(60):
        action = torch.rand((12, 1), generator=random) * 2 - 1
        ours, theirs = here.step(action), there.step(action.cuda())
        np.testing.assert_allclose(theirs.observation.cpu(), ours.observation, atol=1e-3)
        np.testing.assert_allclose(theirs.reward.cpu(), ours.reward, atol=1e-3)
        for name in ("terminated", "truncated", "kind"):
            assert torch.equal(getattr(theirs, name).cpu(), getattr(ours, name))
        ended |= bool(ours.terminated.any())
    assert ended
