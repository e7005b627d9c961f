"""How near tracks come, which run is handed over, and what the tables say of it."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.adversaries import random
from drivegen.adversaries.shared.approach import approaches
from drivegen.adversaries.shared.arena import Arena, Bounds, Ground
from drivegen.adversaries.shared.findings import Findings, handed_over
from drivegen.corner_cases.trials import Trials, Variants
from drivegen.drivers import idm
from drivegen.report.published.corner import corner_rows
from drivegen.report.sections.attack import cost_table, outcome_table, proposer_tables
from drivegen.rollout.choices import choose
from drivegen.selectors.random import Plugin as Random
from drivegen.world.outcome import CollisionKind, DrivingOutcome
from drivegen.world.reactive import Reaction
from tests.checking import IDM, LIMITS
from tests.models import candidate_settings, planner
from tests.scenes import busy_crossing, drive, joined, scenario, stack, straight_road

LAW = Reaction(delay=0.75, braking=6.0, headway=0.6, min_gap=1.0, acceleration=1.5, comfort=3.0)
LENGTH = 4.6


def queue():
    """The target follows on the left of two lanes, 60 m behind somebody as fast."""
    roads = straight_road(500, 2)
    return scenario(roads, stack([drive(joined(roads, 1), 20, 10, 101), drive(joined(roads, 1), 80, 10, 101)]))


def test_the_gap_is_between_boxes_and_the_warning_is_how_long_it_was_in_the_way():
    scene = queue()
    line = joined(scene.map, 1)
    trials = Trials(idm.Plugin(IDM), [scene], [scene.log])
    tracks = stack(
        [drive(line, 80, 4, 101), drive(line, 80, 7, 101), drive(joined(scene.map, 0), 20, 10, 101), drive(line, 5, 10, 101)]
    )
    near = approaches(trials, scene.log[:1], np.zeros(4, np.int64), np.ones(4, np.int64), tracks)
    meets = (60 - LENGTH) / 6  # [s] until the slow one is reached
    assert near.contact.tolist() == [int(np.ceil(meets * 10)), -1, -1, -1]
    assert near.warning[0] == pytest.approx(meets, abs=0.11)
    assert near.gap == pytest.approx([0, 60 - LENGTH - 30, 3.5 - 1.9, 15 - LENGTH], abs=0.01)
    assert near.behind.tolist() == [False, False, False, True]


def test_nobody_comes_near_a_target_that_has_left_and_somebody_does_where_it_stands():
    scene = queue()
    line = joined(scene.map, 1)
    trials = Trials(idm.Plugin(IDM), [scene], [scene.log])
    ended = DrivingOutcome.none(101)
    driven = scene.log[:1].copy()
    driven.valid[:, 30:] = False  # at 50 m
    later = stack([drive(line, 10, 4, 101)])  # passes there after 10 s
    gaps = []
    for left in (True, False):
        ended = replace(ended, motion=driven, left_map=np.array([left]))
        found = approaches(trials, ended.to_the_end, np.zeros(1, np.int64), np.ones(1, np.int64), later)
        gaps.append(float(found.gap[0]))
    assert gaps[0] == pytest.approx(10 + 6 * 1.1 - LENGTH, abs=0.01)  # just behind it, when the first second is over
    assert gaps[1] == 0


@pytest.fixture(scope="module")
def runs():
    """Three runs of one scene: nothing, stops before the target's nose, stands still from the beginning."""
    scene = queue()
    choices = choose([scene], Random(), candidate_settings(), 1.0)
    arena = Arena(
        idm.Plugin(IDM), Ground(choices, np.zeros(1, np.int64), [scene.log], None, LIMITS), Bounds("physical", 5, 20), 7
    )
    arena.drive(Variants.unchanged(np.zeros(1), 101))
    wall = drive(np.array([[160.0, 3.5], [161.0, 3.5]]), 0, 0, 101)
    wall.valid[:40] = False  # out of nothing, 10 m before the target
    wall.position[:] = (77.0, 3.5)
    other = drive(joined(scene.map, 1), 85, 10, 101)
    arena.drive(Variants.one_each(np.zeros(2), np.ones(2), stack([wall, other])), np.array([0.1, 0.2]))
    return arena.runs()


def test_the_first_run_that_counts_is_handed_over_with_its_case(runs):
    assert [array.tolist() for array in handed_over(runs)] == [[1], [False]]
    found = Findings.of(runs, idm.Plugin(IDM), "made_up", LAW)
    [case] = found.cases
    assert (case.queries, case.attacker, case.kind, case.odds) == (2, 1, CollisionKind.FRONT, pytest.approx(0.1))
    assert {name: found.metrics[name].tolist() for name in ("counted", "cases", "queries", "first")} == {
        "counted": [1.0],
        "cases": [1.0],
        "queries": [3.0],
        "first": [2.0],
    }
    assert found.metrics["avoidable"] == 0  # nobody brakes for who was not there
    assert found.samples[0].natural[0, 1] == pytest.approx(0.1)
    assert found.driven[0].motion.valid.shape == (1, 1, 101)


