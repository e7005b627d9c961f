"""Learning to drive: episodes, advantages, the discriminator's reward, and that the same seed gives the same weights."""

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.drivers._gail.discriminator import Discriminator, transitions
from drivegen.drivers.gail import Plugin
from drivegen.drivers.shared import ppo
from drivegen.drivers.shared.episodes import Episodes
from drivegen.drivers.shared.features import COUNT, features
from drivegen.drivers.shared.lessons import Lessons, write_grades
from drivegen.drivers.shared.network import FULL_BRAKING, FULL_THROTTLE, Settings, pedals, write_network
from drivegen.drivers.shared.policy import ACTIVATION, Policy, number_of
from drivegen.world.world import World
from stages._door import read_section
from tests.drivers.taught import PARAMS, straight_lessons, teaching
from tests.scenes import drive, scenario, stack, straight_road


def episodes(live: list[list[int]], crashed: list[bool]) -> Episodes:
    """Steps (T) by rows (R); what was seen and done is noise."""
    alive = torch.tensor(live, dtype=torch.bool)
    steps, rows = alive.shape
    torch.manual_seed(0)
    speed = torch.full((steps + 1, rows), 10.0)
    return Episodes(torch.randn(steps + 1, rows, COUNT), torch.randn(steps, rows), alive, torch.tensor(crashed), speed)


@given(st.integers(1, 6), st.integers(1, 6), st.booleans(), st.integers(0, 99))
@settings(max_examples=30)
def test_advantages_are_the_discounted_sum_of_what_was_not_foreseen(steps, lived, crashed, seed):
    lived = min(lived, steps)
    one = episodes([[int(t < lived)] for t in range(steps)], [crashed and lived < steps])
    random = np.random.default_rng(seed)
    reward, value = random.normal(size=(steps, 1)), random.normal(size=(steps + 1, 1))
    wanted = np.zeros(steps)
    for t in range(lived):
        for k in range(t, lived):
            over = k == lived - 1 and bool(one.crashed[0])
            after = 0.0 if over else 0.9 * value[k + 1, 0]
            wanted[t] += (0.9 * 0.8) ** (k - t) * (reward[k, 0] + after - value[k, 0])
    given_settings = ppo.Settings(1, 1, 1, 1e-3, 0.2, 0.9, 0.8)
    found = ppo.advantages(torch.from_numpy(reward), torch.from_numpy(value), one, given_settings)
    assert found[:, 0].numpy() == pytest.approx(wanted)


def test_a_collision_goes_on_in_the_absorbing_state_to_the_end():
    two = episodes([[1, 1], [1, 1], [1, 0], [1, 0]], [False, True])
    steps = transitions(two)
    assert len(steps) == 6 + 2
    assert steps[:, -1].tolist() == [0] * 6 + [1] * 2
    assert not steps[6:, :-1].any()


def test_who_crashes_is_paid_what_the_absorbing_steps_pay_and_nothing_else():
    two = episodes([[1, 1], [1, 1], [1, 0], [1, 0]], [False, True])
    judge = Discriminator(transitions(two)[:6], teaching("gail").discriminator)
    discount = 0.9
    reward = judge.reward(two, discount)
    alone = judge.reward(episodes([[1, 1], [1, 1], [1, 0], [1, 0]], [False, False]), discount)
    absorbing = torch.zeros(1, COUNT + 2)
    absorbing[0, -1] = 1.0
    each = 0.1 * float(torch.nn.functional.softplus(judge(absorbing)).detach())
    difference = reward - alone
    assert float(difference[1, 1].detach()) == pytest.approx(each * (discount + discount**2), rel=1e-4)
    assert not difference[torch.tensor([[1, 1], [1, 0], [1, 1], [1, 1]], dtype=torch.bool)].any()


def test_the_discriminator_tells_who_brakes_from_who_does_not():
    expert, other = (transitions(episodes([[1] * 40] * 10, [False] * 40)) for _ in range(2))
    expert[:, COUNT], other[:, COUNT] = 0.5, -0.5
    judge = Discriminator(expert, teaching("gail").discriminator)
    random = torch.Generator().manual_seed(1)
    shares = [judge.learn(other, random) for _ in range(4)]
    assert shares[-1] > 0.95


def test_numbers_stand_for_accelerations_and_back():
    numbers = torch.tensor([-2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 3.0])
    wanted = [-FULL_BRAKING, -FULL_BRAKING, -FULL_BRAKING / 2, 0.0, FULL_THROTTLE / 2, FULL_THROTTLE, FULL_THROTTLE]
    assert pedals(numbers.clamp(-1, 1)).tolist() == wanted
    assert number_of(pedals(numbers)).tolist() == numbers.clamp(-1, 1).tolist()


def test_a_demonstration_is_the_log_s_own_way():
    road = straight_road()
    log = stack([drive(road.centreline[0].astype(np.float64), 10, 6, 61, 0.8)])
    shown = Lessons.of([scenario(road, log)], [log]).demonstrations()
    driven = float(np.hypot(*(log.position[0, -1] - log.position[0, 0])))
    assert float(shown.distance[0]) == pytest.approx(driven, abs=0.2)
    assert bool(shown.live.all())


def test_a_replayed_vehicle_that_is_run_into_ends_the_episode_there():
    road = straight_road()
    line = road.centreline[0].astype(np.float64)
    log = stack([drive(line, 10, 10, 61), drive(line, 40, 0, 61)])
    lessons = Lessons.of([scenario(road, log)], [log])
    run = lessons.play(lambda _, seen, __: torch.zeros(len(seen)))
    assert bool(run.crashed[0])
    assert int(run.live.sum()) == 26  # 25.5 m at 10 m/s


def test_the_same_seed_gives_the_same_weights(tmp_path):
    lessons = straight_lessons(8)
    small = {**read_section("train_driver.drivers.gail.ppo", PARAMS), "rows": 8, "epochs": 1, "batch": 256}
    how = teaching("gail", iterations=1, clone_steps=5, ppo=small)
    for name in ("one", "two"):
        policy, grades = Plugin.teach(how, lessons, lessons, 3, lambda _: None)
        write_network(tmp_path / name, "gail", policy.linear, ACTIVATION, squashed=False)
        write_grades(tmp_path / f"{name}.csv", grades)
    for file in ("weights.safetensors", "settings.json"):
        assert (tmp_path / "one" / file).read_bytes() == (tmp_path / "two" / file).read_bytes()
    assert (tmp_path / "one.csv").read_text() == (tmp_path / "two.csv").read_text()
    assert [grade.step for grade in grades] == [0, 1]


def test_the_driver_does_what_its_policy_holds_for_best(tmp_path):
    lessons = straight_lessons(4)
    policy = Policy()
    write_network(tmp_path, "gail", policy.linear, ACTIVATION, squashed=False)
    world = World(lessons.scenes, 4, lookout=lessons.lookout)
    driver = Plugin(Settings(str(tmp_path), sees_rules=True))
    wanted = pedals(policy(features(world.observe())).clamp(-1, 1)).detach()
    torch.testing.assert_close(driver.act(world.observe()).acceleration, wanted)
