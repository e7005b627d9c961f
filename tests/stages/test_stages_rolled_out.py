"""A generator's roll-outs on validation logs: what weights and temperatures are chosen by."""

from collections.abc import Sequence

import numpy as np

from drivegen.checker.verdicts import judged
from drivegen.core.samples import Samples
from drivegen.core.scenario import Scenario
from stages._rolled_out import rolled_out
from tests.checking import LIMITS
from tests.scenes import drive, joined, scenario, stack, straight_road


class Straight:
    """Goes on at its speed whether or not there is road."""

    def generate(self, scenarios: Sequence[Scenario], samples: int, seed: int) -> list[Samples]:
        lines = [np.array([[0.0, 0.0], [400.0, 0.0]]), np.array([[0.0, 3.5], [400.0, 3.5]])]
        motion = stack([stack([drive(line, 20, pace, 101) for line, pace in zip(lines, (12, 5), strict=True)])] * samples)
        return [Samples.without_goals(scene.scenario_id, "straight", motion) for scene in scenarios]


def test_who_leaves_the_map_is_gone_as_in_the_futures_that_are_judged():
    roads = straight_road(100, 2, whole=True)
    scene = scenario(roads, stack([drive(joined(roads, 0), 20, 12, 101), drive(joined(roads, 1), 20, 5, 101)]))
    [(motion, log)] = rolled_out(Straight(), [scene], 2, 7)
    assert log is scene.log
    assert motion.valid.sum(axis=-1).tolist() == [[65, 101]] * 2  # 20 + 2.3 + 12 * 6.5 >= 100
    as_judged = judged(scene, Straight().generate([scene], 2, 7)[0], LIMITS).motion
    np.testing.assert_array_equal(motion.position, as_judged.position)
