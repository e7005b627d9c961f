"""What is around a vehicle: against plain loops over other geometry, by hand, and what must not change it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.boxes import depth
from drivegen.core.geometry import boxes_gap, boxes_overlap, rotate, to_vehicle_frame
from drivegen.core.scenario import DT, Actors, Trajectories
from drivegen.metrics.features import joined, scene_features
from drivegen.metrics.surroundings import (
    CORNER_ROUNDING,
    FARTHEST,
    Boxes,
    centres_meet,
    overlapping_at_first,
    surroundings,
    touching,
)
from tests.scenes import busy_crossing, noisy_samples

SEEDS = st.integers(0, 2**32 - 1)
SIZES = np.float32([[4.6, 1.9], [12.0, 2.5], [4.0, 1.7], [4.6, 1.9]])


def crowd(seed, samples=2, vehicles=4, steps=9, span=12.0) -> tuple[Trajectories, np.ndarray]:
    """Boxes that jostle in a small place, with gaps, in each sample others."""
    random = np.random.default_rng(seed)
    start = random.uniform(-span, span, (samples, vehicles, 1, 2))
    velocity = random.uniform(-4, 4, (samples, vehicles, 1, 2)).astype(np.float32)
    position = (start + velocity * DT * 5 * np.arange(steps)[:, None]).astype(np.float32)
    heading = random.uniform(-7, 7, (samples, vehicles, steps)).astype(np.float32)
    valid = random.random((samples, vehicles, steps)) < 0.85
    return Trajectories(position, heading, np.broadcast_to(velocity, position.shape), valid), valid


def boxes_of(motion, known, size=SIZES, people=None) -> Boxes:
    there = replace(motion, valid=np.broadcast_to(known, motion.valid.shape))
    return Boxes.of(there, size, Actors.none(motion.steps) if people is None else people)


def pedestrian(motion: Trajectories) -> Actors:
    return Actors(np.array(["p"]), np.array([5], np.uint8), np.float32([[0.6, 0.6, 1.7]]), motion[np.newaxis])


def nearest_by_loops(boxes: Boxes, k, a, t):
    """Smallest gap between boxes whose corners are rounded, one pair after the other."""
    heading = np.arctan2(boxes.sin, boxes.cos).astype(np.float64)
    best = FARTHEST
    for b in range(boxes.valid.shape[1]):
        if b == a or not (boxes.valid[k, a, t] and boxes.valid[k, b, t]):
            continue
        shrink = [CORNER_ROUNDING / 2 * boxes.size[i].min() for i in (a, b)]
        sizes = [boxes.size[i].astype(np.float64) - 2 * s for i, s in zip((a, b), shrink, strict=True)]
        box = [(boxes.position[k, i, t].astype(np.float64), heading[k, i, t]) for i in (a, b)]
        gap = float(boxes_gap(*box[0], sizes[0], *box[1], sizes[1]))
        if gap == 0:
            gap = -depth(*(box[1][0] - box[0][0]), box[0][1], *sizes[0], box[1][1], *sizes[1])
        best = min(best, gap - sum(shrink))
    return best


@given(SEEDS)
@settings(max_examples=20, deadline=None)
def test_distances_are_those_of_loops_over_pairs(seed):
    motion, known = crowd(seed)
    boxes = boxes_of(motion, known)
    found = surroundings(boxes, 4).nearest
    for k, a, t in np.ndindex(found.shape):
        assert found[k, a, t] == pytest.approx(nearest_by_loops(boxes, k, a, t), abs=2e-4)


def leader_by_loops(boxes: Boxes, k, a, t):
    """(gap, speed of the box ahead), from the conditions of Waymo's time to collision, corner by corner."""
    heading, best = np.arctan2(boxes.sin, boxes.cos).astype(np.float64), (np.inf, 0.0)
    place = boxes.position[k, a, t].astype(np.float64)
    for b in range(boxes.valid.shape[1]):
        if b == a or not (boxes.valid[k, a, t] and boxes.valid[k, b, t]):
            continue
        angle = abs((heading[k, b, t] - heading[k, a, t] + np.pi) % (2 * np.pi) - np.pi)
        half = boxes.size[b].astype(np.float64) / 2
        corners = np.array([[x, y] for x in (-half[0], half[0]) for y in (-half[1], half[1])])
        world = rotate(corners, heading[k, b, t]) + boxes.position[k, b, t]
        seen = to_vehicle_frame(world, place, heading[k, a, t])
        ahead = seen[:, 0].min() - boxes.size[a, 0] / 2
        beside = abs(seen[:, 1].mean()) - np.ptp(seen[:, 1]) / 2 - boxes.size[a, 1] / 2
        follows = ahead > 0 and angle <= np.deg2rad(75) and beside < 0 and (beside < -0.5 or angle <= np.deg2rad(10))
        if follows and ahead < best[0]:
            best = (ahead, boxes.speed[k, b, t])
    return best


