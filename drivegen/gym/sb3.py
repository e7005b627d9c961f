"""Stable-Baselines3's `VecEnv` over a folder's scenarios, and its policies as files of weights."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gymnasium import ActionWrapper, ObservationWrapper
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.torch_layers import FlattenExtractor
from torch import nn

from drivegen.core.errors import UnusableInput
from drivegen.drivers.shared.conditions import Settings, Traffic
from drivegen.drivers.shared.environment import OBSERVATION
from drivegen.drivers.shared.network import write_network
from drivegen.drivers.shared.vec_env import WorldVecEnv
from drivegen.gym.opening import opened


def save_policy(model: BaseAlgorithm, folder: str | Path, name: str) -> None:
    """Write the network of a SAC's or PPO's policy as the weights of the driver `name` (`drivers.shared.network`).

    Raises UnusableInput for other algorithms, for networks that are more than linear layers with one kind of activation, tanh or
    ReLU, and for policies that a driver could not repeat: those that steer freely, and those that see numbers which
    `VecNormalize`, a wrapper or a features extractor has changed.
    """
    _refuse_unrepeatable(model)
    policy: Any = model.policy
    sac = isinstance(model, SAC)
    if not sac and not isinstance(model, PPO):
        raise UnusableInput(f"{type(model).__name__} is neither SAC nor PPO: its policy is no network of ours")
    parts = [*policy.actor.latent_pi, policy.actor.mu] if sac else [*policy.mlp_extractor.policy_net, policy.action_net]
    linear = [part for part in parts if isinstance(part, nn.Linear)]
    activation = policy.activation_fn.__name__.lower()
    extractor = (policy.actor if sac else policy).features_extractor
    if len(parts) != 2 * len(linear) - 1 or type(extractor) is not FlattenExtractor:  # a subclass may change what is seen
        raise UnusableInput("the policy has layers that are neither linear nor activations between them")
    try:
        write_network(Path(folder), name, linear, activation, squashed=sac or bool(policy.squash_output))
    except ValueError as error:
        raise UnusableInput(f"the policy's network is no driver's ({error}): train one with tanh or ReLU") from None


def _refuse_unrepeatable(model: BaseAlgorithm) -> None:
    if model.observation_space != OBSERVATION:
        raise UnusableInput("the policy does not see what drivers see: train it in this environment")
    environment = model.get_env()
    if environment is None:
        raise UnusableInput("what the policy was trained in is not known: load it with its environment, load(FILE, env=...)")
    if model.get_vec_normalize_env() is not None:
        raise UnusableInput("the policy was trained through VecNormalize, whose numbers no driver sees: train it without")
    if any(any(environment.env_is_wrapped(kind)) for kind in (ActionWrapper, ObservationWrapper)):
        raise UnusableInput("the policy was trained through a wrapper that changes what is seen or done: train it without")
    if environment.get_attr("environment")[0].settings.motion == "free":
        raise UnusableInput("the policy steers freely, and drivers keep to paths: train it with motion `path` or `path_offset`")


class DriveVecEnv(WorldVecEnv):
    """`num_envs` rows in the scenarios of a folder."""

    def __init__(
        self,
        scenarios: str | Path | Sequence[Traffic],
        num_envs: int,
        settings: Settings | None = None,
        of: str | Path | None = None,
        device: str = "cpu",
    ) -> None:
        """See `env.DriveEnv`."""
        super().__init__(opened(scenarios, num_envs, settings, of, device))
