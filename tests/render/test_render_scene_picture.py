"""Pictures of scenes: what has which colour, and where it stands."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from drivegen.core.errors import UnusableInput
from drivegen.render.png import png, shrunk
from drivegen.render.scene_picture import (
    GOAL_COLOUR,
    ILLEGAL_COLOUR,
    PAPER,
    REJECTED_COLOUR,
    SOCIAL_COLOUR,
    TARGET_COLOUR,
    View,
    scene_picture,
    view_of,
)
from tests.scenes import busy_crossing, noisy_samples, rejected_of


def has(image, colour, tolerance=30) -> int:
    return int((np.abs(image.astype(int) - colour).max(axis=-1) <= tolerance).sum())


def test_target_others_and_goals_have_their_colours():
    scene = busy_crossing()
    bare = scene_picture(scene, None)
    marked = scene_picture(scene, None, goals=scene.log.position[:, 60])
    assert has(bare, TARGET_COLOUR) > 20
    assert has(bare, SOCIAL_COLOUR) > 200
    assert has(marked, GOAL_COLOUR) > has(bare, GOAL_COLOUR) + 100


def test_illegal_samples_are_red():
    scene = busy_crossing()
    samples = noisy_samples(scene, 1).motion
    legal = scene_picture(scene, samples, np.zeros((1, 8), np.bool_))
    illegal = scene_picture(scene, samples, np.ones((1, 8), np.bool_))
    assert has(illegal, ILLEGAL_COLOUR, 60) > has(legal, ILLEGAL_COLOUR, 60) + 200


def test_what_was_rejected_is_drawn_where_it_would_have_gone_in_thin_dashes_of_its_own_colour():
    scene = busy_crossing()
    samples = noisy_samples(scene, 1)
    down = rejected_of(samples)
    target = down.only(down.vehicle == 0)
    view = view_of(scene.log, 720)
    plain, marked = (scene_picture(scene, samples.motion, view=view, rejected=one) for one in (None, target))
    changed = (plain != marked).any(axis=-1)
    assert has(marked, REJECTED_COLOUR) > has(plain, REJECTED_COLOUR) + 20
    way = (view.fixed(target.position[0]) / 16).astype(int)
    beside = np.abs(np.argwhere(changed)[:, None, ::-1] - way).max(axis=-1).min(axis=1)
    assert beside.max() <= 8  # nothing else is touched
    drawn = changed[way[:, 1], way[:, 0]]
    assert 0.15 < drawn.mean() < 0.6  # dashes, not a line


def test_the_target_s_box_stands_where_the_view_says():
    scene = busy_crossing()
    view = view_of(scene.log, 720)
    x, y = view.fixed(scene.vehicles.position[0]) // 16
    assert has(scene_picture(scene, None)[y - 2 : y + 3, x - 2 : x + 3], TARGET_COLOUR) > 5


def test_up_is_north_and_far_points_do_not_overflow():
    view = View(np.array([100.0, 50.0]), 100.0, 200)
    assert view.fixed(np.array([100.0, 75.0])).tolist() == [100 * 16, 50 * 16]
    assert np.abs(view.fixed(np.array([1e12, -1e12]))).max() < 2**24


def test_everything_seen_lies_inside_the_view():
    scene = busy_crossing()
    view = view_of(scene.log, 100)
    inside = view.fixed(scene.log.position[0]) / 16
    assert inside.min() > 0
    assert inside.max() < 100


def test_a_picture_is_the_same_every_time_and_is_a_png_in_the_right_colours():
    scene = busy_crossing()
    samples = noisy_samples(scene)
    first, second = (png(scene_picture(scene, samples.motion, ~samples.legal, pixels=200)) for _ in range(2))
    assert first == second
    back = cv2.imdecode(np.frombuffer(first, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]
    assert tuple(back[0, 0]) == PAPER


def test_a_scene_without_a_log_is_drawn_around_its_target():
    assert scene_picture(replace(busy_crossing(), log=None), None, pixels=128).shape == (128, 128, 3)


def test_shrinking_keeps_shape_and_colours():
    data = png(np.full((100, 200, 3), (10, 200, 30), np.uint8))
    small = cv2.imdecode(np.frombuffer(shrunk(data, 50), np.uint8), cv2.IMREAD_COLOR)[..., ::-1]
    assert small.shape == (25, 50, 3)
    assert tuple(small[0, 0]) == (10, 200, 30)
    assert shrunk(data, 400) == data


def test_half_a_picture_is_refused():
    with pytest.raises(UnusableInput, match="not whole"):
        shrunk(png(np.zeros((100, 200, 3), np.uint8))[:40], 50)
