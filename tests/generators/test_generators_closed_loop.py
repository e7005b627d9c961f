"""Who is where: logs as flat arrays, and copies that are driven on."""

import numpy as np

from drivegen.core.scenario import Trajectories
from drivegen.generators.shared.closed_loop import Tracks
from drivegen.store.columns import joined
from tests.models import two_lanes
from tests.scenes import any_scenario, busy_crossing

SCENES = [busy_crossing(41, "a"), any_scenario(3, "b"), two_lanes(9.0, "c", 31)]


def test_logs_of_shards_join_to_the_logs_of_all():
    parts = joined(Tracks, [Tracks.of_logs(SCENES[:1]), Tracks.of_logs(SCENES[1:2]), Tracks.of_logs(SCENES[2:])])
    whole = Tracks.of_logs(SCENES)
    for name in ("start", "planned", "size", "kind", "position", "velocity", "heading", "valid"):
        np.testing.assert_array_equal(getattr(parts, name), getattr(whole, name))
    assert len(joined(Tracks, []).start) == 1


def test_a_crowd_is_all_that_was_there():
    tracks = Tracks.of_logs(SCENES)
    crowd = tracks.at(np.array([2, 0]), np.array([7, 30]))
    log, actors = SCENES[0].log, SCENES[0].context
    first, last = crowd.start[1:]
    assert crowd.start[1] == len(SCENES[2].vehicles) + len(SCENES[2].context)
    np.testing.assert_array_equal(
        crowd.state[first:last, :2], np.concatenate([log.position[:, 30], actors.motion.position[:, 30]])
    )
    np.testing.assert_array_equal(crowd.there[first:last], np.concatenate([log.valid[:, 30], actors.motion.valid[:, 30]]))
    assert crowd.planned[first:last].sum() == len(SCENES[0].vehicles)


def test_copies_begin_alike_and_are_driven_apart():
    tracks = Tracks.of_beginnings(SCENES[:1], 2)
    count = len(SCENES[0].vehicles)
    assert not tracks.valid[tracks.planned, 1:].any()
    box = np.flatnonzero(tracks.planned & (tracks.scene(np.arange(len(tracks.planned))) == 1))
    motion = Trajectories(
        *(np.ones(s, np.float32) for s in ((count, 60, 2), (count, 60), (count, 60, 2))), np.ones((count, 60), bool)
    )
    tracks.drive(box, 0, motion)  # longer than the scene
    made = tracks.samples(SCENES[:1], 2, "some")[0]
    assert made.motion.valid.shape == (2, count, 41)
    assert made.motion.valid[1].all()
    assert not made.motion.valid[0, :, 1:].any()
    np.testing.assert_array_equal(made.motion.position[:, :, 0], np.stack([SCENES[0].vehicles.position] * 2))
