"""The settings that `drivegen generate` works with: those of params.yaml, which a test compares.

They are repeated here because the command runs where no params.yaml is; the models' folder is all that it needs.
"""

from pathlib import Path

from drivegen.assets.place import PlaceSettings
from drivegen.generate import RolloutSettings
from drivegen.generators.base import Settings as GeneratorSettings
from drivegen.goals.candidates import Settings as CandidateSettings
from drivegen.goals.reach import Dynamics
from drivegen.initialise import Settings as InitialSettings
from drivegen.selection import Settings as SelectionSettings

MODELS = Path("data/models")
ASSETS = Path("data/assets.parquet")

LARGEST = 128
"""Vehicles in a scenario at most."""


def generation(drop_illegal: bool) -> GeneratorSettings:
    """Section `rollout.generation`; what is not scored against a log leaves out what could not be made legal."""
    return GeneratorSettings(
        planner="route_fm",
        candidates=CandidateSettings(
            most=32, most_routes=12, radius=3.8, dynamics=Dynamics(acceleration=3.0, braking=4.5, lateral=5.0, limit_factor=1.25)
        ),
        temperature=1.0,
        rollout=RolloutSettings(attempts=4, rounds=4, drop_illegal=drop_illegal, target_steps=None),
    )


def selection(vehicles: int) -> SelectionSettings:
    """Section `ingest.selection`."""
    return SelectionSettings(
        target="focal", max_vehicles=vehicles, first_step=0, horizon=100, map_radius=None, smallest_shrink=0.8
    )


def initial(vehicles: int) -> InitialSettings:
    """Section `place`."""
    return InitialSettings(
        vehicles=vehicles,
        horizon=100,
        shares={"car": 0.85, "truck": 0.09, "bus": 0.06},
        map_radius=250.0,
        longest_cycle=90.0,
        placement=PlaceSettings(radius=80.0, speed_spread=0.15, least_time_gap=0.8, standstill_gap=2.0, attempts=24),
    )
