"""Traffic as engineers type it, beside the plain sentence that means the same."""

import pytest

from drivegen.core.errors import UnusableInput
from drivegen.words.read import read


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("a bus ahead and two other cars", "There is 1 bus ahead of the target vehicle. There are 2 cars."),
        ("two cars follow the ego", "There are 2 cars behind the target vehicle."),
        ("a truck following us", "There is 1 truck behind the target vehicle."),
        ("we follow a delivery truck", "There is 1 truck ahead of the target vehicle."),
        ("the ego follows two cars", "There are 2 cars ahead of the target vehicle."),
        ("the ego is behind a city bus", "There is 1 bus ahead of the target vehicle."),
        ("a van comes from the left", "There is 1 car coming from the left of the target vehicle."),
        ("a car that approaches from the right", "There is 1 car coming from the right of the target vehicle."),
        ("a car next to us on the left", "There is 1 car on the left of the target vehicle."),
        ("a truck in the adjacent right lane", "There is 1 truck on the right of the target vehicle."),
        ("a truck in the right lane", "There is 1 truck on the right of the target vehicle."),
        ("a car 30 m ahead in the left lane", "There is 1 car 30 m ahead on the left of the target vehicle."),
        ("cut-in from the left", "There is 1 vehicle coming from the left of the target vehicle cutting in."),
        ("somebody overtakes us", "There is 1 vehicle overtaking the target."),
        ("a bus from the right goes straight", "There is 1 bus coming from the right going straight over the junction."),
        ("an oncoming car that continues straight ahead", "There is 1 car oncoming going straight over the junction."),
        ("our car goes straight on", "The target is going straight over the junction."),
        ("four cars, two ahead, two behind", "There are 2 cars ahead. There are 2 cars behind."),
        (
            "preceding vehicle 40 m ahead doing 60 km/h, ego at 80 km/h",
            "There is 1 vehicle 40 m ahead driving at 60 km/h. The target is driving at 80 km/h.",
        ),
    ],
)
def test_what_engineers_type_is_what_is_said_plainly(text, plain):
    words, same = read(text, 7), read(plain, 7)
    assert words.road is None
    assert words.traffic == same.traffic


@pytest.mark.parametrize(
    "text",
    [
        "a three-lane motorway, a truck in the right lane",
        "a three-lane motorway, a truck 30 m ahead in the right lane",
        "a two-lane motorway with a truck in the right lane and a car in the left lane",
        "a crossing with three lanes in each direction, a car ahead in the left lane",
    ],
)
def test_the_left_lane_of_more_than_two_is_not_left_of_the_target(text):
    with pytest.raises(UnusableInput, match="in which lane the target is"):
        read(text, 7)


@pytest.mark.parametrize("so", ["a bus behind does too", "so does the bus behind", "the bus behind does", "the bus behind too"])
def test_what_another_does_too_is_not_left_out(so):
    with pytest.raises(UnusableInput, match=r"I do not read '(does|too)'"):
        read(f"the ego turns left, {so}", 7)
    assert read("can you do a crossroads with left-turn lanes too?", 7).road is not None


@pytest.mark.parametrize("does", ["turns left", "goes straight on", "turns left across our path"])
@pytest.mark.parametrize("road", ["a two-lane road", "a motorway with an on-ramp"])
def test_nobody_turns_or_crosses_where_the_road_has_no_junction(road, does):
    with pytest.raises(UnusableInput, match="the road that is described has none"):
        read(f"{road}, a car {does}", 7)
    assert read(f"a street with two crossings, a car {does}", 7).traffic.manoeuvres


def test_the_targets_speed_is_not_the_traffics():
    traffic = read("ego at 110 km/h, traffic at 90 km/h", 7).traffic
    assert (traffic.target_speed, traffic.speed) == (pytest.approx(110 / 3.6), pytest.approx(90 / 3.6))


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("3 -> 2 lane drop on a motorway", "3 to 2 lane drop on a motorway"),
        (
            "a motorway fork: four lanes into two and two",
            "a motorway fork of four lanes, two lanes to the left and two to the right",
        ),
        ("a road with two car lanes in each direction", "a road with two lanes in each direction"),
        (
            "a crossroads with three lanes per direction east-west and two lanes per direction north-south",
            "a crossing, the east-west road has three lanes per direction, the north-south road has two lanes per direction",
        ),
    ],
)
def test_short_forms_of_roads_are_read(text, plain):
    assert read(text, 7, "same").road == read(plain, 7, "same").road
