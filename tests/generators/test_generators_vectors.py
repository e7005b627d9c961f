"""Vectors of a first frame, surroundings of each vehicle, motion from knots: by hand and under rigid motion."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import Polylines, rotate, wrap_angle
from drivegen.core.scenario import Scenario
from drivegen.core.signals import Signals, SignalState
from drivegen.generators.shared.motion import DEGREES, KNOTS, at_knots, filled_in, smoothing_table, trajectories
from drivegen.generators.shared.pieces import PIECE, POINTS, Pieces
from drivegen.generators.shared.relative import REACH, surroundings
from drivegen.generators.shared.vectors import ACTORS, AGENTS, PIECES, STEPS, Scenes, local_future
from drivegen.store.columns import joined
from tests.generators.rivals import scenes
from tests.scenes import busy_crossing, crossing, drive, scenario, stack, straight_road

CPU = torch.device("cpu")


def moved(scene: Scenario, turn: float, shift: tuple[float, float]) -> Scenario:
    """The scene turned about the map's origin, then shifted."""

    def put(points):
        return (rotate(points.astype(np.float64), np.float64(turn)) + np.array(shift)).astype(np.float32)

    line = scene.map.centreline
    vehicles = replace(scene.vehicles, position=put(scene.vehicles.position), heading=scene.vehicles.heading + np.float32(turn))
    motion = scene.context.motion
    context = replace(
        scene.context,
        motion=replace(
            motion, position=put(motion.position), velocity=rotate(motion.velocity, np.float32(turn)), heading=motion.heading
        ),
    )
    log = replace(scene.log, position=put(scene.log.position), heading=scene.log.heading + np.float32(turn))
    roads = replace(scene.map, centreline=Polylines(put(line.points), line.start))
    return replace(scene, map=roads, vehicles=vehicles, log=log, context=context)


def test_pieces_cover_every_lane_in_equal_steps() -> None:
    roads = straight_road(100.0, 2)
    scene = scenario(roads, stack([drive(roads.centreline[0].astype(np.float64), 10, 8, 11)]))
    pieces = Pieces.of([scene, scene])
    assert pieces.start.tolist() == [0, 14, 28]
    first = pieces.points[:7]
    np.testing.assert_allclose(first[:, 0, 0], np.arange(7) * 100 / 7, atol=1e-4)
    np.testing.assert_allclose(first[:, -1, 0], np.arange(1, 8) * 100 / 7, atol=1e-4)
    np.testing.assert_array_equal(first[..., 1], 0)
    np.testing.assert_allclose(np.diff(first[..., 0], axis=1), 100 / 7 / (POINTS - 1), atol=1e-4)
    np.testing.assert_array_equal(pieces.points[:14], pieces.points[14:])


def test_no_piece_is_longer_than_it_may_be_and_none_joins_two_lanes() -> None:
    roads = crossing()
    pieces = Pieces.of([scenario(roads, busy_crossing().log)])
    along = np.hypot(*np.moveaxis(np.diff(pieces.points, axis=1), -1, 0)).sum(axis=1)
    assert 0 < along.min() <= along.max() <= PIECE + 1e-3
    total = sum(np.hypot(*np.diff(line, axis=0).T).sum() for line in roads.centreline.lines())
    assert along.sum() == pytest.approx(total, rel=0.02)  # chords of bends are a little shorter


def test_pieces_of_a_scene_do_not_depend_on_the_others() -> None:
    scenes = [moved(busy_crossing(), 0.1 * k, (37.3 * k, -11.7 * k)) for k in range(8)]
    together = Pieces.of(scenes)
    for scene, first, last in zip(scenes, together.start, together.start[1:], strict=False):
        np.testing.assert_array_equal(together.points[first:last], Pieces.of([scene]).points)


