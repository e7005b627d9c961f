"""Gymnasium environments: after `import drivegen.gym`, `gymnasium.make("DriveGen/Drive-v0", scenarios=FOLDER)` and `make_vec`.

`sb3.py` has a `VecEnv` for Stable-Baselines3. Importing this module registers the name and nothing heavier.
"""

from gymnasium.envs.registration import register, registry

ID = "DriveGen/Drive-v0"

if ID not in registry:
    register(ID, entry_point="drivegen.gym.env:DriveEnv", vector_entry_point="drivegen.gym.vector:DriveVectorEnv")
