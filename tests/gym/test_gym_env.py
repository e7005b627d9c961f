"""The environments pass their libraries' own checks, end where they should and agree with one another."""

from dataclasses import replace

import gymnasium
import numpy as np
import pytest
import stable_baselines3.common.env_checker as sb3_checker
import torch
from gymnasium.utils.env_checker import check_env

import drivegen.gym
from drivegen.core.errors import UnusableInput
from drivegen.core.signals import Signals, SignalState
from drivegen.drivers.shared.environment import TERMS, Environment
from drivegen.drivers.shared.features import COUNT
from drivegen.gym.env import DriveEnv
from drivegen.gym.picture import present
from drivegen.gym.sb3 import DriveVecEnv
from drivegen.gym.vector import DriveVectorEnv
from drivegen.store.scenarios import write_shard
from tests.gym.pairs import (
    LINE,
    ROAD,
    SETTINGS,
    alone,
    behind_a_parked_car,
)
from tests.scenes import busy_crossing, crossing, drive, joined, scenario, stack


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    root = tmp_path_factory.mktemp("gym")
    scenes = [busy_crossing(61, f"scene-{letter}") for letter in "abc"]
    write_shard(root / "scenarios" / "shard-00000.parquet", scenes)
    return root


@pytest.mark.parametrize("motion", ["path", "path_offset", "free"])
def test_it_passes_the_checks_of_gymnasium_and_stable_baselines(folder, motion):
    settings = replace(SETTINGS, motion=motion)
    env = gymnasium.make(drivegen.gym.ID, scenarios=folder / "scenarios", settings=settings, render_mode="rgb_array")
    check_env(env.unwrapped)
    sb3_checker.check_env(env.unwrapped)
    env.reset(seed=0)
    assert env.render().shape == (512, 512, 3)


def test_the_name_and_the_project_s_params_are_enough(folder):
    env = gymnasium.make("DriveGen/Drive-v0", scenarios=str(folder / "scenarios"))
    seen, info = env.reset(seed=3, options={"scenario": 1})
    assert seen.shape == (COUNT,)
    assert info["scenario"] == "scene-b"
    vector = gymnasium.make_vec("DriveGen/Drive-v0", num_envs=4, scenarios=str(folder / "scenarios"))
    assert vector.reset(seed=3)[0].shape == (4, COUNT)


def test_the_reward_is_the_sum_of_its_terms_and_each_can_be_computed_by_hand():
    env = gymnasium.make(drivegen.gym.ID, scenarios=[alone()], settings=SETTINGS)
    env.reset(seed=0)
    _, reward, _, _, info = env.step(np.array([-0.5], np.float32))
    assert info["reward/progress"] == pytest.approx(0.1 * (10 - 0.4) * 0.1, rel=1e-4)
    assert info["reward/comfort"] == pytest.approx(-0.005 * (4 / 3) ** 2, rel=1e-4)
    assert reward == pytest.approx(sum(info[f"reward/{name}"] for name in TERMS), rel=1e-5)
    env = gymnasium.make(drivegen.gym.ID, scenarios=[alone(speed=17.9)], settings=SETTINGS)
    env.reset(seed=0)
    assert env.step(np.zeros(1, np.float32))[4]["reward/speeding"] == pytest.approx(-0.03 * 4.0, rel=1e-4)


def test_a_red_line_that_is_crossed_is_paid_for_once():
    roads = crossing()
    log = stack([drive(joined(roads, 0, 8, 4), 60, 10, 61)])
    red = Signals(np.array([8], np.int32), np.full((1, 61), SignalState.RED, np.uint8))
    env = gymnasium.make(drivegen.gym.ID, scenarios=[(scenario(roads, log, signals=red), log)], settings=SETTINGS)
    env.reset(seed=0)
    paid = [env.step(np.zeros(1, np.float32))[4]["reward/red"] for _ in range(40)]
    assert sum(paid) == SETTINGS.rewards.red
    assert 15 < int(np.argmin(paid)) < 22  # the front reaches the line after 17.7 m


