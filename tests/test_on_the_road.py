"""New scenarios, from their placing to what is shipped: nobody drives off the road of the whole network, whatever its shape."""

from collections import Counter

import numpy as np
import pytest

from drivegen.core.scenario import Scenario
from drivegen.layouts.compile import compile_map
from drivegen.layouts.spec import MapSpec
from drivegen.placement.place import PlaceSettings
from drivegen.placement.scenes import Initialiser, Settings
from drivegen.placement.table import build_table
from drivegen.rollout.batch import roll_out
from drivegen.rollout.choices import choose
from drivegen.rollout.models import Equipment
from drivegen.rollout.scene import RolloutSettings
from drivegen.rollout.shipping import ShipSettings, ship
from drivegen.sumo.network import Network
from tests.checking import FARTHEST_OFF, off_the_road
from tests.models import candidate_settings
from tests.scenes import busy_crossing

PLACING = PlaceSettings(
    mode="paper", road_ahead=60.0, radius=80.0, speed_spread=0.15, least_time_gap=0.8, standstill_gap=2.0, attempts=24
)
SETTINGS = Settings(vehicles=10, horizon=100, shares={"car": 0.9, "bus": 0.1}, map_radius=30.0, placement=PLACING)
ROLLOUT = RolloutSettings(attempts=3, rounds=3, evictions=1, drop_illegal=True, target_steps=None, exclusion=True, tempo=0.8)
ARMS = [{"angle": angle, "lanes_in": 1, "lanes_out": 1, "length": 90} for angle in (0, 95, 180, 260)]
ROADS = {
    "crossing": {"kind": "crossing", "control": "yield", "arms": ARMS},
    "roundabout": {"kind": "roundabout", "arms": ARMS},
}


@pytest.fixture(scope="module")
def networks() -> dict[str, Network]:
    return {name: Network.read(compile_map(MapSpec.model_validate({"road": road})), name) for name, road in ROADS.items()}


@pytest.fixture(scope="module")
def placed(networks) -> list[Scenario]:
    table = build_table([busy_crossing()])
    initialisers = [Initialiser(network, name, "test", table, SETTINGS) for name, network in networks.items()]
    return [initialiser.scenario(number, 7)[0] for initialiser in initialisers for number in range(3)]


@pytest.fixture(scope="module")
def shipped(models, placed) -> tuple[list[Scenario], Counter[str]]:
    tools, counts = Equipment.open(models, "route_fm", "random"), Counter[str]()
    made = roll_out(choose(placed, tools.selector, candidate_settings(), 1.0), tools.planner, tools.limits, ROLLOUT, 3, 7, "test")
    settings = ShipSettings(fewest=2, moved=0.0)
    return [one for scene, samples in zip(placed, made, strict=True) for one in ship(scene, samples, settings, counts)], counts


def test_a_small_network_is_kept_whole_however_small_the_radius(placed, networks):
    for scenario in placed:
        assert len(scenario.map) == len(networks[scenario.city].map)
        assert not scenario.map.is_cut_out


def test_no_vehicle_is_off_the_road_and_some_leave_the_map(shipped, networks):
    scenarios, counts = shipped
    assert counts["vehicles.left_map"] > 0
    assert counts["vehicles.left_map"] == sum(int((~s.log.valid[:, -1]).sum()) for s in scenarios)
    for scenario in scenarios:
        off = off_the_road(scenario, networks[scenario.city])
        assert off.max() <= FARTHEST_OFF, (scenario.scenario_id, np.argwhere(off > FARTHEST_OFF)[:3])