def test_the_first_that_could_have_been_avoided_is_handed_over_before_an_earlier_one():
    scene = queue()
    careless = idm.Plugin(replace(IDM, headway=0.0, emergency_braking=0.5))
    choices = choose([scene], Random(), candidate_settings(), 1.0)
    arena = Arena(careless, Ground(choices, np.zeros(1, np.int64), [scene.log], None, LIMITS), Bounds("physical", 5, 20), 7)
    from_nothing = drive(np.array([[77.0, 3.5], [78.0, 3.5]]), 0, 0, 101)
    from_nothing.valid[:40] = False
    standing = drive(joined(scene.map, 1), 80, 0, 101)
    arena.drive(Variants.one_each(np.zeros(3), np.ones(3), stack([from_nothing, standing, standing])))
    runs = arena.runs()
    assert runs.outcome.counted.all()
    assert [array.tolist() for array in handed_over(runs)] == [[1], [True]]
    metrics = Findings.of(runs, careless, "made_up", LAW).metrics
    assert [metrics[name].tolist() for name in ("avoidable", "first", "queries")] == [[1.0], [1.0], [3.0]]


def test_an_adversary_that_drives_too_often_is_stopped(runs):
    with pytest.raises(AssertionError, match="more often than its budget"):
        runs.arena.drive(Variants.unchanged(np.zeros(6), 101))


def test_who_leaves_out_a_scenario_is_stopped_and_random_goals_drive_one_without_goals_as_it_is():
    scene = queue()
    choices = choose([scene, scene], Random(), candidate_settings(), 1.0)
    alone = replace(scene.log, valid=scene.log.valid & np.array([[True], [False]]))  # nobody is there who could take a goal
    traffic = Ground(
        choices, np.arange(2), [scene.log, alone], planner([busy_crossing(101, f"crossing-{i}") for i in range(2)]), LIMITS
    )
    left_out, attacked = (Arena(idm.Plugin(IDM), traffic, Bounds("physical", 2, 20), 7) for _ in range(2))
    left_out.drive(Variants.unchanged(np.zeros(1), 101))
    with pytest.raises(AssertionError, match="left out a scenario"):
        Findings.of(left_out.runs(), idm.Plugin(IDM), "made_up", LAW)
    random.Plugin(random.Plugin.settings_type()).attack(attacked)
    assert attacked.spent.tolist()[1] == 1
    assert (handed_over(attacked.runs())[0] >= 0).all()


def test_the_tables_and_the_published_rows_hold_what_was_found():
    numbers = {"collision": 0.5, "collision.low": 0.25, "collision.high": 0.75, "counted": 0.25, "kinds": 2, "scenarios": 8.0}
    attacks = {
        "cat.legal.10": {
            "method": "cat", "title": "CAT", "stand_in": "ours", "varies": "goals", "allowed": "legal", "budget": 10, **numbers
        }
    }  # fmt: skip
    costs = {"cat.legal.10": {"cases": 20.0, "cpu_seconds": 5.0}}
    rows = {row["metric"]: row for row in corner_rows("corpus", "idm", [(attacks, costs), (attacks, costs)])}
    assert rows["cr"] == {
        "data": "corpus", "driver": "idm", "method": "cat", "neighbours": "replayed", "allowed": "legal", "queries": 10,
        "metric": "cr", "value": 0.5, "low": 0.25, "high": 0.75, "n": 8, "seeds": 2,
    }  # fmt: skip
    prices = [rows[name] for name in ("cpu_seconds_per_1000", "cpu_seconds_per_1000_counted")]
    assert [(row["value"], row["n"]) for row in prices] == [(625.0, 16), (250.0, 40)]
    timed_once = {row["metric"]: row for row in corner_rows("corpus", "idm", [(attacks, costs), (attacks, {})])}
    assert (timed_once["cpu_seconds_per_1000"]["seeds"], timed_once["cr"]["seeds"]) == (1, 2)
    assert "avoidable" not in rows
    assert "| CAT | legal | 10 | 0.500 (0.250–0.750) |" in outcome_table("idm", attacks).markdown()
    nothing = {"dataset.legal.1": attacks["cat.legal.10"] | {"varies": "nothing", "budget": 1}}
    assert "| CAT | - | 1 | 0.500 (0.250–0.750) |" in outcome_table("idm", nothing).markdown()
    shown = cost_table("idm", attacks, {f"attack/idm-{key}": cost for key, cost in costs.items()})
    assert [cell.text for cell in shown.rows[0].cells] == ["CAT", "legal", "10", "20", "5.0", "625", "250"]


def test_a_table_tells_who_proposes_from_what_varies_where_somebody_proposes_both():
    def attack(proposer, varies, allowed, counted):
        about = {"proposer": proposer, "varies": varies, "allowed": allowed, "budget": 10}
        return f"{proposer}.{varies}.{allowed}", {**about, "counted": counted, "counted.low": 0.1, "counted.high": 0.9}

    goals = [attack("chance", "goals", "legal", 0.25), attack("chance", "goals", "physical", 0.5)]
    alone = [attack("cross-entropy", "motions", "legal", 0.125), ("dataset", {"proposer": "", "varies": "nothing"})]
    assert proposer_tables("idm", dict([*goals, *alone])) == []
    (table,) = proposer_tables("idm", dict([*goals, attack("chance", "motions", "physical", 0.75), *alone]))
    assert table.columns == ("", "runs a scene", "goals, legal", "goals, physical", "motions, legal", "motions, physical")
    texts = {row.cells[0].text: [cell.text for cell in row.cells[2:]] for row in table.rows}
    assert texts == {"chance": ["0.250", "0.500", "-", "0.750"], "cross-entropy": ["-", "-", "0.125", "-"]}
