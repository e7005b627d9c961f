"""Energy score and likelihood: by hand, by plain loops, and that honesty pays (propriety)."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.geometry import rotate
from drivegen.core.scenario import Trajectories
from drivegen.metrics.displacement import scored_steps
from drivegen.metrics.proper import energy_scores, likeliest_for_others, log_densities, mean_errors, spread

SEEDS = st.integers(0, 2**32 - 1)


def motion(position, valid=None) -> Trajectories:
    position = np.asarray(position, np.float32)
    shape = position.shape[:-1]
    return Trajectories(
        position, np.zeros(shape, np.float32), np.zeros_like(position), np.ones(shape, np.bool_) if valid is None else valid
    )


def drawn(seed, worlds=4, vehicles=3, steps=7):
    random = np.random.default_rng(seed)
    valid = random.random((vehicles, steps)) < 0.7
    valid[:, :2] = True
    return motion(random.normal(0, 5, (worlds, vehicles, steps, 2))), motion(random.normal(0, 5, (vehicles, steps, 2)), valid)


def by_loops(samples, log):
    """The four energy scores in plain Python."""
    count, vehicles = samples.valid.shape[:2]
    steps = [[t for t in range(1, log.steps) if log.valid[n, t]] for n in range(vehicles)]

    def squares(a, b, n):
        gaps = [float(((a[n, t].astype(float) - b[n, t]) ** 2).sum()) for t in steps[n]]
        return sum(gaps) / len(gaps), gaps[-1]

    def energy(distance):
        to_log = [distance(world, log.position) for world in samples.position]
        apart = [distance(samples.position[k], samples.position[m]) for k in range(count) for m in range(count) if k != m]
        return sum(to_log) / len(to_log) - sum(apart) / len(apart) / 2

    def one(n, which):
        return lambda a, b: np.sqrt(squares(a, b, n)[which])

    def scene(which):
        return lambda a, b: np.sqrt(np.mean([squares(a, b, n)[which] for n in range(vehicles)]))

    alone = [np.mean([energy(one(n, which)) for n in range(vehicles)]) for which in (1, 0)]
    return [*alone, energy(scene(1)), energy(scene(0))]


@given(SEEDS)
@settings(max_examples=15, deadline=None)
def test_arrays_and_loops_agree(seed):
    samples, log = drawn(seed)
    np.testing.assert_allclose(list(vars(energy_scores(samples, log)).values()), by_loops(samples, log), rtol=1e-5)


def test_the_spread_of_a_scene_is_the_mean_distance_of_two_samples() -> None:
    samples, log = drawn(3)
    scored = scored_steps(log)
    rows = [n for n in range(len(scored)) if scored[n].any()]
    pairs = itertools.combinations(samples.position.astype(np.float64), 2)
    apart = [np.mean([np.linalg.norm(a[n] - b[n], axis=-1)[scored[n]].mean() for n in rows]) for a, b in pairs]
    assert spread(samples, log) == pytest.approx(np.mean(apart), rel=1e-5)
    assert spread(samples[:1], log) == 0


def test_errors_and_energy_score_are_means_over_scenes_with_something_to_score() -> None:
    scenes = [drawn(3), drawn(4)]
    samples, log = drawn(5)
    unseen = motion(log.position, np.zeros(log.valid.shape, np.bool_))
    found = mean_errors([*scenes, (samples, unseen)])
    assert set(found) == {"min_sade", "min_sfde", "mean_sade", "mean_sfde", "energy_joint"}
    assert found["energy_joint"] == pytest.approx(np.mean([energy_scores(*scene).energy_joint for scene in scenes]))
    assert mean_errors([(samples, unseen)]) == {}


def test_two_samples_around_the_log_by_hand():
    log = motion([[[0, 0], [0, 0], [0, 0]]])
    samples = motion([[[[0, 0], [3, 0], [4, 0]]], [[[0, 0], [-3, 0], [-4, 0]]]])
    found = energy_scores(samples, log)
    assert found.energy_final == pytest.approx(4 - 8 / 2)
    assert found.energy_trajectory == pytest.approx(np.sqrt(12.5) - np.sqrt(50) / 2, abs=1e-6)


def test_one_sample_is_certain_and_copies_of_it_are_too():
    samples, log = drawn(3, worlds=1)
    copies = samples[np.zeros(5, np.intp)]
    one, five = vars(energy_scores(samples, log)), vars(energy_scores(copies, log))
    assert one == pytest.approx(five)
    assert all(value > 0 for value in one.values())


def expected(of, random, truth_spread, said_spread, turns=300, together=False):
    """Mean score of samples drawn with one spread where logs are drawn with another; vehicles may swerve together."""

    def draw(spread, together):
        step = random.normal(0, spread, (2 if not together else 1, 1, 2))
        return np.concatenate([np.zeros((2, 1, 2)), np.repeat(step, 2, 0) if together else step], axis=1)

    scores = []
    for _ in range(turns):
        log = motion(draw(truth_spread, together=True))
        samples = motion(np.stack([draw(said_spread, together) for _ in range(8)]))
        scores.append(getattr(energy_scores(samples, log), of))
    return np.mean(scores)


@pytest.mark.parametrize("of", ["energy_final", "energy_trajectory", "energy_joint_final", "energy_joint"])
def test_honesty_pays(of):
    random = np.random.default_rng(0)
    honest = expected(of, random, 2.0, 2.0, together=True)
    assert honest < expected(of, random, 2.0, 0.4, together=True)
    assert honest < expected(of, random, 2.0, 7.0, together=True)


def test_only_joint_scores_see_who_moves_with_whom():
    def both(of):
        random = np.random.default_rng(1)
        return expected(of, random, 2.0, 2.0, 600, together=True), expected(of, random, 2.0, 2.0, 600)

    together, apart = both("energy_joint_final")
    assert together < apart - 0.03
    together, apart = both("energy_final")
    assert together == pytest.approx(apart, abs=0.12)


@given(SEEDS, st.floats(0.2, 5))
@settings(max_examples=15, deadline=None)
def test_permutations_and_rigid_motion_change_nothing_and_scaling_scales(seed, scale):
    samples, log = drawn(seed)
    random = np.random.default_rng(seed)
    actors, worlds, angle = random.permutation(3), random.permutation(4), np.float64(random.uniform(-3, 3))

    def moved(trajectories):
        return motion(rotate(trajectories.position.astype(np.float64), angle) * scale - 3.0, trajectories.valid)

    first = np.array(list(vars(energy_scores(samples, log)).values()))
    again = np.array(list(vars(energy_scores(moved(samples[worlds][:, actors]), moved(log[actors]))).values()))
    np.testing.assert_allclose(again, scale * first, rtol=1e-3, atol=1e-4)


def test_garbage_at_steps_that_the_log_did_not_see_changes_nothing():
    samples, log = drawn(5)
    first = energy_scores(samples, log)
    samples.position[:, ~log.valid] = 1e6
    assert energy_scores(samples, log) == first


HORIZONS, BANDWIDTHS = np.array([0.1, 0.3, 9.0]), np.array([0.5, 2.0, 8.0])


def density_by_loops(samples, log, step, bandwidth):
    """Mean log of the kernel mixture over vehicles, and that of the scene over their number."""
    seen = [n for n in range(len(log.valid)) if log.valid[n, step]]

    def kernel(k, n):
        squared = ((samples.position[k, n, step].astype(float) - log.position[n, step]) ** 2).sum()
        return np.exp(-squared / (2 * bandwidth**2)) / (2 * np.pi * bandwidth**2)

    worlds = range(len(samples.valid))
    alone = np.mean([np.log(np.mean([kernel(k, n) for k in worlds])) for n in seen])
    return alone, np.log(np.mean([np.prod([kernel(k, n) for n in seen]) for k in worlds])) / len(seen)


@given(SEEDS)
@settings(max_examples=15, deadline=None)
def test_densities_are_those_of_loops(seed):
    samples, log = drawn(seed)
    found = log_densities(samples, log, HORIZONS, BANDWIDTHS)
    assert np.isnan(found[:, 2]).all()  # no log is that long
    for h, step in ((0, 1), (1, 3)):
        if not log.valid[:, step].any():
            assert np.isnan(found[:, h]).all()
            continue
        np.testing.assert_allclose(found[:, h, 2], density_by_loops(samples, log, step, 8.0), rtol=1e-5)


def test_the_density_integrates_to_one():
    samples = motion([[[[0, 0], [1, 1]]], [[[0, 0], [-2, 0]]]])
    places = np.linspace(-30, 30, 31)  # as far apart as the kernel is wide: the sum is off by less than 1e-8
    total = 0.0
    for x in places:
        column = [log_densities(samples, motion([[[0, 0], [x, y]]]), np.array([0.1]), np.array([2.0]))[0, 0, 0] for y in places]
        total += float(np.exp(column).sum()) * 4
    assert total == pytest.approx(1, abs=1e-6)


def test_far_logs_do_not_overflow():
    samples, log = motion([[[[0, 0], [0, 0]]]]), motion([[[0, 0], [1e4, 0]]])
    found = log_densities(samples, log, np.array([0.1]), np.array([0.25]))
    assert np.isfinite(found).all()
    assert found[0, 0, 0] == pytest.approx(-0.5 * 1e8 / 0.0625 - np.log(2 * np.pi * 0.0625), rel=1e-6)


def test_a_bandwidth_is_chosen_by_the_other_scenarios():
    densities = np.array([[0.0, -9.0], [-1.0, 0.0], [-1.0, 0.0], [np.nan, np.nan]])
    value, chosen = likeliest_for_others(densities, list("abcd"))
    assert chosen.tolist() == [1, 0, 0, -1]
    np.testing.assert_array_equal(value, [-9.0, -1.0, -1.0, np.nan])


def test_scenarios_of_one_recording_do_not_choose_for_one_another():
    densities = np.array([[0.0, -9.0], [-3.0, 0.0], [-1.0, 0.0], [-1.0, 0.0]])
    value, chosen = likeliest_for_others(densities, ["a", "a", "b", "b"])
    assert chosen.tolist() == [1, 1, 0, 0]
    np.testing.assert_array_equal(value, [-9.0, 0.0, -1.0, -1.0])
    assert np.isnan(likeliest_for_others(densities, ["a"] * 4)[0]).all()


def test_a_scenario_alone_has_no_likelihood():
    value, chosen = likeliest_for_others(np.array([[0.0, 1.0]]), ["a"])
    assert np.isnan(value).all()
    assert chosen.tolist() == [-1]
