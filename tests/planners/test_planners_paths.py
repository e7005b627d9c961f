"""Along their paths long vehicles cut bends as their axles keep to the lane, and short ones do not."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from drivegen.core.geometry import unit
from drivegen.core.scenario import DT, Trajectories
from drivegen.planners.base import ROUTE_POINTS, PlanRequests
from drivegen.planners.shared.fitting import encode
from drivegen.planners.shared.motion import GRID, Residuals, decode
from drivegen.planners.shared.paths import LONG, WHEELBASE, Frames
from tests.planners.tiny import examples

ONE = examples(1).requests[:1]
NOTHING = np.zeros((1, GRID), np.float32)


def request(length: float, radius: float, turn: float) -> PlanRequests:
    """One vehicle of `length` [m], 30 m before a bend to the left through `turn` [rad], that keeps 6 m/s for 15 s."""
    s = np.arange(ROUTE_POINTS - 1) + 0.5
    steps = unit(np.clip((s - 30) / radius, 0, turn))
    line = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)]).astype(np.float32)
    number = np.full(1, 6.0, np.float32)
    return replace(
        ONE,
        size=np.array([[length, 2.5, 3.0]], np.float32),
        position=line[:1],
        heading=number * 0,
        speed=number,
        goal_position=line[90:91],
        goal_heading=number * 0 + np.float32(turn),
        goal_speed=number,
        goal_step=np.full(1, 150, np.int32),
        route=np.zeros(1, np.int32),
        route_line=line[None],
        goal_s=number * 15,
        goal_d=number * 0,
    )


def planned(wanted: PlanRequests) -> Trajectories:
    """The motion (151,) without residuals."""
    return decode(Frames.of(wanted), wanted, Residuals(NOTHING, NOTHING, NOTHING), 151)[0]


def away(points: NDArray[np.floating], line: NDArray[np.floating]) -> NDArray[np.float64]:
    """Distances [m] of points (N, 2) from the line (P, 2), to a few centimetres."""
    fine = np.stack([np.interp(np.arange(0, 120, 0.05), np.arange(ROUTE_POINTS), line[:, axis]) for axis in (0, 1)], axis=1)
    return np.asarray(np.hypot(*np.moveaxis(points[:, None] - fine, -1, 0)).min(axis=1))


@settings(max_examples=40, deadline=None)
@given(st.floats(9, 30), st.floats(0.3, 1.7), st.floats(LONG + 0.1, 13))
def test_the_axles_of_a_long_vehicle_keep_to_its_route(radius: float, turn: float, length: float) -> None:
    wanted = request(length, radius, turn)
    motion, line = planned(wanted), wanted.route_line[0]
    axle = WHEELBASE / 2 * length * unit(motion.heading)
    front, rear = away(motion.position + axle, line), away(motion.position - axle, line)
    assert max(front.max(), rear[10:].max()) < 0.3  # it begins with its middle at the line's beginning; corners are rounded
    moved = np.hypot(*np.diff(motion.position, axis=0).T) / DT
    np.testing.assert_allclose(moved, (motion.speed[1:] + motion.speed[:-1]) / 2, atol=0.25)


@pytest.mark.parametrize("length", [2.0, 4.7])
def test_a_short_vehicle_keeps_to_it_with_its_middle(length: float) -> None:
    wanted, long = request(length, 9.0, np.pi / 2), request(12.0, 9.0, np.pi / 2)
    assert away(planned(wanted).position, wanted.route_line[0]).max() < 0.2
    assert away(planned(long).position, long.route_line[0]).max() > 1.0


def test_a_straight_road_is_driven_alike_by_everybody() -> None:
    short, long = planned(request(4.7, 9.0, 0.0)), planned(request(12.0, 9.0, 0.0))
    np.testing.assert_allclose(long.position, short.position, atol=1e-4)
    np.testing.assert_allclose(long.speed, short.speed, atol=1e-4)


def test_what_a_long_vehicle_does_by_its_length_is_no_residual() -> None:
    wanted = request(12.0, 9.0, np.pi / 2)
    motion = planned(wanted)
    assert np.abs(encode(Frames.of(wanted), wanted, motion[None]).across).max() < 0.1
    as_short = replace(wanted, size=wanted.size * np.float32(0.4))
    assert np.abs(encode(Frames.of(as_short), as_short, motion[None]).across).max() > 0.3