@given(SEEDS)
@settings(max_examples=20, deadline=None)
def test_the_box_ahead_is_that_of_loops_over_corners(seed):
    motion, known = crowd(seed, span=25.0)
    boxes = boxes_of(motion, known)
    found = surroundings(boxes, 4)
    for k, a, t in np.ndindex(found.gap.shape):
        gap, speed = leader_by_loops(boxes, k, a, t)
        assert found.gap[k, a, t] == pytest.approx(gap, abs=1e-3)
        if np.isfinite(gap):
            assert found.closing[k, a, t] == pytest.approx(boxes.speed[k, a, t] - speed, abs=1e-4, nan_ok=True)


def queue(speeds, starts, steps=20) -> tuple[Trajectories, np.ndarray]:
    """Cars on the x axis at constant speeds."""
    x = np.float32(starts)[:, None] + np.float32(speeds)[:, None] * DT * np.arange(steps, dtype=np.float32)
    position = np.stack([x, np.zeros_like(x)], axis=-1)[None]
    velocity = np.zeros_like(position)
    velocity[..., 0] = np.float32(speeds)[:, None]
    valid = np.ones(x.shape, np.bool_)
    return Trajectories(position, np.zeros((1, *x.shape), np.float32), velocity, valid[None]), valid


def test_time_to_collision_by_hand():
    motion, known = queue([10.0, 6.0, 6.0], [0.0, 24.6, 60.0])
    found = surroundings(boxes_of(motion, known, np.tile(np.float32([4.6, 1.9]), (3, 1))), 3)
    assert found.gap[0, 0, 5] == pytest.approx(20.0 - 2.0, abs=1e-4)
    assert found.time_to_collision[0, 0, 5] == pytest.approx((20.0 - 2.0) / 4.0, abs=1e-3)
    assert found.time_to_collision[0, 1, 5] > 1e4  # as fast as its leader, but for rounding
    assert np.isinf(found.time_to_collision[0, 2, 5])
    assert np.isinf(found.gap[0, 2]).all()
    assert found.nearest[0, 2, 5] == pytest.approx(60.0 - 24.6 - 4.6, abs=1e-4)


def test_a_pedestrian_is_a_partner_and_is_not_judged():
    motion, known = queue([5.0], [0.0])
    standing, _ = queue([0.0], [8.0])
    people = pedestrian(standing[0][0])
    boxes = boxes_of(motion, known, SIZES[:1], people)
    assert surroundings(boxes, 1).nearest.shape == (1, 1, 20)
    assert touching(boxes, 1, np.ones(1)).tolist() == [[[True]]]
    gone = replace(people, motion=replace(people.motion, valid=np.zeros_like(people.motion.valid)))
    alone = boxes_of(motion, known, SIZES[:1], gone)
    assert touching(alone, 1, np.ones(1)).tolist() == [[[False]]]
    assert (surroundings(alone, 1).nearest == FARTHEST).all()


def test_larger_boxes_touch_and_smaller_do_not():
    motion, known = queue([0.0, 0.5], [0.0, -6.0], 25)  # comes from a gap of 1.4 m to one of 0.2 m
    boxes = boxes_of(motion, known, np.tile(np.float32([4.6, 1.9]), (2, 1)))
    assert touching(boxes, 2, np.array([0.9, 1.0, 1.1]))[:, 0, 0].tolist() == [False, False, True]


