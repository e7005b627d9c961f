"""The IDM generator: ways, red lights, queues, wishes."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.core.samples import Samples
from drivegen.core.scenario import Scenario
from drivegen.core.signals import Signals, SignalState
from drivegen.generators._idm.ways import POINTS, Ways
from drivegen.generators.idm import Plugin
from tests.generators.rivals import trained
from tests.scenes import LIMIT, crossing, drive, joined, road_map, scenario, stack, straight_road

LINE = straight_road(600, 1).centreline[0].astype(np.float64)


@pytest.fixture(scope="module")
def idm() -> Plugin:
    made = trained("idm")[0]
    assert isinstance(made, Plugin)
    return made


def generated(idm: Plugin, scene: Scenario) -> Samples:
    return idm.generate([scene], 6, 7)[0]


def test_at_a_crossing_there_is_a_way_for_each_turn() -> None:
    roads = crossing()
    scene = scenario(roads, stack([drive(joined(roads, 0, 8, 4), 40, 8, 101)]))
    ways = Ways.of(scene, 6, 0)
    assert ways.start.tolist() == [0, 3]
    assert ways.point.shape == (3, POINTS, 2)
    np.testing.assert_allclose(ways.point[:, 0], np.repeat(scene.vehicles.position, 3, axis=0), atol=1e-4)
    assert len({tuple(np.sign(np.round(point[100] / 30))) for point in ways.point}) == 3
    assert len(Ways.of(scene, 2, 0).point) == 2


def test_who_stands_beside_the_lanes_is_parked_not_who_stands_on_one_or_drives() -> None:
    aside = LINE + np.array([0.0, 2.5])
    cars = [drive(LINE, 50, 0, 11), drive(aside, 100, 0, 11), drive(aside, 150, 8, 11), drive(LINE, 200, 8, 11)]
    assert Ways.of(scenario(straight_road(600, 1), stack(cars)), 1, 0).parked.tolist() == [False, True, False, False]


def test_on_a_free_road_everybody_approaches_his_own_wish(idm: Plugin) -> None:
    samples = generated(idm, scenario(straight_road(600, 1), stack([drive(LINE, 10, 8, 101)])))
    last = samples.motion.speed[:, 0, -1]
    assert (last > 8).any()
    assert (last < 1.5 * LIMIT).all()
    assert len(np.unique(last)) == 6
    np.testing.assert_allclose(samples.motion.position[:, 0, :, 1], 0, atol=1e-3)
    step = np.diff(samples.motion.position[:, 0, :, 0], axis=1)
    np.testing.assert_allclose(step, samples.motion.speed[:, 0, 1:] * 0.1, atol=1e-3)


def test_everybody_slows_down_for_a_bend_and_drives_on_behind_it(idm: Plugin) -> None:
    turn = np.linspace(0, np.pi / 2, 13)
    bend = np.array([100.0, 8.0]) + 8 * np.stack([np.sin(turn), -np.cos(turn)], axis=1)  # to the left, 8 m of radius
    line = np.concatenate([[[0.0, 0.0]], bend, [[108.0, 400.0]]])
    motion = generated(idm, scenario(road_map([line]), stack([drive(line, 75, 8, 101)]))).motion
    inside, behind = (motion.position[:, 0, :, 0] > 101) & (motion.position[:, 0, :, 1] < 7), motion.position[:, 0, :, 1] > 20
    assert (motion.speed[:, 0][inside] ** 2 / 8 < 4.0).all()
    assert inside.any(axis=1).all()
    assert motion.speed[:, 0][behind].max() > 1.5 * motion.speed[:, 0][inside].max()


def test_nobody_runs_into_who_stands_ahead(idm: Plugin) -> None:
    scene = scenario(straight_road(600, 1), stack([drive(LINE, 10, 10, 101), drive(LINE, 40, 8, 101), drive(LINE, 90, 0, 101)]))
    stuck = replace(
        scene,
        vehicles=replace(scene.vehicles, position=scene.vehicles.position + np.array([[0, 0], [0, 0], [0, 2.5]], np.float32)),
    )
    for each in (scene, stuck):  # in the last one the leader is parked 2.5 m beside its lane, out of the way
        x = generated(idm, each).motion.position[..., 0]
        assert (np.diff(x[:, :2], axis=1) > each.vehicles.size[0, 0] - 0.1).all()
    x = generated(idm, scene).motion.position[..., 0]
    assert (x[:, 2] - x[:, 1] > 4.0).all()
    np.testing.assert_array_equal(
        generated(idm, stuck).motion.position[:, 2], np.broadcast_to(stuck.vehicles.position[2], (6, 101, 2))
    )


@pytest.mark.parametrize(("state", "stops"), [(SignalState.RED, True), (SignalState.GREEN, False)])
def test_a_red_light_is_a_wall_and_a_green_one_is_none(idm: Plugin, state: SignalState, stops: bool) -> None:
    roads = crossing()
    scene = scenario(roads, stack([drive(joined(roads, 0, 8, 4), 40, 8, 101)]))
    signals = Signals(np.array([8, 9, 10], np.int32), np.full((3, 101), state, np.uint8))
    x = generated(idm, replace(scene, signals=signals)).motion.position[:, 0, -1]
    inside = (np.abs(x) < 10.0).all(axis=1) | (x[:, 0] > 0)
    assert (~inside).all() == stops
    if stops:
        assert (x[:, 0] > -25).all()
        assert (x[:, 0] < -10).all()


def test_without_a_road_it_goes_straight_on(idm: Plugin) -> None:
    scene = scenario(straight_road(100, 1), stack([drive(LINE + np.array([0.0, 60.0]), 10, 8, 101)]))
    y = generated(idm, scene).motion.position[:, 0, :, 1]
    np.testing.assert_allclose(y, 60, atol=1e-3)


def test_wishes_are_learnt_from_who_drove_freely() -> None:
    plugin = trained("idm")[0]
    free = scenario(straight_road(600, 1), stack([drive(LINE, 10, 0.9 * LIMIT, 101), drive(LINE, 300, 0.1 * LIMIT, 101)]))
    wishes = plugin.examples(plugin.settings, [free])
    np.testing.assert_allclose(wishes.share, [0.9], atol=0.02)


def test_nobody_turns_at_once_though_its_first_heading_is_not_its_ways(idm: Plugin) -> None:
    roads = crossing()
    scene = scenario(roads, stack([drive(joined(roads, 0, 9, 5), 60, 8, 101)]))
    askew = replace(scene, vehicles=replace(scene.vehicles, heading=scene.vehicles.heading + np.float32(0.2)))
    motion = generated(idm, askew).motion
    np.testing.assert_allclose(motion.heading[:, 0, 0], askew.vehicles.heading[0], atol=1e-5)
    steps = np.abs(np.diff(np.unwrap(motion.heading, axis=-1), axis=-1))
    tightest = 0.1 * motion.speed[..., 1:] / 4.0  # within a step, on a circle of 4 m
    assert (steps <= tightest + 0.03).all()  # and what it turns from its first heading besides
