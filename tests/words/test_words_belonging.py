"""Of which road, approach or vehicle something is said: what stands nearest is not always what is meant."""

import pytest

from drivegen.words.read import read
from tests.words.test_words_read import KMH, declined


@pytest.mark.parametrize(
    ("text", "main"),
    [("the north-south road has priority", [False, True, False, True]), ("the east-west road has priority", [True, False] * 2)],
)
def test_one_of_two_roads_has_priority(text, main):
    assert [arm.main for arm in read(f"a four-way intersection in which {text}", 7).road.road.arms] == main


def test_turns_are_banned_from_the_road_that_has_priority():
    text = "a crossroads; the north-south road has priority and three lanes each way; no left turns from the main road"
    arms = read(text, 7).road.road.arms
    assert [(arm.main, arm.lanes_in, arm.turn_bans) for arm in arms] == [(False, 3, ()), (True, 3, ("left",))] * 2


def test_one_more_on_the_other_side_is_of_the_same_kind():
    sides = [
        crossing.sides
        for crossing in read("a street with two side roads on the left and one on the right", 7).road.road.junctions
    ]
    assert sides == [("left",), ("left",), ("right",)]
    assert "'one on the right'" in declined("a road with four crossings, one on the right")


def test_turn_lanes_named_beside_the_lights_are_of_the_crossing():
    arms = read("a six-lane arterial crossing a four-lane road with signals and left-turn bays", 7).road.road.arms
    assert [arm.left_turn_lanes for arm in arms] == [1] * 4


def test_words_that_say_nothing_stand_between_an_adjective_and_its_noun():
    arms = read("an intersection of a six-lane arterial and a two-lane local road with signals", 7).road.road.arms
    assert [arm.lanes_in for arm in arms] == [3, 1, 3, 1]


def test_a_limit_before_the_cars_is_the_roads():
    for cars in ("and five cars", "and moderate traffic of about 20 cars", "five cars"):
        road = read(f"a motorway with an on-ramp after 500 m, speed limit 130 km/h, {cars}", 7).road.road
        assert road.speed == 130 * KMH
    exit_too = "three lanes in each direction, an exit on the right after 1 km and a speed limit of 100 km/h"
    assert read(f"a motorway with {exit_too}", 7).road.road.speed == 100 * KMH
    assert read("a motorway; there are ten cars and the limit is 100 km/h", 7).road.road.speed == 100 * KMH


def test_lanes_of_an_approach_lead_to_the_junction():
    arms = read("a roundabout with four two-lane approaches", 7).road.road.arms
    assert [(arm.lanes_in, arm.lanes_out) for arm in arms] == [(2, 2)] * 4


def test_what_the_side_road_has_fewer_of_need_not_be_said_again():
    arms = read("a crossroads where the main road has two lanes per direction and the side road one", 7).road.road.arms
    assert [arm.lanes_in for arm in arms] == [2, 1, 2, 1]


def test_a_limit_on_everything_is_no_limit_of_the_side_road():
    text = "a crossroads where the main road has three lanes each way and the side road one each way, 40 mph on everything"
    arms = read(f"{text}, each arm 200 m long", 7).road.road.arms
    assert {round(arm.speed / KMH * 0.621371) for arm in arms} == {40}


@pytest.mark.parametrize(
    ("text", "arms"),
    [
        ("a side road ends at the main road; this junction has traffic lights", 3),
        ("a side road joins a main road at a signalised intersection", 3),
        ("a crossroads where a side road meets a main road", 4),
    ],
)
def test_where_a_side_road_ends_are_three_arms(text, arms):
    assert len(read(text, 7).road.road.arms) == arms


@pytest.mark.parametrize(
    ("text", "dead_ends"),
    [
        ("a cul-de-sac off a collector", [True]),
        ("a residential street with three cul-de-sacs on the left", [True] * 3),
        ("a dead-end residential street", []),
        ("a main road ends in a cul-de-sac", []),
    ],
)
def test_dead_ends_beside_a_road_are_its_side_roads(text, dead_ends):
    road = read(text, 7).road.road
    assert [junction.dead_end for junction in road.junctions] == dead_ends
    assert road.dead_end is not bool(dead_ends)


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("a rural highway with one lane per direction", "corridor"),
        ("a highway with two signalised crossings", "corridor"),
        ("a highway crosses a country road", "crossing"),
        ("a highway with two lanes per direction", "highway"),
        ("a rural highway with one lane per direction and an exit", "highway"),
    ],
)
def test_a_highway_that_is_crossed_or_has_one_lane_in_the_country_is_no_motorway(text, kind):
    assert read(text, 7).road.road.kind == kind


