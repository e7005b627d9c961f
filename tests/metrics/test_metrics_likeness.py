"""Distances between kinds of traffic: by hand, and zero, symmetric and growing where they must be."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.core.recorded_log import NO_TRACK, RecordedLog
from drivegen.core.scenario import Trajectories
from drivegen.core.signals import Signals
from drivegen.metrics.distributions import BINS
from drivegen.metrics.likeness import NAMES, RANGES, Traffic, distances, halves_apart, traffic
from tests.scenes import drive, stack, straight_road

STEPS = 110


def recording(*motions: Trajectories) -> RecordedLog:
    """Cars of 4 x 2 m on a straight road of several lanes."""
    count = len(motions)
    return RecordedLog(
        scenario_id="x", source="test", city="x", map=straight_road(400), track_id=np.array([str(i) for i in range(count)]),
        kind=np.zeros(count, np.uint8), size=np.full((count, 3), (4.0, 2.0, 1.5), np.float32), motion=stack(list(motions)),
        focal=0, ego=NO_TRACK, signals=Signals.none(STEPS), skipped={},
    )  # fmt: skip


def lane(number: int) -> np.ndarray:
    return straight_road(400).centreline[number].astype(np.float64)


def mean(found: Traffic, name: str) -> float:
    low, high = RANGES[name]
    counts = found.counts[list(RANGES).index(name)]
    return float(counts @ (low + (np.arange(BINS) + 0.5) * (high - low) / BINS) / counts.sum())


def test_a_follower_has_the_headway_and_time_to_collision_that_its_gap_and_speeds_say():
    found = traffic(recording(drive(lane(0), 20, 10, STEPS), drive(lane(0), 64, 5, STEPS)))
    # the gap of 40 m closes by 5 m/s: at step t it is 40 - 0.5 t, the time to collision 8 - 0.1 t, the headway 4 - 0.05 t
    counted = np.arange(9, 80)  # until the boxes touch
    assert mean(found, "time_to_collision") == pytest.approx((8 - 0.1 * counted).mean(), abs=0.3)
    assert mean(found, "speed") == pytest.approx(7.5, abs=0.1)
    assert mean(found, "acceleration") == pytest.approx(0, abs=0.05)
    assert found.rates[0, 0] == 0
    assert found.rates[0, 1] == pytest.approx((10 + 5) * 0.1 * (STEPS - 17) / 1000, rel=0.01)


def test_who_stands_is_counted_and_who_stands_beside_the_road_is_not():
    moving, standing = drive(lane(0), 20, 10, STEPS), drive(lane(0), 200, 0, STEPS)
    beside = replace(standing, position=standing.position + np.float32((0, -12)))
    shares = [traffic(recording(moving, *others)).rates[1] for others in ([standing], [standing, beside])]
    assert [events / of for events, of in shares] == [0.5, 0.5]


def test_a_track_with_a_gap_is_not_averaged_over_it():
    hidden = drive(lane(0), 200, 0, STEPS)
    hidden.position[50], hidden.valid[50] = 0, False
    averaged = STEPS - 16  # not eight steps at either end, nor eight on each side of the gap; what begins or ends has no speed
    standing, all_steps = traffic(recording(drive(lane(1), 20, 10, STEPS), hidden)).rates[1].tolist()
    assert (standing, all_steps) == (averaged - 17 - 4, 2 * averaged - 17 - 6)


def test_a_change_where_no_kilometre_is_counted_is_none():
    """At its ends a track cannot be smoothed: what happens there is on no counted way."""
    change = np.zeros((STEPS, 1))
    change[:4] = 1.0
    straight = drive(lane(0), 20, 10, STEPS)
    early = replace(straight, position=(straight.position + change * (lane(1)[0] - lane(0)[0])).astype(np.float32))
    assert traffic(recording(early)).rates[0, 0] == 0


def test_a_change_of_lane_is_one_and_wander_is_an_offset():
    t = np.linspace(0, 1, STEPS)
    shift = np.clip(3 * t - 1, 0, 1)[:, None] * (lane(1)[0] - lane(0)[0])
    straight = drive(lane(0), 20, 10, STEPS)
    changed = replace(straight, position=(straight.position + shift).astype(np.float32))
    wave = np.stack([0 * t, 0.6 * np.sin(12 * t)], axis=-1)
    wandering = replace(straight, position=(straight.position + wave).astype(np.float32))
    assert traffic(recording(changed)).rates[0, 0] == 1
    steady, unsteady = traffic(recording(straight)), traffic(recording(wandering))
    assert unsteady.rates[0, 0] == 0
    apart = dict(zip(NAMES, distances([steady], [unsteady]), strict=True))
    assert apart["lateral_offset"] == pytest.approx(0.6 * 2 / np.pi, rel=0.15)
    assert apart["speed"] < 0.5


def test_distances_to_itself_are_zero_and_sources_count_equally():
    slow = traffic(recording(drive(lane(0), 20, 5, STEPS), drive(lane(0), 40, 5, STEPS)))
    fast = traffic(recording(drive(lane(0), 20, 15, STEPS), drive(lane(0), 60, 15, STEPS)))
    much = Traffic.total([fast] * 9)
    same = distances([slow, fast], [much, slow])
    assert same[:4] == pytest.approx(0)
    speed = NAMES.index("speed")
    assert distances([slow], [fast])[speed] == pytest.approx(10, abs=0.01)
    assert distances([slow], [slow, fast])[speed] == pytest.approx(5, abs=0.01)
    assert halves_apart([[slow, fast]], 5, np.random.default_rng(0))[speed] == pytest.approx(10, abs=0.01)
