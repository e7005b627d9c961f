import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.geometry import rotate
from drivegen.core.scenario import Trajectories
from drivegen.metrics.driving import comfort, driving_summary, run_numbers, spread_over_runs, spread_over_samples
from tests.scenes import drive, stack

LINE = np.array([[0.0, 0.0], [500.0, 0.0]])


def cut(motion, steps):
    return Trajectories(motion.position, motion.heading, motion.velocity, np.arange(motion.steps) < steps)


def test_distance_and_acceleration_of_a_steady_start_and_stop():
    numbers = run_numbers(stack([drive(LINE, 0, 10, 101), drive(LINE, 0, 0, 101, 2.0), drive(LINE, 0, 10, 101, -1.0)]))
    assert numbers.distance == pytest.approx([100, 100, 50], rel=1e-3)
    assert numbers.absolute_acceleration == pytest.approx([0, 2, 1], abs=1e-3)
    assert numbers.acceleration == pytest.approx([0, 2, -1], abs=1e-3)
    assert numbers.hardest_braking == pytest.approx([0, 0, 1], abs=1e-3)
    assert numbers.seconds == pytest.approx([10, 10, 10])


def test_what_comes_after_a_collision_is_not_driven():
    numbers = run_numbers(stack([cut(drive(LINE, 0, 10, 101), 31), cut(drive(LINE, 0, 10, 101), 1)]))
    assert numbers.distance == pytest.approx([30, 0], abs=1e-3)
    assert np.isnan(numbers.absolute_acceleration[1])


def test_comfort_has_two_readings():
    numbers = run_numbers(stack([drive(LINE, 0, 5, 51, 2.0), drive(LINE, 0, 20, 51, -1.0)]))
    assert comfort(numbers.absolute_acceleration.mean()) == pytest.approx(1 / 1.5, rel=1e-3)
    assert comfort(numbers.acceleration.mean()) == pytest.approx(1 / 0.5, rel=1e-3)
    assert np.isnan(comfort(0.0))
    assert np.isnan(comfort(np.nan))


def test_spread_over_runs_by_hand():
    """Three speeds on one line: the deviation of the distances grows with time, and headings don't matter."""
    motions = [drive(LINE, start, speed, 101) for start, speed in ((0, 8), (50, 10), (100, 12))]
    by_hand = np.mean([np.std([8 * t, 10 * t, 12 * t]) for t in np.arange(101) * 0.1])
    assert spread_over_runs(stack(motions), np.ones((1, 3))) == pytest.approx([by_hand], rel=1e-4)
    turned = [
        Trajectories(rotate(m.position, np.float32(a)), m.heading + np.float32(a), rotate(m.velocity, np.float32(a)), m.valid)
        for m, a in zip(motions, (0.0, 2.0, -1.0), strict=True)
    ]
    assert spread_over_runs(stack(turned), np.ones((1, 3))) == pytest.approx([by_hand], rel=1e-3)


def test_weights_are_repetitions():
    motions = stack([drive(LINE, 0, v, 41) for v in (3, 7, 11)])
    repeated = motions[np.array([0, 0, 2])]
    assert spread_over_runs(motions, np.array([[2.0, 0.0, 1.0]])) == pytest.approx(spread_over_runs(repeated, np.ones((1, 3))))


def test_steps_with_one_run_do_not_count():
    runs = stack([drive(LINE, 0, 5, 41), cut(drive(LINE, 0, 9, 41), 11)])
    assert spread_over_runs(runs, np.ones((1, 2))) == pytest.approx([np.mean(2 * np.arange(11) * 0.1)], rel=1e-4)


def test_spread_over_samples_is_within_scenes():
    runs = stack(
        [drive(LINE, 0, 5, 41), drive(LINE, 0, 9, 41), drive(LINE, 300, 20, 41), drive(LINE, 300, 20, 41), drive(LINE, 0, 1, 41)]
    )
    spread = spread_over_samples(runs, np.array([0, 0, 1, 1, 2]))
    assert spread[0] == pytest.approx(np.mean(2 * np.arange(41) * 0.1), rel=1e-4)
    assert spread[1] == pytest.approx(0.0, abs=1e-4)
    assert np.isnan(spread[2])


