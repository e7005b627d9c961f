"""Gymnasium environments: `gymnasium.make("DriveGen/Drive-v0", scenarios=FOLDER)`, `make_vec` likewise, a `VecEnv` in `sb3.py`.

This module imports nothing heavy: Gymnasium finds it by the entry point of the installed package and calls `register`.
"""

from gymnasium.envs.registration import register as _register
from gymnasium.envs.registration import registry

ID = "DriveGen/Drive-v0"


def register() -> None:
    """Make ID known to Gymnasium; once is enough."""
    if ID not in registry:
        _register(ID, entry_point="drivegen.gym.env:DriveEnv", vector_entry_point="drivegen.gym.vector:DriveVectorEnv")


register()
