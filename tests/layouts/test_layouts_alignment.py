"""The line of a road where a specification leaves something of it open."""

from typing import Any

import pytest

from drivegen.layouts.alignment import Alignment
from drivegen.layouts.spec import MapSpec
from drivegen.maps.checks import failures
from drivegen.maps.examine import examine


@pytest.mark.parametrize(
    ("fields", "turns"),
    [
        ({"shape": "hairpin"}, (180.0,)),
        ({"shape": "hairpin", "bends": 3}, (180.0, -180.0, 180.0)),
        ({"shape": "hairpin", "angle": -160.0}, (-160.0,)),
        ({"shape": "hairpin", "arcs": [[170, 30]]}, (170.0,)),
        ({"shape": "curve"}, (90.0,)),
        ({"shape": "s_curve"}, (90.0, -90.0)),
        ({}, ()),
    ],
)
def test_a_hairpin_turns_back_where_no_angle_is_given(fields: dict[str, Any], turns: tuple[float, ...]) -> None:
    line = Alignment.model_validate(fields)
    assert line.turns == turns
    assert Alignment.model_validate(line.model_dump()) == line


def test_a_hairpin_without_an_angle_is_drawn_as_one() -> None:
    found = examine(MapSpec.model_validate({"road": {"kind": "corridor", "alignment": {"shape": "hairpin"}}}))
    assert not failures(found.checks)
    assert found.structure.turn == pytest.approx(180.0, abs=5.0)
