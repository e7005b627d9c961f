"""A network that is not what its specification asks for is told, whatever of it is wrong."""

from typing import Any

import pytest

from drivegen.layouts.compilers import crossings
from drivegen.layouts.spec import MapSpec
from drivegen.maps.checks import check, failures
from drivegen.maps.examine import examine

MAIN_AND_SIDE = [{"angle": 0}, {"angle": 180}, {"angle": 90, "main": False}, {"angle": 270, "main": False}]
ROADS: tuple[dict[str, Any], ...] = (
    {"kind": "crossing", "arms": MAIN_AND_SIDE},
    {"kind": "grid", "rows": 1, "columns": 2},
    {"kind": "interchange"},
    {"kind": "quadrant_interchange", "loops": ["northeast"], "directs": ["southwest"]},
)
STREET = {"kind": "corridor", "lanes": 3, "lanes_back": 2, "speed": 22.0, "median": 8.0}
JUNCTIONS = [{"position": 200, "control": "stop"}, {"position": 400}]


def spec(road: dict[str, Any], left_hand: bool = False) -> MapSpec:
    return MapSpec.model_validate({"road": road, "left_hand": left_hand})


@pytest.mark.parametrize("left_hand", [False, True])
@pytest.mark.parametrize("control", sorted(crossings.NODE_TYPES))
@pytest.mark.parametrize("road", ROADS[:3], ids=lambda road: road["kind"])
def test_who_goes_first_is_as_asked_and_another_rule_is_told(road: dict[str, Any], control: str, left_hand: bool) -> None:
    asked = spec({**road, "control": control}, left_hand)
    structure = examine(asked).structure
    assert not failures(check(asked, structure))
    for other in set(crossings.NODE_TYPES) - {control}:
        assert any(
            line.startswith("controls") for line in failures(check(spec({**road, "control": other}, left_hand), structure))
        )


@pytest.mark.parametrize("left_hand", [False, True])
@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"lanes": 1, "lanes_back": 1}, "max lanes"),
        ({"speed": 5.0}, "speed"),
        ({"median": 0.0}, "median"),
        ({"median": 4.0}, "median"),
        ({"junctions": [{"position": 200}, {"position": 400}]}, "controls"),
    ],
)
def test_a_street_with_crossings_that_is_not_as_asked_is_told(change: dict[str, Any], told: str, left_hand: bool) -> None:
    asked = spec({**STREET, "junctions": JUNCTIONS}, left_hand)
    assert not failures(examine(asked).checks)
    got = examine(spec({**STREET, "junctions": JUNCTIONS, **change}, left_hand)).structure
    assert [line.partition(":")[0] for line in failures(check(asked, got))] == [told]


def test_a_median_of_a_crossings_roads_is_looked_at() -> None:
    asked = spec(
        {"kind": "crossing", "arms": [{"angle": angle, "median": 4.0 * (angle % 180 == 0)} for angle in (0, 90, 180, 270)]}
    )
    assert not failures(examine(asked).checks)
    got = examine(spec({"kind": "crossing", "arms": [{"angle": angle} for angle in (0, 90, 180, 270)]})).structure
    assert [line.partition(":")[0] for line in failures(check(asked, got))] == ["median"]


@pytest.mark.parametrize("median", [0.1, 0.6, 1.0, 30.0])
@pytest.mark.parametrize("line", [{}, {"shape": "s_curve", "angle": 60}])
def test_any_median_that_is_drawn_is_as_asked(median: float, line: dict[str, Any]) -> None:
    road = {"kind": "corridor", "alignment": line, "median": median, "junctions": [{"position": 300}]}
    assert not failures(examine(spec(road)).checks)
