"""Junctions along roads that bend, and junctions of a row that differ: where they lie, what each of them has."""

import pytest

from drivegen.errors import UnusableInput
from drivegen.maps.build import build_spec
from drivegen.maps.compile import draw
from drivegen.maps.spec import MapSpec
from drivegen.maps.spec_alignment import Alignment
from drivegen.maps.spec_streets import Corridor, Junction
from drivegen.maps.writers.offline import Plugin


def corridor_of(text: str) -> Corridor:
    spec = Plugin().write(text, 7).spec
    assert isinstance(spec, MapSpec)
    built = build_spec(spec, {})
    assert built.as_asked, built.account["failed"]
    assert isinstance(spec.road, Corridor)
    return spec.road


@pytest.mark.parametrize(
    ("text", "metres"),
    [
        ("a T-junction 80 m before a bend of 90 degrees", -80.0),
        ("a road bending 90 degrees to the left with a radius of 80 m, with a T-junction 120 m before the bend", -120.0),
        ("signalised crossing, 150 m later the road bends to the right by 60 degrees", -150.0),
        ("roundabout, then 200 m later a 45 degree bend to the right", -200.0),
        ("a sharp right-hand bend; 100 m after the bend a minor road joins from the left, stop sign", 100.0),
        ("a bend of 45 degrees and, 200 m further on, a signalised four-way intersection", 200.0),
    ],
)
def test_a_junction_lies_as_far_from_a_bend_as_is_said(text: str, metres: float) -> None:
    road = corridor_of(text)
    (junction,), ((begin, end),) = road.junctions, road.alignment.spans
    assert junction.position - (end if metres > 0 else begin) == pytest.approx(metres)


@pytest.mark.parametrize(
    ("text", "side"),
    [
        ("a crossing on a curve", "left right"),
        ("a road with a left-hand bend and a side road joining on the outside of the bend", "right"),
        ("a bend to the right, with a side road on the inside of the bend", "right"),
        ("a curved road with a side street on the left in the middle of the bend", "left"),
        ("an S-bend with a side road halfway through it", "right"),
    ],
)
def test_a_junction_in_a_bend_lies_in_its_middle_on_the_side_that_is_said(text: str, side: str) -> None:
    road = corridor_of(text)
    (junction,) = road.junctions
    assert junction.position == pytest.approx((road.alignment.spans[0][0] + road.alignment.spans[-1][1]) / 2)
    assert " ".join(junction.sides) == side


def test_a_side_road_that_would_run_into_its_own_road_is_refused() -> None:
    hairpin = Alignment(shape="hairpin", angle=180.0, radius=20.0, length=500.0)
    inner, outer = (
        Corridor(alignment=hairpin, junctions=(Junction(position=100.0, sides=(side,)),)) for side in ("left", "right")
    )
    with pytest.raises(UnusableInput, match="into the road again"):
        draw(MapSpec(road=inner))
    assert build_spec(MapSpec(road=outer), {}).as_asked


def test_roads_on_one_side_of_a_junction_are_spread_over_it() -> None:
    assert Junction(position=100.0, sides=("left", "right", "left")).directions == (60.0, 270.0, 120.0)


@pytest.mark.parametrize(
    ("text", "arms", "controls", "turning"),
    [
        ("three crossings 200 m apart, left-turn lanes at the first one only", [4, 4, 4], ["yield"] * 3, [1, 0, 0]),
        ("four signalised crossings in a row with turn lanes at the first and third", [4] * 4, ["signals"] * 4, [1, 0, 1, 0]),
        ("two roundabouts 300 m apart, the first with five arms, the second with three", [5, 3], ["yield"] * 2, [0, 0]),
        (
            "a row of three T-junctions, the second with traffic lights, the other two with stop signs",
            [3, 3, 3],
            ["stop", "signals", "stop"],
            [0, 0, 0],
        ),
        (
            "two crossroads 250 m apart; the first is signalised and has turn lanes, the second is priority controlled",
            [4, 4],
            ["signals", "yield"],
            [1, 0],
        ),
    ],
)
def test_junctions_of_a_row_have_each_what_is_said_of_it(
    text: str, arms: list[int], controls: list[str], turning: list[int]
) -> None:
    junctions = corridor_of(text).junctions
    assert [2 + len(j.sides) for j in junctions] == arms
    assert [j.control for j in junctions] == controls
    assert [int(j.left_turn_lane) for j in junctions] == turning
