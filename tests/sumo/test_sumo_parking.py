"""Parked cars stand beside slow streets, off every lane, apart from each other and from whoever drives."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.core.geometry import box_corners, unit
from drivegen.core.scenario import TARGET, Trajectories, VehicleKind
from drivegen.layouts.compile import compile_map
from drivegen.layouts.spec import MapSpec
from drivegen.roads.drivable import road_surface
from drivegen.roads.graph import LaneGraph
from drivegen.roads.parked import parked
from drivegen.sumo.network import Network
from drivegen.sumo.parking import ParkingSettings, park, with_parked
from drivegen.sumo.traffic import Traffic
from drivegen.sumo.windows import overlapping_pairs
from tests.scenes import busy_crossing

EVERYWHERE = ParkingSettings(share=1.0, fastest=14.0, spacing=6.5, taken=1.0, gap=(0.2, 0.5), from_end=12.0)
STEPS = 60


@pytest.fixture(scope="module")
def network() -> Network:
    return Network.read(compile_map(MapSpec.model_validate({"road": {"kind": "grid", "rows": 2, "columns": 2}})), "grid")


def stroller(network: Network) -> Traffic:
    """One car drives along the outer edge of the longest lane, half beside it."""
    lengths = [np.hypot(*(line[-1] - line[0])) for line in network.map.right.lines()]
    lane = int(np.argmax(np.where(network.map.in_junction, 0, lengths)))
    edge = network.map.right[lane]
    along = np.linspace(0, 1, STEPS)[:, None]
    motion = Trajectories.empty(1, STEPS)
    motion.position[0] = edge[0] + along * (edge[-1] - edge[0])
    motion.heading[0] = np.arctan2(*(edge[-1] - edge[0])[::-1])
    motion.valid[:] = True
    return Traffic(np.array(["0"]), np.zeros(1, np.uint8), np.array([[4.5, 1.8, 1.5]], np.float32), motion, {})


def stream() -> np.random.Generator:
    return np.random.default_rng(4)


def test_cars_stand_beside_lanes_and_the_rule_that_knows_only_the_first_frame_takes_all_for_parked(network):
    cars = park(network, stroller(network), EVERYWHERE, stream())
    assert len(cars) > 20
    assert (cars.kind == VehicleKind.CAR).all()
    assert parked(LaneGraph.of(network.map), cars).all()
    near = LaneGraph.of(network.map).nearest(cars.position)[1]
    assert near[:, 3].max() < 4.5  # half a lane, the gap, half a car
    corners = box_corners(cars.position, cars.heading, cars.size[:, 0], cars.size[:, 1])
    assert road_surface(network.map).distance_outside(corners).min() > -0.4  # the raster's cells are half a metre
    standing = Trajectories(
        cars.position[:, None], cars.heading[:, None], np.zeros((len(cars), 1, 2), np.float32), np.ones((len(cars), 1), bool)
    )
    assert len(overlapping_pairs(standing, cars.size)) == 0


def test_nobody_parks_where_somebody_drives(network):
    driven = stroller(network)
    elsewhere = replace(driven, motion=replace(driven.motion, position=driven.motion.position + np.float32(5000)))
    there, without = (park(network, traffic, EVERYWHERE, stream()) for traffic in (driven, elsewhere))
    assert 3 <= len(without) - len(there) < len(without) / 2
    ahead = unit(driven.motion.heading[0, :1])[0]
    gone = ~np.isin(without.track_id, there.track_id)
    offset = (without.position[gone] - driven.motion.position[0, 0]) @ np.array([-ahead[1], ahead[0]])
    assert np.abs(offset).max() < 3.0


def test_the_same_stream_gives_the_same_cars_and_a_share_is_a_share(network):
    traffic = stroller(network)
    one, same = (park(network, traffic, EVERYWHERE, stream()) for _ in range(2))
    arrays = ("track_id", "position", "heading", "size")
    assert all(getattr(one, name).tobytes() == getattr(same, name).tobytes() for name in arrays)
    assert len(park(network, traffic, replace(EVERYWHERE, share=0.0), stream())) == 0
    assert len(park(network, traffic, replace(EVERYWHERE, fastest=5.0), stream())) == 0
    assert 0 < len(park(network, traffic, replace(EVERYWHERE, taken=0.3), stream())) < 0.6 * len(one)
    without_cars = replace(traffic, kind=np.full(1, VehicleKind.BUS, np.uint8))
    assert len(park(network, without_cars, EVERYWHERE, stream())) == 0


def test_a_scenario_gets_those_near_its_target_while_they_are_near():
    base = busy_crossing(60)
    assert base.log is not None
    near = base.vehicles.position[TARGET].astype(np.float64) + np.array([6, 8])
    shift = np.array([100.0, 50.0])
    places = np.stack([near, near + 300]) - shift
    cars = replace(base.vehicles[[0, 0]], track_id=np.array(["near", "far"]), position=places.astype(np.float32))
    shown = with_parked(base, cars, base.map.origin + shift, radius=12.0)
    shown.validate()
    assert shown.log is not None
    assert shown.vehicles.track_id.tolist() == [*base.vehicles.track_id, "near"]
    seen = np.hypot(*(base.log.position[TARGET] - near).T) <= 12.0
    assert 0 < seen.sum() < len(seen)
    assert np.array_equal(shown.log.valid[-1], seen)
    assert np.allclose(shown.log.position[-1][seen], near, atol=1e-3)
    assert shown.log[:-1].position.tobytes() == base.log.position.tobytes()


def test_cars_are_parked_on_the_outer_side_where_traffic_keeps_left(network):
    road = {"kind": "corridor", "alignment": {"length": 300}, "lanes": 2, "lanes_back": 2}
    spots = []
    for left_hand in (False, True):
        net = Network.read(compile_map(MapSpec.model_validate({"road": road, "left_hand": left_hand})), "street")
        cars = park(net, stroller(network), EVERYWHERE, stream())
        middles = [np.abs(line[:, 1]).max() for line in net.map.centreline.lines()]
        assert len(cars) > 20
        assert np.abs(cars.position[:, 1]).min() > max(middles)
        spots.append(len(cars))
    assert spots[0] == pytest.approx(spots[1], rel=0.1)
