"""What would be read as something else is declined: edits, and descriptions, of which one word goes astray."""

import pytest

from drivegen.core.errors import UnusableInput
from drivegen.layouts.spec import MapSpec
from drivegen.words.edits import edited
from drivegen.words.read import read
from tests.words.test_words_read import KMH, declined


@pytest.mark.parametrize(
    ("road", "edit", "why"),
    [
        ("a motorway, 120 km/h", "increase the limit by 10 km/h", "by 10 kmh"),
        ("a motorway, 120 km/h", "reduce the limit by 20 km/h", "by 20 kmh"),
        ("a motorway, 120 km/h", "reduce by 20 km/h", "by 20 kmh"),
        ("a crossing, 50 km/h", "raise the limit 20 km/h", "raise the limit 20 kmh"),
        ("a crossing, 50 km/h", "raise 20 km/h", "raise 20 kmh"),
        ("a motorway, 120 km/h", "lower the limit by 10 km/h", "by 10 kmh"),
        ("a motorway, 120 km/h", "raise the limit by 10 mph", "by 10 mph"),
        ("a motorway, 120 km/h", "add 10 km/h", "add 10 kmh"),
        ("a roundabout with four arms", "reduce the ring limit by 5 km/h", "by 5 kmh"),
        ("a T-junction with a main road and a side road", "add a lane to the side road", "changes at 'side road'"),
        ("a T-junction with a main road and a side road", "add a lane to the stem", "changes at 'stem'"),
        ("a crossing of a main road and a side road", "add a lane to the main road", "changes at 'main road'"),
        ("a crossing", "add a lane to the north arm", "changes at 'arm'"),
        ("a motorway with an off-ramp", "add a lane to the off-ramp", "changes at 'offramp'"),
        ("a diamond interchange", "add a lane to the road above", "changes at 'road above'"),
        ("a roundabout with four arms", "add a lane to the ring", "changes at 'ring'"),
        ("a street with three crossings", "30 km/h at the second crossing", "changes at 'crossing'"),
        ("a street with three crossings", "add a lane at the second crossing", "changes at 'crossing'"),
        ("a motorway with an on-ramp and an off-ramp", "40 km/h on the slip road", "there are several ramps"),
        ("a motorway", "40 km/h on the ramps", "no limit can be set there"),
        ("a grid of 3 by 3", "add a signal at the first junction", "single arms or junctions"),
        ("a crossing", "stop sign on the north arm", "single arms or junctions"),
        ("a motorway fork, 4 lanes split into 2 and 2", "add two lanes", "a branch has at most"),
        ("a curve with a radius of 150 m", "300 m shorter", "bends do not fit"),
        ("a curve with a radius of 150 m", "make the curve tighter", "changes of a bend"),
        ("a T-junction", "right turn lane on the east arm", "who comes over the east arm cannot turn right"),
        ("a motorway", "add a lane gain at 700 m with two lanes", "whether 'two lanes' is of the road"),
        ("a motorway with an off-ramp", "move the second off-ramp to 900 m", "no second 'offramp'"),
        ("a motorway", "add a ramp at 400 m", "an on-ramp or an off-ramp"),
        ("a motorway with two on-ramps", "80 km/h on the on-ramp", "say which 'onramp' is meant"),
        ("a crossing", "80 km/h on the main road", "no 'main road'"),
        ("a crossing", "lanes 3 m wide on the first arm", "of the whole road only"),
        ("a crossing with left-turn lanes", "right-turn lanes instead of left-turn lanes", "'instead'"),
        ("a three-lane motorway", "increase by two lanes", "by two lanes"),
        ("a road with two lanes ahead and one back", "remove a lane", "so many lanes are not there"),
        ("a crossing", "left turn lane and no left turns on the first arm", "the first arm cannot turn left"),
        ("a T-junction", "add a fourth arm", "arms more than there are"),
        ("a motorway", "add an off-ramp 300 m from the end", "counted from the end"),
    ],
)
def test_an_edit_of_something_else_than_is_said_is_declined(road, edit, why):
    with pytest.raises(UnusableInput, match="\ntry: ") as refusal:
        edited(read(road, 7).road, edit)
    assert why in str(refusal.value)


