"""Gaps of logged traffic, and placement that draws from them."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.core.errors import UnusableInput
from drivegen.core.signals import Signals, SignalState
from drivegen.placement._spots import QUEUE_GAP
from drivegen.placement.draws import Draws
from drivegen.placement.gaps import Following, Gaps, headways, measure_gaps
from drivegen.placement.place import Placer, PlaceSettings
from drivegen.placement.slots import SPACING, Slots
from drivegen.placement.table import Provenance, build_table
from drivegen.placement.where import Relation, Wish, standing
from tests.scenes import busy_crossing, crossing, drive, scenario, stack, straight_road

LANE = np.array([[0.0, 0.0], [800.0, 0.0]])
SLOTS = Slots(straight_road(800, 3))


def queue(gap: float, speed: float, source: str = "SUMO corpus (simulated)"):
    """Five cars of 4.6 m on the right lane, bumper to bumper `gap` apart."""
    scene = scenario(straight_road(800, 2), stack([drive(LANE, 300 - i * (gap + 4.6), speed, 3) for i in range(5)]))
    return type(scene)(**{**vars(scene), "source": source})


def settings(mode: str) -> PlaceSettings:
    return PlaceSettings(mode, 120.0, 120.0, 0.15, 0.8, 2.0, 24)


def test_gaps_are_measured_bumper_to_bumper_with_where_they_are_from():
    gaps = measure_gaps([queue(15.0, 10.0), queue(30.0, 12.0, "measured somewhere")])
    assert len(gaps) == 10
    assert gaps.led.sum() == 8
    assert np.allclose(np.sort(gaps.gap[gaps.led]), [15] * 4 + [30] * 4, atol=0.05)
    assert np.isnan(gaps.leader_speed[~gaps.led]).all()
    assert set(gaps.provenance[:5]) == {Provenance.SIMULATED}
    assert set(gaps.provenance[5:]) == {Provenance.MEASURED}
    assert set(gaps.scenario_id) == {"scene-0"}
    again = Gaps.from_arrow(gaps.to_arrow(), "there")
    assert all(np.array_equal(getattr(gaps, n), getattr(again, n), equal_nan=n == "leader_speed") for n in vars(gaps))


def test_a_table_without_followers_or_with_other_columns_is_refused():
    gaps = measure_gaps([queue(15.0, 10.0)])
    older = gaps.to_arrow().drop_columns(["to_junction", "closed", "away", "offset"])
    for wrong in (gaps.to_arrow().drop_columns(["gap"]), gaps[~gaps.led].to_arrow(), older):
        with pytest.raises(UnusableInput, match=r"there.*run the assets stage"):
            Gaps.from_arrow(wrong, "there")


def test_rows_say_where_a_vehicle_stands():
    """On the way into a crossing, 20 m before it, 0.5 m to the left of the middle of its lane; a light is red or is not."""
    road = crossing()
    line = road.centreline[0].astype(np.float64)
    course = (line[-1] - line[0]) / np.linalg.norm(line[-1] - line[0])
    left = np.array([-course[1], course[0]])
    scene = scenario(road, stack([drive(line, 0.0, 5.0, 3), drive(line, 30.0, 5.0, 3)]))
    place = np.stack([line[-1] - 20 * course + 0.5 * left, line[-1] - 50 * course]).astype(np.float32)
    vehicles = replace(scene.vehicles, position=place, heading=np.full(2, np.arctan2(*course[::-1]), np.float32))
    entered = np.unique(road.links[road.links[:, 0] == 0, 1]).astype(np.int32)
    for state, closed in ((SignalState.RED, True), (SignalState.GREEN, False)):
        signals = Signals(entered, np.full((len(entered), 4), state, np.uint8))
        rows = measure_gaps([replace(scene, vehicles=vehicles, signals=signals)])
        assert rows.to_junction == pytest.approx([20, 50], abs=0.1)
        assert rows.away == pytest.approx([0, np.hypot(30, 0.5)], abs=0.1)
        assert rows.offset == pytest.approx([0.5, 0], abs=0.02)
        assert rows.closed.tolist() == [closed, closed]
    assert np.isinf(measure_gaps([queue(10.0, 5.0)]).to_junction).all()


def test_placement_from_data_has_the_gaps_of_the_data_where_the_papers_has_not():
    queues = [queue(float(gap), 10.0) for gap in range(12, 20)]
    truth, draws = Following.of(queues), Draws(measure_gaps(queues))
    table = build_table([busy_crossing()])
    found = {}
    for mode in ("paper", "data"):
        placer = Placer(SLOTS, table, settings(mode), draws)
        placed = [placer.place([0] * 12, np.random.default_rng(seed)) for seed in range(12)]
        assert all(len(p.vehicles) + sum(p.rejected.values()) == 12 for p in placed)
        scenes = [scenario(SLOTS.map, stack([drive(LANE, 10, 5, 2)] * len(p.vehicles))) for p in placed]
        scenes = [type(s)(**{**vars(s), "vehicles": p.vehicles, "log": None}) for s, p in zip(scenes, placed, strict=True)]
        rows = measure_gaps(scenes)
        assert set(rows.provenance) == {Provenance.GENERATED}
        found[mode] = headways(Following.of(scenes), truth)["distance"]
    assert found["data"] < 0.6 * found["paper"]


def test_mode_data_needs_gaps_and_there_are_two_modes():
    with pytest.raises(UnusableInput, match="gaps"):
        Placer(SLOTS, build_table([busy_crossing()]), settings("data"))
    with pytest.raises(UnusableInput, match="paper, data"):
        settings("guess")


def test_wished_places_are_where_they_are_said_to_be():
    slots = SLOTS
    middle = int(np.flatnonzero((slots.lane == 1) & (np.abs(slots.along - 401) < 1))[0])
    for relation, lane, low, high in (
        (Relation.AHEAD, 1, 4, 80),
        (Relation.BEHIND, 1, -80, -4),
        (Relation.LEFT, 2, -12, 12),
        (Relation.RIGHT_AHEAD, 0, 4, 40),
        (Relation.LEFT_BEHIND, 2, -40, -4),
    ):
        found = np.flatnonzero(standing(slots, middle, relation, None))
        along = slots.along[found] - slots.along[middle]
        assert set(slots.lane[found].tolist()) == {lane}
        assert low <= along.min() < along.max() <= high
    assert np.allclose(slots.along[standing(slots, middle, Relation.AHEAD, 30.0)] - slots.along[middle], 30, atol=6.1)
    assert not standing(slots, middle, Relation.ONCOMING, None).any()


def test_a_queue_stands_in_one_lane_and_speeds_are_as_wished():
    wishes = [Wish(speed=8.0), Wish(Relation.AHEAD, speed=4.0), *(Wish(beside=i, ahead=True) for i in (1, 2))]
    placer = Placer(SLOTS, build_table([busy_crossing()]), settings("paper"))
    placed = placer.place([0] * 4, np.random.default_rng(5), wishes=wishes)
    assert placed.number.tolist() == [0, 1, 2, 3]
    assert len(set(placed.lane.tolist())) == 1
    x = placed.vehicles.position[:, 0]
    assert (np.diff(x) > 4.6).all()
    assert np.allclose(placed.vehicles.speed, [8, 4, 4, 4])


def test_gaps_of_a_queue_are_from_bumper_to_bumper_whatever_the_lengths():
    table = build_table([busy_crossing()])
    bus = replace(table, size=np.concatenate([table.size[:1], table.size[:1] * np.float32([2.6, 1.0, 1.0]), table.size[2:]]))
    wishes = [Wish(speed=0.0), *(Wish(beside=i, ahead=True, speed=0.0) for i in range(2))]
    for seed in range(20):
        placed = Placer(SLOTS, bus, settings("paper")).place([0, 1, 0], np.random.default_rng(seed), wishes=wishes)
        x, length = placed.vehicles.position[:, 0], placed.vehicles.size[:, 0]
        gaps = np.diff(x) - (length[1:] + length[:-1]) / 2
        assert (gaps > QUEUE_GAP[0] - 0.1).all()
        assert (gaps < QUEUE_GAP[1] + 2 * SPACING + 0.1).all()
