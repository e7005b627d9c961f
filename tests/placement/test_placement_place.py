from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import boxes_overlap, wrap_angle
from drivegen.core.roadmap import LaneControl, LaneKind
from drivegen.core.scenario import SizeSource, VehicleKind
from drivegen.placement.place import Placement, Placer, PlaceSettings
from drivegen.placement.retrieve import Asked, draw_kinds, retrieve
from drivegen.placement.slots import Slots
from drivegen.placement.table import Provenance, Table, build_table
from drivegen.placement.where import Relation, Wish, standing
from tests.scenes import beside, busy_crossing, crossing, road_map, straight_road

SETTINGS = PlaceSettings(
    mode="paper", road_ahead=120.0, radius=80.0, speed_spread=0.15, least_time_gap=0.8, standstill_gap=2.0, attempts=24
)
MAPS = {"crossing": Slots(crossing()), "stop": Slots(crossing(control=LaneControl.STOP)), "road": Slots(straight_road(300, 3))}


def table() -> Table:
    """Three kinds, two rows each: a short and a long one."""
    size = [[4.0, 1.8, 1.5], [5.0, 2.0, 1.8], [7.0, 2.5, 3.0], [9.0, 2.5, 3.2], [11.0, 2.55, 3.1], [12.0, 2.55, 3.1]]
    return Table(
        kind=np.repeat(np.uint8([VehicleKind.CAR, VehicleKind.TRUCK, VehicleKind.BUS]), 2),
        size=np.array(size, np.float32),
        usual_speed=np.full(6, 10, np.float32),
        provenance=np.full(6, Provenance.MEASURED, np.uint8),
        source=np.full(6, "test"),
        count=np.array([3, 1, 1, 1, 1, 1]),
    )


scenes = st.tuples(st.sampled_from(sorted(MAPS)), st.lists(st.integers(0, 5), min_size=1, max_size=20), st.integers(0, 2**32))


def placed(name: str, rows: list[int], seed: int) -> Placement:
    return Placer(MAPS[name], table(), SETTINGS).place(rows, np.random.default_rng(seed))


@settings(max_examples=50, deadline=None)
@given(scenes)
def test_all_asked_are_placed_or_rejected_with_a_reason(scene):
    name, rows, seed = scene
    placement = placed(name, rows, seed)
    assert len(placement.vehicles) + sum(placement.rejected.values()) == len(rows)
    assert set(placement.rejected) <= {"overlap", "time-gap", "does-not-fit"}
    placement.vehicles.validate()


@settings(max_examples=50, deadline=None)
@given(scenes)
def test_nobody_overlaps_or_faces_the_wrong_way_or_is_too_fast(scene):
    name, rows, seed = scene
    placement, slots = placed(name, rows, seed), MAPS[name]
    v = placement.vehicles
    a, b = np.triu_indices(len(v), 1)
    hit = boxes_overlap(v.position[a], v.heading[a], v.size[a, :2], v.position[b], v.heading[b], v.size[b, :2])
    assert not hit.any()
    for i, lane in enumerate(placement.lane):
        line = slots.map.centreline[lane]
        course = np.arctan2(*(line[-1] - line[0])[::-1])
        assert abs(wrap_angle(v.heading[i] - course)) < 0.1  # these lanes are straight
        assert v.speed[i] <= slots.map.speed_limit[lane] + 1e-3
        assert not slots.map.in_junction[lane]
        assert np.hypot(*(v.position[i] - v.position[0])) <= SETTINGS.radius + 1e-3


@settings(max_examples=50, deadline=None)
@given(scenes)
def test_followers_keep_a_time_gap_and_can_still_brake(scene):
    placement = placed(*scene)
    for follower, leader, gap in followers(placement):
        fast, slow = placement.vehicles.speed[follower], placement.vehicles.speed[leader]
        assert gap >= SETTINGS.standstill_gap + SETTINGS.least_time_gap * fast - 0.01
        assert gap >= max(fast**2 - slow**2, 0) / 6 - 0.01