@pytest.mark.parametrize(
    ("edit", "left"),
    [
        ("left-turn lanes at the first crossing", [1, 0, 0]),
        ("left-turn lanes of 40 m at the last crossing", [0, 0, 1]),
        ("left-turn lanes at every crossing", [1, 1, 1]),
        ("no left turns at the first crossing", [0, 0, 0]),
    ],
)
def test_an_edit_at_one_crossing_leaves_the_others(edit, left):
    junctions = edited(read("a street with three crossings", 7).road, edit).road.junctions
    assert [junction.left_turn_lanes for junction in junctions] == left
    assert [bool(junction.turn_bans) for junction in junctions] == ["turns at the" in edit, False, False]


def test_what_is_moved_or_set_by_its_number_leaves_the_others():
    side_roads = read("a street with three side roads 150 m apart", 7).road
    before = [junction.position for junction in side_roads.road.junctions]
    moved = edited(side_roads, "move the second side road 20 m downstream").road.junctions
    assert [junction.position for junction in moved] == [before[0], before[1] + 20, before[2]]
    slower = edited(side_roads, "30 km/h on the third side road").road.junctions
    assert [junction.side_speed for junction in slower] == [50 * KMH, 50 * KMH, 30 * KMH]
    inward = edited(read("a crossing", 7).road, "three lanes in on the first arm").road.arms
    assert [(arm.lanes_in, arm.lanes_out) for arm in inward] == [(3, 1), (1, 1), (1, 1), (1, 1)]


def test_turn_lanes_of_one_side_are_removed_alone():
    road = edited(read("a crossing with left and right turn lanes", 7).road, "remove the left-turn lanes").road
    assert {(arm.left_turn_lanes, arm.right_turn_lanes) for arm in road.arms} == {(0, 1)}


@pytest.mark.parametrize("form", ["cloverleaf", "diamond interchange"])
def test_a_limit_on_the_ramps_is_no_limit_of_the_motorway(form):
    before = read(f"a {form}", 7).road.road
    after = edited(read(f"a {form}", 7).road, "40 km/h on the ramps").road
    assert after == before.model_copy(update={"ramp_speed": 40 * KMH})


def test_a_ramp_is_added_as_it_is_said_and_leaves_the_others_as_they_are():
    before = read("a three-lane motorway, 1.2 km long, with an on-ramp at 200 m", 7).road
    new = edited(before, "add a two-lane off-ramp at 700 m").road
    assert [event.kind for event in new.events] == ["on_ramp", "off_ramp"]
    assert new.events[0] == before.road.events[0]
    assert (new.events[1].position + new.events[1].length, new.events[1].lanes) == (700.0, 2)
    assert new.alignment.length == 1200.0
    limits = [event.ramp_speed for event in edited(MapSpec(road=new), "40 km/h on the ramps").road.events]
    assert limits == [40 * KMH, 40 * KMH]


def test_a_lane_more_on_a_ramp_is_the_ramps():
    road = edited(read("a three-lane motorway with an off-ramp", 7).road, "add a lane on the off-ramp").road
    assert (road.lanes, road.events[0].lanes, road.events[0].keeps) == (3, 2, False)


def test_a_lane_may_end_at_a_place_that_is_said():
    (drop,) = edited(read("a three-lane motorway, 1 km long", 7).road, "the right lane ends after 600 m").road.events
    assert (drop.kind, drop.position, drop.lanes, drop.side) == ("lane_drop", 600.0, 1, "right")


@pytest.mark.parametrize(
    ("edit", "arms", "ring"),
    [
        ("turn it into a roundabout with two lanes", 2, 2),
        ("make it a two-lane roundabout", 1, 2),
        ("turn it into a roundabout with a two-lane ring", 1, 2),
        ("make it a roundabout", 1, 1),
    ],
)
def test_lanes_that_a_new_roundabout_is_said_to_have(edit, arms, ring):
    road = edited(read("a crossing with traffic lights, one lane each way", 7).road, edit).road
    assert (road.kind, road.arms[0].lanes_in, road.ring_lanes) == ("roundabout", arms, ring)


@pytest.mark.parametrize(
    ("edit", "lanes"), [("with two lanes each way", 2), ("add two lanes each way", 3), ("two more lanes each way", 3)]
)
def test_lanes_are_added_only_where_that_is_said(edit, lanes):
    arms = edited(read("a crossing, one lane each way", 7).road, edit).road.arms
    assert {(arm.lanes_in, arm.lanes_out) for arm in arms} == {(lanes, lanes)}