def test_a_red_line_that_is_crossed_in_the_first_step_is_paid_for_as_well():
    roads = crossing()
    log = stack([drive(joined(roads, 0, 8, 4), 77.2, 10, 61)])
    red = Signals(np.array([8], np.int32), np.full((1, 61), SignalState.RED, np.uint8))
    env = gymnasium.make(drivegen.gym.ID, scenarios=[(scenario(roads, log, signals=red), log)], settings=SETTINGS)
    for _ in range(2):
        env.reset(seed=0)
        assert env.step(np.zeros(1, np.float32))[4]["reward/red"] == SETTINGS.rewards.red


def test_rows_are_reset_in_the_step_in_which_they_end_and_the_last_observation_is_kept():
    pairs = [behind_a_parked_car(20.0), alone(steps=21)]
    vector = gymnasium.make_vec(drivegen.gym.ID, num_envs=8, scenarios=pairs, settings=SETTINGS)
    first, _ = vector.reset(seed=1)
    for _ in range(30):
        seen, _, terminated, truncated, info = vector.step(np.zeros((8, 1), np.float32))
        ended = terminated | truncated
        assert ("final_obs" in info) == ended.any()
        for r in np.flatnonzero(ended):
            assert any(np.array_equal(seen[r], begin) for begin in first)
            assert not np.array_equal(info["final_obs"][r], seen[r]) or not info["collision"][r]


def test_the_horizon_does_not_look_like_a_crash_to_stable_baselines():
    env = DriveVecEnv([behind_a_parked_car(20.0), alone(steps=21)], 6, SETTINGS)
    env.seed(2)
    env.reset()
    ends = set()
    for _ in range(40):
        _, _, dones, infos = env.step(np.zeros((6, 1), np.float32))
        for done, info in zip(dones, infos, strict=True):
            assert done == ("terminal_observation" in info)
            if done:
                ends.add((info["collision"] > 0, info["TimeLimit.truncated"]))
    assert ends == {(True, False), (False, True)}


@pytest.mark.parametrize("neighbours", ["replayed", "reactive"])
def test_one_row_and_many_tell_the_same_story_and_the_same_seed_does(neighbours):
    settings = replace(SETTINGS, neighbours=neighbours)
    base = busy_crossing(61)
    actions = np.random.default_rng(0).uniform(-0.5, 0.5, (40, 1)).astype(np.float32)
    one = gymnasium.make(drivegen.gym.ID, scenarios=[(base, base.log)], settings=settings)
    many = gymnasium.make_vec(drivegen.gym.ID, num_envs=3, scenarios=[(base, base.log)], settings=settings)
    again = gymnasium.make_vec(drivegen.gym.ID, num_envs=3, scenarios=[(base, base.log)], settings=settings)
    alone, whole, other = one.reset(seed=0)[0], many.reset(seed=0)[0], again.reset(seed=0)[0]
    for action in actions:
        np.testing.assert_allclose(whole, np.tile(alone, (3, 1)), atol=1e-5)
        assert np.array_equal(whole, other)
        alone, _, ended, cut, _ = one.step(action)
        whole, other = (env.step(np.tile(action, (3, 1)))[0] for env in (many, again))
        if ended or cut:
            break


def test_a_free_target_follows_its_wheels_within_limits_and_ends_off_the_road():
    settings = replace(SETTINGS, motion="free")
    log = stack([drive(LINE, 50, 10, 101)])
    episodes = Environment([(scenario(ROAD, log), log)], 1, settings)
    for _ in range(20):
        episodes.step(torch.zeros(1, 2))
    assert float(episodes.world.ego.position[0, 0]) == pytest.approx(70.0, abs=0.1)
    assert float(episodes.world.ego.offset[0]) == pytest.approx(0.0, abs=0.05)
    steps = [episodes.step(torch.tensor([[0.0, 1.0]])) for _ in range(25)]
    ends = [bool(step.off_road) for step in steps]
    assert any(ends)
    assert bool(steps[ends.index(True)].terminated)
    assert float(steps[ends.index(True)].terms[0, TERMS.index("off_road")]) == SETTINGS.rewards.off_road


