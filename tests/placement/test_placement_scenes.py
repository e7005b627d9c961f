"""First frames of new scenarios: when they are, as their signals show it."""

import re

from drivegen.layouts.compile import compile_map
from drivegen.layouts.spec import MapSpec
from drivegen.placement.place import PlaceSettings
from drivegen.placement.scenes import Initialiser, Settings
from drivegen.placement.table import build_table
from drivegen.sumo.network import Network
from tests.scenes import busy_crossing

PLACING = PlaceSettings(
    mode="paper", road_ahead=60.0, radius=80.0, speed_spread=0.15, least_time_gap=0.8, standstill_gap=2.0, attempts=24
)
SETTINGS = Settings(vehicles=1, horizon=1, shares={"car": 1.0}, map_radius=200.0, placement=PLACING)
ARMS = [{"angle": angle, "lanes_in": 1, "lanes_out": 1, "length": 90} for angle in (0, 90, 180, 270)]


def test_scenes_begin_at_any_time_of_a_signals_programme_however_long_it_is():
    spec = MapSpec.model_validate({"road": {"kind": "crossing", "control": "signals", "arms": ARMS}})
    xml = re.sub(rb'<phase duration="[0-9.]+"', b'<phase duration="75"', compile_map(spec))
    phases = re.findall(rb'<phase duration="75" +state="(\w+)"', xml)
    assert len(set(phases)) == len(phases) >= 4
    start = Initialiser(Network.read(xml, "slow"), "slow", "test", build_table([busy_crossing()]), SETTINGS)
    seen = [tuple(start.scenario(number, 7)[0].signals.state[:, 0].tolist()) for number in range(40)]
    assert len(set(seen)) == len(phases)
    assert max(map(seen.count, set(seen))) < 20
