"""A policy that SB3 trained is written as safetensors and drives as it did there."""

from dataclasses import replace

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.wrappers import RescaleAction, TransformObservation
from stable_baselines3 import DDPG, PPO, SAC
from stable_baselines3.common.torch_layers import FlattenExtractor
from stable_baselines3.common.vec_env import VecNormalize
from torch import nn

from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.settings import read_params
from drivegen.drivers.shared.conditions import Settings
from drivegen.drivers.shared.features import (
    COUNT,
    DISTANCES,
    LIMIT,
    NEAREST,
    crossing,
    features,
    leader,
    nearest_boxes,
    road_ahead,
)
from drivegen.drivers.shared.network import Network
from drivegen.drivers.shared.network import Settings as Weights
from drivegen.gym.sb3 import DriveVecEnv, save_policy
from drivegen.simulators.batch import Plugin as Batch
from drivegen.world.rules import Lookout
from drivegen.world.scenes import Scenes
from drivegen.world.world import World
from tests.scenes import any_scenario, busy_crossing

SETTINGS = replace(read_params("environment", Settings), neighbours="replayed", rules=False)


class Mine(Network):
    name = "mine"


class Scaled(FlattenExtractor):
    """Shows a policy other numbers than drivers see."""

    def forward(self, observations):
        return 3 * super().forward(observations)


@pytest.fixture(scope="module")
def env():
    scene = busy_crossing(61)
    return DriveVecEnv([(scene, scene.log)], 4, SETTINGS)


def test_a_policy_whose_actions_are_squashed_is_a_driver_whose_actions_are(env, tmp_path):
    how = {"net_arch": [16, 8], "squash_output": True}
    model = PPO("MlpPolicy", env, seed=0, device="cpu", use_sde=True, policy_kwargs=how, n_steps=8, batch_size=16)
    with torch.no_grad():
        model.policy.action_net.weight *= 100.0  # far from 0, where squashing is felt
    save_policy(model, tmp_path, "mine")
    env.seed(0)
    wanted, _ = model.predict(env.reset(), deterministic=True)
    acceleration = Mine(Weights(str(tmp_path), sees_rules=False)).act(env.environment.world.observe()).acceleration.numpy()
    np.testing.assert_allclose(acceleration, np.where(wanted[:, 0] > 0, 3 * wanted[:, 0], 8 * wanted[:, 0]), atol=1e-4)
    assert np.abs(wanted[:, 0]).max() > 0.3


@pytest.mark.parametrize("algorithm", [PPO, SAC])
@pytest.mark.parametrize("activation", [nn.Tanh, nn.ReLU])
def test_the_driver_decides_as_the_policy_did(env, tmp_path, algorithm, activation):
    few = {"n_steps": 8, "batch_size": 16, "n_epochs": 1} if algorithm is PPO else {"learning_starts": 8, "batch_size": 16}
    model = algorithm(
        "MlpPolicy", env, seed=0, device="cpu", policy_kwargs={"net_arch": [16, 8], "activation_fn": activation}, **few
    )
    model.learn(32)
    save_policy(model, tmp_path / "mine", "mine")
    driver = Mine(Weights(str(tmp_path / "mine"), sees_rules=False))
    env.seed(0)
    seen = env.reset()
    wanted, _ = model.predict(seen, deterministic=True)
    acceleration = driver.act(env.environment.world.observe()).acceleration.numpy()
    np.testing.assert_allclose(acceleration, np.where(wanted[:, 0] > 0, 3 * wanted[:, 0], 8 * wanted[:, 0]), atol=1e-4)
    scene = busy_crossing(61)
    assert Batch().run(driver, [scene], [scene.log]).motion.valid[0].sum() > 1


