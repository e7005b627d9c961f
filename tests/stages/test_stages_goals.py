"""The selector's stages from end to end on two hand-made shards."""

from dataclasses import replace

import numpy as np
import orjson
import pyarrow.parquet as pq
import pytest

from drivegen.core.errors import UnusableInput
from drivegen.core.signals import SignalState
from drivegen.goals.candidates import candidates
from drivegen.goals.packing import unpack
from drivegen.roads.graph import LaneGraph
from drivegen.selectors.learned import Plugin as Learned
from drivegen.store.goals import read_goals
from drivegen.store.scenarios import write_shard
from stages import goal_lists, goals, train_selector
from tests import scenes
from tests.goals.test_goals_candidates import SETTINGS
from tests.selectors.test_selectors_contract import LEARNING
from tests.selectors.test_selectors_vlm import SETTINGS as ASKING

ENDS = ("parquet", "json")


def several(name):
    return [replace(scenes.busy_crossing(), scenario_id=f"{name}-{letter}") for letter in "ab"]


def listed(goals="", name=""):
    return goal_lists.Params(1, SETTINGS, goal_lists.Teacher(goals, name))


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    root = tmp_path_factory.mktemp("run")
    for split in ("train", "val", "test"):
        write_shard(root / "scenarios" / split / "shard-00000.parquet", several(split))
    short = replace(LEARNING, training=replace(LEARNING.training, steps=20, report_every=10))
    goal_lists.main(listed(), root / "scenarios", root / "lists")
    train_selector.main(
        train_selector.Params(7, SETTINGS, short),
        *(root / name for name in ("scenarios", "lists", "selector", "train.json", "curve.csv")),
    )
    return root


def test_training_leaves_scores_and_a_curve(trained):
    metrics = orjson.loads((trained / "train.json").read_bytes())
    assert set(metrics["validation"]) == {"learned", "prior", "random"}
    assert metrics["train_lists"] == 2 * 16
    assert (trained / "curve.csv").read_text().splitlines()[0] == "step,train,validation,goal_distance"


def test_scores_are_of_the_first_frame_alone(trained, tmp_path):
    """What signals show later is not known to who chooses goals, on the validation split either."""
    one = scenes.busy_crossing()
    later = one.signals.state.copy()
    later[:, 1:] = np.where(one.signals.state[:, 1:] == SignalState.RED, SignalState.GREEN, SignalState.RED)
    for name, state in (("as-it-is", one.signals.state), ("turned", later)):
        shown = replace(one, signals=replace(one.signals, state=state))
        write_shard(tmp_path / name / "shard-00000.parquet", [shown])
    params = train_selector.Params(7, SETTINGS, LEARNING)
    found = [
        train_selector._scores(tmp_path / name, params, Learned.load(trained / "selector")) for name in ("as-it-is", "turned")
    ]
    assert found[0] == found[1]


@pytest.mark.parametrize("selector", ["random", "log", "learned", "prior"])
def test_goals_stand_beside_their_scenarios(trained, selector, tmp_path):
    out, metrics = trained / "goals" / selector, trained / f"{selector}.json"
    goals.main(
        goals.Params(7, 1, 20, SETTINGS, ASKING),
        trained / "scenarios" / "test",
        trained / "selector",
        out,
        tmp_path / "rows.parquet",
        metrics,
    )
    rows = read_goals(out / "shard-00000.parquet")
    assert [row.scenario_id for row in rows] == ["test-a", "test-b"]
    found, probability = unpack(LaneGraph.of(scenes.crossing()), rows[0])
    assert [len(c) for c in found] == [len(p) for p in probability]
    table = orjson.loads(metrics.read_bytes())
    assert table["all"]["vehicles"] == 16
    assert table["all"]["coverage_4m"] == 1
    assert table["all"]["nll.low"] <= table["all"]["nll"] <= table["all"]["nll.high"]
    record = pq.read_table(tmp_path / "rows.parquet").to_pylist()
    assert {row["scenario"] for row in record} == {"test-a", "test-b"}
    assert np.mean([row["value"] for row in record if row["metric"] == "nll"]) == pytest.approx(table["all"]["nll"])
    if selector == "random":
        assert np.isclose(table["all"]["nll"], np.mean([np.log(len(c)) for c in found]), atol=1e-4)


def test_a_selector_can_be_taught_by_recorded_odds_and_says_by_whose(trained, tmp_path):
    scenarios, taught = trained / "scenarios", tmp_path / "taught"
    out = tmp_path / "goals" / "prior"
    goals.main(
        goals.Params(7, 1, 0, SETTINGS, ASKING), scenarios / "train", taught, out, *(tmp_path / f"p.{end}" for end in ENDS)
    )
    long = replace(LEARNING, training=replace(LEARNING.training, steps=200, report_every=100))
    goal_lists.main(listed(str(out), "language model little"), scenarios, tmp_path / "lists")
    params = train_selector.Params(7, SETTINGS, long)
    train_selector.main(params, scenarios, tmp_path / "lists", taught, tmp_path / "train.json", tmp_path / "curve.csv")
    selector = Learned.load(taught)
    assert selector.described == "learned selector (distilled from language model little)"
    assert orjson.loads((tmp_path / "train.json").read_bytes())["described"] == selector.described
    logs = orjson.loads((trained / "train.json").read_bytes())
    assert logs["described"] == "learned selector (imitates logs)"
    scene = several("train")[0]
    graph = LaneGraph.of(scene.map)
    found = [candidates(graph, scene, n, SETTINGS) for n in range(len(scene.vehicles))]
    for c, p in zip(found, selector.rank(graph, scene, found), strict=True):
        assert np.abs(p - c.prior).sum() < np.abs(1 / len(c) - c.prior).sum()  # it is the prior that was learnt
    with pytest.raises(UnusableInput, match="belong together"):
        goal_lists.Teacher("somewhere", "")


def test_odds_of_other_scenarios_teach_nothing(trained, tmp_path):
    scenarios = trained / "scenarios"
    goals.main(
        goals.Params(7, 1, 0, SETTINGS, ASKING),
        scenarios / "val",
        tmp_path,
        tmp_path / "prior",
        *(tmp_path / f"p.{end}" for end in ENDS),
    )
    with pytest.raises(UnusableInput, match="other scenarios"):
        goal_lists.main(listed(str(tmp_path / "prior"), "prior"), scenarios, tmp_path / "lists")
    assert not (tmp_path / "lists").exists()
