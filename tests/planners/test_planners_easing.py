"""Bends that would be taken too fast are taken calmly, over the same way in the same time; other speeds stay as they are."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from drivegen.core.geometry import unit
from drivegen.core.scenario import DT
from drivegen.planners.base import ROUTE_POINTS
from drivegen.planners.shared.easing import CALM, HARD, ease

STEPS = 101


def bend(radius: float, turn: float, before: float) -> NDArray[np.float64]:
    """A path (P, 2): straight on for `before` [m], to the right through `turn` [rad], straight on."""
    s = np.arange(ROUTE_POINTS - 1) + 0.5
    return np.concatenate([np.zeros((1, 2)), np.cumsum(unit(-np.clip((s - before) / radius, 0, turn)), axis=0)])


def steady(speed: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Speeds and ways (101,) of who keeps its speed [m/s]."""
    return np.full(STEPS, speed), np.arange(STEPS) * DT * speed


def eased(line: NDArray[np.float64], speed: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Speeds and ways (101,) of who would keep its speed [m/s] along `line`."""
    v, gone = steady(speed)
    ease(line, 0.0, 0.0, float(gone[-1]), v, gone)
    return v, gone


def across(v: NDArray[np.float64], gone: NDArray[np.float64], radius: float, turn: float, before: float) -> float:
    """The highest acceleration across [m/s2], of means over a second: turns by the ways of a circle, not by the path's points."""
    heading = np.clip((gone - before) / radius, 0, turn)
    return float((v[5:-5] * (heading[10:] - heading[:-10]) / (10 * DT)).max())


@settings(max_examples=60, deadline=None)
@given(st.floats(8, 30), st.floats(0.6, 1.6), st.floats(40, 60), st.floats(8, 14))
def test_a_bend_is_taken_calmly_over_the_same_way_and_time(radius: float, turn: float, before: float, speed: float) -> None:
    v, gone = eased(bend(radius, turn, before), speed)
    assert (v[0], v[-1], gone[0]) == (speed, speed, 0.0)
    assert gone[-1] == pytest.approx(100 * DT * speed)
    assert (v >= 0).all()
    assert (np.diff(gone) >= 0).all()
    was = across(*steady(speed), radius, turn, before)
    if was < 0.9 * HARD:
        assert (v == speed).all()
    elif not (v == speed).all() and gone[-1] > before + radius * turn + 20:
        assert across(v, gone, radius, turn, before) < min(was, HARD + 0.6)


def test_speeds_and_ways_belong_together() -> None:
    v, gone = eased(bend(10.0, 1.5, 50.0), 8.0)
    np.testing.assert_allclose(np.diff(gone) / DT, (v[1:] + v[:-1]) / 2, atol=0.3)
    assert v[(gone > 54) & (gone < 61)].max() < 1.1 * np.sqrt(CALM * 10.0)
    assert v.max() > 8.5  # what is lost is made up elsewhere


def test_who_stands_for_a_while_stands_as_long() -> None:
    line, v = bend(8.0, 1.5, 40.0), np.concatenate([np.zeros(30), np.linspace(0, 14, 71)])
    gone = np.concatenate([[0.0], np.cumsum((v[1:] + v[:-1]) / 2 * DT)])
    was, way = v.copy(), float(gone[-1])
    ease(line, 0.0, 0.0, way, v, gone)
    assert (v[:30] == 0).all()
    assert not np.array_equal(v, was)


def test_a_bend_that_there_is_no_time_for_is_left_to_the_checker() -> None:
    v, _ = eased(bend(5.0, 1.5, 4.0), 30.0)
    assert (v == 30.0).all()