def test_what_is_given_overlapping_counts_only_after_coming_apart():
    motion, known = queue([0.0, 0.0], [0.0, 4.0], 30)
    boxes = boxes_of(motion, known, np.tile(np.float32([4.6, 1.9]), (2, 1)))
    assert not touching(boxes, 2, np.ones(1)).any()
    assert overlapping_at_first(boxes, 2).all()
    motion.position[0, 1, 10:20, 0] += 5.0
    apart = boxes_of(motion, known, np.tile(np.float32([4.6, 1.9]), (2, 1)))
    assert touching(apart, 2, np.ones(1)).all()


def touching_by_loops(boxes, vehicles, scale):
    hit = np.zeros(boxes.valid.shape[:2], np.bool_)
    heading = np.arctan2(boxes.sin, boxes.cos).astype(np.float64)
    for k, a, b in np.ndindex(*hit.shape, hit.shape[1]):
        inherited, seen = False, False
        for t in np.flatnonzero(boxes.valid[k, a] & boxes.valid[k, b]) if a < b and a < vehicles else ():
            box = [(boxes.position[k, i, t].astype(np.float64), heading[k, i, t], boxes.size[i] * scale) for i in (a, b)]
            overlap = bool(boxes_overlap(*box[0], *box[1]))
            inherited = overlap and (inherited or not seen)
            hit[k, [a, b]] |= overlap and not inherited
            seen = True
    return hit[:, :vehicles]


@given(SEEDS)
@settings(max_examples=15, deadline=None)
def test_touching_is_that_of_loops_at_every_scale(seed):
    motion, known = crowd(seed, steps=15)
    boxes = boxes_of(motion, known)
    scales = np.array([0.7, 1.0, 1.3])
    found = touching(boxes, 4, scales)
    for scale, hit in zip(scales, found, strict=True):
        np.testing.assert_array_equal(hit, touching_by_loops(boxes, 4, scale))


def av2_compute_world_collisions(forecasted):
    """av2.datasets.motion_forecasting.eval.metrics.compute_world_collisions: (M, K, N, 2) -> (M, K)."""
    actors = []
    for i, trajectory in enumerate(forecasted):
        others = np.concatenate([forecasted[:i], forecasted[i + 1 :]])
        actors.append((np.linalg.norm(trajectory - others, axis=-1) < 1.0).any(axis=(0, 2)))
    return np.stack(actors)


@given(SEEDS)
@settings(max_examples=15, deadline=None)
def test_centres_that_meet_are_av2_s_collisions(seed):
    motion, _ = crowd(seed, span=4.0)
    known = np.ones(motion.valid.shape[1:], np.bool_)
    found = centres_meet(boxes_of(motion, known), 4)
    np.testing.assert_array_equal(found.T, av2_compute_world_collisions(np.moveaxis(motion.position, 0, 1).astype(np.float64)))


@given(SEEDS)
@settings(max_examples=10, deadline=None)
def test_the_order_of_vehicles_and_samples_and_the_frame_do_not_matter(seed):
    motion, known = crowd(seed)
    random = np.random.default_rng(seed)
    actors, worlds, angle = random.permutation(4), random.permutation(2), random.uniform(-3, 3)
    turned = Trajectories(
        (rotate(motion.position.astype(np.float64), np.float64(angle)) + 7.0).astype(np.float32),
        (motion.heading + np.float32(angle)).astype(np.float32),
        motion.velocity,
        motion.valid,
    )
    first = surroundings(boxes_of(motion, known), 4)
    again = surroundings(boxes_of(turned[worlds][:, actors], known[worlds][:, actors], SIZES[actors]), 4)
    np.testing.assert_allclose(again.nearest, first.nearest[worlds][:, actors], atol=1e-3)
    np.testing.assert_allclose(again.gap, first.gap[worlds][:, actors], atol=1e-2)


def test_the_log_is_the_last_sample_and_lends_its_mask():
    scene = busy_crossing(40)
    log = replace(scene.log, valid=scene.log.valid.copy())
    log.valid[3, 10:20] = False
    samples = noisy_samples(scene, 3).motion
    both = joined(samples, log)
    np.testing.assert_array_equal(both.position[-1], log.position)
    assert (both.valid == log.valid).all()
    features, _ = scene_features(scene, samples, log, None)
    assert np.isnan(features.edge).all()
    assert not features.known[0][..., 0].any()
    assert not features.known[1][:, 3, 9:21].any()
    assert features.known[0][:, 3, 9].all()
    assert features[:-1].edge.shape[0] == 3
