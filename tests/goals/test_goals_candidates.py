"""Candidate goals on hand-made scenes, and their way through the store."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.errors import UnusableInput
from drivegen.core.roadmap import LaneKind
from drivegen.core.scenario import VehicleKind
from drivegen.core.signals import Signals, SignalState
from drivegen.goals.candidates import Settings, candidates
from drivegen.goals.cover import cover
from drivegen.goals.manoeuvres import Manoeuvre
from drivegen.goals.packing import pack, unpack
from drivegen.goals.scores import Judged, judge, scores
from drivegen.roads.frenet import from_frenet
from drivegen.roads.graph import LaneGraph
from drivegen.roads.reach import Dynamics, end_speed
from drivegen.store.goals import read_goals, write_goals
from tests import scenes

SETTINGS = Settings(most=32, most_routes=12, spacing=2.6, dynamics=Dynamics(3.0, 4.5, 5.0, 1.25))
SCENE = scenes.busy_crossing()
GRAPH = LaneGraph.of(SCENE.map)
REAL = Path(os.environ.get("DRIVEGEN_REAL_DATA", Path(__file__).parents[3] / "shared" / "data")) / "argoverse2"


def alone(roads, line, start, speed, signals=None):
    return scenes.scenario(roads, scenes.stack([scenes.drive(line, start, speed, 101)]), signals=signals)


def all_candidates(scene, graph):
    return [candidates(graph, scene, n, SETTINGS) for n in range(len(scene.vehicles))]


def test_only_buses_have_goals_on_a_bus_lane():
    roads = scenes.straight_road(300, 2)
    roads.kind[0] = LaneKind.BUS
    scene = alone(roads, np.array([[0.0, 3.5], [300.0, 3.5]]), 20, 10.0)
    assert set(candidates(LaneGraph.of(roads), scene, 0, SETTINGS).lane.tolist()) == {1}
    scene.vehicles.kind[0] = VehicleKind.BUS
    assert set(candidates(LaneGraph.of(roads), scene, 0, SETTINGS).lane.tolist()) == {0, 1}


def test_candidates_lie_on_their_routes_and_within_reach():
    for n, c in enumerate(all_candidates(SCENE, GRAPH)):
        assert 1 <= len(c) <= SETTINGS.most
        assert c.prior.sum() == pytest.approx(1, abs=1e-5)
        assert (c.speed >= 0).all()
        speed = SCENE.vehicles.speed[n]
        for i in np.flatnonzero((c.route >= 0) & (c.manoeuvre != Manoeuvre.STAY)):
            place, heading = from_frenet(c.routes[c.route[i]], c.s[i], c.d[i])
            assert np.allclose(place, c.position[i], atol=1e-3)
            assert np.isclose(np.cos(heading), np.cos(c.heading[i]), atol=1e-4)
            assert c.s[i] >= speed**2 / (2 * SETTINGS.dynamics.braking) - 1e-3
            assert c.s[i] <= speed * 10 + SETTINGS.dynamics.acceleration * 50 + 1e-3


def test_all_three_turns_are_offered_at_a_crossing():
    found = candidates(GRAPH, SCENE, 0, SETTINGS)
    assert {Manoeuvre.KEEP, Manoeuvre.LEFT, Manoeuvre.RIGHT} <= set(found.manoeuvre)


def test_lane_changes_to_both_sides_are_offered():
    roads = scenes.straight_road(300, 3)
    scene = alone(roads, scenes.joined(roads, 1), 20, 12)
    found = candidates(LaneGraph.of(roads), scene, 0, SETTINGS)
    assert {Manoeuvre.CHANGE_LEFT, Manoeuvre.CHANGE_RIGHT} <= set(found.manoeuvre)


def test_a_red_light_brings_a_stop_before_its_line():
    roads = scenes.crossing()
    lanes = np.arange(8, 11, dtype=np.int32)
    red = Signals(lanes, np.full((3, 101), SignalState.RED, np.uint8))
    scene = alone(roads, scenes.joined(roads, 0, 8, 4), 30, 9, red)
    found = candidates(LaneGraph.of(roads), scene, 0, SETTINGS)
    stops = found.position[found.manoeuvre == Manoeuvre.STOP]
    assert np.abs(stops[:, 0] - (-10 - 2.3 - 1)).min() < 1.5  # the front bumper a metre before the line at x = -10


def test_a_standing_leader_brings_a_stop_behind_it():
    roads = scenes.straight_road()
    line = scenes.joined(roads, 0)
    scene = scenes.scenario(roads, scenes.stack([scenes.drive(line, 20, 10, 101), scenes.drive(line, 80, 0, 101)]))
    found = candidates(LaneGraph.of(roads), scene, 0, SETTINGS)
    stops = found.position[found.manoeuvre == Manoeuvre.STOP]
    assert np.abs(stops[:, 0] - (80 - 4.6 - 2.5)).min() < 1.5
    assert found.ahead[0].leader_gap == pytest.approx(60 - 4.6, abs=0.1)


def test_a_moving_leader_brings_a_place_in_the_queue_behind_it():
    roads = scenes.straight_road()
    line = scenes.joined(roads, 0)
    scene = scenes.scenario(roads, scenes.stack([scenes.drive(line, 20, 10, 101), scenes.drive(line, 60, 3, 101)]))
    found = candidates(LaneGraph.of(roads), scene, 0, SETTINGS)
    behind = 60 + 3 * 10 - 4.6 - 2.5 - 1.2 * 3  # where the leader will be, less a car, the gap and the headway
    assert np.abs(found.s - (behind - 20)).min() < SETTINGS.spacing * 1.1


def test_a_way_back_is_a_u_turn():
    plain = scenes.crossing()
    lines = [plain.centreline[i] for i in range(len(plain))]
    back = scenes._arc(lines[0][-1], lines[6][0], 0.0, np.pi)
    links = [*map(tuple, plain.links.tolist()), (0, len(lines)), (len(lines), 6)]
    roads = scenes.road_map([*lines, back], links, [*range(8, 20), len(lines)])
    scene = alone(roads, scenes.joined(roads, 0), 60, 5)
    found = candidates(LaneGraph.of(roads), scene, 0, SETTINGS)
    turned = found.manoeuvre == Manoeuvre.U_TURN
    assert turned.any()
    assert (np.abs(found.heading[turned]) > 2.5).all()
    assert (found.lane[turned] == 6).any()
    assert Manoeuvre.U_TURN not in candidates(LaneGraph.of(plain), scene, 0, SETTINGS).manoeuvre


def test_the_kerb_is_on_offer_where_one_may_park():
    roads = scenes.straight_road(300, 2)
    graph = LaneGraph.of(roads)
    right, left = (candidates(graph, alone(roads, scenes.joined(roads, lane), 30, 8), 0, SETTINGS) for lane in (0, 1))
    [at] = np.flatnonzero(right.manoeuvre == Manoeuvre.PARK)
    assert right.speed[at] == 0
    assert right.position[at] == pytest.approx((30 + 16, -(1.75 - 0.95 - 0.3)), abs=0.05)  # 8 m/s at 2 m/s2; beside the edge
    assert Manoeuvre.PARK not in left.manoeuvre  # another lane is to its right
    fast = replace(roads, speed_limit=np.full(2, 30.0, np.float32))
    scene = alone(fast, scenes.joined(fast, 0), 30, 8)
    assert Manoeuvre.PARK not in candidates(LaneGraph.of(fast), scene, 0, SETTINGS).manoeuvre
    crossing = scenes.crossing()
    scene = alone(crossing, scenes.joined(crossing, 0), 70, 8)  # would stand in the junction
    assert Manoeuvre.PARK not in candidates(LaneGraph.of(crossing), scene, 0, SETTINGS).manoeuvre


@pytest.mark.parametrize("place", [(30.0, 0.0), (30.0, -40.0), (30.0, 900.0)])
def test_a_standing_vehicle_may_stay_wherever_it_is(place):
    roads = scenes.straight_road()
    scene = alone(roads, scenes.joined(roads, 0), 30, 0)
    scene.vehicles.position[0] = place
    found = candidates(LaneGraph.of(roads), scene, 0, SETTINGS)
    stay = np.flatnonzero((found.manoeuvre == Manoeuvre.STAY) & (found.position == np.float32(place)).all(1))
    assert len(stay) >= 1
    assert found.speed[stay[0]] == 0


def test_a_moving_vehicle_off_the_lanes_gets_goals_ahead_of_it():
    roads = scenes.straight_road()
    scene = alone(roads, scenes.joined(roads, 0), 30, 4)
    scene.vehicles.position[0] = (30, -60)
    found = candidates(LaneGraph.of(roads), scene, 0, SETTINGS)
    assert (found.manoeuvre == Manoeuvre.OFF_LANE).sum() > 5
    assert (found.position[:, 0] >= 30 - 1e-3).all()


def test_goals_beyond_the_map_say_so():
    roads = scenes.straight_road(100)
    scene = alone(roads, scenes.joined(roads, 0), 40, 14)
    found = candidates(LaneGraph.of(roads), scene, 0, SETTINGS)
    assert np.array_equal(found.leaves_map, found.position[:, 0] > 100)
    assert found.leaves_map.any()


def test_end_speed_is_that_of_the_smoothest_cubic():
    distance = np.array([0.0, 40.0, 100.0, 150.0])
    assert np.allclose(end_speed(distance, 10.0, np.full(4, 16.0), 10.0), [0, 1, 10, 16])


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**6), count=st.integers(1, 60), most=st.integers(1, 20))
def test_cover_is_greedy(seed, count, most):
    random = np.random.default_rng(seed)
    places, mass = random.uniform(0, 30, (count, 2)), random.uniform(0.1, 1, count)
    picked = cover(places, mass, np.zeros(0, np.intp), 4.0, most)
    near = np.hypot(*(places[:, None] - places).transpose(2, 0, 1)) <= 4.0
    left = mass.copy()
    for pick in picked:
        assert np.isclose(left[near[pick]].sum(), (near * left).sum(1).max())
        left[near[pick]] = 0
    assert len(set(picked.tolist())) == len(picked)
    assert len(picked) == most or np.isclose(left.sum(), 0)


def test_hand_made_logs_end_near_a_candidate():
    found = all_candidates(SCENE, GRAPH)
    judged = judge(SCENE, found, [c.prior for c in found])
    assert len(judged.distance) == len(SCENE.vehicles)
    table = scores(judged)["all"]
    assert table["coverage_4m"] == 1
    assert table["oracle_fde"] < 2.5


def test_scores_of_a_known_ranking():
    found = [replace(c, position=c.position.copy()) for c in all_candidates(SCENE, GRAPH)[:1]]
    found[0].position[3] = SCENE.log.position[0, -1]
    certain = np.zeros(len(found[0]), np.float32)
    certain[3] = 1
    one = replace(SCENE, vehicles=SCENE.vehicles[:1], log=SCENE.log[:1])
    table = scores(judge(one, found, [certain]))["moving"]
    assert (table["hit_1"], table["hit_3"], table["mean_reciprocal_rank"], table["oracle_fde"]) == (1, 1, 1, 0)
    assert table["nll"] == pytest.approx(0, abs=1e-6)
    uniform = np.full(len(certain), 1 / len(certain), np.float32)
    table = scores(judge(one, found, [uniform]))["moving"]
    assert table["nll"] == pytest.approx(np.log(len(certain)), abs=1e-5)
    assert table["hit_1"] == pytest.approx(1 / len(certain))  # by lot
    assert table["hit_3"] == pytest.approx(3 / len(certain))
    assert table["expected_fde"] == pytest.approx(np.hypot(*(found[0].position - found[0].position[3]).T).mean(), rel=1e-4)


def test_scores_are_drawn_by_recording_and_not_averaged_over_horizons():
    found = all_candidates(SCENE, GRAPH)
    names = ("USA_Lanker-2_10_T-1-000", "USA_Lanker-2_10_T-1-001", "USA_US101-12_1_T-1-000")
    sure = [(c.prior == c.prior.max()).astype(np.float32) for c in found]
    parts = [
        judge(replace(SCENE, scenario_id=name), found, odds)
        for name, odds in zip(names, ([c.prior for c in found], [c.prior for c in found], sure), strict=True)
    ]
    short = replace(parts[0], steps=parts[0].steps - 30, scene_steps=parts[0].scene_steps - 30)
    table = scores(Judged.joined([*parts, short]), 7, 200)["all"]
    vehicles = len(SCENE.vehicles)
    assert (table["vehicles"], table["left_out"], table["recordings"]) == (3 * vehicles, vehicles, 2)
    one, other = (scores(part)["all"]["nll"] for part in (parts[0], parts[2]))
    assert table["nll"] == pytest.approx((2 * one + other) / 3)
    assert [table["nll.low"], table["nll.high"]] == pytest.approx(sorted([one, other]))  # draws of one recording alone


def test_the_usual_horizon_is_that_of_most_scenes_however_many_vehicles_they_have():
    found = all_candidates(SCENE, GRAPH)
    full = judge(SCENE, found, [c.prior for c in found])
    unseen = np.zeros_like(SCENE.log.valid)
    unseen[:, 0] = True
    nobody = judge(replace(SCENE, log=replace(SCENE.log, valid=unseen)), found, [c.prior for c in found])
    assert len(full.steps) == len(SCENE.vehicles)
    assert (len(nobody.steps), nobody.scene_steps.tolist()) == (0, full.scene_steps.tolist())
    short = replace(nobody, scene_steps=nobody.scene_steps - 30)
    table = scores(Judged.joined([full, short, short]))["all"]
    assert (table["vehicles"], table["left_out"]) == (0, len(SCENE.vehicles))


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_goals_come_back_from_the_store_as_they_went_in(tmp_path_factory, seed):
    scene = scenes.any_scenario(seed)
    graph = LaneGraph.of(scene.map)
    found = all_candidates(scene, graph)
    path = tmp_path_factory.mktemp("goals") / "shard-00000.parquet"
    columns = pack(scene, "prior", found, [c.prior for c in found])
    write_goals(path, [columns, columns])
    first = path.read_bytes()
    write_goals(path, [columns, columns])
    assert path.read_bytes() == first
    back = read_goals(path)[1]
    assert (back.scenario_id, back.selector) == (scene.scenario_id, "prior")
    again, probability = unpack(graph, back)
    for a, b, p in zip(found, again, probability, strict=True):
        assert np.array_equal(a.prior, p)
        assert a.ahead == b.ahead
        for name in ("position", "heading", "speed", "route", "s", "d", "step", "manoeuvre", "lane", "leaves_map", "offset"):
            assert np.array_equal(getattr(a, name), getattr(b, name)), name
        for mine, theirs in zip(a.routes, b.routes, strict=True):
            assert mine.pieces == theirs.pieces
            assert np.array_equal(mine.line, theirs.line)


def test_goals_of_another_map_are_refused():
    columns = pack(SCENE, "prior", all_candidates(SCENE, GRAPH), [c.prior for c in all_candidates(SCENE, GRAPH)])
    with pytest.raises(UnusableInput, match="do not fit its map"):
        unpack(LaneGraph.of(scenes.straight_road()), columns)


@pytest.mark.skipif(not REAL.exists(), reason="real Argoverse 2 data is not there")
def test_real_tracks_end_near_a_candidate():
    from drivegen.datasets.argoverse2 import Plugin
    from drivegen.ingest.selection import Settings as Selection
    from drivegen.ingest.selection import select

    data, wanted = Plugin(REAL / "motion-forecasting"), Selection("focal", 64, 0, 100, None, 0.5)
    nearest = []
    for name in data.scenes("train"):
        scene = select(data.read("train", name), wanted)
        graph = LaneGraph.of(scene.map)
        found = all_candidates(scene, graph)
        nearest += [d.min() for d in judge(scene, found, [c.prior for c in found]).distance]
    assert len(nearest) >= 8
    assert np.mean(np.array(nearest) < 4) >= 0.9
