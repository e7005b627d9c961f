"""What no ring can have is refused, rather than left out."""

from typing import Any

import pytest
from pydantic import ValidationError

from drivegen.layouts.spec import MapSpec
from drivegen.words.edits import edited


@pytest.mark.parametrize("side", ["left", "right"])
def test_turn_lanes_at_a_roundabout_are_refused(side: str) -> None:
    arms: list[dict[str, Any]] = [{"angle": angle} for angle in (0, 90, 180, 270)]
    arms[0] |= {f"{side}_turn_lanes": 1}
    with pytest.raises(ValidationError, match="roads that meet a roundabout have no turn lanes here"):
        MapSpec.model_validate({"road": {"kind": "roundabout", "arms": arms}})


@pytest.mark.parametrize(
    ("field", "why"),
    [
        ({"control": "signals"}, "who enters a roundabout gives way"),
        ({"control": "all_way_stop"}, "who enters a roundabout gives way"),
        ({"left_turn_lanes": 1}, "neither turn lanes nor banned turns"),
        ({"right_turn_lanes": 1}, "neither turn lanes nor banned turns"),
        ({"turn_bans": ["left"]}, "neither turn lanes nor banned turns"),
        ({"side_turn_bans": ["right"]}, "neither turn lanes nor banned turns"),
    ],
)
def test_what_a_ring_along_a_road_cannot_have_is_refused(field: dict[str, Any], why: str) -> None:
    with pytest.raises(ValidationError, match=why):
        MapSpec.model_validate({"road": {"kind": "corridor", "junctions": [{"position": 200, "form": "roundabout", **field}]}})
    MapSpec.model_validate({"road": {"kind": "corridor", "junctions": [{"position": 200, **field}]}})


@pytest.mark.parametrize(
    ("edit", "field", "value"),
    [
        ("left-turn lanes on the main road", "left_turn_lanes", 1),
        ("no left turns", "turn_bans", ("left",)),
        ("replace the traffic lights by stop signs", "control", "stop"),
    ],
)
def test_an_edit_of_a_road_with_crossings_and_rings_leaves_the_rings(edit: str, field: str, value: object) -> None:
    road = {"kind": "corridor", "junctions": [{"position": 200, "control": "signals"}, {"position": 400, "form": "roundabout"}]}
    after: Any = edited(MapSpec.model_validate({"road": road}), edit).road
    before: Any = MapSpec.model_validate({"road": road}).road
    assert getattr(after.junctions[0], field) == value
    assert after.junctions[1] == before.junctions[1]


def test_rings_along_a_road_that_become_crossings_and_rings_again_are_as_they_were() -> None:
    rings = [{"position": position, "form": "roundabout"} for position in (200, 400)]
    spec = MapSpec.model_validate({"road": {"kind": "corridor", "junctions": rings}})
    lit = edited(edited(edited(spec, "make it a crossing"), "traffic lights"), "left-turn lanes on the main road")
    assert edited(lit, "make it a roundabout") == spec
