"""A motorway to place traffic on, and what makes it drive."""

import pytest

from drivegen.core.settings import build, read_section
from drivegen.generators.base import Settings as GeneratorSettings
from drivegen.layouts.compile import compile_map
from drivegen.layouts.spec import MapSpec
from drivegen.placement.scenes import Initialiser
from drivegen.placement.scenes import Settings as InitialSettings
from drivegen.placement.table import build_table
from drivegen.rollout.models import Equipment
from drivegen.sumo.network import Network
from tests.projects import PARAMS
from tests.scenes import busy_crossing

HIGHWAY = MapSpec.model_validate({"road": {"kind": "highway", "lanes": 3, "speed": 20}})


@pytest.fixture(scope="module")
def initialiser() -> Initialiser:
    settings = build(InitialSettings, read_section("place.initial", PARAMS), "place.initial")
    network = Network.read(compile_map(HIGHWAY), "highway")
    return Initialiser(network, "highway", "test", build_table([busy_crossing()]), settings)


@pytest.fixture(scope="module")
def tools(models) -> tuple[Equipment, GeneratorSettings]:
    generation = build(GeneratorSettings, read_section("ship.generation", PARAMS), "ship.generation")
    return Equipment.open(models, generation.planner, "learned"), generation