def test_signals_are_told_as_they_are_at_step_0_and_never_later() -> None:
    scene = busy_crossing()
    state = np.array([[SignalState.RED] + [SignalState.GREEN] * (scene.steps - 1)], np.uint8)
    red = replace(scene, signals=Signals(np.array([8], np.int32), state))
    other = replace(scene, signals=Signals(np.array([8], np.int32), np.full_like(state, SignalState.RED)))
    assert np.array_equal(Scenes.of([red]).piece, Scenes.of([other]).piece)
    assert not np.array_equal(Scenes.of([red]).piece, Scenes.of([scene]).piece)


def test_the_log_is_not_in_the_first_frame() -> None:
    scene = scenes()[0]
    blind, seeing = Scenes.of([replace(scene, log=None)]), Scenes.of([scene])
    for name in Scenes.__dataclass_fields__:
        np.testing.assert_array_equal(getattr(blind, name), getattr(seeing, name))
    assert blind.future.shape == (1, AGENTS, 0, 2)


@given(st.floats(-3.1, 3.1), st.floats(-200, 200), st.floats(-200, 200))
@settings(max_examples=15, deadline=None)
def test_turning_and_shifting_the_map_changes_nothing_but_the_frame(turn: float, x: float, y: float) -> None:
    scene = busy_crossing()
    here, there = Scenes.with_logs([scene]), Scenes.with_logs([moved(scene, turn, (x, y))])
    for name in ("position", "speed", "agent", "actor_position", "actor_velocity", "future"):
        np.testing.assert_allclose(getattr(here, name), getattr(there, name), atol=2e-2)
    np.testing.assert_allclose(wrap_angle(here.heading - there.heading), 0, atol=1e-4)
    np.testing.assert_array_equal(here.logged, there.logged)
    assert abs(wrap_angle(there.frame[0, 2] - here.frame[0, 2] - np.float32(turn))) < 1e-4


def test_surroundings_are_seen_from_each_vehicle() -> None:
    roads = straight_road(200.0, 2)
    line = roads.centreline[0].astype(np.float64)
    scene = scenario(roads, stack([drive(line, 40, 8, 11), drive(line, 65, 5, 11), drive(line[::-1], 60, 5, 11)]))
    told = Scenes.of([scene]).tensors(CPU)
    seen = surroundings(told, 4)
    ahead = seen.other[0, 0, 1]
    assert ahead[0] * REACH == pytest.approx(25.0, abs=1e-3)
    assert ahead[2] * 10 == pytest.approx(5.0, abs=1e-3)
    facing = seen.other[0, 0, 2]
    assert facing[4] == pytest.approx(-1.0, abs=1e-5)
    assert seen.other[0, 2, 0, 0] * REACH == pytest.approx(100.0, abs=1e-3)  # 140 - 40 m, and ahead for both
    there = seen.there[0, 0]
    assert there[4 : 4 + AGENTS].tolist() == [True] * 3 + [False] * (AGENTS - 3)
    assert not there[4 + AGENTS :].any()
    assert len(there) == 4 + AGENTS + ACTORS


def test_what_the_log_did_is_seen_from_the_vehicle() -> None:
    scene = scenario(straight_road(), stack([drive(straight_road().centreline[1].astype(np.float64)[::-1], 20, 6, 101)]))
    future = local_future(Scenes.with_logs([scene]).tensors(CPU))[0, 0]
    np.testing.assert_allclose(future[:, 0], 0.6 * np.arange(1, STEPS + 1), atol=0.05)
    np.testing.assert_allclose(future[:, 1], 0, atol=1e-3)


def test_more_vehicles_than_there_is_room_for_are_named() -> None:
    line = straight_road(600).centreline[0].astype(np.float64)
    scene = scenario(straight_road(600), stack([drive(line, 10 + 20 * k, 5, 11) for k in range(AGENTS + 1)]))
    with pytest.raises(UnusableInput, match="max_vehicles"):
        Scenes.of([scene])


