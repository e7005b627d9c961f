"""How episodes end, and by which collision, is what the simulator says of whole runs."""

from dataclasses import replace

import gymnasium
import numpy as np
import pytest
import torch

import drivegen.gym
from drivegen.drivers.shared.environment import TERMS, Environment
from drivegen.simulators.batch import Plugin as Batch
from drivegen.world.observation import Action
from drivegen.world.outcome import CollisionKind
from tests.gym.pairs import (
    LINE,
    ROAD,
    SETTINGS,
    alone,
    behind_a_parked_car,
    hit_from_behind_at_once,
    met_at_once_by_who_appears,
)
from tests.scenes import across, busy_crossing, drive, noisy_samples, scenario, stack


class Held:
    """One acceleration for good."""

    name = "held"

    def __init__(self, acceleration):
        self.acceleration = acceleration

    def act(self, seen):
        return Action(self.acceleration + 0 * seen.speed)


def at_the_end(pair, motion="path"):
    """What an episode that holds its speed ends by: the number of the step, terminated, truncated, the reward and the infos."""
    env = gymnasium.make(drivegen.gym.ID, scenarios=[pair], settings=replace(SETTINGS, motion=motion))
    env.reset(seed=0)
    ended, cut, step = False, False, 0
    while not (ended or cut):
        _, reward, ended, cut, info = env.step(np.zeros(env.action_space.shape, np.float32))
        step += 1
    return step, ended, cut, reward, info


def test_episodes_end_by_a_crash_or_at_the_end_of_the_scenario_or_of_the_map():
    for pair, terminated, kind, steps in (
        (behind_a_parked_car(), True, CollisionKind.FRONT, 26),
        (alone(steps=51), False, CollisionKind.NONE, 50),
        (alone(start=265, steps=51), False, CollisionKind.NONE, None),
    ):
        step, ended, cut, _, info = at_the_end(pair)
        assert (ended, cut) == (terminated, not terminated)
        assert info["collision"] == kind
        assert steps is None or step == pytest.approx(steps, abs=1)
        assert info["left_map"] == (steps is None and kind == CollisionKind.NONE)


def test_collisions_in_the_first_step_of_an_episode_are_of_their_kind_whatever_was_before():
    episodes = Environment([alone(), hit_from_behind_at_once(), met_at_once_by_who_appears()], 2, SETTINGS)
    rows = torch.tensor([1])
    for scene, kind in ((1, CollisionKind.HIT_FROM_BEHIND), (2, CollisionKind.AT_SPAWN)):
        for _ in range(3):
            episodes.reset(torch.tensor([0, 0]))
            episodes.step(torch.zeros(2, 1))
            episodes.reset(torch.tensor([scene]), rows)
            made = episodes.step(torch.zeros(2, 1))
            assert made.kind.tolist() == [CollisionKind.NONE, kind]
            assert float(made.terms[1, TERMS.index("hit")]) == SETTINGS.rewards.hit
            assert float(made.terms[1, TERMS.index("collision")]) == 0


def test_a_crash_in_the_last_step_ends_an_episode_and_one_beyond_the_exit_is_none():
    scene, log = behind_a_parked_car()
    hit = int(Batch().run(Held(0.0), [scene], [log]).step[0])
    beyond = stack([drive(LINE, 265, 10, 101), drive(across(301), 120, 0, 101)])  # met in the step in which the target leaves
    for pair, expected in (
        ((scene, log.until(hit + 1)), (hit, True, False, False)),
        ((scenario(ROAD, beyond), beyond), (33, False, True, True)),
    ):
        step, ended, truncated, _, info = at_the_end(pair)
        assert (step, ended, truncated, info["left_map"]) == expected
        outcome = Batch().run(Held(0.0), *zip(pair, strict=True))
        assert (outcome.collided[0], outcome.left_map[0]) == (ended, truncated)


def test_who_leaves_by_an_exit_is_not_off_the_road_however_it_moves():
    for motion in ("path", "free"):
        for start, speed in ((265, 8.0), (265, 10.0), (265, 12.0), (265, 13.9), (264.5, 5.0), (264.5, 12.0)):
            pair = alone(start, speed, steps=101)
            _, ended, cut, reward, info = at_the_end(pair, motion)
            assert (ended, cut, info["left_map"], info["off_road"]) == (False, True, True, False)
            assert reward > 0


@pytest.mark.parametrize("acceleration", [-1.0, 0.0, 1.5])
@pytest.mark.parametrize("neighbours", ["replayed", "reactive"])
def test_episodes_end_where_whole_runs_of_the_simulator_do(acceleration, neighbours):
    """Step by step and after the run: two ways to the first collision and its kind."""
    pairs = [(busy_crossing(), busy_crossing().log), alone(steps=101), *map(behind_a_parked_car, (15.0, 30.0, 60.0, 90.0))]
    log = stack([drive(LINE, 10, 10, 101), drive(LINE, 27, 2, 101)])
    log.valid[1, :20], log.position[1, :20] = False, 0.0  # somebody who appears in the target's way
    pairs += [(scenario(ROAD, log), log)]
    pairs += [hit_from_behind_at_once(), met_at_once_by_who_appears()]
    pairs += [(busy_crossing(), noisy_samples(busy_crossing(), 4, seed=3).motion[k]) for k in range(4)]
    episodes = Environment(pairs, len(pairs), replace(SETTINGS, neighbours=neighbours))
    batch = Batch(reaction=SETTINGS.reaction if neighbours == "reactive" else None)
    outcome = batch.run(Held(acceleration), *zip(*pairs, strict=True))
    episodes.reset(torch.arange(len(pairs)))
    action = torch.full((len(pairs), 1), acceleration / (3.0 if acceleration > 0 else 8.0))
    step, kind = np.full(len(pairs), -1), np.zeros(len(pairs), int)
    for t in range(1, 101):
        made = episodes.step(action)
        first = (made.kind.numpy() > 0) & (step < 0)
        step[first], kind[first] = t, made.kind.numpy()[first]
    hit = outcome.step > 0
    assert hit.sum() > 1
    assert step[hit].tolist() == outcome.step[hit].tolist()
    assert kind[hit].tolist() == outcome.kind[hit].tolist()
    assert (step[~hit & ~outcome.left_map & (outcome.step < 0)] < 0).all()
