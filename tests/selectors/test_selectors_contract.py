"""What every goal selector keeps to, and what the learned one learns."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
import torch

from drivegen.core import plugins
from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.roadmap import LaneControl
from drivegen.core.signals import Signals, SignalState
from drivegen.core.twins import twin
from drivegen.goals import list_files
from drivegen.goals.candidates import candidates
from drivegen.goals.features import NAMES, features
from drivegen.goals.list_files import list_writer, read_lists
from drivegen.goals.lists import Lists
from drivegen.goals.manoeuvres import Manoeuvre
from drivegen.roads.graph import LaneGraph
from drivegen.selectors._ranker import Ranker
from drivegen.selectors.learned import Plugin, Settings
from drivegen.selectors.log import logged_ends
from drivegen.store.columns import joined
from drivegen.training import weights
from drivegen.training.loop import Settings as Training
from tests import scenes
from tests.goals.test_goals_candidates import SETTINGS

TRAINING = Training(120, 32, 0.01, 5, True, 0.0, 0.9, 1.0, False, 60, 60)
LEARNING = Settings(width=16, dropout=0.0, sigma=2.0, farthest=8.0, floor=0.0, training=TRAINING)


def offered(scene):
    graph = LaneGraph.of(scene.map)
    return graph, [candidates(graph, scene, n, SETTINGS) for n in range(len(scene.vehicles))]


def steady_scene(speed):
    """Two cars that keep their speed on a straight road."""
    roads = scenes.straight_road(400, 2)
    log = [scenes.drive(scenes.joined(roads, lane), 10 + 30 * lane, speed + lane, 101) for lane in range(2)]
    return scenes.scenario(roads, scenes.stack(log), f"steady-{speed}")


def lists(speeds):
    return joined(Lists, (Lists.of(scene, offered(scene)[1]) for scene in map(steady_scene, speeds)))


def write_lists(path, *parts, teacher=""):
    with list_writer(path, teacher) as write:
        for part in parts:
            write(part)


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    folder = tmp_path_factory.mktemp("selector")
    learnt = lists(np.linspace(3, 14, 40))
    selector, curve = Plugin.fit(learnt, lists(np.linspace(3.3, 13.3, 8)), LEARNING, 7, None, lambda _: None)
    selector.save(folder)
    return folder, selector, curve


@pytest.mark.parametrize("name", plugins.names("selectors"))
def test_selectors_give_every_vehicle_probabilities(name, trained):
    selector = plugins.load("selectors", name).load(trained[0])
    assert selector.described
    scene = scenes.busy_crossing()
    graph, found = offered(scene)
    asked = selector.offer(graph, scene, found)
    assert all(len(a) >= len(f) for a, f in zip(asked, found, strict=True))
    for c, p in zip(asked, selector.rank(graph, scene, asked), strict=True):
        assert p.shape == (len(c),)
        assert p.dtype == np.float32
        assert (p >= 0).all()
        assert p.sum() == pytest.approx(1, abs=1e-5)


@pytest.mark.parametrize("name", plugins.names("selectors"))
def test_a_ranking_depends_on_its_scenario_alone(name, trained):
    selector = plugins.load("selectors", name).load(trained[0])
    scene = scenes.busy_crossing()
    graph, found = offered(scene)
    first = selector.rank(graph, scene, found)
    other = steady_scene(9.0)
    selector.rank(*(lambda g, f: (g, other, f))(*offered(other)))
    assert all(np.array_equal(a, b) for a, b in zip(first, selector.rank(graph, scene, found), strict=True))


def test_only_the_log_selector_sees_the_log(trained):
    scene = scenes.busy_crossing()
    blind = replace(scene, log=None)
    graph, found = offered(blind)
    for name in set(plugins.names("selectors")) - {"log"}:
        selector = plugins.load("selectors", name).load(trained[0])
        for a, b in zip(selector.rank(graph, blind, found), selector.rank(graph, scene, found), strict=True):
            assert np.array_equal(a, b)
    with pytest.raises(UnusableInput, match="no log"):
        plugins.load("selectors", "log").load(trained[0]).offer(graph, blind, found)


def test_the_log_selector_gives_the_logged_end_itself():
    scene = scenes.busy_crossing()
    graph, found = offered(scene)
    selector = plugins.load("selectors", "log").load(Path())
    asked = selector.offer(graph, scene, found)
    for n, (c, p) in enumerate(zip(asked, selector.rank(graph, scene, asked), strict=True)):
        chosen = int(p.argmax())
        assert p[chosen] == 1
        assert np.array_equal(c.position[chosen], logged_ends(scene.log)[n])
        assert c.heading[chosen] == scene.log.heading[n, -1]
        assert c.step[chosen] == 100


def test_the_ranker_learns_what_cars_do(trained):
    _, selector, curve = trained
    assert curve[-1].train < curve[0].train
    scene = steady_scene(8.7)
    graph, found = offered(scene)
    for n, (c, p) in enumerate(zip(found, selector.rank(graph, scene, found), strict=True)):
        gap = np.hypot(*(c.position - logged_ends(scene.log)[n]).T)
        assert (p * gap).sum() < 0.5 * (c.prior * gap).sum()
        assert p[gap.argmin()] > c.prior[gap.argmin()]


def test_the_same_seed_gives_the_same_bytes(trained, tmp_path):
    folder, _, _ = trained
    learnt = lists(np.linspace(3, 14, 40))
    Plugin.fit(learnt, lists(np.linspace(3.3, 13.3, 8)), LEARNING, 7, None, lambda _: None)[0].save(tmp_path)
    for file in (weights.WEIGHTS, weights.SETTINGS):
        assert (tmp_path / file).read_bytes() == (folder / file).read_bytes()


def test_weights_that_are_missing_or_broken_are_named(trained, tmp_path):
    with pytest.raises(MissingTool, match="no trained goal selector"):
        Plugin.load(tmp_path)
    folder = trained[0]
    (tmp_path / weights.SETTINGS).write_bytes((folder / weights.SETTINGS).read_bytes())
    (tmp_path / weights.WEIGHTS).write_bytes((folder / weights.WEIGHTS).read_bytes()[:200])
    with pytest.raises(UnusableInput, match="is not what was written"):
        Plugin.load(tmp_path)


def test_nothing_to_learn_from_is_an_error():
    with pytest.raises(UnusableInput, match="no example"):
        Plugin.fit(Lists.none(), Lists.none(), LEARNING, 7, None, lambda _: None)


def test_features_are_named_finite_and_bounded():
    for seed in range(5):
        scene = scenes.any_scenario(seed)
        _, found = offered(scene)
        for rows in features(scene, found):
            assert rows.shape[1] == len(NAMES)
            assert np.isfinite(rows).all()
            assert np.abs(rows).max() <= 3


def test_the_floor_is_the_prior_and_kept_with_the_weights(trained, tmp_path):
    _, selector, _ = trained
    scene = steady_scene(8.7)
    graph, found = offered(scene)
    floored = Plugin(selector.net, 0.1)
    floored.save(tmp_path)
    for c, p, q in zip(found, selector.rank(graph, scene, found), Plugin.load(tmp_path).rank(graph, scene, found), strict=True):
        assert np.allclose(q, 0.9 * p + 0.1 * c.prior, atol=1e-6)
    with pytest.raises(UnusableInput, match="floor"):
        replace(LEARNING, floor=1.0)


def test_who_stands_beside_the_lanes_is_parked_and_stays():
    """Two standing cars, one on its lane and one three metres beside it, by a net that knows nothing."""
    roads = scenes.straight_road(400, 1)
    log = scenes.stack([scenes.drive(scenes.joined(roads, 0), start, 0.0, 101) for start in (40, 90)])
    log.position[1, :, 1] -= 3.0
    scene = scenes.scenario(roads, log)
    net = Ranker(len(NAMES), 16)
    torch.nn.init.zeros_(net.scored[-1].weight)
    graph, found = offered(scene)
    odds = Plugin(net).rank(graph, scene, found)
    on_lane, beside = (p[c.manoeuvre == Manoeuvre.STAY].sum() for c, p in zip(found, odds, strict=True))
    assert on_lane < 0.5
    assert np.isclose(beside, 0.9)
    assert all(np.isclose(p.sum(), 1.0, atol=1e-5) for p in odds)


def test_a_log_is_learnt_from_with_its_signals_and_rules_and_without():
    """A vehicle gives two lists; the second tells of no signals and rules of way, and half of the twins of no limit."""
    roads = scenes.straight_road(400, 1)
    roads = replace(roads, control=np.full_like(roads.control, LaneControl.FREE))
    log = scenes.stack([scenes.drive(scenes.joined(roads, 0), 10.0, 10.0, 101)])
    scene = scenes.scenario(roads, log)
    lists = Lists.of_log(scene, SETTINGS)
    rules = lists.x[lists.start[:-1], NAMES.index("rules")]
    assert rules.tolist() == [1.0, 0.0]
    twins = [twin(replace(scene, scenario_id=f"scene-{n}")) for n in range(40)]
    assert all(len(t.signals) == 0 and (t.map.control == LaneControl.UNKNOWN).all() for t in twins)
    kept = [not np.isnan(t.map.speed_limit).any() for t in twins]
    assert 10 <= sum(kept) <= 30
    assert all(np.isnan(t.map.speed_limit).all() for t, known in zip(twins, kept, strict=True) if not known)
    assert twin(scene).log is scene.log
    assert not len(twin(scene).map.yields_to)


def test_a_log_and_its_twin_give_the_lists_that_each_gives_alone():
    """Routes are found once for both: what the twin is told of limits must not come from the log, nor the other way round."""
    limited = 0
    for scene in (scenes.busy_crossing(scenario_id=f"crossing-{n}") for n in range(6)):
        limited += not np.isnan(twin(scene).map.speed_limit).any()
        apart = joined(Lists, (Lists.of(one, offered(one)[1]) for one in (scene, twin(scene))))
        together = Lists.of_log(scene, SETTINGS)
        for name in Lists.__dataclass_fields__:
            assert np.array_equal(getattr(together, name), getattr(apart, name)), name
    assert 0 < limited < 6


@pytest.mark.parametrize("group", [2**14, 5])
def test_lists_come_back_from_their_file_as_they_were(tmp_path, monkeypatch, group):
    """Whoever taught them and however many row groups they fill; the same lists are the same bytes, in one part or in several."""
    monkeypatch.setattr(list_files, "GROUP", group)
    parts = [lists(speeds) for speeds in (np.linspace(3, 8, 4), [9.0], np.linspace(10, 14, 6))]
    made = joined(Lists, parts)
    taught = replace(made, taught=np.full_like(made.taught, 0.25), doubt=made.doubt + 0.5)
    for given, teacher, folder in ((made, "", None), (taught, "somebody", tmp_path), (Lists.none(), "", None)):
        write_lists(tmp_path / "lists.parquet", given, teacher=teacher)
        found, who = read_lists(tmp_path / "lists.parquet", folder)
        assert who == teacher
        for name in Lists.__dataclass_fields__:
            np.testing.assert_array_equal(getattr(found, name), getattr(given, name), err_msg=name)
            assert getattr(found, name).dtype == getattr(given, name).dtype
    write_lists(tmp_path / "whole.parquet", made)
    write_lists(tmp_path / "parts.parquet", *parts)
    assert (tmp_path / "whole.parquet").read_bytes() == (tmp_path / "parts.parquet").read_bytes()
    assert pq.read_metadata(tmp_path / "whole.parquet").num_row_groups == -(-len(made) // group)


def test_damaged_lists_are_refused(tmp_path):
    write_lists(tmp_path / "lists.parquet", lists([5.0]))
    raw = bytearray((tmp_path / "lists.parquet").read_bytes())
    raw[len(raw) // 3] ^= 1
    (tmp_path / "lists.parquet").write_bytes(raw)
    with pytest.raises(UnusableInput, match="is not what was written"):
        read_lists(tmp_path / "lists.parquet")


def test_lists_of_other_features_are_not_learnt_from(tmp_path, monkeypatch):
    write_lists(tmp_path / "lists.parquet", lists([5.0]))
    monkeypatch.setattr(list_files, "NAMES", (*NAMES[:-1], "something new"))
    with pytest.raises(UnusableInput, match="run the goal_lists stage again"):
        read_lists(tmp_path / "lists.parquet")


def test_a_candidate_that_others_goals_exclude_is_told_apart():
    """Beyond a car that will hardly move, on one lane: who wants to end there clashes with it."""
    roads = scenes.straight_road(400, 1)
    log = [scenes.drive(scenes.joined(roads, 0), start, speed, 101) for start, speed in ((10, 10.0), (40, 0.0))]
    scene = scenes.scenario(roads, scenes.stack(log))
    _, found = offered(scene)
    clash = features(scene, found)[0][:, NAMES.index("clash")]
    beyond = found[0].s > 80
    assert beyond.any()
    assert clash[beyond].min() > 0.2 + clash[found[0].s < 25].max(initial=0.0)


def test_the_learned_selector_is_told_of_lights_what_it_has_learnt_from(models):
    """Lists hold what the first frame shows; a programme that is known beside it would be features it never saw."""
    scene = scenes.busy_crossing()
    graph, candidates_of = offered(scene)
    told = Plugin.load(models / "selector").rank(graph, scene, candidates_of)
    later = scene.signals.state.copy()
    later[:, 1:] = np.where(later[:, :1] == SignalState.RED, SignalState.GREEN, SignalState.RED)
    other = replace(scene, signals=Signals(scene.signals.lane, later))
    assert len(scene.signals) > 0
    for odds, same in zip(told, Plugin.load(models / "selector").rank(graph, other, candidates_of), strict=True):
        np.testing.assert_array_equal(odds, same)


def test_weights_that_are_not_finite_are_refused(trained, tmp_path):
    selector = Plugin(Ranker(len(NAMES), 16))
    selector.net.scale[0] = float("nan")
    with pytest.raises(UnusableInput, match="scale has a number that is not finite"):
        selector.save(tmp_path)