def test_padding_and_joining_keep_rows_as_they_are() -> None:
    three = Scenes.of(scenes())
    assert len(three.padded(5)) == 5
    assert not three.padded(5).present[3:].any()
    again = joined(Scenes, [three[0:1], three[1:3]])
    for name in Scenes.__dataclass_fields__:
        np.testing.assert_array_equal(getattr(again, name), getattr(three, name))
    assert len(joined(Scenes, [])) == 0
    assert three.points.shape == (3, PIECES, POINTS, 2)


@given(st.floats(0, 30), st.floats(-1.5, 1.5), st.floats(-0.02, 0.02))
@settings(max_examples=20, deadline=None)
def test_knots_of_a_steady_motion_give_that_motion(speed: float, acceleration: float, bend: float) -> None:
    t = np.arange(1, STEPS + 1) * 0.1
    dense = np.stack([speed * t + acceleration * t**2 / 2, bend * t**3], axis=-1)[None, None]
    position, velocity = filled_in(
        at_knots(torch.from_numpy(dense)).numpy().astype(np.float32), np.full((1, 1), speed, np.float32)
    )
    np.testing.assert_allclose(position, dense, atol=0.2)  # the curvature is taken to end at 0
    np.testing.assert_allclose(position[:, :, :85], dense[:, :, :85], atol=5e-3)
    np.testing.assert_allclose(velocity[0, 0, :80, 0], speed + acceleration * t[:80], atol=1e-2)


def test_smoothing_is_a_projection_that_keeps_smooth_curves() -> None:
    table, share = smoothing_table(), np.arange(1, KNOTS + 1) / KNOTS
    np.testing.assert_allclose(table @ table, table, atol=1e-10)
    assert np.trace(table) == pytest.approx(DEGREES)
    braking = share**2 * (1 - 0.5 * share)
    np.testing.assert_allclose(table @ braking, braking, atol=1e-10)
    zigzag = (-1.0) ** np.arange(KNOTS)
    assert np.abs(table @ zigzag)[:-2].max() < 0.4


def test_who_stands_and_who_hardly_moves_is_parked_only_if_both_are_true() -> None:
    line = straight_road(600).centreline[0].astype(np.float64)
    scene = scenario(straight_road(600), stack([drive(line, 100 * k, speed, 101) for k, speed in enumerate((0.0, 0.0, 2.0))]))
    position = np.zeros((1, 3, STEPS, 2), np.float32)
    position[0, :, :, 0] = np.outer((0.9, 1.1, 0.9), np.linspace(0, 1, STEPS))
    motion = trajectories(scene, position, np.zeros_like(position))
    gone = motion.position[0, :, -1, 0] - scene.vehicles.position[:, 0]
    np.testing.assert_allclose(gone, (0, 1.1, 0.9), atol=1e-4)


def test_parked_vehicles_stay_and_longer_scenarios_go_straight_on() -> None:
    line = straight_road(600).centreline[0].astype(np.float64)
    scene = scenario(straight_road(600), stack([drive(line, 10, 8, 131), drive(line, 100, 0, 131)]))
    knots = np.zeros((1, 2, KNOTS, 2), np.float32)
    knots[0, 0, :, 0] = 4.0 * np.arange(1, KNOTS + 1)
    knots[0, 1, :, 0] = 0.5 * np.sin(np.arange(KNOTS))
    motion = trajectories(scene, *filled_in(knots, scene.vehicles.speed))
    assert motion.valid.shape == (1, 2, 131)
    np.testing.assert_array_equal(motion.position[0, 1], np.repeat(scene.vehicles.position[1][None], 131, 0))
    np.testing.assert_array_equal(motion.velocity[0, 1], 0)
    np.testing.assert_allclose(motion.position[0, 0, :, 0], 10 + 0.8 * np.arange(131), atol=1e-2)
    np.testing.assert_allclose(motion.heading, 0, atol=1e-5)
