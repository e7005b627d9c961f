from itertools import pairwise

import numpy as np
import pytest

from drivegen.core import seeds
from drivegen.core.errors import UnusableInput
from drivegen.core.roadmap import RoadMap
from drivegen.core.scenario import VehicleKind
from drivegen.core.signals import SignalState
from drivegen.layouts.compile import compile_map
from drivegen.layouts.spec import MapSpec
from drivegen.sumo.child import SimulationFailed
from drivegen.sumo.demand import Demand, draw_demand, vehicles_at_begin
from drivegen.sumo.network import Network
from drivegen.sumo.traffic import LAG, Run, simulate

RUN = Run(seed=3, warm_up=5.0, seconds=6.0, lateral_resolution=0.8, time_limit=30.0)
ARMS = [{"angle": angle, "lanes_in": 2, "lanes_out": 2, "length": 100} for angle in (0, 90, 180, 270)]
ROUTE = b"""<routes>
  <vType id="lorry" vClass="passenger" guiShape="truck" length="8" width="2.5" height="3" speedFactor="1" speedDev="0"/>
  <vehicle id="0" type="lorry" depart="0" departPos="20" departSpeed="10"><route edges="%s"/></vehicle>
</routes>"""


@pytest.fixture(scope="module")
def raw() -> bytes:
    spec = MapSpec.model_validate({"road": {"kind": "crossing", "control": "signals", "arms": ARMS}})
    return compile_map(spec)


def test_tracks_are_box_centres_on_lanes_with_matching_speeds(raw):
    net = Network.read(raw, "crossing")
    demand = draw_demand(net, Demand(12, 14.0, 10.0), seeds.rng(7, "test"))
    traffic = simulate(raw, demand, net.map.origin, RUN)
    motion = traffic.motion
    assert motion.valid.shape == (len(traffic.track_id), 60)
    assert np.count_nonzero(motion.valid.any(-1)) >= 8
    both = motion.valid[:, 1:] & motion.valid[:, :-1]
    step = np.hypot(*np.moveaxis(np.diff(motion.position, axis=1), -1, 0))
    pace = (motion.speed[:, 1:] + motion.speed[:, :-1]) / 2
    assert np.abs(step / 0.1 - pace)[both].max() < 1.0
    fast = motion.valid & (motion.speed > 3)
    course = np.arctan2(motion.velocity[..., 1], motion.velocity[..., 0])
    off = np.abs((course - motion.heading + np.pi) % (2 * np.pi) - np.pi)[fast]
    assert np.quantile(off, 0.95) < 0.2
    assert distance_to_lanes(net.map, motion.position[motion.valid]).max() < 2.5


def test_a_lorry_is_known_by_its_size_and_its_centre_is_half_a_length_behind_its_front(raw):
    net = Network.read(raw, "crossing")
    edge = next(name.rpartition("_")[0] for name in net.lane_names if not name.startswith(":"))
    begin = Run(seed=1, warm_up=0.0, seconds=2.0, lateral_resolution=0.0, time_limit=30.0)
    traffic = simulate(raw, ROUTE % edge.encode(), net.map.origin, begin)
    assert traffic.kind.tolist() == [VehicleKind.TRUCK]
    assert np.allclose(traffic.size, [[8.0, 2.5, 3.0]])
    line = net.map.centreline[net.lane_names.index(f"{edge}_0")]
    assert traffic.motion.valid[0].argmax() == LAG
    along = np.hypot(*(traffic.motion.position[0, LAG] - line[0]))
    assert along == pytest.approx(20.0 - 4.0, abs=0.2)


def test_lights_follow_the_networks_own_programs(raw):
    net = Network.read(raw, "crossing")
    traffic = simulate(raw, draw_demand(net, Demand(8, 14.0, 8.0), seeds.rng(1)), net.map.origin, RUN)
    (name,) = traffic.lights
    own = net.signals(5.0 + 0.1 * np.arange(60))
    links = net.signal_link[net.signal_name == name]
    assert np.array_equal(traffic.lights[name][links], own.state)
    assert {SignalState.GREEN, SignalState.RED} <= set(own.state.ravel().tolist())


