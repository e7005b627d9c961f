"""Choosing the target and its neighbours from a recording."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.errors import UnusableInput
from drivegen.core.first_frame import first_frame
from drivegen.core.geometry import boxes_overlap
from drivegen.core.recorded_log import NO_TRACK, RecordedLog
from drivegen.core.scenario import SizeSource, Trajectories, VehicleKind
from drivegen.core.signals import Signals, SignalState
from drivegen.ingest.selection import Settings, everybody, select
from drivegen.ingest.vehicles import ASSUMED_SIZE
from tests.futures import bytes_of, otherwise
from tests.scenes import crossing, drive, joined, stack, straight_road

SETTINGS = Settings(target="focal", max_vehicles=16, first_step=0, horizon=100, map_radius=None, smallest_shrink=0.8)
STEPS = 40


def parked(x: float, y: float, heading: float = 0.0, steps: int = STEPS) -> Trajectories:
    whole = Trajectories.empty(steps)
    whole.position[:] = (x, y)
    whole.heading[:] = heading
    whole.valid[:] = True
    return whole


def seen_for(steps: int, x: float) -> Trajectories:
    whole = parked(x, 0)
    whole.valid[steps:] = False
    return whole


def recording(motions: list[Trajectories], **changes: object) -> RecordedLog:
    """Cars on a straight road; track 0 is the focal one, track 1 the ego."""
    count = len(motions)
    log = RecordedLog(
        scenario_id="recording",
        source="test",
        city="testville",
        map=replace(straight_road(), origin=np.array([5000.0, -3000.0])),
        track_id=np.array([f"track-{i}" for i in range(count)]),
        kind=np.full(count, VehicleKind.CAR, np.uint8),
        size=np.full((count, 3), np.nan, np.float32),
        motion=stack(motions),
        focal=0,
        ego=1,
        signals=Signals.none(motions[0].steps),
        skipped={},
    )
    return replace(log, **changes)


def row(count: int = 5, gap: float = 12.0) -> list[Trajectories]:
    return [parked(100 + gap * i, 0) for i in range(count)]


def names(log: RecordedLog, wanted: Settings = SETTINGS) -> list[str]:
    return select(log, wanted).vehicles.track_id.tolist()


def kinds(*changed: tuple[int, VehicleKind], count: int = 5) -> np.ndarray:
    kind = np.full(count, VehicleKind.CAR, np.uint8)
    for track, value in changed:
        kind[track] = value
    return kind


def test_the_target_comes_first_then_the_nearest() -> None:
    assert names(recording(row(), focal=3)) == ["track-3", "track-2", "track-4", "track-1", "track-0"]
    assert names(recording(row(), focal=3), replace(SETTINGS, max_vehicles=3)) == ["track-3", "track-2", "track-4"]


def test_the_ego_is_the_target_if_asked_for() -> None:
    assert names(recording(row()), replace(SETTINGS, target="ego"))[0] == "track-1"


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"focal": NO_TRACK}, "is not in the recording"),
        ({"kind": kinds((0, VehicleKind.CYCLIST))}, "is no vehicle"),
        ({"motion": stack([Trajectories.empty(STEPS), *row()[1:]])}, "is absent at the first step"),
    ],
)
def test_an_unfit_focal_track_makes_way_for_the_av_and_it_is_noted(changes: dict, why: str) -> None:
    scenario = select(recording(row(), **changes), SETTINGS)
    assert scenario.vehicles.track_id[0] == "track-1"
    assert scenario.notes["target"] == f"AV, because the focal track {why}"


@pytest.mark.parametrize(
    ("log", "reason"),
    [
        (recording(row(), focal=NO_TRACK, ego=NO_TRACK), "no-target"),
        (recording(row(), kind=np.full(5, VehicleKind.PEDESTRIAN, np.uint8)), "no-vehicles"),
        (recording([parked(0, 0, steps=8)] * 2), "too-short"),
        (recording([replace(parked(0, 0), velocity=np.full((STEPS, 2), 90, np.float32)), parked(9, 0)]), "implausible-target"),
        (
            recording([seen_for(1, 100), seen_for(1, 112), parked(124, 0)], kind=kinds((2, VehicleKind.CYCLIST), count=3)),
            "nothing-to-score",
        ),
    ],
)
def test_what_yields_no_scenario_is_rejected_with_a_reason(log: RecordedLog, reason: str) -> None:
    with pytest.raises(UnusableInput) as caught:
        select(log, SETTINGS)
    assert caught.value.reason == reason


def test_one_vehicle_that_is_seen_once_more_is_enough_to_score() -> None:
    scenario = select(recording([seen_for(1, 100), seen_for(2, 112)]), SETTINGS)
    assert scenario.log is not None
    assert scenario.log.valid.sum(axis=1).tolist() == [1, 2]


def test_a_track_ends_where_it_jumps_and_is_dropped_and_counted_if_that_is_at_once() -> None:
    jumping, racing = parked(124, 0), parked(136, 0)
    jumping.position[20:] += 30
    racing.velocity[:] = 80
    scenario = select(recording([*row(2), jumping, racing]), SETTINGS)
    assert scenario.vehicles.track_id.tolist() == ["track-0", "track-1", "track-2"]
    assert scenario.log is not None
    assert scenario.log.valid[2].tolist() == [True] * 20 + [False] * (STEPS - 20)
    assert scenario.notes == {"dropped_implausible": "1", "ended_implausible": "1"}


@given(st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_logs_that_begin_alike_give_scenarios_of_equal_first_frames(seed: int) -> None:
    random, roads = np.random.default_rng(seed), crossing(arm=200.0)
    moving = [drive(joined(roads, 0, 8, 4), random.uniform(0, 150), random.choice([0, 9]), STEPS) for _ in range(12)]
    kind = random.choice([VehicleKind.CAR, VehicleKind.CYCLIST], 12).astype(np.uint8)
    kind[0] = VehicleKind.CAR
    signals = Signals(np.arange(8, 20, dtype=np.int32), np.full((12, STEPS), SignalState.RED, np.uint8))
    log = recording(moving, map=roads, kind=kind, signals=signals)
    shown = np.full((12, STEPS), SignalState.GREEN, np.uint8)
    shown[:, 0] = SignalState.RED
    other = replace(log, motion=otherwise(log.motion), signals=replace(signals, state=shown))
    one, two = (first_frame(select(one, replace(SETTINGS, map_radius=20.0))) for one in (log, other))
    assert len(one.map) < len(roads)
    assert one.notes == two.notes
    assert bytes_of(one) == bytes_of(two)


def test_unknown_sizes_are_assumed_by_kind_and_known_ones_kept() -> None:
    size = np.full((5, 3), np.nan, np.float32)
    size[0] = (5.1, 2.0, 1.4)
    log = recording(row(gap=20), size=size, kind=kinds((1, VehicleKind.BUS)))
    vehicles = select(log, SETTINGS).vehicles
    np.testing.assert_allclose(vehicles.size[0], (5.1, 2.0, 1.4))
    np.testing.assert_allclose(vehicles.size[1], ASSUMED_SIZE[VehicleKind.BUS])
    assert vehicles.size_source[:2].tolist() == [SizeSource.MEASURED, SizeSource.ASSUMED]


def test_assumed_boxes_of_parked_cars_shrink_together_until_they_are_apart() -> None:
    scenario = select(recording([parked(100, 0), parked(104.4, 0), parked(120, 0)]), SETTINGS)
    vehicles = scenario.vehicles
    assert vehicles.size_source.tolist() == [SizeSource.SHRUNK, SizeSource.SHRUNK, SizeSource.ASSUMED]
    assert vehicles.size[0, 0] == vehicles.size[1, 0] < 4.4
    assert vehicles.size[0, 0] > 4.4 * 0.97
    assert scenario.notes == {"overlaps": "1", "shrunk": "2"}


def test_a_box_that_shrank_does_not_grow_again_beside_one_that_needs_less() -> None:
    sizes = select(recording([parked(100, 0), parked(104.2, 0), parked(108.56, 0)]), SETTINGS).vehicles.size
    np.testing.assert_allclose(sizes[:, 0] / ASSUMED_SIZE[VehicleKind.CAR][0], (0.9, 0.9, 0.94), rtol=1e-5)


@pytest.mark.parametrize(("smallest", "left"), [(0.8, 2), (0.82, 1)])
def test_boxes_shrink_as_far_as_they_may_and_no_farther(smallest: float, left: int) -> None:
    log = recording([parked(100, 0), parked(103.75, 0)])  # 0.80 of 4.63 m is short enough, 0.82 is not
    assert len(names(log, replace(SETTINGS, smallest_shrink=smallest))) == left


@pytest.mark.parametrize("case", ["too deep", "moving", "measured"])
def test_other_overlaps_drop_the_farther_vehicle(case: str) -> None:
    size = np.full((3, 3), np.nan, np.float32)
    second = parked(102 if case == "too deep" else 104.4, 0)
    if case == "moving":
        second = replace(second, velocity=np.full((STEPS, 2), 3, np.float32))
    if case == "measured":
        size[0] = (4.63, 1.97, 1.74)
    scenario = select(recording([parked(100, 0), second, parked(120, 0)], size=size), SETTINGS)
    assert scenario.vehicles.track_id.tolist() == ["track-0", "track-2"]
    assert scenario.notes == {"overlaps": "1", "dropped_overlapping": "1"}


@given(st.integers(0, 10_000))
@settings(max_examples=30, deadline=None)
def test_no_two_vehicles_overlap_in_the_first_frame(seed: int) -> None:
    random = np.random.default_rng(seed)
    motions = [parked(*random.uniform(0, 25, 2), random.uniform(-3, 3)) for _ in range(12)]
    vehicles = select(recording(motions), SETTINGS).vehicles
    overlap = boxes_overlap(
        vehicles.position[:, None], vehicles.heading[:, None], vehicles.size[:, None, :2],
        vehicles.position[None], vehicles.heading[None], vehicles.size[None, :, :2],
    )  # fmt: skip
    assert np.array_equal(overlap, np.eye(len(vehicles), dtype=bool))


def test_the_origin_moves_near_the_target_and_city_coordinates_stay() -> None:
    log = recording(row(), focal=2)
    scenario = select(log, SETTINGS)
    assert scenario.log is not None
    np.testing.assert_allclose(scenario.vehicles.position[0], 0, atol=0.5)
    before = log.motion.position[2].astype(np.float64) + log.map.origin
    np.testing.assert_allclose(scenario.log.position[0] + scenario.map.origin, before, atol=1e-3)
    np.testing.assert_allclose(
        scenario.map.centreline.points + scenario.map.origin, log.map.centreline.points + log.map.origin, atol=1e-3
    )


def test_everything_is_cut_to_the_same_steps() -> None:
    roads = crossing()
    moving = [drive(joined(roads, 0, 8, 4), start, 8, 60) for start in (0, 20)]
    signals = Signals(np.int32([8]), (np.arange(60, dtype=np.uint8) % 4)[None])
    log = recording(moving, map=roads, signals=signals, kind=kinds((1, VehicleKind.CYCLIST), count=2))
    scenario = select(log, replace(SETTINGS, first_step=5, horizon=20))
    assert scenario.log is not None
    assert (scenario.horizon, scenario.log.steps, scenario.context.motion.steps) == (20, 21, 21)
    np.testing.assert_array_equal(scenario.signals.state, signals.state[:, 5:26])
    np.testing.assert_array_equal(scenario.context.track_id, ["track-1"])


def test_the_map_is_cut_around_the_target_and_signals_follow_their_lanes() -> None:
    roads = crossing(arm=200.0)
    moving = [drive(joined(roads, 0, 8, 4), start, 1, 30) for start in (10, 40)]
    lanes = np.arange(8, 20, dtype=np.int32)
    signals = Signals(lanes, np.ones((12, 30), np.uint8))
    near = select(recording(moving, map=roads, signals=signals), replace(SETTINGS, map_radius=50.0))
    assert near.map.lane_id.tolist() == [100, 106]  # the way in, and beside it the way out
    assert near.map.dangling == 6
    assert len(near.signals) == 0
    wide = select(recording(moving, map=roads, signals=signals), replace(SETTINGS, map_radius=160.0))
    assert 1 < len(wide.map) < len(roads)
    np.testing.assert_array_equal(wide.map.lane_id[wide.signals.lane], [n for n in range(108, 120) if n in wide.map.lane_id])


def test_a_map_that_is_elsewhere_is_refused() -> None:
    log = recording([parked(2000, 0), parked(2020, 0)])
    with pytest.raises(UnusableInput) as caught:
        select(log, replace(SETTINGS, map_radius=50.0))
    assert caught.value.reason == "no-lanes"


def test_people_in_the_way_of_the_first_frame_are_noted_and_left() -> None:
    log = recording([*row(2), parked(100, 0.5)], kind=kinds((2, VehicleKind.PEDESTRIAN), count=3))
    scenario = select(log, SETTINGS)
    assert scenario.notes == {"context_overlaps": "1"}
    assert len(scenario.context) == 1


def test_what_was_not_recorded_is_zero_in_every_array() -> None:
    motions = row(3)
    motions[1].valid[7:] = False
    motions[1].position[7:] = np.nan
    scenario = select(recording(motions), SETTINGS)
    assert scenario.log is not None
    assert (scenario.log.position[1, 7:] == 0).all()


def test_an_unknown_target_is_refused() -> None:
    with pytest.raises(UnusableInput, match="focal"):
        select(recording(row()), replace(SETTINGS, target="nearest"))


@pytest.mark.parametrize("name", ["", "/tmp/outside", "../outside", ".hidden", "a b", "x" * 201])
def test_an_id_that_cannot_name_a_file_is_refused(name: str) -> None:
    with pytest.raises(UnusableInput, match="cannot be a scenario's id") as refusal:
        select(recording(row(), scenario_id=name), SETTINGS)
    assert refusal.value.reason == "bad-id"


def test_everybody_of_a_recording_is_shown_wherever_and_whenever_they_are() -> None:
    motions = [*row(4), parked(100.5, 0)]
    motions[2].valid[:20], motions[3].valid[:] = False, False  # comes later, is never there
    motions[1].position[15:] += 500  # jumps
    log = recording(motions, kind=kinds((4, VehicleKind.TRUCK), count=5))
    assert len(select(log, SETTINGS).vehicles) == 2
    scenario = everybody(log, 0)
    assert scenario.vehicles.track_id.tolist() == [f"track-{i}" for i in (0, 1, 2, 4)]
    assert scenario.notes == {}
    assert scenario.log is not None
    np.testing.assert_array_equal(scenario.log.valid.sum(-1), [STEPS, STEPS, STEPS - 20, STEPS])
    np.testing.assert_array_equal(scenario.vehicles.size[3], np.float32(ASSUMED_SIZE[VehicleKind.TRUCK]))


def test_the_target_of_everybody_is_the_focal_track_or_stands_in_for_it() -> None:
    motions = row(3)
    motions[2].valid[:20] = False
    scenario = everybody(recording(motions, focal=2), 0)
    assert scenario.vehicles.track_id.tolist() == ["track-2", "track-0", "track-1"]
    assert scenario.log is not None
    assert np.abs(scenario.log.position[0, 20]).max() < 1  # the frame begins where it does
    for ego, target in {1: "track-1", NO_TRACK: "track-0"}.items():
        log = recording(motions, focal=2, ego=ego, kind=kinds((2, VehicleKind.PEDESTRIAN), count=3))
        assert everybody(log, 0).vehicles.track_id.tolist()[0] == target
        assert everybody(log, 0).notes == {"target": f"{target}, because no vehicle is the focal track"}
    with pytest.raises(UnusableInput, match="recording has no vehicles"):
        everybody(recording(row(1), kind=kinds((0, VehicleKind.CYCLIST), count=1)), 0)