@pytest.mark.parametrize("motion", ["path", "path_offset", "free"])
def test_what_is_no_action_is_refused_before_anybody_has_moved(motion):
    pair = behind_a_parked_car()
    episodes = Environment([pair, pair], 2, replace(SETTINGS, motion=motion))
    numbers = episodes.actions.shape[0]
    bad = torch.zeros(2, numbers)
    bad[1, -1] = torch.nan
    with pytest.raises(UnusableInput, match=r"the action of row 1 is .*nan"):
        episodes.step(bad)
    for shape in ((2, numbers + 1), (1, numbers), (2,)):
        with pytest.raises(UnusableInput, match=r"have the shape \(2, "):
            episodes.step(torch.zeros(shape))
    assert not episodes.world.step.any()
    assert float(episodes.step(torch.zeros(2, numbers)).terms[0, 0]) == pytest.approx(0.1, rel=1e-3)


@pytest.mark.parametrize("kind", [DriveVectorEnv, DriveVecEnv])
@pytest.mark.parametrize("rows", [0, -1, 1.5, "a", None])
def test_what_is_no_number_of_rows_is_refused(kind, rows):
    with pytest.raises(UnusableInput, match="give a whole number from 1 on"):
        kind([alone()], rows, SETTINGS)


def test_scenarios_without_motion_are_refused():
    with pytest.raises(UnusableInput, match="are pairs of a scenario and motion of its vehicles, or a folder"):
        DriveVectorEnv([alone()[0]], 1, SETTINGS)
    with pytest.raises(UnusableInput, match="needs at least one scenario"):
        DriveVectorEnv([], 1, SETTINGS)


def test_actions_of_another_shape_are_refused_and_not_rearranged():
    pairs, settings = [alone()], replace(SETTINGS, motion="path_offset")
    vector, adapter = DriveVectorEnv(pairs, 3, settings), DriveVecEnv(pairs, 3, settings)
    for env in (vector, adapter):
        env.reset()
        for shape in ((2, 3), (6,), (3,), (1, 3, 2), ()):
            with pytest.raises(UnusableInput, match=r"have the shape \(3, 2\), not"):
                env.step(np.zeros(shape, np.float32))
    one_number = DriveVectorEnv(pairs, 3, SETTINGS)
    assert one_number.step(np.zeros(3, np.float32))[1].shape == (3,)


@pytest.mark.parametrize(
    ("number", "why"),
    [
        *((number, "the playable scenarios have the numbers 0 to 0, give one") for number in (-1, 1, "alone", None, 0.5, False)),
        ([0, 0, 0], r"give one number, or a list of \d, one for each environment"),
    ],
)
def test_a_scenario_that_is_not_there_is_named(number, why):
    for env in (DriveEnv([alone()], SETTINGS), DriveVectorEnv([alone()], 2, SETTINGS)):
        with pytest.raises(UnusableInput, match=rf"is .*: {why}"):
            env.reset(options={"scenario": number})
        with pytest.raises(UnusableInput, match=r"options \['reset_mask'\] are not known"):
            env.reset(options={"reset_mask": np.array([True])})


def test_rows_begin_in_the_scenarios_that_are_asked_for_and_say_in_which():
    vector = DriveVectorEnv([alone(10.0), alone(20.0)], 2, SETTINGS)
    for asked, ids in ((1, ["alone-20.0"] * 2), ([1, 0], ["alone-20.0", "alone-10.0"])):
        _, info = vector.reset(seed=0, options={"scenario": asked})
        assert info["scenario"].tolist() == ids
        assert info["_scenario"].all()