def test_the_same_seed_drives_the_same_and_another_does_not(raw):
    net = Network.read(raw, "crossing")
    demand = draw_demand(net, Demand(8, 14.0, 8.0), seeds.rng(1))
    assert demand == draw_demand(net, Demand(8, 14.0, 8.0), seeds.rng(1))
    assert demand != draw_demand(net, Demand(8, 14.0, 8.0), seeds.rng(2))
    a, b = (simulate(raw, demand, net.map.origin, RUN).motion for _ in range(2))
    assert np.array_equal(a.position, b.position)


def test_a_network_that_crashes_sumo_is_a_failure_of_that_process_alone(raw):
    with pytest.raises(SimulationFailed) as caught:
        simulate(b"<net/>", ROUTE % b"a", np.zeros(2), RUN)
    assert caught.value.reason == "sumo-crashed"


def test_what_sumo_refuses_and_what_never_drives_are_typed_failures(raw):
    with pytest.raises(SimulationFailed) as caught:
        simulate(raw[: len(raw) // 2], ROUTE % b"a", np.zeros(2), RUN)
    assert caught.value.reason == "sumo-refused"
    with pytest.raises(SimulationFailed) as caught:
        simulate(raw, b"<routes/>", np.zeros(2), RUN)
    assert caught.value.reason == "no-traffic"


def test_a_run_that_takes_too_long_is_stopped(raw):
    net = Network.read(raw, "crossing")
    demand = draw_demand(net, Demand(60, 14.0, 2000.0), seeds.rng(1))
    with pytest.raises(SimulationFailed) as caught:
        simulate(raw, demand, net.map.origin, Run(1, 100_000.0, 1.0, 0.8, time_limit=0.4))
    assert caught.value.reason in ("timeout", "sumo-crashed")  # stopped by our clock, or by its own limit on processor time


def test_a_network_without_a_trip_is_said_to_be_so():
    lone = b"""<net><edge id="a" from="x" to="y"><lane id="a_0" index="0" speed="10" length="50" shape="0,0 50,0"/></edge>
      <junction id="x" type="dead_end" x="0" y="0" shape=""/><junction id="y" type="dead_end" x="50" y="0" shape=""/></net>"""
    net = Network.read(lone, "lone")
    assert vehicles_at_begin(net, 10.0, 100) == 8
    with pytest.raises(UnusableInput, match="trip"):
        draw_demand(net, Demand(8, 14.0, 10.0), seeds.rng(1))


def test_ways_across_a_junction_that_lead_round_in_a_circle_end():
    """Lanes within the junction lead into one another; a trip still goes over it, and none is sought for ever."""
    lane = '<lane id="{0}_0" index="0" speed="10" length="{1}" shape="{2}"/>'
    within, way = (
        '<edge id="{0}" function="internal">' + lane + "</edge>",
        '<edge id="{0}" from="{3}" to="{4}">' + lane + "</edge>",
    )
    edges = within.format(":c_0", 5, "50,0 55,0") + within.format(":c_1", 5, "55,0 50,0")
    edges += way.format("a", 50, "0,0 50,0", "w", "c") + way.format("b", 50, "55,0 105,0", "c", "e")
    link = '<connection from="{}" to="{}" fromLane="0" toLane="0" {} state="M"/>'
    ways = [("a", "b", 'via=":c_0_0"'), (":c_0", ":c_1", ""), (":c_1", ":c_0", ""), (":c_1", "b", "")]
    nodes = "".join(f'<junction id="{name}" type="priority" x="0" y="0" shape=""/>' for name in "wce")
    raw = f"<net>{edges}{nodes}{''.join(link.format(*each) for each in ways)}</net>".encode()
    assert b'edges="a b"' in draw_demand(Network.read(raw, "circle"), Demand(5, 14.0, 5.0), seeds.rng(1))


def distance_to_lanes(road_map: RoadMap, points: np.ndarray) -> np.ndarray:
    """Distance of each point to the nearest centreline piece."""
    best = np.full(len(points), np.inf)
    for line in road_map.centreline.lines():
        for a, b in pairwise(line):
            step = b - a
            share = np.clip(((points - a) @ step) / max(step @ step, 1e-9), 0, 1)
            best = np.minimum(best, np.hypot(*(points - a - share[:, None] * step).T))
    return best
