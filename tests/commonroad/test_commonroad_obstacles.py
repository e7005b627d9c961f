"""Obstacles become tracks: boxes about their middle, 10 Hz, velocities in the map's frame."""

import numpy as np
import pytest

from drivegen.commonroad import obstacles
from drivegen.commonroad.recording import read_recording
from drivegen.core import recorded_log
from drivegen.core.errors import UnusableInput
from drivegen.core.recorded_log import RecordedLog
from drivegen.core.scenario import VehicleKind
from tests.commonroad_files import BOX, ROAD, car, obstacle, points, state, xml


def read(*parts: str, version: str = "2018b", step: str = "0.1") -> RecordedLog:
    return read_recording(xml([*ROAD, *parts], version, step), "file.xml", "CommonRoad")


def place(log: RecordedLog, row: int, step: int) -> np.ndarray:
    return log.motion.position[row, step] + log.map.origin


def test_a_car_is_where_and_as_fast_as_the_file_says() -> None:
    turned = obstacle(7, [state(t, 30, 5 * t * 0.1, np.pi / 2) for t in range(3, 9)])
    log = read(car(1, 20, 0), turned)
    assert log.motion.steps == 60
    np.testing.assert_allclose(place(log, 0, 10), (25, 0), atol=1e-4)
    np.testing.assert_allclose(log.motion.velocity[0, 10], (5, 0), atol=1e-5)
    assert np.flatnonzero(log.motion.valid[1]).tolist() == [3, 4, 5, 6, 7, 8]
    np.testing.assert_allclose(log.motion.velocity[1, 5], (0, 5), atol=1e-5)
    np.testing.assert_allclose(log.size[0, :2], (4.5, 1.8))
    assert np.isnan(log.size[0, 2])
    assert log.city == "Tiny"


def test_intervals_and_regions_stand_for_their_middle() -> None:
    vague = (
        state(0, 0, 0)
        .replace(
            "<orientation><exact>0.0</exact>", "<orientation><intervalStart>0.1</intervalStart><intervalEnd>0.3</intervalEnd>"
        )
        .replace("<exact>5.0</exact>", "<intervalStart>4</intervalStart><intervalEnd>8</intervalEnd>")
        .replace("<point><x>0</x><y>0</y></point>", "<circle><radius>1</radius><center><x>40</x><y>1</y></center></circle>")
    )
    log = read(car(1, 20, 0), obstacle(2, [vague]))
    np.testing.assert_allclose(place(log, 1, 0), (40, 1), atol=1e-4)
    assert log.motion.heading[1, 0] == pytest.approx(0.2)
    assert log.motion.speed[1, 0] == pytest.approx(6.0)


def test_without_velocities_the_positions_tell() -> None:
    log = read(obstacle(1, [state(t, 20 + 0.7 * t, 0, speed=None) for t in range(20)]))
    np.testing.assert_allclose(log.motion.velocity[0], np.tile([7.0, 0.0], (20, 1)), atol=1e-3)


@pytest.mark.parametrize(
    ("shape", "size", "middle"),
    [
        (BOX, (4.5, 1.8), (50, 2)),
        (BOX.replace("</width>", "</width><center><x>1.4</x><y>0</y></center>"), (4.5, 1.8), (50, 3.4)),
        (BOX.replace("</width>", f"</width><orientation>{np.pi / 2}</orientation>"), (1.8, 4.5), (50, 2)),
        ("<circle><radius>0.4</radius></circle>", (0.8, 0.8), (50, 2)),
        (
            f"<polygon>{points([(3, 1), (-1, 1), (-1, -1), (3, -1)])}</polygon>",
            (4, 2),
            (50, 3),
        ),
    ],
)
def test_the_box_is_about_the_middle_of_its_shape(shape: str, size: tuple[float, float], middle: tuple[float, float]) -> None:
    log = read(obstacle(1, [state(0, 50, 2, np.pi / 2)], shape=shape), car(2, 0, 0))
    np.testing.assert_allclose(log.size[0, :2], size, atol=1e-5)
    np.testing.assert_allclose(place(log, 0, 0), middle, atol=1e-4)


def test_a_parked_vehicle_stays_for_the_whole_recording() -> None:
    log = read(obstacle(1, [state(0, 50, 8, 0.3)], "parkedVehicle", role="static"), car(2, 0, 0))
    assert log.motion.valid[0].all()
    assert not log.motion.speed[0].any()
    np.testing.assert_allclose(place(log, 0, 59), (50, 8), atol=1e-4)


def test_at_shorter_time_steps_a_parked_vehicle_is_there_whatever_time_its_state_names() -> None:
    parked = [obstacle(i, [state(i, 50, 8 * i, 0.3)], "parkedVehicle", role="static") for i in (1, 2)]
    assert read(*parked, car(3, 0, 0), step="0.05").motion.valid[:2].all()


def test_kinds_are_told_apart_and_what_is_no_road_user_is_counted() -> None:
    others = [obstacle(i, [state(0, 5 * i, 0)], kind) for i, kind in enumerate(("truck", "bicycle", "train", "taxi"), 10)]
    unseen = '<obstacle id="20"><role>dynamic</role><type>car</type><shape/><occupancySet/></obstacle>'
    log = read(car(1, 0, 0), *others, unseen, '<obstacle id="21"><role>static</role><type>roadBoundary</type></obstacle>')
    assert log.kind.tolist() == [VehicleKind.CAR, VehicleKind.TRUCK, VehicleKind.CYCLIST, VehicleKind.CAR]
    assert log.skipped == {"train": 1, "occupancy set": 1, "roadBoundary": 1}