def test_what_was_said_of_an_episode_that_ended_is_kept_beside_its_last_observation():
    vector = DriveVectorEnv([alone(steps=21), alone(steps=31)], 2, SETTINGS)
    vector.reset(options={"scenario": [0, 1]})
    for _ in range(20):
        _, _, terminated, truncated, info = vector.step(np.zeros((2, 1), np.float32))
    assert (terminated.tolist(), truncated.tolist()) == ([False, False], [True, False])
    for name in ("_final_obs", "_final_info", "_scenario"):
        assert info[name].tolist() == [True, False]
    assert info["final_info"]["_collision"].tolist() == [True, False]
    assert info["final_info"]["reward/progress"][0] == pytest.approx(0.1, rel=1e-3)
    assert info["scenario"][0] == "alone-10.0"
    assert info["scenario"][1] is None


def test_a_picture_shows_others_at_the_speed_that_they_have():
    """Whoever reacts to the target is slower than planned."""
    log = stack([drive(LINE, 60, 10, 101), drive(LINE, 40, 10, 101)])
    env = DriveEnv([(scenario(ROAD, log), log)], replace(SETTINGS, neighbours="reactive"), render_mode="rgb_array")
    env.reset(seed=0)
    for _ in range(25):
        env.step(np.array([-1.0], np.float32))
    assert float(env.environment.world.neighbours.speed[0, 0]) < 8.0
    assert float(present(env.environment).vehicles.speed[1]) == pytest.approx(
        float(env.environment.world.neighbours.speed[0, 0]), abs=0.1
    )


@pytest.mark.parametrize("kind", [DriveVectorEnv, DriveVecEnv])
def test_what_is_no_traffic_settings_or_device_is_one_sentence(kind):
    scene, motion = alone()
    for wrong in (3, [(motion, scene)], [(scene, motion[:0])], iter([scene])):
        with pytest.raises(UnusableInput, match="are pairs of a scenario and motion of its vehicles"):
            kind(wrong, 1, SETTINGS)
    with pytest.raises(UnusableInput, match="settings are a dict: give Settings"):
        kind([alone()], 1, {"motion": "path"})
    if not torch.cuda.is_available():
        with pytest.raises(UnusableInput, match="finds no GPU here"):
            kind([alone()], 1, SETTINGS, device="cuda")
    with pytest.raises(UnusableInput, match="device is 'gpu', which PyTorch does not know: cpu or cuda"):
        kind([alone()], 1, SETTINGS, device="gpu")
    assert kind(iter([alone()]), 2, SETTINGS).num_envs == 2


def test_many_rows_are_not_asked_for_pictures_and_a_file_is_no_folder(tmp_path, monkeypatch):
    with pytest.raises(UnusableInput, match="many rows have no picture"):
        DriveVectorEnv([alone()], 2, SETTINGS, render_mode="rgb_array")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "data").mkdir()
    (tmp_path / "data/shard-00000.parquet").touch()
    with pytest.raises(UnusableInput, match=r"data/shard-00000.parquet is no folder: give one"):
        DriveVectorEnv("data/shard-00000.parquet", 2, SETTINGS)
    with pytest.raises(UnusableInput, match=r"data/shipped is no folder: run `make run` first"):
        DriveVectorEnv("data/shipped", 2, SETTINGS)


def test_nothing_to_drive_is_said():
    with pytest.raises(UnusableInput, match="at least one scenario"):
        gymnasium.make(drivegen.gym.ID, scenarios=[], settings=SETTINGS)
    log = stack([drive(LINE, 50, 10, 51), drive(LINE, 52, 10, 51)])
    with pytest.raises(UnusableInput, match="overlaps somebody at step 0"):
        gymnasium.make(drivegen.gym.ID, scenarios=[(scenario(ROAD, log), log)], settings=SETTINGS)
    with pytest.raises(UnusableInput, match=r"environment\.motion is one of"):
        replace(SETTINGS, motion="sideways")