@pytest.mark.parametrize(
    ("road", "edit", "control"),
    [
        ("a crossing with traffic lights", "replace the signals by stop signs", "all_way_stop"),
        ("a crossing with stop signs", "change the stop signs to traffic lights", "signals"),
    ],
)
def test_signs_and_lights_are_replaced(road, edit, control):
    assert edited(read(road, 7).road, edit).road.control == control


def test_nobody_is_told_of_turn_lanes_where_there_is_nowhere_to_turn():
    said = read("a T-junction with left turn lanes", 7)
    assert [arm.left_turn_lanes for arm in said.road.road.arms] == [0, 1, 1]  # the first arm's left is where no road is
    with pytest.raises(UnusableInput, match="who comes over the second arm cannot turn right"):
        read("a T-junction, right turn lane on the second arm", 7)


def test_who_passes_a_junction_does_not_overtake():
    assert "'pass'" in declined("a T-junction, four cars pass from the right")
    assert read("a two-lane motorway, a truck passing the ego", 7).traffic.groups[0].manoeuvre == "overtake"


def test_the_lane_may_be_said_before_the_distance():
    (group,) = read("a two-lane motorway, a stationary vehicle in the ego lane 80 m ahead", 7).traffic.groups
    assert (group.place, group.distance) == ("ahead", 80.0)


@pytest.mark.parametrize(
    "text", ["a crossing, protected left turn lanes on every arm", "a crossing with lights, protected left turns"]
)
def test_protected_turns_are_declined_by_name(text):
    with pytest.raises(UnusableInput, match="protected turns"):
        read(text, 7)


