"""Descriptions in many people's words: what belongs to what, negation, spelling, and edits in other words than ours."""

from typing import Any

import pytest

from drivegen.errors import UnusableInput
from drivegen.maps.examine import examine
from drivegen.maps.overlaps import overlapping
from drivegen.maps.refine import refine
from drivegen.maps.spec import MapSpec
from drivegen.maps.spec_crossings import Crossing
from drivegen.maps.spec_highways import Fork, Highway, Interchange
from drivegen.maps.spec_streets import Corridor
from drivegen.maps.writers.offline import Plugin
from drivegen.sumo.network import read_network

KMH = 1 / 3.6


def specified(text: str) -> MapSpec:
    spec = Plugin().write(text, 7).spec
    assert isinstance(spec, MapSpec)
    return spec


def written(text: str) -> Any:
    return specified(text).road


def pair(road: Crossing) -> tuple[int, int]:
    """Lanes of the first two arms: of the main and the other road of a crossing, of a T's bar and stem."""
    stem = 2 if len(road.arms) == 3 else 1
    return road.arms[0].lanes_in, road.arms[stem].lanes_in


@pytest.mark.parametrize(
    ("text", "lanes"),
    [
        ("A signalised T-junction, three lanes on the main road, two on the side road", (3, 2)),
        ("crossroads: the north-south road has two lanes each way and the east-west road one, lights", (2, 1)),
        ("intersection of a 4 lane avenue and a 2 lane street, signalized", (2, 1)),
        ("minor street meets major street, minor is stop-controlled, major has two lanes each way, minor one", (2, 1)),
        ("A T. The road that goes straight has 3 lanes per direction, the one that ends has a single lane", (3, 1)),
        ("丁字路口，有红绿灯，主路三车道，支路一车道", (3, 1)),
    ],
)
def test_lanes_belong_to_the_road_that_they_are_said_of(text: str, lanes: tuple[int, int]) -> None:
    assert pair(written(text)) == lanes


@pytest.mark.parametrize(
    ("text", "main", "ramp"),
    [
        ("Autobahn, drei Spuren, 120 km/h, mit Auffahrt", 120, None),
        ("cars enter the 2-lane motorway by a ramp; limit on the ramp is 60 and 120 on the motorway", 120, 60),
        ("an expressway, 100 km/h, with a two-lane on-ramp (60 km/h)", 100, 60),
    ],
)
def test_limits_belong_to_the_road_that_they_are_said_of(text: str, main: int, ramp: int | None) -> None:
    road = written(text)
    assert road.speed == pytest.approx(main * KMH)
    assert ramp is None or road.events[0].ramp_speed == pytest.approx(ramp * KMH)


@pytest.mark.parametrize(
    ("text", "control"),
    [
        ("3-leg intersection, TWSC, major street 2 lanes each way", "stop"),
        ("AWSC four leg intersection", "all_way_stop"),
        ("four-way intersection, no lights, no signs", "uncontrolled"),
        ("T-junction without stop signs or lights", "uncontrolled"),
        ("crossroads, no roundabout, with traffic lights", "signals"),
        ("4 way intersecton with trafic lights", "signals"),
    ],
)
def test_control_in_many_words(text: str, control: str) -> None:
    assert written(text).control == control


def test_what_happens_along_a_road_lies_where_it_is_said() -> None:
    ramps = written("motorway with an exit at 300 m and an entry at 900 m")
    assert [(e.kind, e.position) for e in ramps.events] == [("off_ramp", 300), ("on_ramp", 900)]
    row = written("first a signalised T junction, 200 m later an unsignalised crossroads")
    assert isinstance(row, Corridor)
    assert [j.control for j in row.junctions] == ["signals", "yield"]
    assert row.junctions[1].position - row.junctions[0].position == 200


def test_branches_and_roads_that_become_one_have_the_lanes_said() -> None:
    fork = written("the road forks: two lanes go left, one lane goes right")
    assert isinstance(fork, Fork)
    assert (fork.left_lanes, fork.right_lanes, fork.lanes) == (2, 1, 3)
    both = specified("two motorways merge into one")
    assert isinstance(both.road, Fork)
    assert both.road.joins
    assert all(c.passed for c in examine(both).checks)


@pytest.mark.parametrize("left_hand", [False, True])
@pytest.mark.parametrize("form", ["diamond", "half_diamond", "side", "terminal"])
def test_an_interchange_is_as_asked_and_its_bridge_is_no_junction(form: Any, left_hand: bool) -> None:
    examined = examine(MapSpec(road=Interchange(form=form), left_hand=left_hand))
    assert all(c.passed for c in examined.checks)
    assert examined.structure.junctions == {"diamond": 2, "half_diamond": 2, "side": 1, "terminal": 1}[form]


def test_a_bridge_too_low_would_be_found() -> None:
    network = examine(MapSpec(road=Interchange())).network
    assert overlapping(network, "map") == ()
    assert overlapping(network.replace(b",6.00", b",1.00"), "map") != ()


@pytest.mark.parametrize("text", ["a T-junction in a tunnel", "stack interchange", "a roundabout with zero arms", "flyover"])
def test_what_is_not_drawn_is_refused(text: str) -> None:
    with pytest.raises(UnusableInput):
        written(text)


def test_where_traffic_keeps_left_the_outermost_lane_has_no_left_neighbour() -> None:
    for left_hand in (False, True):
        spec = MapSpec(road=Corridor(lanes=2, lanes_back=2), left_hand=left_hand)
        roads = read_network(examine(spec).network, "map")
        kerb = 0 if left_hand else 1
        assert (roads.neighbour[:, kerb] == -1).sum() == 2
        assert (roads.neighbour[:, 1 - kerb] != -1).all()
        assert roads.same_direction[roads.neighbour[:, kerb] == -1, 1 - kerb].all()


@pytest.mark.parametrize(
    ("edit", "events"),
    [
        ("shift the on-ramp 150 m downstream", [("on_ramp", 400)]),
        ("the entry should be 50 metres further upstream", [("on_ramp", 200)]),
        ("remove the ramp", []),
        ("add an off-ramp after the on-ramp", [("on_ramp", 250), ("off_ramp", 570)]),
    ],
)
def test_ramps_are_edited_in_other_words(edit: str, events: list[tuple[str, float]]) -> None:
    road = refine(specified("a motorway with two lanes and an on-ramp"), edit)[0].road
    assert isinstance(road, Highway)
    assert [(e.kind, e.position) for e in road.events] == events
    assert road.lanes == 2
