"""The bird-eye image: numbers never overlap, lie inside, stand at their places."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.render.bird_eye import EXTENT, draw_bird_eye
from drivegen.render.marks import place_marks
from tests import scenes

SCENE = scenes.busy_crossing()


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 10**6), count=st.integers(1, 40), spread=st.floats(0, 600))
def test_marks_never_overlap_and_lie_inside(seed, count, spread):
    random = np.random.default_rng(seed)
    anchors = 384 + random.uniform(-spread, spread, (count, 2))
    half = np.stack([random.choice([13.0, 50.0], count), np.full(count, 13.0)], axis=1)
    placed = place_marks(anchors, half, 2.0, 768)
    assert (placed - half >= 0).all()
    assert (placed + half <= 768).all()
    apart = np.abs(placed[:, None] - placed) - (half[:, None] + half + 2.0 - 1e-6)
    assert (apart.max(-1) >= 0)[~np.eye(count, dtype=bool)].all()


def test_a_mark_with_room_stays_where_it_is():
    anchors = np.array([[100.0, 100.0], [300.0, 200.0]])
    assert np.array_equal(place_marks(anchors, np.full((2, 2), 13.0), 2.0, 768), anchors)


def test_the_image_is_heading_up_and_numbers_stand_at_their_places():
    heading, where = SCENE.vehicles.heading[0], SCENE.vehicles.position[0]
    ahead = where + 40 * np.array([np.cos(heading), np.sin(heading)])
    left = where + 40 * np.array([-np.sin(heading), np.cos(heading)])
    picture, marks = draw_bird_eye(SCENE, 0, np.stack([ahead, left]), np.array([1, -1]))
    scale = 768 / EXTENT
    assert picture.shape == (768, 768, 3)
    assert np.allclose(marks.place, [(384, 384 - 40 * scale), (384 - 40 * scale, 384)], atol=0.1)
    assert np.allclose(marks.disc, marks.place)
    for x, y in marks.disc.round().astype(int):
        disc = picture[y - 10 : y + 10, x - 10 : x + 10].astype(int).sum(-1)
        assert (disc < 150).mean() > 0.3  # dark disc ...
        assert (disc > 600).any()  # ... with a white digit


def test_goals_outside_the_window_are_noted_inside_it():
    far = SCENE.vehicles.position[0] + np.array([[150.0, 10.0], [300.0, -20.0], [0.0, 500.0], [150.0, 10.0]])
    picture, marks = draw_bird_eye(SCENE, 0, far, np.array([3, 4, -1, 3]))
    assert not marks.inside.any()
    assert ((marks.disc > 13) & (marks.disc < 755)).all()
    near = np.hypot(*(marks.disc[:, None] - marks.disc).transpose(2, 0, 1)) + 1000 * np.eye(4)
    assert near.min() >= 28
    without, _ = draw_bird_eye(SCENE, 0, far[:0], np.zeros(0, int))
    assert (picture != without).any()


def test_the_vehicle_itself_is_magenta_in_the_middle():
    for vehicle in range(len(SCENE.vehicles)):
        picture, _ = draw_bird_eye(SCENE, vehicle, np.zeros((0, 2)), np.zeros(0, int))
        red, green, blue = picture[384, 384].astype(int)
        assert red > 180
        assert green < 80 < blue


def test_the_same_scene_gives_the_same_pixels_and_vehicle_frames_do_not_matter():
    first, _ = draw_bird_eye(SCENE, 2, SCENE.log.position[2, ::20], np.full(6, -1))
    again, _ = draw_bird_eye(SCENE, 2, SCENE.log.position[2, ::20], np.full(6, -1))
    assert np.array_equal(first, again)