def test_a_lane_that_ends_has_no_ramp_whose_limit_could_be_said():
    assert not any("ramp" in sentence for sentence in read("a motorway with a lane drop", 7).sentences())


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("a crossing, two cars from the left, one from the right", "whether 'one' is among the 2"),
        ("a crossing with signals, a car and a bus at the traffic light", "what 'at the traffic light' belongs to"),
        ("a motorway with an on-ramp at 500 m and 1500 m", "what '1500 m' belongs to"),
        ("a motorway, six cars including the ego", "how many are there beside 'ego'"),
        ("a two-lane motorway, a truck cutting in on a car", "of the target only, not of 'car'"),
        ("a motorway, a car and a bus at 80 km/h", "what 'at 80 kmh' belongs to"),
        ("a motorway, a car behind and a truck in front, both at 80 km/h", "of which 'at 80 kmh'"),
        ("a motorway, a truck ahead, we overtake", "what 'overtake' belongs to"),
        ("a crossing with a car, and we go left", "'go'"),
        ("a road with a bus ahead and a truck behind, both braking hard", "of which 'braking hard'"),
        ("a road with a bus ahead and a truck behind, both are braking hard", "of which 'braking hard'"),
        ("a crossing, a bus ahead and a truck behind, both of them turning right", "of which 'turning right'"),
        ("a bus ahead and a truck behind, both standing still", "of which 'standing still'"),
        ("a car in front and a truck, both 30 m ahead", "of which '30 m ahead'"),
        ("a motorway, ten cars and two trucks, each driving at 80 km/h", "of which 'driving at 80 kmh'"),
        ("a motorway with an on-ramp and an off-ramp, each limited to 40 km/h", "of which 'limited to 40 kmh'"),
        ("a road with a crossing, 300 m before it a roundabout", "'300 m before it'"),
        ("a road with a crossing, 200 m before it a T-junction", "'200 m before it'"),
        ("a roundabout, 100 m before it a crossing, on a road", "'100 m before it'"),
        ("a road with a crossing and a roundabout 100 m before", "'100 m before .'"),
        ("a cloverleaf between three motorways", "two roads meet"),
        ("a cloverleaf between four motorways", "two roads meet"),
        ("a trumpet interchange with three motorways", "two roads meet"),
        ("a cloverleaf with eight ramps", "their number cannot be said"),
        ("a diamond interchange with one off-ramp", "their number cannot be said"),
        ("a diamond interchange with three on-ramps", "their number cannot be said"),
        ("a diamond interchange with two ramps", "their number cannot be said"),
        ("a staggered junction with three side roads", "has two side roads"),
        ("an intersection of three major roads", "there is one main road"),
        ("a junction of two main roads and a side road", "there is one main road"),
        ("an intersection of two major roads", "there is one main road"),
        ("a T-junction of two major roads", "there is one main road"),
        ("a roundabout where a four-lane road meets a two-lane road", "two different numbers of lanes"),
        ("a roundabout where a four-lane road and a two-lane road cross", "two different numbers of lanes"),
        ("a road with two roundabouts 200 m apart, with traffic lights", "neither lights, signs"),
        ("a road with three roundabouts, stop signs", "neither lights, signs"),
        ("a road with three roundabouts, priority to the right", "neither lights, signs"),
        ("a crossing and a roundabout along a road, both with traffic lights", "neither lights, signs"),
        ("a road with two large roundabouts 300 m apart", "a diameter in metres"),
        ("a road with a huge roundabout at 300 m", "a diameter in metres"),
        ("a road with two roundabouts and left-turn lanes", "nor turn lanes"),
        ("a crossing with lights on three arms", "which ones 'three arms'"),
        ("a crossing with stop signs on three arms", "which ones 'three arms'"),
        ("a crossing with left-turn lanes on three arms", "which ones 'three arms'"),
        ("a crossing with two lanes on three arms", "which ones 'three arms'"),
        ("a grid of 5 by 5 blocks of 80 m", "the number of blocks"),
        ("a motorway with a car following a truck", "of the target only"),
        ("the ego follows a truck and turns left", "of whom 'turns left'"),
        ("the ego follows a truck, turning left", "of whom 'turning left'"),
        ("a car behind, driving straight", "of whom 'straight'"),
        ("four vehicles: one ahead, one behind, one on the left, one on the right", "what 'one' belongs to"),
        ("a crossing, a car goes left", "'goes'"),
        ("a crossing, a bus drives to the right", "'drives'"),
        ("a car goes right on a motorway", "'goes'"),
        ("a motorway, a car gets in front of us", "'gets'"),
        ("a road with an oncoming car passing us", "begins behind the target, not oncoming"),
        ("a road with an oncoming truck that passes us", "begins behind the target, not oncoming"),
        ("a motorway with a car ahead overtaking us", "begins behind the target, not ahead"),
        ("a motorway with a car ahead that brakes", "'brakes'"),
        ("a crossing with a two-way left turn lane", "from both directions"),
        ("three crossings in a row, only the first one has no lights", "what the others have"),
        ("a road with three connecting roads", "three connecting roads"),
        ("two parallel streets and three roads", "parallel"),
        ("a road with three turnings", "'turnings'"),
        ("a curved road with a roundabout at 100 m and 300 m east of it a crossing", "in which direction"),
        ("a motorway with two roads joining it", "what 'two roads joining it' belongs to"),
        ("a motorway with an exit on each side and an entrance", "what 'on each side' belongs to"),
        ("a motorway with an exit, an entrance, and 300 m after the exit a lane ends", "what lies '300 m after the exit'"),
        ("a T-junction with stop signs on all three arms", "which ones 'three arms'"),
        ("two crossings in a row, the middle one has lights", "no 'middle one'"),
        ("a star-shaped junction with four arms", "five arms or more"),
        ("a narrow mountain road with hairpins", "how many hairpins"),
        ("three roads that meet at 60 degrees", "120 degrees each, not 60"),
        ("two crossings on a road, the first with a side road on the left", "not 'side road'"),
        ("a motorway with an on-ramp at 400 m in both directions", "'the same in both directions'"),
        ("a two-lane motorway, in both directions a lane ends at 500 m", "'the same in both directions'"),
    ],
)
def test_a_description_of_something_else_than_is_said_is_declined(text, why):
    assert why in declined(text)


@pytest.mark.parametrize(
    ("text", "does"),
    [
        ("a crossing with a bus, we turn left", "turn_left"),
        ("a crossing with a bus ahead, I turn right", "turn_right"),
        ("a motorway with a bus, we change to the left lane", "change_left"),
    ],
)
def test_what_we_do_is_done_by_the_target(text, does):
    traffic = read(text, 7).traffic
    assert (traffic.target_does, [group.manoeuvre for group in traffic.groups]) == (does, [None])


@pytest.mark.parametrize("text", ["a motorway with a lead truck and five cars", "a motorway with a lead bus braking hard"])
def test_a_lead_vehicle_is_ahead(text):
    assert read(text, 7).traffic.groups[0].place == "ahead"


@pytest.mark.parametrize(
    "text",
    [
        "roadworks on a motorway: three lanes reduced to one, 80 km/h",
        "two intersections in a row, the first with traffic lights and the second without",
    ],
)
def test_what_the_offer_holds_is_not_said_to_be_left_out(text):
    assert "Left out" not in declined(text)