def followers(placement: Placement) -> Iterator[tuple[int, int, float]]:
    """Pairs on one straight lane, with the gap between their bumpers."""
    v = placement.vehicles
    for i in range(len(v)):
        for j in range(len(v)):
            if i != j and placement.lane[i] == placement.lane[j]:
                ahead = float((v.position[j] - v.position[i]) @ [np.cos(v.heading[i]), np.sin(v.heading[i])])
                if ahead > 0:
                    yield i, j, ahead - float(v.size[i, 0] + v.size[j, 0]) / 2


def test_social_vehicles_drive_about_as_fast_as_the_target():
    speeds = [placed("road", [0] * 8, seed).vehicles.speed for seed in range(20)]
    ratio = np.concatenate([speed[1:] / speed[0] for speed in speeds])
    assert 0.9 < np.median(ratio) <= 1.1
    assert ratio.std() < 0.3


def test_nobody_is_too_fast_to_stop_before_a_stop_line_or_a_red_light():
    stop, lights = MAPS["stop"], MAPS["crossing"]
    into = np.arange(4)  # the crossing's ways in
    for slots, closed in ((stop, None), (lights, np.arange(8, 20, dtype=np.int32))):
        for seed in range(20):
            placement = Placer(slots, table(), SETTINGS).place([0] * 10, np.random.default_rng(seed), closed)
            v = placement.vehicles
            for i in np.flatnonzero(np.isin(placement.lane, into)):
                left = np.hypot(*(slots.map.centreline[placement.lane[i]][-1] - v.position[i]))
                before = max(left - v.size[i, 0] / 2, 0.0)  # its front, not its middle, must not get over
                assert v.speed[i] ** 2 <= 2 * 2.0 * before + 1e-3
    fast = [placed("crossing", [0], seed) for seed in range(40)]
    assert any(p.vehicles.speed[0] > 10 and p.lane[0] in into for p in fast)  # with green lights they need not


def test_what_waits_behind_a_short_lane_is_seen_from_before_it():
    turned = np.linspace(0, np.pi / 2, 30)
    bend = np.column_stack([104 + 15 * np.sin(turned), 15 - 15 * np.cos(turned)])
    lines = [np.array([[0.0, 0.0], [100.0, 0.0]]), np.array([[100.0, 0.0], [104.0, 0.0]]), bend]
    slots = Slots(road_map(lines, links=[(0, 1), (1, 2)]))
    before = slots.lane == 0
    left = 104 - slots.along[before]
    assert (slots.limit[before] <= np.sqrt(2.5 * 15 * 1.1 + 2 * 2.0 * left)).all()
    assert slots.limit[before].max() > 13
    red = slots.limit_before(np.array([2], np.int32))[before]
    assert (red <= np.sqrt(2 * 2.0 * left) + 1e-3).all()


@pytest.mark.parametrize("piece", [1.0, 4.0])
def test_a_bend_is_as_slow_however_finely_it_is_drawn(piece):
    turned = np.arange(0, np.pi, piece / 20)
    slots = Slots(road_map([np.column_stack([20 * np.sin(turned), 20 - 20 * np.cos(turned)])]))
    assert slots.limit == pytest.approx(np.sqrt(2.5 * 20), rel=0.15)


def test_who_stands_in_a_queue_is_close_to_the_next_one():
    wishes = [Wish(), Wish(relation=Relation.AHEAD, distance=40, speed=0.0), Wish(beside=1, ahead=True, speed=0.0)]
    gaps = []
    for seed in range(60):
        v = Placer(MAPS["road"], table(), SETTINGS).place([0, 2, 2], np.random.default_rng(seed), wishes=wishes).vehicles
        if len(v) == 3:
            gaps.append(np.hypot(*(v.position[2] - v.position[1])) - v.size[1:, 0].mean())
    assert 2 <= min(gaps) < max(gaps) <= 10


def test_a_full_road_rejects_what_has_no_room():
    placement = placed("crossing", [5] * 60, 1)
    assert 1 <= len(placement.vehicles) < 60
    assert sum(placement.rejected.values()) == 60 - len(placement.vehicles)


def test_cars_stay_off_bus_and_bicycle_lanes():
    roads = crossing()
    roads.kind[[0, 4]] = LaneKind.BUS
    roads.kind[[1, 5]] = LaneKind.BIKE
    slots = Slots(roads)
    for seed in range(10):
        placement = Placer(slots, table(), SETTINGS).place([0] * 10 + [4] * 3, np.random.default_rng(seed))
        cars = placement.vehicles.kind == VehicleKind.CAR
        assert set(placement.lane[cars].tolist()) <= {2, 3, 6, 7}
        assert not {1, 5} & set(placement.lane.tolist())


