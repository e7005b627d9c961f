"""What every planner promises, tried with a tiny net on a busy crossing."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivegen.core import plugins
from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.geometry import wrap_angle
from drivegen.core.scenario import Trajectories
from drivegen.planners.base import Examples, Planner, PlanRequests
from drivegen.planners.shared import motion
from drivegen.rollout.choices import choose
from drivegen.rollout.towards import plan_all_goals
from drivegen.selectors.random import Plugin as Uniform
from drivegen.training.weights import read_weights, write_weights
from tests.futures import other_future, with_riders
from tests.models import candidate_settings
from tests.planners.tiny import tiny
from tests.scenes import busy_crossing

NAMES = plugins.names("planners")


def same(a: Trajectories, b: Trajectories) -> bool:
    return all(np.array_equal(getattr(a, n), getattr(b, n)) for n in ("position", "heading", "velocity", "valid"))


def without_routes(requests: PlanRequests) -> PlanRequests:
    none = np.full(len(requests), -1, np.int32)
    return replace(requests, route=none, goal_s=0 * requests.goal_s, goal_d=0 * requests.goal_d)


@pytest.mark.parametrize("name", NAMES)
def test_the_same_seed_gives_the_same_bytes(name: str, logs: Examples, tmp_path: Path) -> None:
    for folder in ("a", "b"):
        planner = tiny(name)
        planner.fit([logs], logs[:4], 7, tmp_path / f"checkpoints-{folder}", lambda line: None)
        planner.save(tmp_path / folder)
    for file in ("settings.json", "weights.safetensors"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()


def test_the_loss_curve_covers_the_budget(logs: Examples) -> None:
    curve = tiny("route_fm").fit([logs], logs[:4], 7, None, lambda line: None)
    assert [row.step for row in curve] == [3, 6]
    assert all(np.isfinite([row.train, row.validation]).all() for row in curve)


def test_a_request_gets_the_same_motion_alone_and_in_any_batch(trained: Planner, logs: Examples) -> None:
    rows = np.tile(np.arange(len(logs)), 14)
    requests = replace(logs.requests[rows], seed=np.arange(len(rows), dtype=np.int64))
    together = trained.sample(logs.scenarios, requests)
    for b in (0, 5, 100, 255, 256, len(rows) - 1):
        assert same(trained.sample(logs.scenarios, requests[[b]])[0], together[b])
    assert same(trained.sample(logs.scenarios, requests[::-1]), together[::-1])


def test_motion_is_the_same_however_many_are_decoded_at_once(
    trained: Planner, logs: Examples, monkeypatch: pytest.MonkeyPatch
) -> None:
    together = trained.sample(logs.scenarios, logs.requests)
    monkeypatch.setattr(motion, "ROWS", 7)
    assert len(logs) % 7
    assert same(trained.sample(logs.scenarios, logs.requests), together)


def test_where_nothing_is_asked_for_nothing_is_planned(trained: Planner, logs: Examples) -> None:
    assert len(trained.sample(logs.scenarios, logs.requests[:0]).valid) == 0


def test_motion_starts_in_the_initial_state_and_is_finite(trained: Planner, logs: Examples) -> None:
    for requests in (logs.requests, without_routes(logs.requests)):
        motion = trained.sample(logs.scenarios, requests)
        motion.validate()
        assert motion.valid.all()
        np.testing.assert_array_equal(motion.position[:, 0], requests.position)
        np.testing.assert_array_equal(motion.heading[:, 0], requests.heading)
        np.testing.assert_allclose(motion.speed[:, 0], requests.speed, atol=1e-5)


def test_parked_vehicles_stay_exactly_where_they_are(trained: Planner, logs: Examples) -> None:
    parked = logs.requests[logs.requests.parked]
    assert len(parked) == 3
    motion = trained.sample(logs.scenarios, parked)
    np.testing.assert_array_equal(motion.position, np.repeat(parked.position[:, None], 101, axis=1))
    np.testing.assert_allclose(wrap_angle(motion.heading - parked.heading[:, None]), 0, atol=1e-6)


def test_plans_of_logs_that_begin_alike_are_the_same(trained: Planner) -> None:
    scene = with_riders(busy_crossing())
    one, other = (choose([log], Uniform(), candidate_settings(), 1.0) for log in (scene, other_future(scene)))
    assert same(plan_all_goals(one, trained, 7)[0], plan_all_goals(other, trained, 7)[0])


def test_another_seed_gives_another_motion(trained: Planner, logs: Examples) -> None:
    moving = logs.requests[~logs.requests.parked]
    other = replace(moving, seed=moving.seed + 1)
    a, b = (trained.sample(logs.scenarios, r).position for r in (moving, other))
    assert (np.abs(a - b).max(axis=(1, 2)) > 1e-3).mean() > 0.9


def test_saved_and_loaded_it_plans_the_same(trained: Planner, logs: Examples, tmp_path: Path) -> None:
    trained.save(tmp_path)
    loaded = type(trained).load(tmp_path)
    assert same(loaded.sample(logs.scenarios, logs.requests), trained.sample(logs.scenarios, logs.requests))


@pytest.mark.parametrize("name", NAMES)
def test_missing_foreign_and_damaged_weights_are_named(name: str, trained: Planner, tmp_path: Path) -> None:
    plugin = plugins.load("planners", name)
    with pytest.raises(MissingTool, match="make run"):
        plugin.load(tmp_path / "nothing")
    trained.save(tmp_path)
    if not isinstance(trained, plugin):
        with pytest.raises(UnusableInput, match="holds planner"):
            plugin.load(tmp_path)
    (tmp_path / "weights.safetensors").write_bytes(b"half a file")
    with pytest.raises(UnusableInput):
        plugin.load(tmp_path)


def test_weights_of_other_settings_are_refused_in_a_sentence(trained: Planner, tmp_path: Path) -> None:
    trained.save(tmp_path)
    name = json.loads((tmp_path / "settings.json").read_text())["planner"]
    settings, tensors = read_weights(tmp_path, "planner", name)
    for change, sentence in (
        ({"width": 2 * settings["width"]}, "weights do not fit the settings"),
        ({"depth": 1}, "unknown name 'depth'"),
    ):
        write_weights(tmp_path, "planner", name, settings | change, tensors)
        with pytest.raises(UnusableInput, match=sentence):
            type(trained).load(tmp_path)


@pytest.mark.parametrize("name", NAMES)
def test_an_untrained_planner_and_a_train_set_without_motion_are_refused(name: str, logs: Examples) -> None:
    with pytest.raises(UnusableInput, match="not been trained"):
        tiny(name).sample(logs.scenarios, logs.requests)
    with pytest.raises(UnusableInput):
        tiny(name).fit([logs[logs.requests.parked]], logs, 7, None, lambda line: None)