def test_the_spread_of_few_recordings_has_an_interval_though_some_draws_hold_a_single_run():
    runs = stack([drive(LINE, 0, v, 41) for v in (3, 5, 9)])
    metrics = {"absolute_acceleration": np.full(3, 0.5), "acceleration": np.full(3, -0.25)}
    found = driving_summary(metrics, ["a", "b", "c"], runs, np.arange(3), 200, np.random.default_rng(7))
    assert found["spread_over_runs.low"] <= found["spread_over_runs"] <= found["spread_over_runs.high"]


def test_a_summary_counts_runs_and_has_intervals_over_recordings():
    """Three scenarios of two recordings, one run in the first and two in the others."""
    runs, scene = stack([drive(LINE, 0, v, 41) for v in (3, 5, 7, 9, 11)]), np.array([0, 1, 1, 2, 2])
    metrics = {
        "collision": np.array([0.0, 0.5, 1.0]),
        "absolute_acceleration": np.full(3, 0.5),
        "acceleration": np.full(3, -0.25),
        "distance": np.array([30.0, 50.0, 80.0]),
        "planned_distance": np.array([40.0, 60.0, 100.0]),
        "red_run": np.array([1.0, 0.5, 0.0]),
        "red_lights": np.array([1.0, 1.0, 2.0]),
    }
    found = driving_summary(metrics, ["a", "a", "b"], runs, scene, 200, np.random.default_rng(7))
    assert (found["scenarios"], found["recordings"], found["runs"]) == (3, 2, 5)
    assert found["collision"] == pytest.approx(0.5)
    assert (found["collision.low"], found["collision.high"]) == pytest.approx((0.25, 1.0))  # all of a, all of b
    assert (found["comfort_absolute"], found["comfort_signed"]) == pytest.approx((2.0, 4.0))
    assert (found["progress"], found["progress.low"], found["progress.high"]) == pytest.approx((160 / 200, 0.8, 0.8))
    assert (found["red_share"], found["red_share.low"], found["red_share.high"]) == pytest.approx((1.5 / 4, 0.0, 0.75))
    assert found["spread_over_runs"] == pytest.approx(spread_over_runs(runs, np.ones((1, 5)))[0])
    ends = [spread_over_runs(runs, times[None])[0] for times in (np.array([2.0, 2, 2, 0, 0]), np.array([0, 0, 0, 2.0, 2]))]
    assert (found["spread_over_runs.low"], found["spread_over_runs.high"]) == pytest.approx(
        (min(ends), max([*ends, found["spread_over_runs"]]))
    )


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 1000), st.floats(0.1, 5.0))
def test_numbers_are_those_of_plain_loops_and_scale_with_length(seed, scale):
    random = np.random.default_rng(seed)
    shape = (4, 12)
    position = random.normal(0, 5, (*shape, 2)).astype(np.float32)
    velocity = random.normal(0, 5, (*shape, 2)).astype(np.float32)
    valid = np.arange(12) < random.integers(2, 13, (4, 1))
    motion = Trajectories(position, random.uniform(-3, 3, shape).astype(np.float32), velocity, valid)
    numbers = run_numbers(motion)
    for i in range(4):
        steps = [t for t in range(11) if valid[i, t + 1]]
        speeds = np.hypot(velocity[i, :, 0], velocity[i, :, 1]).astype(float)
        assert numbers.distance[i] == pytest.approx(
            sum(np.hypot(*(position[i, t + 1] - position[i, t])) for t in steps), rel=1e-4
        )
        changes = [(speeds[t + 1] - speeds[t]) / 0.1 for t in steps]
        assert numbers.absolute_acceleration[i] == pytest.approx(np.mean(np.abs(changes)), rel=1e-4)
    larger = Trajectories(position * np.float32(scale), motion.heading, velocity, valid)
    assert run_numbers(larger).distance == pytest.approx(numbers.distance * scale, rel=1e-3)
    ones = np.ones((1, 4))
    assert spread_over_runs(larger, ones) == pytest.approx(spread_over_runs(motion, ones) * scale, rel=1e-3)