def test_a_motorway_that_a_road_crosses_is_declined():
    assert "interchange" in declined("a motorway crosses a road")


def test_motorways_that_merge_have_a_motorways_limit():
    assert [round(read(f"two {roads} merge into one", 7).road.road.speed / KMH) for roads in ("motorways", "roads")] == [120, 50]


@pytest.mark.parametrize(
    ("text", "lanes"),
    [
        ("a two-lane one-way road that splits into two one-lane roads", (2, 1, 1)),
        ("a three-lane motorway that splits into two two-lane motorways", (3, 2, 2)),
        ("two two-lane roads that merge into one three-lane road", (3, 2, 2)),
        ("a three-lane road forking into a two-lane and a one-lane road", (3, 2, 1)),
    ],
)
def test_a_fork_has_the_lanes_of_its_branches(text, lanes):
    road = read(text, 7).road.road
    assert (road.lanes, road.left_lanes, road.right_lanes) == lanes


@pytest.mark.parametrize(
    ("text", "lanes", "speeds"),
    [
        ("a crossing of a main road and a side road, both with a 30 km/h limit", [1] * 4, [30] * 4),
        ("a T-junction of a main road and a side road, each with two lanes per direction", [2] * 3, [50] * 3),
        ("an intersection of a one-way street and a two-way street, both with two lanes", [2, 2, 0, 2], [50] * 4),
        ("a roundabout with four arms, each with three lanes", [3] * 4, [50] * 4),
        ("a three-lane roundabout with four entries, each with two lanes", [2] * 4, [50] * 4),
        ("a crossing where the main road has two lanes per direction and the side road has one", [2, 1, 2, 1], [50] * 4),
        ("a yield-controlled T-junction on a 60 km/h road", [1] * 3, [60, 60, 50]),
        ("an intersection on a four-lane arterial", [2] * 4, [60] * 4),
        ("a one-way road crossing a two-way road at a traffic light", [1, 1, 0, 1], [50] * 4),
        ("two one-way streets that cross at an intersection", [1, 1, 0, 0], [50] * 4),
        ("a stop sign on the side road and 60 km/h on the main road at a crossing", [1] * 4, [60, 50] * 2),
    ],
)
def test_each_road_at_a_crossing_has_what_is_said_of_it(text, lanes, speeds):
    arms = read(text, 7).road.road.arms
    assert [arm.lanes_in for arm in arms] == lanes
    assert [arm.speed / KMH for arm in arms] == pytest.approx(speeds)


def test_lanes_in_each_direction_are_never_an_exits():
    road = read("a highway with an exit and two lanes per direction", 7).road.road
    assert (road.lanes, road.events[0].lanes) == (2, 1)
    assert read("a freeway on-ramp merge with two mainline lanes", 7).road.road.lanes == 2
    assert read("a motorway where an on-ramp adds a lane", 7).road.road.events[0].keeps


@pytest.mark.parametrize("text", ["a road that splits into three", "five roads that become one", "three motorways merge"])
def test_a_fork_of_more_than_two_branches_is_declined(text):
    assert "a fork has two branches" in declined(text)