def test_a_target_that_fits_nowhere_is_said_to():
    wide = replace(table(), size=np.full((6, 3), 30.0, np.float32))
    with pytest.raises(UnusableInput) as caught:
        Placer(MAPS["road"], wide, SETTINGS).place([0], np.random.default_rng(0))
    assert caught.value.reason == "no-place"
    long = np.where(np.arange(6)[:, None] == 0, np.float32([400, 2, 2]), table().size).astype(np.float32)
    placement = Placer(MAPS["road"], replace(table(), size=long), SETTINGS).place([1, 0], np.random.default_rng(0))
    assert placement.rejected == {"does-not-fit": 1}


def test_retrieval_goes_by_kind_number_and_length_and_by_how_often_a_row_was_seen():
    random = np.random.default_rng(0)
    rows = retrieve(table(), VehicleKind.CAR, 400, random)
    assert set(rows.tolist()) == {0, 1}
    assert np.mean(rows == 0) == pytest.approx(0.75, abs=0.07)
    assert set(retrieve(table(), VehicleKind.TRUCK, 9, random, Asked(length=(8, 20))).tolist()) == {3}
    with pytest.raises(UnusableInput, match="no bus 1 to 2 m long, 0 to 3 m/s fast"):
        retrieve(table(), VehicleKind.BUS, 1, random, Asked(length=(1, 2), speed=(0, 3)))


@pytest.mark.parametrize(
    ("asked", "rows"),
    [
        (Asked(), {0, 1}),
        (Asked(width=(1.9, 2.5)), {1}),
        (Asked(height=(0, 1.5)), {0}),
        (Asked(length=(4.0, 4.0)), {0}),
        (Asked(speed=(12, 30)), {1}),
        (Asked(length=(3, 6), width=(1, 3), height=(1, 2), speed=(10, 10)), {0}),
    ],
)
def test_retrieval_goes_by_every_side_and_by_speed(asked, rows):
    own = replace(table(), usual_speed=np.float32([10, 20, 10, 10, 10, 10]))
    assert set(retrieve(own, VehicleKind.CAR, 50, np.random.default_rng(0), asked).tolist()) == rows


@given(st.integers(0, 2**32), *(st.tuples(st.floats(0, 6), st.floats(0, 6)).map(sorted).map(tuple) for _ in range(3)))
def test_what_is_retrieved_lies_within_the_ranges_or_nothing_is(seed, length, width, height):
    asked = Asked(length=length, width=width, height=height)
    rows = np.flatnonzero(asked.fits(table()))
    inside = [
        all(low <= x <= high for x, (low, high) in zip(size, (length, width, height), strict=True)) for size in table().size
    ]
    assert rows.tolist() == np.flatnonzero(inside).tolist()


def test_every_row_says_where_it_is_from():
    scene = busy_crossing()
    assumed = replace(scene.vehicles, size_source=np.full(len(scene.vehicles), SizeSource.ASSUMED, np.uint8))
    simulated = replace(scene, source="SUMO corpus (simulated)")
    made = build_table([replace(scene, source="logs"), simulated, replace(scene, source="old logs", vehicles=assumed)])
    told = {(Provenance(p), s) for p, s in zip(made.provenance.tolist(), made.source.tolist(), strict=True)}
    here = {(Provenance.MEASURED, "logs"), (Provenance.SIMULATED, "SUMO corpus (simulated)"), (Provenance.DOCUMENTED, "old logs")}
    assert here <= told
    rows = retrieve(made, VehicleKind.CAR, 20, np.random.default_rng(0))
    assert {made.source[row] for row in rows} == {"logs"}  # the best that there is


def test_better_provenance_wins_within_a_kind():
    mixed = replace(table(), provenance=np.uint8([Provenance.SIMULATED, Provenance.MEASURED, 1, 1, 2, 2]))
    assert set(retrieve(mixed, VehicleKind.CAR, 50, np.random.default_rng(0)).tolist()) == {1}


