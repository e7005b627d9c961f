"""Descriptions read whole or declined: by name, with the words that nothing reads, and with a sentence to try."""

import time

import pytest

from drivegen.core.errors import UnusableInput
from drivegen.words.edits import edited
from drivegen.words.facts import contradicted, facts
from drivegen.words.read import read
from drivegen.words.request import Density, Kind, Manoeuvre

KMH = 1 / 3.6


def declined(text: str) -> str:
    with pytest.raises(UnusableInput) as refusal:
        read(text, 7)
    message, _, offer = str(refusal.value).rpartition("\ntry: ")
    words = read(offer, 7)
    assert words.road is not None or words.traffic
    return message


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("a 2+1 road", "+"),
        ("a cul-de-sac on Oak Street", "oak"),
        ("a car runs the red light", "running a red light"),
        ("a crossroads with pedestrians", "pedestrians"),
        ("five cars are queueing at the traffic light ahead of me", "no road with traffic lights"),
        ("a roundabout with a car waiting at the stop line", "no road with traffic lights"),
        ("a T-junction with dense traffic on the main road", "main road"),
        ("a motorway with two lane drops, four lanes narrow to three", "one event or several"),
        ("a motorway that loses a lane; the right lane ends", "one event or several"),
        ("a street with a bus lane", "bus lanes"),
        ("a motorway, on-ramp from the left", "ramps on the left"),
        ("a motorway in a tunnel", "tunnels"),
        ("a motorway with -2 lanes", "-"),
        ("a motorway, 1e9 m/s", "1e9"),
        ("a street with three lanes", "in total"),
        ("a T-junction with four arms", "contradict"),
        ("a straight road with a hairpin", "straight"),
        ("a crossroads with traffic lights and no traffic lights", "ruled out"),
        ("eine Kreuzung mit Ampel und zwei Spuren", "English"),
        ("", "empty"),
    ],
)
def test_what_cannot_be_read_is_declined_by_name_with_a_sentence_to_try(text, word):
    assert word in declined(text)


@pytest.mark.parametrize(
    ("text", "lanes"),
    [
        ("a two-lane country road", (1, 1)),
        ("a four-lane road", (2, 2)),
        ("a road with three lanes in each direction", (3, 3)),
        ("a road with four lanes in total", (2, 2)),
        ("a one-way street with two lanes", (2, 0)),
        ("a road with two lanes in one direction and one in the other", (2, 1)),
    ],
)
def test_lanes_are_counted_by_one_convention(text, lanes):
    road = read(text, 7).road.road
    assert (road.lanes, road.lanes_back) == lanes


@pytest.mark.parametrize(
    ("text", "events"),
    [
        ("The highway gains a lane: two lanes become three.", [("lane_gain", "right")]),
        ("a motorway where the left lane ends: three lanes become two", [("lane_drop", "left")]),
        ("a motorway with a lane drop on the left, where three lanes become two", [("lane_drop", "left")]),
        ("a motorway where a lane is added and then another lane is added", [("lane_gain", "right")] * 2),
        ("a motorway that gains a lane and loses a lane", [("lane_gain", "right"), ("lane_drop", "right")]),
        ("a motorway: four lanes narrow to three, then three lanes narrow to two", [("lane_drop", "right")] * 2),
    ],
)
def test_an_event_that_two_phrases_speak_of_happens_once(text, events):
    assert [(event.kind, event.side) for event in read(text, 7).road.road.events] == events


def test_who_stands_at_a_light_stands_at_one_that_is_there():
    words = read("a crossroads with traffic lights, five cars are queueing at the light", 7)
    assert words.road.road.control == "signals"
    assert (words.traffic.groups[0].queue, words.traffic.groups[0].speed) == (True, 0.0)
    assert read("a truck turning left at the intersection", 7).road.road.kind == "crossing"


def test_facts_belong_to_what_their_scope_names():
    road = read("T-junction: three lanes on the main road and two on the side road, 30 km/h on the side road", 7)
    assert road.road is not None
    arms = road.road.road.arms
    assert [arm.lanes_in for arm in arms] == [3, 3, 2]
    assert [arm.speed for arm in arms] == pytest.approx([50 * KMH, 50 * KMH, 30 * KMH])
    half = read("a motorway, 1/2 mile long", 7).road.road
    assert half.alignment.length == pytest.approx(804.672)


def test_traffic_never_reaches_the_road():
    words = read("a crossroads with a car turning left and two trucks, one of them cutting in, heavy traffic", 7)
    assert words.road.road.kind == "crossing"
    assert [(g.count, g.kind, g.manoeuvre) for g in words.traffic.groups] == [
        (1, Kind.CAR, Manoeuvre.TURN_LEFT),
        (1, Kind.TRUCK, None),
        (1, Kind.TRUCK, Manoeuvre.CUT_IN),
    ]
    assert words.traffic.density is Density.DENSE
    assert read("a straight road, no cars", 7).traffic.density is Density.NONE
    ahead = read("a truck ahead at 80 km/h", 7).traffic.groups[0]
    assert (ahead.place.value, ahead.speed) == ("ahead", pytest.approx(80 * KMH))


def test_an_edit_is_scoped_or_declined():
    spec = read("a T-junction with a main road and a side road", 7).road
    arms = edited(spec, "30 km/h on the side road").road.arms
    assert [arm.speed for arm in arms] == pytest.approx([50 * KMH, 50 * KMH, 30 * KMH])
    assert len(edited(spec, "make it a roundabout").road.arms) == 3
    for edit in ("sing me a song", "add an on-ramp", "remove the traffic lights", "a pedestrian crossing"):
        with pytest.raises(UnusableInput, match="\ntry: "):
            edited(spec, edit)


def test_a_models_specification_is_held_against_the_texts_numbers():
    said = facts("My favourite motorway has four lanes in each direction, honestly, and 130 km/h.")
    assert {name for _, name, _, _ in said} >= {"lanes_each", "speed"}
    right = read("a motorway with four lanes in each direction, 130 km/h", 7).road
    wrong = read("a motorway with three lanes in each direction, 100 km/h", 7).road
    assert contradicted(said, right) == []
    assert len(contradicted(said, wrong)) == 2


def test_long_nonsense_is_declined_soon():
    began = time.process_time()
    declined("two lanes in each direction at the crossing with a song " * 35)
    assert time.process_time() - began < 5.0