@pytest.mark.parametrize(
    ("text", "lanes", "left", "bans"),
    [
        ("an avenue crosses a street; the avenue has 2 lanes in each direction", [2, 2, 2, 2], [0] * 4, [()] * 4),
        ("a 4-lane avenue crosses a 2-lane street, left turn lanes on the avenue", [2, 1, 2, 1], [1, 0, 1, 0], [()] * 4),
        ("a 4-lane avenue crosses a 2-lane street, no left turn from the avenue", [2, 1, 2, 1], [0] * 4, [("left",), ()] * 2),
        ("a 4-lane avenue crosses a 2-lane street, no left turn from the street", [2, 1, 2, 1], [0] * 4, [(), ("left",)] * 2),
    ],
)
def test_a_road_that_is_named_again_is_the_one_of_that_name(text, lanes, left, bans):
    arms = read(text, 7).road.road.arms
    assert [arm.lanes_in for arm in arms] == lanes
    assert [arm.left_turn_lanes for arm in arms] == left
    assert [arm.turn_bans for arm in arms] == bans


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("a road crosses a road; the road has two lanes in each direction", "which one 'road'"),
        ("a crossing of two streets, the first street has two lanes each way", "which one 'street'"),
        ("a crossing of an avenue and a street, no left turn onto the street", "from which road"),
        ("a motorway and a freeway merge; the motorway has three lanes", "a road that merges"),
        ("a crossroads with lights in one direction only", "clear what is 'in one direction'"),
        ("a crossroads with left-turn lanes in one direction", "clear what is 'in one direction'"),
        ("a motorway with an exit in one direction only", "'in one direction'"),
        ("motorway on-ramp: two through lanes, 100 km/h", "of the ramp or of the road"),
        ("a highway with an off-ramp and two lanes", "of the ramp or of the road"),
        ("a motorway entrance with an acceleration lane of 300 m and three lanes", "of the ramp or of the road"),
        ("a motorway with an on-ramp and an off-ramp, each with a 60 km/h limit", "of which"),
        ("rural highway, 100 km/h, T-junction with a left turn lane on the main road", "'highway' is the main road"),
        ("a road with 50 km/h in one direction only", "clear what is 'in one direction'"),
        ("a road with bends to the left", "say of each of 'bends'"),
        ("a road with sharp curves to the right", "say of each of 'curves'"),
        ("a road with S-curves", "say how many bends 's curves' have together"),
        ("a Y-junction, the main road two lanes each way and the side road one", "which of the 3 arms are of the main road"),
        ("three intersections 300 m apart. The last one is a roundabout", "not that 'last one' is 'roundabout'"),
        ("four crossings, the last one a T-junction", "not that 'last one' is 't junction'"),
        ("a crossing between a roundabout and a T-junction", "in which order junctions lie"),
        ("a T-junction with a left-turn lane on the main road, 50 m long", "whether '50 m long' is said of the turn lanes"),
        ("a crossroads with left-turn lanes on all arms, each 50 m long", "said of the turn lanes"),
        ("a rural road with barriers", "barriers ('barriers') cannot"),
        ("a crossroads, the main road runs north-south", "drawn from east to west"),
        ("traffic keeps left: a T-junction, the side road from the south", "which side of the main road"),
    ],
)
def test_what_may_be_said_of_another_road_or_direction_is_declined(text, word):
    assert word in declined(text)


def test_a_road_in_one_direction_only_is_one_way():
    for text in ("a road with two lanes in one direction only", "a street with traffic in one direction only, two lanes"):
        assert (read(text, 7).road.road.lanes, read(text, 7).road.road.lanes_back) == (2, 0)


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("a road without lights and crossings", "'crossings', too"),
        ("a road without crossings and bends", "'bends', too"),
        ("a crossroads without traffic lights and left-turn lanes", "'left turn lanes', too"),
        ("a dual carriageway that becomes a single carriageway", "carriageways that begin or end"),
    ],
)
def test_what_no_or_without_may_rule_out_too_is_declined(text, word):
    assert word in declined(text)


@pytest.mark.parametrize(
    "text", ["with left-turn lanes and without traffic lights", "without traffic lights and with left-turn lanes"]
)
def test_with_and_without_are_told_apart(text):
    road = read(f"a crossroads {text}", 7).road.road
    assert (road.control, road.arms[0].left_turn_lanes) == ("yield", 1)


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("a T-junction, major 2 lanes each way, yield on minor", "a T-junction, 2 lanes each way on the main road, give way"),
        ("a dual carriageway, 2+2 lanes", "a dual carriageway, two lanes in each direction"),
        (
            "motorway split: 4 lanes into 2 left and 2 right",
            "a motorway that splits, 4 lanes, 2 to the left and 2 to the right",
        ),
        ("skewed 4-way crossing, at 70 degrees", "a four-way crossing at 70 degrees"),
    ],
)
def test_short_forms_draw_what_long_ones_do(text, plain):
    assert read(text, 7, "same").road == read(plain, 7, "same").road


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("a crossing with one left-turn lane on the main road and two on the side road", "of what there are so many"),
        ("a cloverleaf, 80 km/h on the motorway and 50 km/h on the crossing road", "'50 kmh' does not fit"),
        ("a crossing where the main road yields to the side road", "say by main and side road"),
        ("a crossing; the north-south road has a stop sign", "say by main and side road"),
        ("a motorway narrowing from three lanes to two in both directions", "'in both directions'"),
        ("a road widening from one lane to two in each direction", "what 'in each direction' belongs to"),
        ("a lane drop in both directions on a motorway", "'in both directions'"),
        ("two crossings, the second one has two lanes each way", "'two lanes each way' belongs to"),
        ("a motorway with an on-ramp with a limit of 40 km/h and 60 km/h on the ramp", "contradict one another"),
        ("a crossing, both cars turn left", "say how many"),
        ("five cars on a motorway, the second one brakes hard", "'second one' is"),
        ("a motorway, my speed is 100 km/h, ten cars", "the target is driving at"),
        ("a motorway with ten cars; the third car brakes hard", "which one 'car' is"),
        ("ten vehicles including three trucks on a motorway", "is among 'vehicles'"),
        ("ten vehicles (three trucks) on a motorway", "is among 'vehicles'"),
        ("ten vehicles: three trucks, on a motorway", "is among 'vehicles'"),
        ("ten vehicles with three trucks on a motorway", "is among 'vehicles'"),
        ("a motorway, every truck overtakes me", "say how many"),
    ],
)
def test_what_is_said_of_one_of_several_is_not_said_of_all(text, why):
    assert why in declined(text)


