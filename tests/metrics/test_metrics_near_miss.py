"""Near misses by hand."""

import numpy as np

from drivegen.metrics.near_miss import near_misses, rich_in_encounters
from tests.scenes import crossing, drive, joined, scenario, stack, straight_road

ROAD = straight_road()
LINE = ROAD.centreline[0].astype(np.float64)


def follows(speed, gap, leader=5.0, lateral=0.0, steps=31):
    """Whether a target misses narrowly that drives on at `speed`, `gap` metres of air behind a car."""
    beside = LINE + np.array([0.0, lateral])
    log = stack([drive(LINE, 10, speed, steps), drive(beside, 10 + 4.6 + gap, leader, steps)])
    scene = scenario(ROAD, log)
    return bool(near_misses(log[:1], [scene], [log])[0])


def test_who_closes_in_within_a_second_and_a_half_misses_narrowly():
    assert follows(10.0, 20.0)  # 20 m at 5 m/s: 4 s at first, 1 s at the end
    assert not follows(10.0, 25.0)  # 2 s at the end
    assert not follows(5.0, 1.0)  # near, but it does not close in
    assert not follows(10.0, 20.0, lateral=3.5)  # in the other lane


def test_traffic_may_be_shorter_than_its_scenario():
    log = stack([drive(LINE, 10, 10, 101), drive(LINE, 34.6, 5, 101)])
    scene = scenario(ROAD, log)
    assert near_misses(log[:1].until(41), [scene], [log.until(41)])[0]
    assert not near_misses(log[:1].until(21), [scene], [log.until(21)])[0]


def test_the_first_second_and_what_comes_after_the_end_do_not_count():
    log = stack([drive(LINE, 10, 10, 31), drive(LINE, 34.6, 5, 31)])
    ended = log[:1]
    ended.valid[0, 20:] = False  # 2.0 s before contact
    assert not near_misses(ended, [scenario(ROAD, log)], [log])[0]
    assert not follows(10.0, 3.0, leader=9.0, steps=10)


def test_scenes_rich_in_encounters_are_known_by_their_logs():
    roads = crossing()
    ways = [drive(joined(roads, 0, 8, 4), 40, 10, 101), drive(joined(roads, 1, 11, 5), 5, 10, 101)]  # 3.5 s apart
    crosses = scenario(roads, stack(ways))
    late = scenario(roads, stack([ways[0], drive(joined(roads, 1, 11, 5), 0, 6, 101)]))
    closes = scenario(ROAD, stack([drive(LINE, 10, 10, 41), drive(LINE, 44.6, 5, 41)]))  # from 6 s to 2 s
    alone = scenario(ROAD, stack([drive(LINE, 10, 10, 41), drive(LINE, 60, 10, 41)]))
    scenes = [crosses, late, closes, alone]
    assert rich_in_encounters(scenes, [scene.log for scene in scenes]).tolist() == [True, False, True, False]
