"""The checker looks at the part of a map where motion is: verdicts are those of the whole map."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.checker.limits import RULES
from drivegen.checker.scene import SceneChecker, check_samples
from drivegen.roads.drivable import MARGIN
from tests.checking import LIMITS
from tests.scenes import busy_crossing, noisy_samples


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.floats(0, 30), st.floats(-600, 600))
def test_rasters_of_where_motion_is_say_of_it_what_those_of_the_whole_map_say(seed, astray, away):
    """Among vehicles that are somewhat or far off the road, or nowhere; whatever was judged before."""
    scene, random = busy_crossing(), np.random.default_rng(seed)
    motion = noisy_samples(scene, 3, seed).motion
    shift = random.normal(0, astray, (*motion.valid.shape[:2], 1, 2)).astype(np.float32)
    shift[0, 0] += np.float32(away)
    motion = replace(motion, position=motion.position + shift, valid=motion.valid & (random.random(motion.valid.shape) < 0.95))
    everywhere = replace(motion, position=random.uniform(-2000, 2000, motion.position.shape).astype(np.float32))
    whole, part, growing = (SceneChecker(scene, LIMITS) for _ in range(3))
    whole.severities(everywhere)
    for one in range(len(scene.vehicles)):
        growing.alone(np.full(3, one), motion[:, one])
    expected = whole.severities(motion)
    for checker in (part, growing):
        found = checker.severities(motion)
        assert np.array_equal(found.worst, expected.worst)
        assert np.array_equal(found.first, expected.first)
    assert expected.worst[..., RULES.index("off_road")].max() <= MARGIN


def test_nobody_anywhere_is_legal():
    scene = busy_crossing()
    nobody = replace(noisy_samples(scene, 1).motion, valid=np.zeros((1, len(scene.vehicles), scene.steps), np.bool_))
    assert not check_samples(scene, nobody, LIMITS)[0].any()
