"""Descriptions read whole or declined: by name, with the words that nothing reads, and with a sentence to try."""

import pytest

from drivegen.core.errors import UnusableInput
from drivegen.words.edits import edited
from drivegen.words.facts import contradicted, facts
from drivegen.words.read import covers_of, read
from drivegen.words.request import Density, Kind, Manoeuvre
from drivegen.words.tokens import tokenise
from tests.timing import cpu_seconds, yardstick

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
        ("a crossroads with people on foot", "pedestrians"),
        ("five cars are queueing at the traffic light ahead of me", "no road with traffic lights"),
        ("a roundabout with a car waiting at the stop line", "no road with traffic lights"),
        ("a T-junction with dense traffic on the main road", "main road"),
        ("a motorway with two lane drops, four lanes narrow to three", "one event or several"),
        ("a motorway that loses a lane; the right lane ends", "one event or several"),
        ("a street with a bus lane", "bus lanes"),
        ("a country road with one lane each way that widens to two lanes per direction", "of highways only"),
        ("a dual carriageway with a T-junction", "say what the other road is like"),
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
        ("a motorway with an on-ramp after 500 m and an off-ramp after 1200 m", "two ways"),
        ("an intersection with a one-way street", "other road"),
        ("five cars and a truck ahead of me on a motorway", "'cars', too"),
        ("25 cars on a motorway, and the car ahead of me brakes hard", "among 'cars'"),
        ("off ramp from a motorway with 4 lanes per direction, one exit, 60 mph", "exit"),
        ("a street with side streets", "say how many"),
        ("a motorway with on-ramps", "say how many"),
        ("a residential street with four side streets, two on each side", "of what there are so many"),
        ("a roundabout where a two-lane road meets three single-lane roads", "how many arms"),
        ("a signalised crossroads between two roundabouts", "in which order"),
        ("a crossing with four lanes on each approach including two left-turn lanes", "of what there are so many"),
        ("a road with roundabouts every 300 m", "say how many"),
        ("a road with a crossing every 200 m", "say how many"),
        ("a street with a side street every 80 m", "say how many"),
        ("a motorway with an on-ramp every 500 m", "say how many"),
        ("a residential area with cul-de-sacs", "say how many"),
        ("a motorway with a ramp limit of 40 km/h", "no ramp"),
        ("a crossroads with three lanes on the northbound approach", "northbound"),
        ("an intersection of a three-lane road and a two-lane road", "each direction"),
        ("a 3 by 4 grid with 10 intersections", "rows by columns"),
        ("a motorway with an off-ramp and a lane drop 200 m before the off-ramp", "200 m before"),
        ("five cars at a traffic light at a crossroads", "at a traffic light"),
        ("a coach on a country road and three cars behind it", "of the target only"),
        ("three cars behind the bus on a road", "of the target only"),
        ("three cars behind a bus on a road", "of the target only"),
        ("a car overtaking two trucks on a motorway", "of the target only"),
        ("a car cuts in in front of a truck on a motorway", "of the target only"),
        ("a truck turning left in front of one oncoming car at a crossroads", "of the target only"),
        ("a diamond interchange, the freeway over an arterial", "'over'"),
        ("two crossroads and two traffic lights", "at which crossing"),
        ("five lanes go on for 300 m and then drop to four", "'300 m'"),
        ("a T-junction with two lanes on the left arm", "'two lanes'"),
        ("ten vehicles, three trucks and seven cars on a motorway", "or as many more"),
        ("a motorway with four cars and another behind me", "of what other one"),
        ("a grid of streets 200 m long", "'200 m long'"),
        ("a roundabout of 40 m", "the diameter of the roundabout or the length of its arms"),
        ("a road with a limit of 30 km/h for 200 m", "for '200 m'"),
        ("a skewed crossroads", "which angle"),
        ("a crossroads with dual left-turn lanes", "2 lanes to turn into"),
        ("the main road has 3 m lanes at a T-junction with a side road", "3 m lanes"),
        ("a T-junction with right turn only from the side road", "turn bans"),
        ("lane drop from two lanes to four lanes", "is no lane drop"),
        ("a motorway where two lanes narrow to four", "says the opposite of 2 to 4 lanes"),
        ("a road that is 0 metres long", "nothing that could be drawn"),
        ("a main road with a side road with one lane", "crosses the main road or ends at it"),
        ("two north-south streets cross two east-west streets", "crossing of two roads"),
        ("one-way street with two lanes in each direction", "no lanes in the other direction"),
        ("a single-lane roundabout with three lanes in the ring", "two numbers of lanes"),
        ("grid of zero by zero blocks", "a block at least"),
        ("an urban street crossing a two-way street, stop signs on the two-way street", "which one 'street' is"),
        ("an intersection with six arms, 3 lanes on the main road and 1 lane on the side road", "by their numbers"),
        ("a street with four crossings, every second one signalised", "which ones every"),
        ("a crossing; the north-south road has priority and the east-west road has priority", "not both"),
    ],
)
def test_what_cannot_be_read_is_declined_by_name_with_a_sentence_to_try(text, word):
    assert word in declined(text)


