"""Signals and right of way: the named cases, each with the IDM that heeds rules and the one that does not."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from drivegen.core.geometry import arc_length, interpolate
from drivegen.core.roadmap import LaneControl
from drivegen.core.signals import Signals, SignalState
from drivegen.drivers import idm
from drivegen.roads.graph import LaneGraph
from drivegen.simulators.batch import Plugin
from drivegen.world.observation import Action
from drivegen.world.right_of_way import has_right_of_way
from drivegen.world.rules import Lookout
from drivegen.world.scenes import Scenes
from drivegen.world.world import World
from tests.checking import IDM
from tests.scenes import crossing, drive, joined, road_map, scenario, stack

STEPS = 151
STRAIGHT, LEFT, RIGHT = 0, 1, 2
LINE = -10.0
"""The target comes from the west, along y = -1.75; its stop line is at x = -10."""


def way(roads, arm, turn):
    """The line from arm 0 (west), 1 (south), 2 (east) or 3 (north), and the lane in the junction."""
    lane = 8 + 3 * arm + turn
    out = next(int(b) for a, b in roads.links if a == lane)
    return joined(roads, arm, lane, out), lane


def meet(control, own_turn, others=(), states=None, own_control=None, start=30.0, speed=10.0):
    """The scene of a target from the west that turns `own_turn`, and others (arm, turn, start [m], speed)."""
    roads = crossing(control=control)
    line, lane = way(roads, 0, own_turn)
    if own_control is not None:
        own = np.isin(np.arange(len(roads)), [8, 9, 10])
        roads = replace(roads, control=np.where(own, own_control, roads.control).astype(np.uint8))
    motions = [drive(line, start, speed, STEPS)]
    motions += [drive(way(roads, arm, turn)[0], begin, pace, STEPS) for arm, turn, begin, pace in others]
    signals = None
    if states is not None:
        signals = Signals(np.array([lane], np.int32), np.array([states], np.uint8))
    return scenario(roads, stack(motions), signals=signals)


def driven(scene, heeds=True, **kind):
    outcome = Plugin(**kind).run(idm.Plugin(replace(IDM, heeds_rules=heeds)), [scene], [scene.log])
    front = outcome.motion.position[0, :, 0] + 2.3
    return outcome, front


def passes(front):
    """The step at which the front is first over the line, None if it stays before it."""
    over = front > LINE + 0.5
    return int(np.argmax(over)) if over.any() else None


def test_red_light():
    states = np.where(np.arange(STEPS) < 90, SignalState.RED, SignalState.GREEN)
    scene = meet(LaneControl.SIGNAL, STRAIGHT, states=states)
    assert passes(driven(scene, heeds=False)[1]) < 80
    _, front = driven(scene)
    assert 90 <= passes(front) < 125
    assert LINE - 4 < front[85] < LINE
    yellow = np.where(np.arange(STEPS) < 36, SignalState.GREEN, SignalState.YELLOW)
    assert passes(driven(meet(LaneControl.SIGNAL, STRAIGHT, states=yellow))[1]) < 80  # too late to stop in comfort
    assert passes(driven(meet(LaneControl.SIGNAL, STRAIGHT, states=np.full(STEPS, SignalState.YELLOW)))[1]) is None


@pytest.mark.parametrize("heeds", [True, False])
def test_red_lights_that_are_run_are_counted(heeds):
    """The target comes to a light that is red for as long as it drives, and to one that has turned green long before."""
    red = meet(LaneControl.SIGNAL, STRAIGHT, states=np.full(STEPS, SignalState.RED))
    states = np.where(np.arange(STEPS) < 5, SignalState.RED, SignalState.GREEN)
    outcomes = [driven(scene, heeds, counts_lights=True)[0] for scene in (red, meet(LaneControl.SIGNAL, STRAIGHT, states=states))]
    assert [float(outcome.red_lights[0]) for outcome in outcomes] == [1, 0]
    assert [float(outcome.red_run[0]) for outcome in outcomes] == [0 if heeds else 1, 0]
    assert np.isnan(driven(red, False)[0].red_run[0])  # nobody looked


@pytest.mark.parametrize(("lasts", "counted"), [(None, (1, 1)), (48, (1, 0)), (30, (0, 0))])
def test_red_lights_behind_the_end_of_a_run_are_not_counted(lasts, counted):
    """The front comes within 20 m of the line in step 28 and over it in step 48."""
    scene = meet(LaneControl.SIGNAL, STRAIGHT, states=np.where(np.arange(STEPS) < 33, SignalState.GREEN, SignalState.RED))
    scenes = Scenes.of([scene], [scene.log])
    front = torch.arange(STEPS)[None] + 2.3
    valid = torch.arange(STEPS)[None] < (lasts or STEPS)
    near, ran = Lookout.of(scenes, [scene], [scene.log]).red_lights(front, valid)
    assert (int(near), int(ran)) == counted


def test_the_last_known_state_of_a_light_lasts_for_drivers():
    known = np.where(np.arange(STEPS) < 20, SignalState.RED, SignalState.UNKNOWN)
    assert passes(driven(meet(LaneControl.SIGNAL, STRAIGHT, states=known))[1]) is None
    assert away_of_who_waits(known).isinf().all()


@pytest.mark.parametrize(("state", "comes"), [(SignalState.GREEN, True), (SignalState.YELLOW, False), (SignalState.RED, False)])
def test_who_has_no_green_light_does_not_come(state, comes):
    away = away_of_who_waits(np.full(STEPS, state))
    assert bool(away.isfinite().all() if comes else away.isfinite().any()) == comes


def away_of_who_waits(states):
    """(T,) [m] from who stands opposite, before a light that shows `states`, to the way of a target that turns left."""
    scene = meet(LaneControl.SIGNAL, LEFT, [(2, STRAIGHT, 40.0, 0.0)])
    light = Signals(np.array([14, 15, 16], np.int32), np.tile(states, (3, 1)).astype(np.uint8))
    scene = replace(scene, signals=light)
    return Lookout.of(Scenes.of([scene], [scene.log]), [scene], [scene.log]).distance[:, 0, 0]


def test_lights_are_known_for_as_long_as_the_shorter_of_scene_and_motion():
    red = meet(LaneControl.SIGNAL, STRAIGHT, states=np.full(STEPS, SignalState.RED))
    outcome = Plugin(counts_lights=True).run(idm.Plugin(IDM), [red, red], [red.log.until(81), red.log])
    assert outcome.red_lights.tolist() == [1, 1]


def test_yield():
    comes = (1, STRAIGHT, 30.0, 10.0)  # abreast of the target, from its right; it has priority
    scene = meet(LaneControl.FREE, STRAIGHT, [comes], own_control=LaneControl.YIELD)
    outcome, front = driven(scene)
    assert not outcome.collided[0]
    gone = int(np.argmax(scene.log.position[1, :, 1] > 2.3))
    assert passes(front) > gone - 15
    free = meet(LaneControl.FREE, STRAIGHT, own_control=LaneControl.YIELD)
    assert passes(driven(free)[1]) == passes(driven(free, heeds=False)[1])


def test_stop():
    scene = meet(LaneControl.FREE, STRAIGHT, own_control=LaneControl.STOP)
    outcome, front = driven(scene)
    stands = np.flatnonzero(outcome.motion.speed[0] < 0.1)
    assert len(stands) > 0
    assert LINE - 6 < front[stands[0]] < LINE
    assert stands[-1] < passes(front) < 140


def test_unprotected_left():
    states = np.full(STEPS, SignalState.GREEN)
    oncoming = (2, STRAIGHT, 40.0, 9.0)
    scene = meet(LaneControl.SIGNAL, LEFT, [oncoming], states=states, start=40.0)
    outcome, front = driven(scene)
    clear = int(np.argmax(scene.log.position[1, :, 0] < -2))
    assert not outcome.collided[0]
    assert passes(front) > clear - 25
    assert passes(driven(scene, heeds=False)[1]) < passes(front)
    straight = meet(LaneControl.SIGNAL, STRAIGHT, [oncoming], states=states, start=40.0)
    assert passes(driven(straight)[1]) == passes(driven(straight, heeds=False)[1])


@pytest.mark.parametrize("keeps", ["right", "left"])
def test_oncoming_traffic_goes_before_who_turns_across_its_way_on_either_side_of_the_road(keeps):
    roads = crossing(control=LaneControl.SIGNAL)
    if keeps == "left":  # seen in a mirror
        parts = {name: replace(lines, points=lines.points * np.float32([1, -1])) for name, lines in (
            ("centreline", roads.centreline), ("left", roads.right), ("right", roads.left))}  # fmt: skip
        roads = replace(roads, **parts)
    graph = LaneGraph.of(roads)
    across, straight, away = (way(roads, 0, turn)[1] for turn in (LEFT, STRAIGHT, RIGHT))
    theirs = way(roads, 2, STRAIGHT)[1]
    assert has_right_of_way(graph, theirs, across)
    assert not has_right_of_way(graph, theirs, straight)
    assert not has_right_of_way(graph, theirs, away)
    assert not has_right_of_way(graph, across, theirs)


def in_two(roads, lane, first):
    """The roads with a lane in the junction cut `first` [m] behind its beginning, as SUMO cuts ways; the latter half yields."""
    lines = [line.astype(np.float64) for line in roads.centreline]
    length, added = float(arc_length(lines[lane])[-1]), len(lines)
    halves = [interpolate(lines[lane], np.linspace(*ends, 12)) for ends in ((0, first), (first, length))]
    links = {(int(a), int(b)) for a, b in roads.links}
    out = next(b for a, b in links if a == lane)
    control = [(n, roads.control[n]) for n in range(added)] + [(added, LaneControl.YIELD)]
    return road_map(
        [*lines[:lane], halves[0], *lines[lane + 1 :], halves[1]],
        (links - {(lane, out)}) | {(lane, added), (added, out)},
        [*np.flatnonzero(roads.in_junction), added],
        control,
        drivable=list(roads.drivable),
        stop_lines=roads.stop_lines,
        stop_lane=roads.stop_lane,
    )


def test_a_left_turn_that_the_map_cuts_in_two_waits_as_one_that_is_whole():
    green = Signals(np.arange(8, 20, dtype=np.int32), np.full((12, STEPS), SignalState.GREEN, np.uint8))
    whole = crossing(control=LaneControl.SIGNAL)
    left, oncoming = way(whole, 0, LEFT)[1], drive(way(whole, 2, STRAIGHT)[0], 40.0, 9.0, STEPS)
    fronts = []
    for roads in (whole, in_two(whole, left, 4.0)):
        lanes = (0, left, len(whole), 5) if len(roads) > len(whole) else (0, left, 5)
        scene = scenario(roads, stack([drive(joined(roads, *lanes), 40.0, 10.0, STEPS), oncoming]), signals=green)
        outcome, front = driven(scene)
        assert not outcome.collided[0]
        fronts.append(passes(front))
    assert fronts[0] == pytest.approx(fronts[1], abs=1)
    assert fronts[0] > 60


def test_the_lights_of_ways_that_begin_at_one_place_are_told_apart():
    roads = in_two(crossing(control=LaneControl.SIGNAL), 9, 4.0)  # its first half lies beside the way straight on
    for straight, arrow, wanted in ((SignalState.RED, SignalState.RED, (1, 1)), (SignalState.GREEN, SignalState.RED, (0, 0))):
        states = np.full((12, STEPS), straight, np.uint8)
        states[1] = arrow
        signals = Signals(np.arange(8, 20, dtype=np.int32), states)
        scene = scenario(roads, stack([drive(joined(roads, 0, 8, 4), 40.0, 10.0, STEPS)]), signals=signals)
        outcome = driven(scene, heeds=False, counts_lights=True)[0]
        assert (float(outcome.red_lights[0]), float(outcome.red_run[0])) == wanted


def test_right_before_left():
    from_right, from_left = (1, STRAIGHT, 30.0, 9.0), (3, STRAIGHT, 5.0, 8.0)
    for control in (LaneControl.FREE, LaneControl.UNKNOWN):
        scene = meet(control, STRAIGHT, [from_right])
        assert not driven(scene)[0].collided[0]
        assert passes(driven(scene)[1]) > passes(driven(scene, heeds=False)[1])
        scene = meet(control, STRAIGHT, [from_left])
        assert passes(driven(scene)[1]) == passes(driven(scene, heeds=False)[1])


@pytest.mark.parametrize("control", [LaneControl.FREE, LaneControl.SIGNAL])
def test_of_two_ways_that_meet_one_at_most_has_right_of_way(control):
    graph = LaneGraph.of(crossing(control=control))
    ways = range(8, 20)
    pairs = [(a, b) for a in ways for b in ways if a < b and has_right_of_way(graph, a, b) and has_right_of_way(graph, b, a)]
    assert pairs == []


@pytest.mark.parametrize("control", [LaneControl.YIELD, LaneControl.STOP])
def test_the_order_that_the_map_says_is_taken_before_signs_and_geometry(control):
    roads = crossing(control=LaneControl.YIELD)
    roads.control[17] = control  # from the north, so from the left of who comes from the west
    for order, first in (([], (8, 17)), ([(17, 8)], (8, 17)), ([(8, 17)], (17, 8))):
        graph = LaneGraph.of(replace(roads, yields_to=np.array(order, np.int32).reshape(-1, 2)))
        assert has_right_of_way(graph, *first)
        assert not has_right_of_way(graph, *first[::-1])


def test_what_is_seen_of_a_line_and_of_who_comes():
    states = np.where(np.arange(STEPS) < 20, SignalState.RED, SignalState.GREEN)
    scene = meet(LaneControl.SIGNAL, LEFT, [(2, STRAIGHT, 40.0, 10.0), (3, STRAIGHT, 40.0, 10.0)], states=states)
    scenes = Scenes.of([scene], [scene.log])
    world = World(scenes, 1, lookout=Lookout.of(scenes, [scene], [scene.log]))
    rules = world.observe().rules
    assert float(rules.distance) == pytest.approx(50 - 2.3, abs=0.6)
    assert (int(rules.signal), int(rules.control), bool(rules.halted)) == (SignalState.RED, LaneControl.SIGNAL, False)
    assert 4.0 < float(rules.arrives[0, 0]) < 6.0
    assert torch.isinf(rules.arrives[0, 1:]).all()
    for _ in range(30):
        world.advance(idm.Plugin(IDM).act(world.observe()))
    assert int(world.observe().rules.signal) == SignalState.GREEN


def test_who_stands_before_a_line_when_it_begins_has_halted_there():
    scene = meet(LaneControl.FREE, STRAIGHT, own_control=LaneControl.STOP, start=76.0, speed=0.0)
    scenes = Scenes.of([scene], [scene.log])
    world = World(scenes, 1, lookout=Lookout.of(scenes, [scene], [scene.log]))
    for rows in (None, torch.tensor([0])):
        world.reset(torch.tensor([0]), rows)
        for _ in range(6):  # it is not asked what it sees before it rolls
            world.advance(Action(torch.tensor([3.0])))
        assert float(world.ego.speed) > 1.0
        assert bool(world.observe().rules.halted)
        for _ in range(20):
            world.advance(Action(torch.tensor([3.0])))
        rules = world.observe().rules
        assert (bool(rules.distance.isinf()), bool(rules.halted)) == (True, False)  # the only line is behind it


def test_who_stands_arrives_late_but_arrives():
    scene = meet(LaneControl.SIGNAL, LEFT, [(2, STRAIGHT, 40.0, 0.0)])
    scenes = Scenes.of([scene], [scene.log])
    lookout = Lookout.of(scenes, [scene], [scene.log])
    arrives = World(scenes, 1, lookout=lookout).observe().rules.arrives[0, 0]
    assert float(arrives) == pytest.approx(float(lookout.distance[0, 0, 0]) / 0.1, rel=1e-4)


def test_nobody_knows_a_moment_ahead_who_will_back_off():
    scene = meet(LaneControl.FREE, STRAIGHT, [(1, STRAIGHT, 30.0, 10.0)], own_control=LaneControl.YIELD)
    there_and_back = np.concatenate([np.arange(41), np.maximum(39 - np.arange(STEPS - 41), 0)])
    ways = np.stack([scene.log.position[0], scene.log.position[1, there_and_back]])
    backs = replace(scene, log=replace(scene.log, position=ways))
    seen = [Lookout.of(Scenes.of([s], [s.log]), [s], [s.log]).distance for s in (scene, backs)]
    assert torch.equal(seen[0][:41], seen[1][:41])
    assert seen[1][42].isinf().all()


def test_lines_are_where_they_are_in_reactive_traffic_too():
    from tests.world.test_world_neighbours import LAW

    scene = meet(LaneControl.FREE, STRAIGHT, [(1, STRAIGHT, 30.0, 10.0)], own_control=LaneControl.YIELD)
    outcome, front = driven(scene, reaction=LAW)
    assert not outcome.collided[0]
    assert passes(front) is not None
