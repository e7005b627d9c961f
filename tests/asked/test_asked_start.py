"""From a request to a first frame, goals that realise it, and a measure of what was got."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.asked.account import first_frame, manoeuvres
from drivegen.asked.achieved import BRAKING, does
from drivegen.asked.goals import ACROSS, ROOM, ROUND, SETTLED, Duty, keeping, ordered, realising
from drivegen.asked.offered import HARDEST
from drivegen.asked.start import Settings, start
from drivegen.asked.wishes import TURNING, Fill, cast
from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import rotate, wrap_angle
from drivegen.core.scenario import VehicleKind
from drivegen.core.settings import build, read_section
from drivegen.core.signals import SignalState
from drivegen.generators.base import Settings as GeneratorSettings
from drivegen.layouts.compile import compile_map
from drivegen.layouts.spec import MapSpec
from drivegen.placement.scenes import Initialiser
from drivegen.placement.scenes import Settings as InitialSettings
from drivegen.placement.table import build_table
from drivegen.placement.where import TURN_BEGINS
from drivegen.roads.frenet import to_frenet
from drivegen.roads.graph import LaneGraph
from drivegen.roads.routes import feasible_routes
from drivegen.rollout.batch import roll_out
from drivegen.selectors.random import Plugin as Random
from drivegen.sumo.network import Network
from drivegen.words.read import read
from drivegen.words.request import Manoeuvre
from tests.projects import PARAMS
from tests.scenes import busy_crossing, drive, scenario, stack, straight_road

SETTINGS = Settings({"dense": Fill(12, 60.0)}, placements=12, starts=2)


def begun(initialiser, tools, words, seed=3, settings=SETTINGS):
    equipment, generation = tools
    request = read(words, 7).traffic
    return request, start(initialiser, "asked", request, settings, 4, equipment.selector, generation, seed)


def test_everybody_stands_as_asked_and_what_was_got_is_told(initialiser, tools):
    words = "a bus 30 m ahead, a truck on the left, a car behind, about 50 km/h"
    request, made = begun(initialiser, tools, words)
    items = first_frame(request, made, SETTINGS.densities)
    assert {item.kind for item in items} == {"kind", "place", "speed"}
    assert all(item.got for item in items), items
    vehicles = made.scenario.vehicles
    bus = made.vehicle(1 + [g.kind for g in request.groups].index("bus"))
    assert vehicles.kind[bus] == VehicleKind.BUS
    assert np.hypot(*(vehicles.position[bus] - vehicles.position[0])) == pytest.approx(30, abs=7)
    assert np.allclose(vehicles.speed, 50 / 3.6, rtol=0.2)


def test_the_target_begins_at_the_speed_that_is_said_of_it(initialiser, tools):
    request, made = begun(initialiser, tools, "the target is driving at 30 km/h, a car ahead, traffic at 50 km/h")
    items = {item.what: item.got for item in first_frame(request, made, SETTINGS.densities) if item.kind == "speed"}
    assert items == {"the target at 30 km/h": True, "about 50 km/h": True}
    assert made.scenario.vehicles.speed[0] == pytest.approx(30 / 3.6, rel=0.05)
    assert made.scenario.vehicles.speed[1] > 40 / 3.6


def told(initialiser, tools, words, present=None):
    request, made = begun(initialiser, tools, words)
    seen = made if present is None else made.only(np.array(present))
    return {item.what: item.got for item in first_frame(request, seen, SETTINGS.densities)}


def test_a_number_counts_only_where_one_is_asked_for(initialiser, tools):
    assert "3 vehicles beside the target" in told(initialiser, tools, "three cars")
    assert told(initialiser, tools, "a bus ahead, a truck behind").keys() == {
        "1 x bus",
        "1 x truck",
        "1 x bus ahead",
        "1 x truck behind",
    }


def test_nothing_is_got_of_whom_a_future_leaves_out(initialiser, tools):
    words = "two cars, a bus ahead"
    assert all(told(initialiser, tools, words, [0, 1, 2, 3]).values())
    assert told(initialiser, tools, words, [0, 2, 3]) == {
        "3 vehicles beside the target": False,
        "1 x bus": False,
        "2 x car": True,
        "1 x bus ahead": False,
    }


def test_a_queue_that_is_not_whole_is_not_where_it_is_asked_for(initialiser, tools):
    words = "a queue of three cars ahead"
    assert told(initialiser, tools, words)["3 x car ahead"]
    assert not told(initialiser, tools, words, [0, 1])["3 x car ahead"]


@pytest.mark.parametrize("seed", range(6))
def test_nobody_stands_between_the_target_and_who_is_asked_for_ahead_of_it(initialiser, tools, seed):
    equipment, generation = tools
    request = read("a car 60 m ahead", 7).traffic
    made = start(initialiser, "asked", request, SETTINGS, 16, equipment.selector, generation, seed)
    place = made.scenario.vehicles.position
    local = rotate(place - place[0], -float(made.scenario.vehicles.heading[0]))
    ahead = (np.abs(local[:, 1]) < 1.5) & (local[:, 0] > 1) & (local[:, 0] < local[made.vehicle(1), 0] - 1)
    assert not ahead.any()


@pytest.mark.parametrize("left_hand", [False, True])
def test_one_overtakes_on_the_side_that_traffic_does_not_keep(left_hand):
    spec = MapSpec.model_validate({"left_hand": left_hand, "road": {"kind": "highway", "lanes": 3, "speed": 20}})
    assert Network.read(compile_map(spec), "highway").left_hand == left_hand
    asked = cast(read("a car overtakes the target", 7).traffic, {}, 4, np.random.default_rng(0), left_hand=left_hand)
    assert asked.wishes[1].relation == ("right_behind" if left_hand else "left_behind")


def test_many_vehicles_have_room_farther_away(initialiser, tools):
    _, made = begun(initialiser, tools, "twenty vehicles at 70 km/h")
    assert len(made.scenario.vehicles) == 21


def test_the_same_seed_gives_the_same_start_and_another_one_another(initialiser, tools):
    first, again, other = (begun(initialiser, tools, "six cars, a truck behind", seed)[1] for seed in (3, 3, 4))
    assert np.array_equal(first.scenario.vehicles.position, again.scenario.vehicles.position)
    assert not np.array_equal(first.scenario.vehicles.position, other.scenario.vehicles.position)


@pytest.mark.parametrize("full", [{2, 5}, {1}])
def test_a_draw_without_room_for_its_target_costs_no_start_that_another_finds(initialiser, tools, monkeypatch, full):
    begin, turns = initialiser.begin, []

    def now_and_then(*asked):
        turns.append(asked)
        if len(turns) in full:
            raise UnusableInput("no lane on which the target fits", reason="no-place")
        return begin(*asked)

    monkeypatch.setattr(initialiser, "begin", now_and_then)
    _, made = begun(initialiser, tools, "a car approaching from the left turns right")
    assert len(made.scenario.vehicles) >= 1
    assert len(turns) > min(full)


def test_where_no_draw_has_room_for_its_target_that_is_an_error(initialiser, tools, monkeypatch):
    def never(*asked):
        raise UnusableInput("no lane on which the target fits", reason="no-place")

    monkeypatch.setattr(initialiser, "begin", never)
    with pytest.raises(UnusableInput, match="no lane"):
        begun(initialiser, tools, "a car ahead")


def test_a_manoeuvre_binds_the_goals_of_its_vehicle_and_keeps_their_own_probability(initialiser, tools):
    _, made = begun(initialiser, tools, "a car cuts in from the left")
    [duty] = made.duties
    used, natural = made.ordered.choices.used[duty.vehicle], made.ordered.choices.natural[duty.vehicle]
    assert made.ordered.feasible == (True,)
    assert used.sum() == pytest.approx(1, abs=1e-5)
    assert (used > 0).sum() < len(used)
    assert made.ordered.natural[0] == pytest.approx(float(natural[used > 0].sum()), rel=1e-4)


def test_what_the_road_cannot_offer_is_counted_as_not_got(initialiser, tools):
    request, made = begun(initialiser, tools, "a car approaching from the left turns right")
    assert made.vehicle(1) is None
    assert sum(made.rejected.values()) == 1
    assert not any(item.got for item in first_frame(request, made, SETTINGS.densities) if item.kind == "place")
    samples = roll_out([made.ordered.choices], tools[0].planner, tools[0].limits, tools[1].rollout, 1, 7, "asked")[0]
    assert [item.got for item in manoeuvres(made, samples, 0)] == [False]


def test_a_density_that_no_settings_know_is_refused():
    request = read("sparse traffic", 7).traffic
    with pytest.raises(UnusableInput, match="sparse"):
        cast(request, SETTINGS.densities, 4, np.random.default_rng(0))


def test_who_is_asked_for_by_place_comes_first_and_the_rest_fills_up():
    random = np.random.default_rng(0)
    asked = cast(read("ten cars, a truck ahead", 7).traffic, {}, 4, random)
    assert [kind.value for kind in asked.kinds] == ["car", "truck", *["car"] * 10]
    assert len(cast(read("a truck ahead", 7).traffic, {}, 4, random)) == 4
    assert len(cast(read("a truck ahead, dense", 7).traffic, SETTINGS.densities, 4, random)) == 12


@pytest.mark.parametrize(
    ("text", "vehicles"),
    [
        ("dense traffic with two buses", 12),
        ("dense traffic, a bus ahead of the target, two trucks", 12),
        ("two buses", 3),
        ("dense traffic, five cars and two buses", 8),
        ("dense traffic, five vehicles", 6),
    ],
)
def test_beside_a_density_trucks_and_buses_do_not_say_how_many_there_are(text, vehicles):
    asked = cast(read(text, 7).traffic, SETTINGS.densities, 4, np.random.default_rng(0))
    assert len(asked) == vehicles
    assert sum(kind.value == "bus" for kind in asked.kinds) == text.count("two buses") * 2 + text.count("a bus")


ROAD = straight_road(600, 2)


def two_lanes(*motions):
    scene = scenario(ROAD, stack(list(motions)))
    graph = LaneGraph.of(scene.map)
    routes = [
        next(r for r in feasible_routes(graph, p, float(h), 10.0, 300.0) if r.lane_changes == 0)
        for p, h in zip(scene.vehicles.position, scene.vehicles.heading, strict=True)
    ]
    return scene.log, routes


def right_lane(start, speed, acceleration=0.0):
    return drive(np.array([[0.0, 0.0], [600.0, 0.0]]), start, speed, 101, acceleration)


def changing(start, speed, at, steps=101):
    """From the left lane to the right one around x = `at`."""
    xs = np.arange(0.0, 601.0, 5.0)
    return drive(np.stack([xs, 3.5 / (1 + np.exp((xs - at) / 5))], axis=1), start, speed, steps)


def test_cut_ins_are_told_from_driving_beside_and_in_time():
    log, routes = two_lanes(right_lane(20, 10), changing(35, 10, 60))
    assert does(Duty(1, Manoeuvre.CUT_IN, None), log, routes[:1], routes[1:2], ROAD)
    assert does(Duty(1, Manoeuvre.CHANGE_RIGHT, None), log, routes[:1], routes[1:2], ROAD)
    assert not does(Duty(1, Manoeuvre.CUT_IN, 1.0), log, routes[:1], routes[1:2], ROAD)
    late = log.until(20)
    assert not does(Duty(1, Manoeuvre.CUT_IN, None), late, routes[:1], routes[1:2], ROAD)
    behind, lines = two_lanes(right_lane(90, 10), changing(35, 10, 60))
    assert not does(Duty(1, Manoeuvre.CUT_IN, None), behind, lines[:1], lines[1:2], ROAD)


def test_braking_overtaking_and_standing_are_measured():
    log, routes = two_lanes(right_lane(50, 8), right_lane(90, 12, -BRAKING - 1), right_lane(130, 12, -1.0), right_lane(10, 0))
    assert does(Duty(1, Manoeuvre.HARD_BRAKING, None), log, routes[:1], routes[1:2], ROAD)
    assert not does(Duty(2, Manoeuvre.HARD_BRAKING, None), log, routes[:1], routes[2:3], ROAD)
    assert does(Duty(3, Manoeuvre.STOPPED, None), log, routes[:1], routes[3:4], ROAD)
    assert not does(Duty(1, Manoeuvre.STOPPED, None), log, routes[:1], routes[1:2], ROAD)
    fast, lines = two_lanes(right_lane(50, 5), changing(20, 15, 900))
    assert does(Duty(1, Manoeuvre.OVERTAKE, None), fast, lines[:1], lines[1:2], ROAD)
    assert not does(Duty(1, Manoeuvre.OVERTAKE, 1.0), fast, lines[:1], lines[1:2], ROAD)
    gone = replace(fast, valid=fast.valid & (np.arange(2)[:, None] != 1))
    assert not does(Duty(1, Manoeuvre.OVERTAKE, None), gone, lines[:1], lines[1:2], ROAD)
    for until, overtakes in ((60, True), (20, False)):  # it leaves the map then
        left = replace(fast, valid=fast.valid & ((np.arange(2)[:, None] != 1) | (np.arange(101) < until)))
        assert does(Duty(1, Manoeuvre.OVERTAKE, None), left, lines[:1], lines[1:2], ROAD) == overtakes


def turning_start(initialised, words):
    generation = build(GeneratorSettings, read_section("ship.generation", PARAMS), "ship.generation")
    settings = replace(SETTINGS, placements=60, starts=60)
    request = read(words, 7).traffic
    return start(initialised, "turn", request, settings, 3, Random.load(PARAMS), generation, 7)


@pytest.fixture(scope="module")
def junction() -> Initialiser:
    settings = build(InitialSettings, read_section("place.initial", PARAMS), "place.initial")
    arms = [{"angle": angle} for angle in (0, 90, 180, 270)]
    spec = MapSpec.model_validate({"road": {"kind": "crossing", "control": "signals", "arms": arms}})
    return Initialiser(Network.read(compile_map(spec), "junction"), "junction", "test", build_table([busy_crossing()]), settings)


@pytest.mark.parametrize(("words", "side"), [("the target turns right", -1.0), ("the target turns left", 1.0)])
def test_who_turns_has_a_goal_beyond_the_turn_begins_slowly_and_meets_no_red_light(junction, words, side):
    made = turning_start(junction, words)
    assert made.ordered.feasible == (True,)
    own, scene = made.ordered.choices.candidates[0], made.scenario
    bound = made.ordered.choices.used[0] > 0
    assert (side * wrap_angle(own.heading - scene.vehicles.heading[0])[bound] > ROUND).all()
    assert scene.vehicles.speed[0] <= TURNING + 0.1
    assert (own.s[bound] / 10.0 < 9.0).all()  # on average: no dash to the corner
    [duty] = made.duties
    red = replace(scene.signals, state=np.full_like(scene.signals.state, SignalState.RED))
    assert len(red) > 0
    assert not realising(replace(scene, signals=red), made.ordered.choices.candidates, duty, hastily=True).any()
    green = replace(scene.signals, state=np.full_like(scene.signals.state, SignalState.GREEN))
    eager = realising(replace(scene, signals=green), made.ordered.choices.candidates, duty, hastily=True)
    assert (eager >= bound).all()


@pytest.mark.parametrize(("words", "who"), [("the target goes straight on", 0), ("a car from the left goes straight", 1)])
def test_who_goes_straight_stands_before_the_crossing_and_has_goals_wholly_beyond_it(junction, words, who):
    made = turning_start(junction, words)
    assert made.ordered.feasible == (True,)
    [duty] = made.duties
    assert duty.vehicle == made.vehicle(who)
    own, scene = made.ordered.choices.candidates[duty.vehicle], made.scenario
    bound = made.ordered.choices.used[duty.vehicle] > 0
    inside = scene.map.in_junction
    for route, s in zip(own.route[bound].tolist(), own.s[bound].tolist(), strict=True):
        rear = int(s - scene.vehicles.size[duty.vehicle, 0] / 2)
        lanes = own.routes[route].lane
        assert not inside[lanes[0]]
        assert inside[lanes[:rear]].any()
        assert not inside[lanes[rear + 1]]
    assert (np.abs(wrap_angle(own.heading[bound] - scene.vehicles.heading[duty.vehicle])) < 0.3).all()
    red = replace(scene.signals, state=np.full_like(scene.signals.state, SignalState.RED))
    assert not realising(replace(scene, signals=red), made.ordered.choices.candidates, duty).any()


def test_a_goal_in_the_middle_of_a_turn_across_the_targets_way_does_not_realise_it(junction):
    made = turning_start(junction, "an oncoming car turns left across our path")
    assert made.ordered.feasible == (True,)
    [duty] = made.duties
    candidates = made.ordered.choices.candidates
    way = keeping(candidates[0])
    began = to_frenet(way, made.scenario.vehicles.position[duty.vehicle][None])[0, 1]
    ends = to_frenet(way, candidates[duty.vehicle].position)[:, 1]
    bound = made.ordered.choices.used[duty.vehicle] > 0
    assert (np.sign(ends[bound]) == -np.sign(began)).all()
    assert (np.abs(ends[bound]) > ACROSS).all()


@pytest.mark.parametrize(("words", "side"), [("the target turns left", 0), ("a car ahead turns right", 1)])
def test_who_turns_stands_just_before_a_turn(junction, words, side):
    made = turning_start(junction, words)
    [duty] = made.duties
    own = made.ordered.choices.candidates[duty.vehicle]
    [turns] = [r for r in own.routes if (r.turned[-1] > 0.9, r.turned[-1] < -0.9)[side]][:1]
    begins = int(np.argmax(np.abs(turns.turned) > 0.05))  # a point every metre
    assert TURN_BEGINS[0] - 2 <= begins <= TURN_BEGINS[1] + 8


def test_who_is_to_change_lanes_is_offered_places_that_it_has_settled_at(initialiser, tools):
    _, made = begun(initialiser, tools, "a car on the left changes to the right lane")
    [duty] = made.duties
    own, used = made.ordered.choices.candidates[duty.vehicle], made.ordered.choices.used[duty.vehicle]
    assert len(own) > len(made.free.candidates[duty.vehicle])
    assert len(made.ordered.choices.natural[duty.vehicle]) == len(used) == len(own)
    assert (np.abs(own.d[used > 0]) < SETTLED).all()
    assert (own.s[used > 0] > ROOM).all()


def test_nobody_drives_beside_who_is_to_change_lanes(initialiser, tools):
    words = "a car on the left changes to the right lane"
    _, made = begun(initialiser, tools, words, settings=replace(SETTINGS, starts=12))
    assert made.ordered.feasible == (True,)
    [duty] = made.duties
    vehicles = made.scenario.vehicles
    at = vehicles.position[duty.vehicle] + rotate(np.array([0.0, -3.7]), vehicles.heading[duty.vehicle])
    beside = replace(made.scenario, vehicles=replace(vehicles, position=np.concatenate([at[None], vehicles.position[1:]])))
    choices = replace(made.free, scenario=beside)
    bound = ordered(LaneGraph.of(beside.map), choices, tools[0].selector, made.duties)
    assert bound.feasible == (False,)


def test_of_two_duties_that_nobody_can_do_at_once_the_first_is_done(initialiser, tools):
    words = "a car on the left changes to the right lane"
    _, made = begun(initialiser, tools, words, settings=replace(SETTINGS, starts=12))
    [duty] = made.duties
    other = replace(duty, manoeuvre=Manoeuvre.HARD_BRAKING)
    both = ordered(LaneGraph.of(made.scenario.map), made.free, tools[0].selector, (duty, other))
    assert both.feasible == (True, False)
    own = both.choices.candidates[duty.vehicle]
    assert (np.abs(own.d[both.choices.used[duty.vehicle] > 0]) < SETTLED).all()


def test_the_target_stops_behind_who_brakes_hard(initialiser, tools):
    _, made = begun(initialiser, tools, "the lead vehicle brakes hard")
    assert made.ordered.feasible == (True,)
    [duty] = made.duties
    target, vehicles = made.ordered.choices.candidates[0], made.scenario.vehicles
    ahead = float(to_frenet(keeping(target), vehicles.position[duty.vehicle][None])[0, 0])
    halt = ahead + float(vehicles.speed[duty.vehicle]) ** 2 / (2 * HARDEST)
    lets = made.ordered.choices.used[0] > 0
    assert lets.sum() < len(target)
    assert (target.s[lets] < halt - vehicles.size[[0, duty.vehicle], 0].mean()).all()


def test_the_target_stops_behind_who_stands(initialiser, tools):
    _, made = begun(initialiser, tools, "a stopped bus 40 m ahead")
    assert made.ordered.feasible == (True,)
    [duty] = made.duties
    target, vehicles = made.ordered.choices.candidates[0], made.scenario.vehicles
    ahead = float(to_frenet(keeping(target), vehicles.position[duty.vehicle][None])[0, 0])
    lets = made.ordered.choices.used[0] > 0
    assert (target.s[lets] < ahead - vehicles.size[[0, duty.vehicle], 0].mean()).all()