def test_what_is_no_policy_of_ours_is_refused(env, tmp_path):
    with pytest.raises(UnusableInput, match="neither SAC nor PPO"):
        save_policy(DDPG("MlpPolicy", env), tmp_path, "mine")
    with pytest.raises(UnusableInput, match="through VecNormalize"):
        save_policy(PPO("MlpPolicy", VecNormalize(env), device="cpu"), tmp_path, "mine")
    scene = busy_crossing(61)
    free = DriveVecEnv([(scene, scene.log)], 4, replace(SETTINGS, motion="free"))
    with pytest.raises(UnusableInput, match="steers freely"):
        save_policy(PPO("MlpPolicy", free, device="cpu"), tmp_path, "mine")
    loaded = PPO("MlpPolicy", free, device="cpu")
    loaded.env = None  # so `PPO.load(FILE)` leaves it
    with pytest.raises(UnusableInput, match="load it with its environment"):
        save_policy(loaded, tmp_path, "mine")
    with pytest.raises(UnusableInput, match="neither linear nor activations"):
        save_policy(PPO("MlpPolicy", env, device="cpu", policy_kwargs={"features_extractor_class": Scaled}), tmp_path, "mine")
    with pytest.raises(UnusableInput, match=r"no driver's .activation 'elu'.*: train one with tanh or ReLU"):
        save_policy(SAC("MlpPolicy", env, policy_kwargs={"activation_fn": nn.ELU}), tmp_path, "mine")
    with pytest.raises(UnusableInput, match="does not see what drivers see"):
        save_policy(PPO("MlpPolicy", "Pendulum-v1", device="cpu"), tmp_path, "mine")
    assert not list(tmp_path.iterdir())
    with pytest.raises(MissingTool, match="holds no trained driver"):
        Mine(Weights(str(tmp_path / "none"), sees_rules=False))


@pytest.mark.parametrize(
    "wrapped", [lambda env: RescaleAction(env, np.float32(-2), np.float32(2)), lambda env: TransformObservation(env, abs, None)]
)
def test_a_policy_that_was_trained_through_a_wrapper_is_refused(tmp_path, wrapped):
    scene = busy_crossing(61)
    env = wrapped(gymnasium.make("DriveGen/Drive-v0", scenarios=[(scene, scene.log)], settings=SETTINGS))
    with pytest.raises(UnusableInput, match="through a wrapper that changes what is seen or done"):
        save_policy(PPO("MlpPolicy", env, device="cpu"), tmp_path, "mine")


def test_who_is_beyond_a_kilometre_is_as_present_by_loops_as_by_tensors():
    scene = any_scenario(0)
    scenes = Scenes.of([scene], [scene.log])
    seen = World(scenes, 1).observe()
    seen = replace(seen, ahead=torch.where(seen.present, 1200.0, seen.ahead))
    first = 12 + 2 * len(DISTANCES)
    boxes = features(seen)[:, first : first + 8 * NEAREST]
    assert float(boxes[0, 7]) == 1.0
    torch.testing.assert_close(boxes, nearest_boxes(seen).clamp(-LIMIT, LIMIT))


@pytest.mark.parametrize("seed", range(4))
def test_the_compiled_features_are_those_of_tensors(seed):
    scene = any_scenario(seed)
    scenes = Scenes.of([scene], [scene.log])
    world = World(scenes, 3, lookout=Lookout.of(scenes, [scene], [scene.log]))
    seen = world.observe()
    numbers = features(seen)
    assert numbers.shape == (3, COUNT)
    assert torch.isfinite(numbers).all()
    assert (numbers.abs() <= LIMIT).all()
    gap, closing = leader(seen)
    torch.testing.assert_close(numbers[:, 6], (gap / 30).clamp_max(LIMIT))
    torch.testing.assert_close(numbers[:, 7], (closing / 15).clamp(-LIMIT, LIMIT))
    comes, place = crossing(seen)
    torch.testing.assert_close(numbers[:, 10], comes / 5)
    torch.testing.assert_close(numbers[:, 11], place / 30)
    first = 12 + 2 * len(DISTANCES)
    torch.testing.assert_close(numbers[:, 12:first], torch.cat(road_ahead(seen), dim=1).clamp(-LIMIT, LIMIT))
    torch.testing.assert_close(numbers[:, first : first + 8 * NEAREST], nearest_boxes(seen).clamp(-LIMIT, LIMIT))
