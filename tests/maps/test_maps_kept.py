"""What is said is in the road that is built, or the description is refused by the name of what isn't."""

from xml.etree import ElementTree

import pytest

from drivegen.errors import UnusableInput
from drivegen.maps.build import build_map
from drivegen.maps.compile import compile_map
from drivegen.maps.spec import MapSpec
from drivegen.maps.structure import Structure, measure
from drivegen.maps.writers._built import built
from drivegen.maps.writers.offline import Plugin


def spec_of(text: str) -> MapSpec:
    spec = Plugin().write(text, 7).spec
    assert isinstance(spec, MapSpec)
    return spec


def structure_of(text: str) -> Structure:
    return measure(compile_map(spec_of(text)), "here")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a street with two lanes per direction, exactly three lanes per direction", ["2 lanes per direction", "3 lanes per"]),
        ("a straight street, 300 m long, limit 50 km/h, limit 80 km/h", ["50 kmh", "80 kmh"]),
        ("a motorway without any exits and with two off-ramps", ["off ramps", "exits"]),
        ("a highway that gains a lane, from four lanes to three", ["4 lanes", "gains"]),
        ("a one-way street with traffic in both directions", ["one way", "both directions"]),
    ],
)
def test_a_refusal_names_what_is_not_kept(text: str, words: list[str]) -> None:
    with pytest.raises(UnusableInput) as refused:
        Plugin().write(text, 7)
    assert all(word in str(refused.value) for word in words)
    assert str(refused.value).count("\n") == 0


def test_lengths_that_are_too_short_for_a_part_are_assumed_aloud() -> None:
    account = build_map("a motorway with an on-ramp, 150 m, 100 km/h", 7).account
    assert any("too short" in what for what in account["assumed"])


def test_turn_lanes_are_as_long_as_said() -> None:
    spec = spec_of("a signalised crossing with left-turn pockets of 35 m, arms 200 m long")
    assert {arm.pocket for arm in spec.road.arms} == {35.0}  # type: ignore[union-attr]
    edges = ElementTree.fromstring(compile_map(spec)).iter("edge")
    pockets = [float(edge[0].get("length", "0")) for edge in edges if edge.get("id", "").endswith("_pocket")]
    assert len(pockets) == 4
    assert all(20.0 < length <= 35.0 for length in pockets)  # the crossing's own surface takes the rest
    assert 35.0 in built(spec).lengths


def test_an_even_number_of_lanes_names_a_road_by_both_directions() -> None:
    assert structure_of("a six-lane boulevard, 1 km").lanes == 3
    assert structure_of("a one-way six-lane boulevard, 1 km").lanes == 6
    assert structure_of("a four-lane motorway per direction, 1 km").lanes == 4
    assert structure_of("a four-lane motorway loses a lane").max_lanes == 4


def test_a_junction_lies_where_it_is_said_along_a_road() -> None:
    road = spec_of("a main road of 1 km with a T-junction after 300 m where a side road joins").road
    lengths = sorted(arm.length for arm in road.arms if arm.main)  # type: ignore[union-attr]
    assert lengths == [300.0, 700.0]


def test_streets_of_a_grid_end_as_far_beyond_it_as_said() -> None:
    found = structure_of("a grid of 2 x 2 crossings, 150 m apart, the streets continue 80 m beyond the outer crossings")
    assert found.junctions == 4
    assert found.size == pytest.approx(150 + 160, abs=15)


def test_a_dead_end_holds_its_turning_place() -> None:
    assert structure_of("a dead end of 180 m, 30 km/h").length == pytest.approx(180, rel=0.05)


def test_measures_of_what_is_no_road_change_nothing() -> None:
    with_humps = spec_of("a straight street, 350 m, speed humps every 50 m")
    assert with_humps.road == spec_of("a straight street, 350 m, speed humps").road


def test_lengths_of_different_things_contradict_one_another_only_by_what_the_road_lacks() -> None:
    with pytest.raises(UnusableInput, match="cannot both hold"):
        Plugin().write("a curve with a radius of 40 m and a radius of 100 m", 7)
    with pytest.raises(UnusableInput, match="does not keep '90 m'"):
        Plugin().write("a row of two crossings, 150 m apart, each island 90 m in width", 7)


def test_how_far_off_something_lies_is_ignored_aloud() -> None:
    understanding = Plugin().write("a straight street of 600 m, one lane each way; the old school lies 120 m away", 7)
    assert "120 m" in understanding.ignored
    assert understanding.spec.road.alignment.length == 600.0  # type: ignore[union-attr]


def test_bends_that_differ_are_drawn_one_by_one() -> None:
    road = spec_of(
        "an arc of 90 degrees to the left with radius 50 m, then an arc of 70 degrees to the right with radius 75 m"
    ).road
    assert road.alignment.curves == ((90.0, 50.0), (-70.0, 75.0))  # type: ignore[union-attr]


def test_straights_before_and_behind_a_bend_make_the_road_longer_and_their_mean_is_told() -> None:
    account = build_map(
        "a road runs 200 m straight, turns left by 90 degrees on a radius of 50 m and runs another 300 m", 7
    ).account
    assert any("250 m before the bend" in what for what in account["assumed"])
    found = structure_of("a road runs 200 m straight, turns left by 90 degrees on a radius of 50 m and runs another 300 m")
    assert found.length == pytest.approx(500 + 50 * 3.1416 / 2, abs=3)


def test_a_fork_has_the_lengths_of_its_parts() -> None:
    road = spec_of("a one-way road of two lanes; after 500 m it splits into two branches, each 300 m long").road
    assert (road.stem, road.length) == (500.0, 300.0)  # type: ignore[union-attr]
