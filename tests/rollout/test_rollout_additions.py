"""Additions choose among a method's own trajectories, by futures in which everybody follows the log at a pace of its own."""

import numpy as np
import pytest

from drivegen.checker.verdicts import judged
from drivegen.core.samples import Samples
from drivegen.rollout.additions import CHECKER, TEMPO, with_additions
from tests.checking import LIMITS
from tests.scenes import busy_crossing, drive, joined, noisy_samples, scenario, stack, straight_road

COUNT = 8
SCENE = busy_crossing(81, "additions")


def lengths(samples: Samples) -> np.ndarray:
    return np.linalg.norm(samples.motion.position[:, :, -1] - samples.motion.position[:, :, 0], axis=-1)


def test_without_additions_futures_are_what_they_were_and_judged() -> None:
    given = noisy_samples(SCENE, COUNT)
    made = with_additions(SCENE, given, LIMITS, (), 0.8, 7)
    np.testing.assert_array_equal(made.motion.position, given.motion.position)
    assert not made.legal.all()


def test_a_tempo_uses_every_trajectory_once_and_all_get_far_together() -> None:
    given = noisy_samples(SCENE, COUNT)
    made = with_additions(SCENE, given, LIMITS, (TEMPO,), 0.9, 7)
    np.testing.assert_array_equal(np.sort(lengths(made), axis=0), np.sort(lengths(given), axis=0))
    moving = SCENE.vehicles.speed > 1

    def together(samples: Samples) -> float:
        ranks = np.corrcoef(lengths(samples)[:, moving].T)
        return float(ranks[np.triu_indices(len(ranks), 1)].mean())

    assert together(made) > 0.5 > together(given) + 0.2


def test_of_those_who_leave_the_fast_have_the_higher_rank():
    """All leave after 80 m; a tempo that all share orders them as their ways would be if the road went on."""
    roads = straight_road(100, 2, whole=True)
    lines = [joined(roads, lane) for lane in (0, 1)]
    paces = np.random.default_rng(0).permuted(np.tile(np.linspace(10.0, 17.0, COUNT), (2, 1)), axis=1)
    motion = stack([stack([drive(line, 20, pace, 101) for line, pace in zip(lines, both, strict=True)]) for both in paces.T])
    scene = scenario(roads, motion[0])
    given = judged(scene, Samples.without_goals(scene.scenario_id, "made", motion), LIMITS)
    assert given.left_map.all()
    first = with_additions(scene, given, LIMITS, (TEMPO,), 1.0, 7).motion.speed[:, :, 0]
    np.testing.assert_allclose(first[:, 0], first[:, 1], atol=1e-3)


@pytest.mark.parametrize("additions", [(CHECKER,), (CHECKER, TEMPO)])
def test_the_checker_takes_what_is_legal_and_only_of_the_same_vehicle(additions: tuple[str, ...]) -> None:
    given = noisy_samples(SCENE, COUNT)
    before, made = (with_additions(SCENE, given, LIMITS, chosen, 0.8, 7) for chosen in ((), additions))
    assert made.legal.mean() > before.legal.mean()
    for n in range(len(SCENE.vehicles)):
        own = {tuple(place) for place in given.motion.position[:, n, -1].tolist()}
        assert {tuple(place) for place in made.motion.position[:, n, -1].tolist()} <= own


def test_the_same_seed_makes_the_same_choice_and_another_one_another() -> None:
    given = noisy_samples(SCENE, COUNT)
    one, same, other = (with_additions(SCENE, given, LIMITS, (TEMPO,), 0.5, seed).motion.position for seed in (7, 7, 8))
    np.testing.assert_array_equal(one, same)
    assert not np.array_equal(one, other)