def test_the_elements_of_2020a_say_the_same() -> None:
    old = car(1, 20, 0), obstacle(2, [state(0, 50, 8)], "parkedVehicle", role="static")
    new = tuple(
        part.replace("<role>dynamic</role>", "").replace("<role>static</role>", "").replace("obstacle", name)
        for part, name in zip(old, ("dynamicObstacle", "staticObstacle"), strict=True)
    )
    one, two = read(*old), read(*new, '<phantomObstacle id="3"/>', version="2020a")
    np.testing.assert_array_equal(one.motion.position, two.motion.position)
    np.testing.assert_array_equal(one.track_id, two.track_id)
    assert two.skipped == {"unknown": 1}


def test_shorter_time_steps_are_thinned_out() -> None:
    log = read(car(1, 20, 0, dt=0.02), step="0.02")
    assert log.motion.steps == 12
    np.testing.assert_allclose(place(log, 0, 10), (25, 0), atol=1e-4)
    unknown = obstacle(1, [state(t, 20 + 0.14 * t, 0, speed=None) for t in range(60)])
    np.testing.assert_allclose(read(unknown, step="0.02").motion.speed, 7.0, atol=1e-3)


@pytest.mark.parametrize("step", ["0.2", "0.03", "0", "-0.1", "nan", "soon", "1e-30", "5e-324"])
def test_other_time_steps_are_refused(step: str) -> None:
    with pytest.raises(UnusableInput) as caught:
        read(car(1, 20, 0), step=step)
    assert caught.value.reason in ("time-step", "not-a-number")


@pytest.mark.parametrize(
    ("part", "reason"),
    [
        ("", "no-vehicles"),
        (obstacle(1, []), "no-states"),
        (obstacle(1, [state(0, float("nan"), 0)]), "not-a-number"),
        (obstacle(1, [state(0, 0, 0, speed=float("inf"))]), "not-a-number"),
        (obstacle(1, [state(0, 0, 0, speed=None)]), "missing-value"),
        (obstacle(1, [state(0, 0, 0).replace("orientation", "course")]), "missing-value"),
        (obstacle(1, [state(0, 0, 0).replace("position", "spot")]), "missing-value"),
        (obstacle(1, [state(0, 0, 0).replace("<point>", "<lanelet>").replace("</point>", "</lanelet>")]), "missing-value"),
        (obstacle(1, [state(0, 0, 0)], shape=""), "missing-value"),
        (obstacle(1, [state(0, 0, 0)], shape=BOX.replace("4.5", "-4.5")), "out-of-range"),
        (obstacle(1, [state(0.5, 0, 0)]), "out-of-range"),
        (obstacle(1, [state(-1, 0, 0)]), "out-of-range"),
        (obstacle(1, [state(10**9, 0, 0)]), "out-of-range"),
        (obstacle(1, [state(0, 1e9, 0)]), "out-of-range"),
        (obstacle(1, [state(0, 0, 0, speed=1e4)]), "out-of-range"),
        (obstacle(1, [state(0, 0, 0), state(0, 1, 0)]), "duplicate-rows"),
        (car(1, 0, 0) + car(1, 9, 0), "duplicate-rows"),
        (car(1, 0, 0).replace('id="1"', 'id="one"'), "bad-id"),
    ],
)
def test_what_is_no_track_is_refused_with_file_and_reason(part: str, reason: str) -> None:
    with pytest.raises(UnusableInput, match=r"^file\.xml") as caught:
        read(part)
    assert caught.value.reason == reason
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("module", "name", "reason"), [(recorded_log, "MOST_CELLS", "out-of-range"), (obstacles, "MOST_OBSTACLES", "too-large")]
)
def test_many_obstacles_or_states_are_refused_before_they_take_memory(
    monkeypatch: pytest.MonkeyPatch, module: object, name: str, reason: str
) -> None:
    monkeypatch.setattr(module, name, 1)
    with pytest.raises(UnusableInput, match=r"^file\.xml") as caught:
        read(car(1, 20, 0), obstacle(2, [state(0, 50, 8)], "parkedVehicle", role="static"))
    assert caught.value.reason == reason


WHOLE = xml([*ROAD, car(1, 0, 0)])


@pytest.mark.parametrize(
    ("raw", "reason"),
    [
        (WHOLE[:-20], "truncated"),
        (WHOLE[: len(WHOLE) // 3], "truncated"),
        (b"", "empty"),
        (WHOLE.replace(b"2018b", b"2017a"), "unknown-version"),
        (WHOLE.replace(b"commonRoad ", b"net ").replace(b"/commonRoad", b"/net"), "wrong-root"),
        (WHOLE.replace(b"<commonRoad", b'<!DOCTYPE x [<!ENTITY e SYSTEM "file:///etc/hostname">]><commonRoad', 1), "xml-dtd"),
    ],
)
def test_what_is_no_recording_is_refused(raw: bytes, reason: str) -> None:
    with pytest.raises(UnusableInput, match=r"^file\.xml") as caught:
        read_recording(raw, "file.xml", "CommonRoad")
    assert caught.value.reason == reason
