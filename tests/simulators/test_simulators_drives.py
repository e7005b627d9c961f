"""Means over each scenario's runs, with outcomes set by hand."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import Scenario, Trajectories
from drivegen.drivers.idm import Plugin as Idm
from drivegen.simulators.batch import Plugin as Batch
from drivegen.simulators.shared.drives import Drives
from drivegen.world.outcome import CollisionKind, DrivingOutcome
from drivegen.world.paths import TargetPaths
from tests.checking import IDM
from tests.scenes import drive, scenario, stack, straight_road

ROAD = straight_road()
LINE = ROAD.centreline[0].astype(np.float64)


class Replay:
    """Every target drives as its traffic says; who starts beyond 50 m is said to collide with its front."""

    name = "replay"

    def run(
        self,
        driver: object,
        scenarios: Sequence[Scenario],
        traffic: Sequence[Trajectories],
        paths: TargetPaths | None = None,
        attacker: NDArray[np.integer] | None = None,
    ) -> DrivingOutcome:
        motion = stack([one[0] for one in traffic])
        hit = motion.position[:, 0, 0] > 50
        count = len(scenarios)
        return DrivingOutcome(
            kind=np.where(hit, CollisionKind.FRONT, CollisionKind.NONE).astype(np.uint8),
            step=np.where(hit, 20, -1).astype(np.int16),
            partner=np.where(hit, 1, -1).astype(np.int32),
            left_map=np.zeros(count, np.bool_),
            motion=motion,
            contact=np.where(hit, 3, 0).astype(np.uint8),
            at_fault=hit,
            impact_speed=np.where(hit, 4, np.nan).astype(np.float32),
            imposed_braking=np.zeros(count, np.float32),
            imposed_loss=np.zeros(count, np.float32),
            red_lights=np.full(count, 2, np.float32),
            red_run=np.ones(count, np.float32),
            off_road=np.full(count, np.nan, np.float32),
        )


def driven(name: str, *starts: float) -> Drives:
    """One scenario, a run at 10 m/s from each start [m]."""
    motions = [stack([drive(LINE, start, 10, 51)]) for start in starts]
    scene = scenario(ROAD, motions[0], name)
    return Drives.of(Replay(), Idm(IDM), [(scene, motion) for motion in motions])


def test_runs_of_shards_of_different_lengths_are_joined() -> None:
    motion = stack([drive(LINE, 10, 10, 31)])
    shorter = Drives.of(Replay(), Idm(IDM), [(scenario(ROAD, motion, "b"), motion)])
    both = Drives.joined([driven("a", 10), shorter])
    np.testing.assert_allclose(both.per_scenario()["distance"], [50, 30], rtol=1e-4)


def test_a_run_of_one_step_has_no_comfort_and_leaves_that_of_the_others() -> None:
    free = stack([drive(LINE, 20, 10, 51), drive(LINE, 200, 10, 51)])
    inside = stack([drive(LINE, 20, 10, 51), drive(LINE, 21, 10, 51)])
    scene = scenario(ROAD, free, "a")
    both = Drives.of(Batch(), Idm(IDM), [(scene, free), (scene, inside)])
    alone = Drives.of(Batch(), Idm(IDM), [(scene, free)])
    assert np.isnan(both.per_run()[2]["absolute_acceleration"][1])
    for name in ("absolute_acceleration", "hardest_braking"):
        assert both.per_scenario()[name] == alone.per_scenario()[name]
    assert both.per_scenario()["collision"] == 0.5
    assert np.isnan(Drives.of(Batch(), Idm(IDM), [(scene, inside)]).per_scenario()["absolute_acceleration"]).all()


def test_runs_are_averaged_over_their_own_scenario_also_after_joining() -> None:
    drives = Drives.joined([driven("a", 10, 60), driven("b", 10, 20, 30, 70)])
    assert drives.scenarios == ["a", "b"]
    assert drives.scene.tolist() == [0, 0, 1, 1, 1, 1]
    means = drives.per_scenario()
    assert means["collision"].tolist() == means["collision.front"].tolist() == means["collision.at_fault"].tolist() == [0.5, 0.25]
    assert means["collision.side"].tolist() == means["left_map"].tolist() == [0, 0]
    np.testing.assert_allclose(means["distance"], [50, 50], rtol=1e-4)
    np.testing.assert_allclose(means["spread_over_samples"], [25, np.std([10, 20, 30, 70])], rtol=1e-4)
    assert means["off_road"].tolist() == [0, 0]