def test_it_is_what_the_sentence_before_begins_with():
    road = read("A road of 1 km. In the middle there is a side road on the left. It is 150 m long.", 7).road.road
    assert (road.alignment.length, [(j.position, j.side_length) for j in road.junctions]) == (1000, [(500, 150)])
    brakes = read("A motorway. There is a truck ahead of me. It brakes hard.", 7).traffic.groups
    assert [group.manoeuvre for group in brakes] == ["hard_braking"]


def test_the_first_and_the_second_are_those_that_were_counted():
    road = read("two T-junctions in a row, the first is on the left, the second is on the right", 7).road.road
    assert [junction.sides for junction in road.junctions] == [("left",), ("right",)]
    ramps = read("a motorway with two on-ramps, the second one at 800 m", 7).road.road.events
    assert [ramp.position for ramp in ramps] == [250, 800]
    arms = read("a crossing; the last arm has two lanes each way", 7).road.road.arms
    assert [arm.lanes_in for arm in arms] == [1, 1, 1, 2]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("eight cars, two of them turning left", "There are 6 cars. There are 2 cars turning left."),
        ("ten cars driving at 50 km/h, two of them driving at 30 km/h",
         "There are 8 cars driving at 50 km/h. There are 2 cars driving at 30 km/h."),
        ("eight cars, two turning left", "There are 6 cars. There are 2 cars turning left."),
        ("six cars, two of them turning left and one of them turning right",
         "There are 3 cars. There are 2 cars turning left. There is 1 car turning right."),
        ("six cars, two turning left and one turning right",
         "There are 3 cars. There are 2 cars turning left. There is 1 car turning right."),
        ("six cars and three trucks, two of the cars turning left",
         "There are 4 cars. There are 3 trucks. There are 2 cars turning left."),
        ("six cars and three trucks, one of the cars turning left",
         "There are 5 cars. There are 3 trucks. There is 1 car turning left."),
        ("three buses and two cars, two of the buses turning left",
         "There is 1 bus. There are 2 cars. There are 2 buses turning left."),
        ("ten cars and two trucks, three of them cutting in",
         "There are 7 cars. There are 2 trucks. There are 3 cars cutting in."),
        ("ten vehicles, two of them trucks and one of them a bus", "There are 7 vehicles. There are 2 trucks. There is 1 bus."),
        ("ten vehicles, three of them trucks, one of the trucks braking hard",
         "There are 7 vehicles. There are 2 trucks. There is 1 truck braking hard."),
        ("four cars of which one cuts in", "There are 3 cars. There is 1 car cutting in."),
        ("eight cars: two turn left, one turns right",
         "There are 5 cars. There are 2 cars turning left. There is 1 car turning right."),
        ("six cars, one brakes hard", "There are 5 cars. There is 1 car braking hard."),
        ("six cars, two oncoming", "There are 4 cars. There are 2 cars oncoming."),
    ],
)  # fmt: skip
def test_some_of_those_that_are_named_do_something_of_their_own(text: str, said: str):
    words = read(text, 7)
    assert " ".join(words.sentences()) == said
    assert read(said, 7).traffic == words.traffic


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("four cars, five of them turning left", "there are not so many as 'five of them'"),
        ("ten cars and two trucks, three of the trucks cutting in", "there are not so many as 'three of the trucks'"),
        ("three cars, one of the trucks braking hard", "it is not clear who 'one of the trucks' is"),
        ("ten cars, two of them trucks", "it is not clear who 'two of them trucks' is"),
        ("two cars and one turning left", "it is not clear"),
        ("eight cars, zero of them turning left", "ruling out some vehicles cannot be asked for"),
        ("eight vehicles, 0 of them trucks", "ruling out some vehicles cannot be asked for"),
        ("six cars and two turning trucks", "I do not read 'turning'"),
    ],
)
def test_some_of_those_that_are_not_there_are_declined(text: str, why: str):
    assert why in declined(text)