def test_kinds_are_drawn_by_shares_and_wrong_shares_refused():
    kinds = draw_kinds({VehicleKind.CAR: 3, VehicleKind.BUS: 1}, 2000, np.random.default_rng(0))
    assert np.mean([kind == VehicleKind.CAR for kind in kinds]) == pytest.approx(0.75, abs=0.04)
    for wrong in ({}, {VehicleKind.CAR: 0.0}, {VehicleKind.CAR: 1.0, VehicleKind.BUS: -1.0}):
        with pytest.raises(UnusableInput):
            draw_kinds(wrong, 1, np.random.default_rng(0))


def test_the_table_holds_each_box_once_with_speed_count_and_where_it_is_from():
    scene = busy_crossing()
    simulated = replace(scene, source="SUMO corpus (simulated)")
    assumed = replace(scene, vehicles=replace(scene.vehicles, size_source=np.full(8, SizeSource.ASSUMED, np.uint8)))
    shrunk = replace(scene, vehicles=replace(scene.vehicles, size_source=np.full(8, SizeSource.SHRUNK, np.uint8)))
    built = build_table([scene, scene, simulated, assumed, shrunk])
    cars = built.kind == VehicleKind.CAR
    assert np.allclose(built.size[cars], [4.6, 1.9, 1.6])
    assert built.provenance[cars].tolist() == [Provenance.MEASURED, Provenance.SIMULATED, Provenance.DOCUMENTED]
    assert built.count[cars].tolist() == [16, 8, 8]
    assert 5 < built.usual_speed[cars][0] < 12
    others = built.provenance[~cars]
    assert sorted(built.kind[~cars].tolist()) == [VehicleKind.TRUCK, VehicleKind.BUS]  # not in the logs: documented
    assert (others == Provenance.DOCUMENTED).all()


def test_the_table_goes_to_columns_and_back_and_wrong_columns_are_refused():
    built = build_table([busy_crossing()])
    again = Table.from_arrow(built.to_arrow(), "table")
    for name in ("kind", "size", "usual_speed", "provenance", "source", "count"):
        assert np.array_equal(getattr(built, name), getattr(again, name))
    with pytest.raises(UnusableInput, match="elsewhere"):
        Table.from_arrow(built.to_arrow().drop_columns(["width"]), "elsewhere")
    with pytest.raises(UnusableInput, match="elsewhere"):
        Table.from_arrow(built.to_arrow().slice(0, 0), "elsewhere")


def test_the_target_has_road_ahead_where_the_map_has_it():
    slots = MAPS["crossing"]
    wanted = min(SETTINGS.road_ahead, float(np.quantile(slots.road_ahead, 0.9)))
    for seed in range(20):
        target = placed("crossing", [0], seed).vehicles.position[0]
        at = np.hypot(*(slots.position - target).T).argmin()
        assert slots.road_ahead[at] >= wanted - 2.0
    assert slots.road_ahead.min() < wanted


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(
    ("relation", "lane", "low", "high"),
    [
        (Relation.LEFT_AHEAD, 3, 4, 40),
        (Relation.RIGHT_AHEAD, 1, 4, 40),
        (Relation.LEFT_BEHIND, 3, -40, -4),
        (Relation.RIGHT_BEHIND, 1, -40, -4),
        (Relation.LEFT, 3, -12, 12),
        (Relation.RIGHT, 1, -12, 12),
    ],
)
def test_in_a_bend_too_who_is_beside_is_in_the_next_lane_on_its_side(side, relation, lane, low, high):
    angle = np.linspace(0, 3, 121)
    middle = 60.0 * np.stack([np.sin(angle), side * (1 - np.cos(angle))], axis=1)
    lines = [beside(middle, (number - 2) * 3.2) for number in range(5)]
    slots = Slots(road_map(lines, neighbours=[(number + 1, number) for number in range(4)]))
    target = int(np.flatnonzero(slots.lane == 2)[40])
    found = np.flatnonzero(standing(slots, target, relation, None))
    turned = side * wrap_angle(slots.heading[found] - slots.heading[target]) * 60.0  # [m] along the target's lane
    assert set(slots.lane[found].tolist()) == {lane}
    assert len(found) >= (high - low) / 2 - 4
    assert low - 3 < turned.min() < turned.max() < high + 3
