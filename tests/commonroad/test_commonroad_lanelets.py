"""Lanelets, signs and lights become the road map that the file describes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.commonroad.recording import read_recording
from drivegen.core.errors import UnusableInput
from drivegen.core.recorded_log import RecordedLog
from drivegen.core.roadmap import NO_LANE, LaneControl, LaneKind, RoadMap
from drivegen.core.signals import SignalState
from tests.commonroad_files import CARS, ROAD, car, lanelet, points, xml

STRAIGHT = ([(0.0, 2.0), (50.0, 2.0)], [(0.0, -2.0), (50.0, -2.0)])


def read(*parts: str, version: str = "2018b") -> RecordedLog:
    return read_recording(xml([*parts, *CARS], version), "file.xml", "CommonRoad")


def lane(road_map: RoadMap, name: int) -> int:
    return int(np.flatnonzero(road_map.lane_id == name)[0])


def test_lanes_lie_midway_between_bounds_of_different_point_counts() -> None:
    road_map = read(*ROAD).map
    line = road_map.centreline[lane(road_map, 1)] + road_map.origin
    np.testing.assert_allclose(line[[0, -1]], [(0, 0), (100, 0)], atol=1e-4)
    np.testing.assert_allclose(line[:, 1], 0, atol=1e-4)
    assert np.hypot(*np.diff(line, axis=0).T).max() <= 2.01


def test_links_neighbours_and_limits_are_as_in_the_file() -> None:
    road_map = read(*ROAD).map
    one, two, three, back = (lane(road_map, name) for name in (1, 2, 3, 9))
    np.testing.assert_array_equal(road_map.links, [(one, three)])
    assert road_map.dangling == 1
    assert road_map.neighbour[one].tolist() == [two, NO_LANE]
    assert road_map.neighbour[two].tolist() == [back, one]
    assert road_map.same_direction[two].tolist() == [False, True]
    assert road_map.may_change[two].tolist() == [False, True]
    assert road_map.speed_limit[one] == pytest.approx(13.4)
    assert np.isnan(road_map.speed_limit[two])


def test_without_intersections_the_lanes_that_cross_are_the_junction() -> None:
    road_map = read(*ROAD).map
    assert road_map.lane_id[road_map.in_junction].tolist() == [3, 4]


def test_a_turn_beside_a_crossing_lane_is_in_the_junction_too() -> None:
    turn = lanelet(5, [(100, 1.75), (110, -4), (112, -20)], [(100, -1.75), (107, -6), (109, -20)], '<predecessor ref="1"/>')
    road_map = read(*ROAD, turn).map
    assert road_map.lane_id[road_map.in_junction].tolist() == [3, 4, 5]


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.floats(0.01, 0.99), max_size=6, unique=True),
    st.lists(st.floats(0.01, 0.99), max_size=6, unique=True),
    st.floats(-3.1, 3.1),
)
def test_a_straight_lane_is_straight_however_its_bounds_are_sampled(left, right, heading) -> None:
    along = np.array([np.cos(heading), np.sin(heading)])
    side = 1.7 * np.array([-along[1], along[0]])
    sides = ((left, side), (right, -side))
    bounds = [[tuple((60 * share * along + shift).tolist()) for share in (0, *sorted(shares), 1)] for shares, shift in sides]
    road_map = read(lanelet(1, *bounds)).map
    line = road_map.centreline[0] + road_map.origin
    assert abs(along[0] * line[:, 1] - along[1] * line[:, 0]).max() < 1.7
    np.testing.assert_allclose(line[[0, -1]], [(0, 0), 60 * along], atol=1e-3)


TYPED = [
    lanelet(1, *STRAIGHT, "<laneletType>urban</laneletType><laneletType>busLane</laneletType>"),
    lanelet(2, [(0, 6), (50, 6)], [(0, 2), (50, 2)], "<laneletType>bicycleLane</laneletType>"),
    lanelet(3, [(0, -2), (50, -2)], [(0, -5), (50, -5)], "<laneletType>shoulder</laneletType>"),
    lanelet(4, [(0, -5), (50, -5)], [(0, -7), (50, -7)], "<laneletType>sidewalk</laneletType>"),
    lanelet(5, [(20, -5), (20, 6)], [(23, -5), (23, 6)], "<laneletType>crosswalk</laneletType>"),
]


def test_types_decide_who_uses_a_lane_and_what_is_none() -> None:
    road_map = read(*TYPED, version="2020a").map
    assert road_map.lane_id.tolist() == [1, 2]
    assert road_map.kind.tolist() == [LaneKind.BUS, LaneKind.BIKE]
    assert len(road_map.drivable) == 2  # the bus lane and the shoulder
    assert len(road_map.crossings) == 1
    assert road_map.crossings[0].shape == (4, 2)


@pytest.mark.parametrize("kind", ["shoulder", "border", "parking", "restricted"])
def test_what_lies_beside_the_lanes_is_road_and_no_lane(kind: str) -> None:
    beside = lanelet(
        2, [(0, 6), (50, 6)], [(0, 2), (50, 2)], f"<laneletType>urban</laneletType><laneletType>{kind}</laneletType>"
    )
    road_map = read(lanelet(1, *STRAIGHT), beside, version="2020a").map
    assert road_map.lane_id.tolist() == [1]
    assert len(road_map.drivable) == 2


@pytest.mark.parametrize(
    ("users", "kinds", "drivable"),
    [
        ("vehicle", [LaneKind.VEHICLE] * 2, 2),
        ("car bicycle", [LaneKind.VEHICLE] * 2, 2),
        ("bus taxi", [LaneKind.VEHICLE, LaneKind.BUS], 2),
        ("pedestrian bicycle", [LaneKind.VEHICLE, LaneKind.BIKE], 1),
        ("pedestrian", [LaneKind.VEHICLE], 1),
        ("train", [LaneKind.VEHICLE], 2),
        ("train vehicle", [LaneKind.VEHICLE] * 2, 2),
    ],
)
@pytest.mark.parametrize("word", ["userOneWay", "userBidirectional"])
def test_users_decide_who_uses_a_lane_that_no_type_keeps_for_somebody(users, kinds, drivable, word) -> None:
    named = "".join(f"<{word}>{user}</{word}>" for user in users.split())
    road_map = read(lanelet(1, *STRAIGHT), lanelet(2, [(0, 6), (50, 6)], [(0, 2), (50, 2)], named), version="2020a").map
    assert road_map.kind.tolist() == kinds
    assert len(road_map.drivable) == drivable


def test_solid_lines_are_not_crossed() -> None:
    beside = '<adjacentLeft ref="2" drivingDir="same"/>', '<adjacentRight ref="1" drivingDir="same"/>'
    road_map = read(
        lanelet(1, *STRAIGHT, beside[0], marking="solid"),
        lanelet(2, [(0, 6), (50, 6)], STRAIGHT[0], beside[1], marking="dashed"),
        version="2020a",
    ).map
    assert road_map.same_direction[0, 0]
    assert not road_map.may_change[0, 0]
    assert road_map.may_change[1, 1]


@pytest.mark.parametrize(
    ("kinds", "may"), [("busLane urban", True), ("bicycleLane urban", False), ("busLane bicycleLane", False)]
)
def test_one_may_change_between_lanes_for_motor_vehicles_alone(kinds, may) -> None:
    left, right = (f"<laneletType>{kind}</laneletType>" for kind in kinds.split())
    beside = '<adjacentLeft ref="2" drivingDir="same"/>', '<adjacentRight ref="1" drivingDir="same"/>'
    road_map = read(
        lanelet(1, *STRAIGHT, beside[0] + right), lanelet(2, [(0, 6), (50, 6)], STRAIGHT[0], beside[1] + left), version="2020a"
    ).map
    assert road_map.may_change.tolist() == [[may, False], [False, may]]


STOP_LINE = f"<stopLine>{points([(49, -2), (49, 2)])}<lineMarking>solid</lineMarking></stopLine>"
LIGHT = """<trafficLight id="70"><cycle><cycleElement><duration>20</duration><color>red</color></cycleElement>
<cycleElement><duration>10</duration><color>redYellow</color></cycleElement>
<cycleElement><duration>15</duration><color>green</color></cycleElement><timeOffset>5</timeOffset></cycle>
<direction>straight</direction><active>true</active></trafficLight>"""
SIGNS = """<trafficSign id="80"><trafficSignElement><trafficSignID>206</trafficSignID></trafficSignElement></trafficSign>
<trafficSign id="81"><trafficSignElement><trafficSignID>274</trafficSignID><additionalValue>8.33</additionalValue>
</trafficSignElement></trafficSign>"""
INTERSECTION = """<intersection id="90"><incoming id="91"><incomingLanelet ref="1"/><successorsStraight ref="2"/>
<successorsLeft ref="3"/></incoming></intersection>"""


def approach(inside: str) -> list[str]:
    ahead = lanelet(2, [(50, 2), (80, 2)], [(50, -2), (80, -2)])
    left = lanelet(3, [(50, 2), (60, 10)], [(50, -2), (64, 8)])
    return [lanelet(1, *STRAIGHT, f'<successor ref="2"/><successor ref="3"/>{inside}'), ahead, left]


def test_a_light_guards_the_ways_of_its_direction_and_runs_its_cycle() -> None:
    log = read(*approach(f'{STOP_LINE}<trafficLightRef ref="70"/>'), LIGHT, INTERSECTION, version="2020a")
    ahead, left = lane(log.map, 2), lane(log.map, 3)
    assert log.map.in_junction.tolist() == [False, True, True]
    assert log.map.control[ahead] == LaneControl.SIGNAL
    assert log.map.control[left] == LaneControl.UNKNOWN
    assert log.signals.lane.tolist() == [ahead]
    shown = log.signals.state[0]
    assert shown.tolist()[:5] == [SignalState.GREEN] * 5  # the cycle begins anew at step 5
    assert shown.tolist()[5:35] == [SignalState.RED] * 30
    assert shown.tolist()[35:50] == [SignalState.GREEN] * 15
    assert shown[50] == SignalState.RED
    assert log.map.stop_lane.tolist() == [ahead, left]
    np.testing.assert_allclose(log.map.stop_lines[0] + log.map.origin, [(49, -2), (49, 2)])


def test_signs_stop_and_limit() -> None:
    log = read(*approach('<stopLine/><trafficSignRef ref="80"/><trafficSignRef ref="81"/>'), SIGNS, version="2020a")
    assert log.map.control.tolist() == [LaneControl.UNKNOWN, LaneControl.STOP, LaneControl.STOP]
    assert log.map.speed_limit[0] == pytest.approx(8.33)
    np.testing.assert_allclose(log.map.stop_lines[0] + log.map.origin, [(50, -2), (50, 2)])  # at the lane's end


def test_what_the_stop_line_alone_refers_to_holds_too() -> None:
    line = STOP_LINE.replace("</stopLine>", '<trafficSignRef ref="80"/><trafficLightRef ref="70"/></stopLine>')
    signed = read(*approach(line), SIGNS, INTERSECTION, version="2020a").map
    assert signed.control[[lane(signed, 2), lane(signed, 3)]].tolist() == [LaneControl.STOP, LaneControl.STOP]
    lit = read(*approach(line), LIGHT, INTERSECTION, version="2020a").map
    assert lit.control[lane(lit, 2)] == LaneControl.SIGNAL


@pytest.mark.parametrize("order", [(81, 82), (82, 81)])
def test_of_several_limits_the_least_holds(order: tuple[int, int]) -> None:
    slower = SIGNS.replace("81", "82").replace("80", "83").replace("8.33", "5.5")
    references = "".join(f'<trafficSignRef ref="{sign}"/>' for sign in (80, *order))
    log = read(*approach(references), SIGNS, slower, version="2020a")
    assert log.map.speed_limit[0] == pytest.approx(5.5)


@pytest.mark.parametrize(
    ("part", "reason"),
    [
        ('<lanelet id="1"/>', "bad-map"),
        (lanelet(1, [(0, 2)], STRAIGHT[1]), "bad-map"),
        (lanelet(1, [(0, 2), (0, 2)], STRAIGHT[1]), "bad-map"),
        (lanelet(1, [(0, float("nan")), (50, 2)], STRAIGHT[1]), "not-a-number"),
        (lanelet(1, [(0, 2), (90_000_000, 2)], STRAIGHT[1]), "out-of-range"),
        (lanelet(1, [(0, 2), (50, 2)], [(50, -2), (0, -2)]), "bad-map"),
        (lanelet(1, *STRAIGHT, '<successor ref="x"/>'), "bad-id"),
        (lanelet(1, *STRAIGHT, "<speedLimit>fast</speedLimit>"), "not-a-number"),
        (lanelet(1, *STRAIGHT, "<speedLimit>-3</speedLimit>"), "out-of-range"),
        (lanelet(1, *STRAIGHT) * 2, "bad-map"),
        (lanelet(1, *STRAIGHT, "<laneletType>sidewalk</laneletType>"), "no-lanes"),
        (car(1, 0, 0), "no-lanes"),
    ],
)
def test_what_is_no_map_is_refused_with_file_and_reason(part: str, reason: str) -> None:
    with pytest.raises(UnusableInput, match=r"^file\.xml") as caught:
        read(part)
    assert caught.value.reason == reason


def test_an_endless_phase_is_refused() -> None:
    light = LIGHT.replace("20", "1e12", 1)
    with pytest.raises(UnusableInput, match="traffic light 70") as caught:
        read(*approach('<trafficLightRef ref="70"/>'), light, version="2020a")
    assert caught.value.reason == "out-of-range"


@pytest.mark.parametrize("begins", ["1e30", "-1e30", "50", "-40"])
def test_a_cycle_may_begin_any_number_of_cycles_away(begins: str) -> None:
    def shown(offset: str) -> list[int]:
        light = LIGHT.replace("<timeOffset>5<", f"<timeOffset>{offset}<")
        return list(
            read(*approach('<trafficLightRef ref="70"/>'), light, INTERSECTION, version="2020a").signals.state[0].tolist()
        )

    assert shown(begins) == shown(str(int(float(begins)) % 45))


@pytest.mark.parametrize("limit", ["0", "-3", "1e39"])
def test_a_sign_with_a_limit_that_no_road_has_is_refused(limit: str) -> None:
    with pytest.raises(UnusableInput, match=r"sign has the speed limit") as caught:
        read(*approach('<trafficSignRef ref="81"/>'), SIGNS.replace("8.33", limit), version="2020a")
    assert caught.value.reason == "out-of-range"
