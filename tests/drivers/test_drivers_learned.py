"""Learning to drive: episodes, advantages, the discriminator's reward, and that the same seed gives the same weights."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.roadmap import LaneControl
from drivegen.core.signals import Signals, SignalState
from drivegen.drivers._gail.discriminator import Discriminator, transitions
from drivegen.drivers.gail import Plugin
from drivegen.drivers.shared import ppo
from drivegen.drivers.shared.episodes import Episodes
from drivegen.drivers.shared.features import COUNT, features
from drivegen.drivers.shared.lessons import Lessons, graded
from drivegen.drivers.shared.network import FULL_BRAKING, FULL_THROTTLE, Settings, pedals
from drivegen.drivers.shared.policy import Policy, number_of
from drivegen.drivers.shared.teaching import teach
from drivegen.world.observation import Rules
from drivegen.world.scenes import Scenes
from drivegen.world.world import World
from tests.drivers.taught import PARAMS, quick, straight_lessons, teaching
from tests.scenes import crossing, drive, joined, scenario, stack, straight_road

GAP = 6
"""The place of `gap` among the features; `closing` follows."""


def episodes(live: list[list[int]], crashed: list[bool], ran_red: list[bool] | None = None) -> Episodes:
    """Steps (T) by rows (R); what was seen and done is noise."""
    alive = torch.tensor(live, dtype=torch.bool)
    steps, rows = alive.shape
    torch.manual_seed(0)
    speed = torch.full((steps + 1, rows), 10.0)
    return Episodes(
        torch.randn(steps + 1, rows, COUNT),
        torch.randn(steps, rows),
        alive,
        torch.full((rows,), steps),
        speed,
        torch.tensor(crashed),
        torch.tensor(ran_red or [False] * rows),
    )


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


@pytest.mark.parametrize("fault", ["crashed", "ran_red"])
def test_a_fault_goes_on_in_the_absorbing_state_to_the_end(fault):
    two = episodes([[1, 1], [1, 1], [1, 0], [1, 0]], **{"crashed": [False] * 2, fault: [False, True]})
    steps = transitions(two)
    assert len(steps) == 6 + 2
    assert steps[:, -1].tolist() == [0] * 6 + [1] * 2
    assert not steps[6:, :-1].any()
    shorter = transitions(replace(two, lasts=torch.tensor([4, 3])))
    assert shorter[:, -1].tolist() == [0] * 6 + [1]


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
    shown = Lessons.of([(scenario(road, log), log)]).demonstrations()
    driven = float(np.hypot(*(log.position[0, -1] - log.position[0, 0])))
    assert float(shown.distance[0]) == pytest.approx(driven, abs=0.2)
    assert bool(shown.live.all())


def test_a_demonstration_ends_with_its_target_and_goes_on_over_a_gap():
    road = straight_road()
    log = stack([drive(road.centreline[0].astype(np.float64), 10, 10, 61)])
    log.valid[0, 20:25], log.valid[0, 50:] = False, False
    shown = Lessons.of([(scenario(road, log), log)]).demonstrations()
    assert int(shown.live.sum()) == 49
    assert float(shown.number[:49].abs().max()) < 0.01
    assert not bool(shown.failed[0])


def test_who_stands_with_the_brake_pressed_does_not_accelerate():
    road = straight_road()
    log = stack([drive(road.centreline[0].astype(np.float64), 10, 0, 61)])
    lessons = Lessons.of([(scenario(road, log), log)])
    policy = Policy()
    torch.nn.init.constant_(policy.layers[-1].bias, -9.0)
    assert graded(1, policy, lessons, lessons.demonstrations()).acceleration == 0.0


def test_a_replayed_vehicle_that_is_run_into_ends_the_episode_there():
    road = straight_road()
    line = road.centreline[0].astype(np.float64)
    log = stack([drive(line, 10, 10, 61), drive(line, 40, 0, 61)])
    lessons = Lessons.of([(scenario(road, log), log)])
    run = lessons.play(lambda _, seen, __: torch.zeros(len(seen)))
    assert bool(run.crashed[0])
    assert int(run.live.sum()) == 26  # 25.5 m at 10 m/s


def test_a_red_light_that_is_run_ends_the_episode_there():
    road = crossing(control=LaneControl.SIGNAL)
    log = stack([drive(joined(road, 0, 8, 3), 30, 10, 61)])  # from the west straight on; its line is at x = -10
    red = Signals(np.array([8], np.int32), np.full((1, 61), SignalState.RED, np.uint8))
    lessons = Lessons.of([(scenario(road, log, signals=red), log)])
    run = lessons.play(lambda _, seen, __: torch.zeros(len(seen)))
    assert (bool(run.ran_red[0]), bool(run.crashed[0]), bool(run.failed[0])) == (True, False, True)
    begins = float(log.position[0, 0, 0]) + 2.3
    assert int(run.live.sum()) == pytest.approx((-10 - begins) / 1.0, abs=1)
    waits = lessons.play(lambda _, seen, __: torch.full((len(seen),), -1.0))
    assert not bool(waits.failed[0])
    assert bool(waits.live.all())


@pytest.mark.parametrize(
    ("signal", "distance", "gap", "closing"),
    [
        (SignalState.RED, 20.0, 19.0, 10.0),  # it halts 1 m before the line
        (SignalState.RED, 0.5, 0.0, 10.0),
        (SignalState.RED, 50.0, 35.0, 10.0),  # somebody stands before the line
        (SignalState.RED, -1.0, 35.0, 10.0),  # the line is behind
        (SignalState.YELLOW, 20.0, 19.0, 10.0),
        (SignalState.YELLOW, 10.0, 35.0, 10.0),  # too late to halt in comfort
        (SignalState.GREEN, 20.0, 35.0, 10.0),
    ],
)
def test_a_line_where_one_has_to_halt_is_seen_as_somebody_who_stands_there(signal, distance, gap, closing):
    line = straight_road().centreline[0].astype(np.float64)
    log = stack([drive(line, 10, 10, 11), drive(line, 10 + 35 + 4.6, 0, 11)])
    scenes = Scenes.of([scenario(straight_road(), log)], [log])
    view = World(scenes, 1).observe()
    ahead = Rules(
        torch.tensor([distance]), torch.tensor([int(signal)]), torch.tensor([int(LaneControl.SIGNAL)]), torch.tensor([False]),
        torch.full((1, view.ahead.shape[1]), torch.inf),
    )  # fmt: skip
    seen = features(replace(view, rules=ahead))[0]
    assert (float(seen[GAP]) * 30, float(seen[GAP + 1]) * 15) == pytest.approx((gap, closing), abs=0.2)


@pytest.fixture(scope="module")
def lessons():
    return straight_lessons(8)


def taught(name, lessons, folder, checkpoint=None, rounds=2, seed=3):
    """Bytes of the weights, and the grades, of a teaching of `rounds`."""
    how = replace(quick(name), **{"gail": {"clone_steps": 20}, "sac": {"rows": 4, "updates": 1, "batch": 32}}[name])
    pupil = plugins.load("drivers", name).pupil(how, lessons, seed)
    policy, grades = teach(pupil, replace(how.course, rounds=rounds), lessons, seed, checkpoint, lambda _: None)
    policy.write(folder, name)
    return (folder / "weights.safetensors").read_bytes(), grades


@pytest.mark.parametrize("name", ["gail", "sac"])
def test_the_same_seed_gives_the_same_weights_and_so_does_a_training_that_was_interrupted(name, lessons, tmp_path):
    checkpoint = tmp_path / "checkpoint.safetensors"
    taught(name, lessons, tmp_path / "begun", checkpoint, rounds=1)
    torch.rand(3), np.random.rand(3)  # noqa: NPY002 another process has other global generators
    resumed = taught(name, lessons, tmp_path / "resumed", checkpoint)
    assert resumed == taught(name, lessons, tmp_path / "whole")
    assert resumed != taught(name, lessons, tmp_path / "other", seed=4)
    assert [grade.round for grade in resumed[1]] == [0, 1, 2]


@pytest.mark.parametrize("name", ["gail", "sac"])
def test_a_checkpoint_that_is_damaged_or_another_driver_s_is_refused(name, lessons, tmp_path):
    path = tmp_path / "checkpoint.safetensors"
    taught({"gail": "sac", "sac": "gail"}[name], lessons, tmp_path / "other", path, rounds=1)
    with pytest.raises(UnusableInput, match="does not fit this training"):
        taught(name, lessons, tmp_path / "own", path)


def test_who_drives_needs_no_stable_baselines():
    code = "import sys, drivegen.drivers.sac; print('stable_baselines3' in sys.modules, 'gymnasium' in sys.modules)"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=PARAMS.parent).stdout
    assert said.split() == ["False", "False"]


def test_the_driver_does_what_its_policy_holds_for_best(lessons, tmp_path):
    policy = Policy()
    policy.write(tmp_path, "gail")
    world = World(lessons.scenes, 8, lookout=lessons.lookout)
    driver = Plugin(Settings(str(tmp_path), sees_rules=True))
    wanted = pedals(policy(features(world.observe())).clamp(-1, 1)).detach()
    torch.testing.assert_close(driver.act(world.observe()).acceleration, wanted)


def test_weights_that_learned_from_other_features_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("drivegen.drivers.shared.network.VERSION", 1)
    Policy().write(tmp_path, "gail")
    monkeypatch.undo()
    with pytest.raises(UnusableInput, match="learned from features of version 1, not 2: train them anew"):
        Plugin(Settings(str(tmp_path), sees_rules=True))