@pytest.mark.parametrize(
    ("text", "lanes"),
    [
        ("a two-lane country road", (1, 1)),
        ("a single-lane road", (1, 1)),
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


@pytest.mark.parametrize(
    ("text", "places"),
    [
        ("a motorway with an on-ramp at 500 m and an off-ramp at 1200 m", [500.0, 1200.0]),
        ("At 600 m an on-ramp joins the motorway. 700 m after it an exit leaves.", [600.0, 1300.0]),
        ("a motorway with an off-ramp after 500 m", [500.0]),
        ("a motorway with an on-ramp and 700 m later an off-ramp", [250.0, 950.0]),
    ],
)
def test_places_along_a_motorway_are_where_ramps_join_and_leave(text, places):
    events = read(text, 7).road.road.events
    assert [event.position + event.length * (event.kind == "off_ramp") for event in events] == places


def test_a_place_before_its_noun_is_of_that_noun():
    junctions = read("a road with a roundabout, then after 350 m a T-junction", 7).road.road.junctions
    assert [junction.form for junction in junctions] == ["roundabout", "crossing"]
    assert junctions[1].position - junctions[0].position == 350.0


@pytest.mark.parametrize(
    ("text", "sides"),
    [
        ("a rural two-lane road with a side road on the left", [("left",)]),
        ("a main road with a side road on the right and traffic lights", [("right",)]),
        (
            "a road with a side road on the left 100 m from the start, and a side road on the right 200 m later",
            [("left",), ("right",)],
        ),
    ],
)
def test_a_road_may_have_a_side_road_on_one_side(text, sides):
    assert [junction.sides for junction in read(text, 7).road.road.junctions] == sides


@pytest.mark.parametrize(
    ("text", "has", "lacks"),
    [
        ("a motorway portion with three lanes and an on-ramp after 500 m", ("3 lanes", "500 m"), ()),
        ("a motorway without an off-ramp at its end", ("motorway",), ("off-ramp",)),
        ("a street with three crossings, the second of which has lights", ("3 crossings",), ("traffic lights",)),
        ("an intersection with an eastbound one-way street", ("crossing",), ("lanes in", "lanes out", "one-way")),
        ("a railway crossing with barriers on a road", ("road",), ("60 km/h", "2 lanes")),
        ("a six-lane highway", ("3 lanes in each direction",), ("6 lanes",)),
        ("a street with four lanes", ("2 lanes in each direction",), ("4 lanes",)),
        ("a crossing with lights, two cars go straight and one turns left", ("2 cars",), ("turning",)),  # one of them would
        ("eight cars, zero of them turning left", ("8 cars",), ("turning",)),
        ("five cars on a motorway, the second one brakes hard", ("5 cars",), ("braking",)),
        ("a motorway, a car behind a truck", ("1 car", "1 truck"), ("behind",)),
        ("a road with eight cars, one of them overtakes a truck", ("7 cars", "1 truck"), ("overtaking",)),
        ("two crossings in a row, the middle one has lights", ("2 crossings",), ("lights",)),
        ("a road with a 300 m long tunnel and two left-turn lanes", ("road",), ("300",)),
        ("two left-turn lanes", ("crossing", "left-turn lanes"), ()),  # of nothing that is named: an example that has some
    ],
)
def test_an_offer_holds_what_was_read_and_nothing_that_was_not(text, has, lacks):
    with pytest.raises(UnusableInput) as refusal:
        read(text, 7)
    offer = str(refusal.value).rpartition("\ntry: ")[2]
    assert all(words in offer for words in has)
    assert not any(words in offer for words in lacks)


def test_several_vehicles_that_do_something_do_it_each():
    groups = read("two cars turning left at a crossroads", 7).traffic.groups
    assert [(group.count, group.manoeuvre) for group in groups] == [(1, Manoeuvre.TURN_LEFT)] * 2
    queue = read("a queue of five cars ahead of me at a crossroads", 7).traffic.groups
    assert [(group.count, group.place.value, group.queue) for group in queue] == [(5, "ahead", True)]
    ahead = read("two cars ahead of me, one of them brakes hard", 7).traffic.groups
    assert [group.place.value for group in ahead] == ["ahead", "ahead"]
    truck = read("Truck ahead of the ego at 25 m, motorway, two lanes.", 7)
    assert truck.traffic.groups[0].distance == 25.0
    assert truck.road.road.alignment.length > 500.0


def test_who_stands_at_a_light_stands_at_one_that_is_there():
    words = read("a crossroads with traffic lights, five cars are queueing at the light", 7)
    assert words.road.road.control == "signals"
    assert (words.traffic.groups[0].queue, words.traffic.groups[0].speed) == (True, 0.0)
    assert read("a truck turning left at the intersection", 7).road.road.kind == "crossing"


@pytest.mark.parametrize(
    ("text", "left", "right", "pocket"),
    [
        ("a T-junction, right-turn pocket 50 m long on the main road", 0, 1, 50.0),
        ("a crossroads with a left-turn pocket of 150 ft", 1, 0, 45.72),
        ("a crossroads with left and right turn lanes of 40 m", 1, 1, 40.0),
    ],
)
def test_a_length_behind_turn_lanes_is_theirs_on_their_side(text, left, right, pocket):
    arm = read(text, 7).road.road.arms[0]
    assert (arm.left_turn_lanes, arm.right_turn_lanes, arm.pocket) == (left, right, pytest.approx(pocket))
    assert arm.length > 100.0


def test_the_length_of_a_road_is_that_of_both_its_arms():
    arms = read("a crossing of a 600 m long main road with a side road 100 m long", 7).road.road.arms
    assert [arm.length for arm in arms] == [300.0, 50.0, 300.0, 50.0]
    stem = read("a T-junction with a main road and a side road 80 m long", 7).road.road.arms[2]
    assert stem.length == 80.0


def test_lanes_between_an_article_and_a_noun_are_of_that_noun():
    arms = read("a crossing of a 5-lanes-per-direction arterial with a 2-lanes-per-direction avenue", 7).road.road.arms
    assert [arm.lanes_in for arm in arms] == [5, 2, 5, 2]
    assert read("a motorway that forks into two motorways, two lanes each", 7).road.road.left_lanes == 2


def test_a_road_that_is_named_again_is_the_same():
    road = read("a side road joins a main road, side road 30 km/h", 7).road.road
    assert (road.kind, road.arms[2].speed) == ("crossing", pytest.approx(30 * KMH))


@pytest.mark.parametrize(
    ("text", "gap"),
    [
        ("a T-junction and, 250 m further, a four-way crossing", 250.0),
        ("two roundabouts connected by a road of 500 m", 500.0),
        ("an arterial with three traffic lights 300 m apart", 300.0),
    ],
)
def test_junctions_are_as_far_apart_as_it_is_said(text, gap):
    junctions = read(text, 7).road.road.junctions
    assert junctions[1].position - junctions[0].position == gap


def test_one_of_several_is_told_by_its_number():
    junctions = read("a street with three crossings, the second one signalised", 7).road.road.junctions
    assert [junction.control for junction in junctions] == ["yield", "signals", "yield"]


def test_what_a_third_set_of_lines_had_wrong_is_right():
    assert read("one carriageway of a motorway, 2 lanes, with an exit slip road", 7).road.road.carriageways == 1
    grid = read("a grid: four north-south streets crossing three east-west streets", 7).road.road
    assert (grid.rows, grid.columns) == (3, 4)
    arms = read("an arterial with 3 lanes per direction crossing another arterial, 50 mph limit", 7).road.road.arms
    assert {arm.speed for arm in arms} == {50 * 0.44704}
    arms = read("a four-lane one-way avenue crossed by a two-way street", 7).road.road.arms
    assert [arm.lanes_in for arm in arms] == [4, 1, 0, 1]


def test_turns_are_banned_where_it_is_said():
    def bans(text):
        return [arm.turn_bans for arm in read(text, 7).road.road.arms]

    assert bans("a crossroads, no left turns") == [("left",)] * 4
    assert bans("a T-junction of a main road and a side road, no left turn from the side road") == [(), (), ("left",)]
    assert bans("a T-junction, no left turn into the side road") == [("left",), ("left",), ()]
    assert bans("a crossroads with no right turns on the main road") == [("right",), (), ("right",), ()]
    row = read("a road with two side streets, left turns from the side streets are not allowed", 7).road.road.junctions
    assert [(junction.turn_bans, junction.side_turn_bans) for junction in row] == [((), ("left",))] * 2


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
    ramps = edited(read("a motorway with two on-ramps and an off-ramp", 7).road, "remove the last on-ramp").road.events
    assert [event.kind for event in ramps] == ["on_ramp", "off_ramp"]
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


def test_turn_lanes_bans_lane_widths_and_sizes_are_held_against_a_specification():
    text = "a crossroads with three lanes per direction, two left-turn lanes, no right turns, lanes 3 m wide"
    said = facts(text)
    assert contradicted(said, read(text, 7).road) == []
    told = " ".join(contradicted(said, read("a crossroads with three lanes per direction", 7).road))
    assert all(words in told for words in ("two left turn lanes", "no right turns", "lanes 3 m wide"))
    assert len(contradicted(facts("a 3 by 4 grid"), read("a 3 by 3 grid", 7).road)) == 1


@pytest.mark.parametrize(
    "text",
    [
        "signalised crossing, then a T-junction, then another signalised crossing",
        "main road with four side streets, alternating left and right and well spaced out, stop signs on the side streets",
    ],
)
def test_long_ambiguous_texts_are_read_soon(text):
    assert cpu_seconds(lambda: declined(text), times=2) < 15 * yardstick()  # about 4; one may collect garbage


def test_covers_that_differ_in_silent_words_are_one():
    covers = covers_of(tokenise("signalised crossing, then a roundabout, then another signalised crossing"))
    readings = [tuple((item.phrase, item.values) for item in cover.items if item.phrase is not None) for cover in covers]
    assert len(set(readings)) == len(readings) > 1


def test_long_nonsense_is_declined_soon():
    text = "two lanes in each direction at the crossing with a song " * 35
    assert cpu_seconds(lambda: declined(text)) < 20 * yardstick()


@pytest.mark.parametrize(
    "text", ["a main road crossed by three side streets", "avenue crossed by three streets, lights at each crossing"]
)
def test_streets_that_cross_a_road_cross_it_one_after_another(text):
    road = read(text, 7).road.road
    assert [junction.sides for junction in road.junctions] == [("left", "right")] * 3


def test_blocks_lie_between_streets():
    road = read("a grid of 2 by 3 city blocks", 7).road.road
    assert (road.rows, road.columns) == (3, 4)


def test_a_number_that_no_float_holds_is_not_read():
    assert "I do not read" in declined(f"a road of {'9' * 400} m")
    assert "I do not read" in declined("a road of 500/00 m")


def test_a_2_plus_1_road_is_declined_by_its_name():
    assert "2+1 roads ('2 + 1 road') cannot be drawn" in declined("a rural 2+1 road, 100 km/h")
