"""Whatever the types of a specification let pass is built, on either side of the road."""

import math
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from drivegen.layouts.compile import compile_map
from drivegen.layouts.spec import MapSpec
from drivegen.maps.build import build_spec
from drivegen.maps.structure import Structure

FEW = settings(max_examples=10, deadline=None)
LENGTH = st.floats(20, 10000)
SPEED = st.floats(1, 45)
ARC = st.tuples(st.floats(-280, 280), st.floats(12, 3000))
SIDES = st.sampled_from([["left"], ["right"], ["left", "right"]])
FORK = {"kind": st.just("fork"), "lanes": st.just(2), "length": LENGTH, "stem": st.none() | LENGTH, "joins": st.booleans()}
ARM = st.fixed_dictionaries({"lanes_in": st.integers(1, 3), "speed": SPEED})
MEDIAN = st.just(0.0) | st.floats(0, 30)
TURN_LANES = {"left_turn_lanes": st.booleans(), "right_turn_lanes": st.booleans(), "pocket": st.floats(15, 500)}
SIDE = {"sides": SIDES, "side_lanes": st.integers(1, 3), "side_speed": SPEED, "dead_end": st.booleans()}
CROSSING = st.fixed_dictionaries({**SIDE, **TURN_LANES, "form": st.just("crossing")})
RING = st.fixed_dictionaries({**SIDE, "form": st.just("roundabout"), "diameter": st.floats(14, 60)})


def build_and_look(road: dict[str, Any], left_hand: bool) -> Structure:
    """It becomes a sound road map, the same bytes again; what the network has."""
    spec = MapSpec.model_validate({"road": road, "left_hand": left_hand})
    made = build_spec(spec, {})
    made.road_map.validate()
    assert made.network == compile_map(MapSpec.model_validate(spec.model_dump(mode="json")))
    assert not made.structure.stuck
    assert made.structure.left_hand == left_hand
    return made.structure


@given(st.fixed_dictionaries({**FORK, "angle": st.floats(10, 120), "speed": SPEED}), st.booleans())
@FEW
def test_any_fork_is_built(road: dict[str, Any], left_hand: bool) -> None:
    network = build_and_look(road, left_hand)
    assert (network.merges, network.diverges) == ((1, 0) if road["joins"] else (0, 1))


@given(st.lists(ARM, min_size=3, max_size=8), st.floats(14, 60), st.integers(1, 4), st.booleans())
@FEW
def test_any_ring_is_built_or_is_told_its_least_size(arms: list[Any], diameter: float, lanes: int, left_hand: bool) -> None:
    around = [{**arm, "angle": 360 / len(arms) * i} for i, arm in enumerate(arms)]
    road = {"kind": "roundabout", "arms": around, "diameter": diameter, "ring_lanes": lanes}
    arc = 7.8 if lanes == 1 else 9.0
    if diameter < max(24 * (lanes > 1), arc * len(arms) / math.pi + 4 * lanes):
        with pytest.raises(ValidationError, match=r"at least [0-9]+ m across"):
            MapSpec.model_validate({"road": road})
    else:
        assert build_and_look(road, left_hand).roundabouts == (len(arms),)


@given(
    st.lists(CROSSING | RING, min_size=1, max_size=4),
    st.floats(85, 400),
    st.integers(1, 3),
    st.integers(0, 3),
    MEDIAN,
    SPEED,
    st.booleans(),
)
@FEW
def test_any_corridor_with_turn_lanes_is_built(
    junctions: list[Any], apart: float, lanes: int, lanes_back: int, median: float, speed: float, left_hand: bool
) -> None:
    row = [{**junction, "position": apart * (i + 1)} for i, junction in enumerate(junctions)]
    if not lanes_back:
        row = [{**junction, "form": "crossing"} for junction in row]
    road = {"kind": "corridor", "alignment": {"length": apart * (len(row) + 1)}, "junctions": row, "speed": speed}
    road["median"] = median if lanes_back else 0.0
    network = build_and_look({**road, "lanes": lanes, "lanes_back": lanes_back}, left_hand)
    assert sorted([*network.arms, *network.roundabouts]) == sorted(2 + len(junction["sides"]) for junction in row)


@given(st.lists(ARC, min_size=1, max_size=4), LENGTH, st.sampled_from(["curve", "s_curve", "hairpin"]), st.booleans())
@example([(0.0, 50.0)], 600.0, "curve", False)
@FEW
def test_any_arcs_are_built(arcs: list[tuple[float, float]], length: float, shape: str, left_hand: bool) -> None:
    line = {"shape": shape, "length": length, "arcs": arcs}
    for kind in ("corridor", "highway"):
        network = build_and_look({"kind": kind, "alignment": line}, left_hand)
        assert network.turn == pytest.approx(sum(abs(angle) for angle, _ in arcs), abs=5)


@pytest.mark.parametrize("kind", ["corridor", "highway"])
@pytest.mark.parametrize(
    ("line", "failed"),
    [
        ({"angle": 180, "radius": 200, "length": 300}, ["length: asked 300.0"]),
        ({"shape": "s_curve", "arcs": [(90, 150), (-90, 150)], "length": 200}, ["length: asked 200.0"]),
        ({"angle": 90, "radius": 60, "length": 300}, []),
        ({"angle": 90, "radius": 60, "length": 150}, []),  # 4 m too short
        ({"angle": 180, "radius": 300}, []),  # nobody has asked for a length
    ],
)
def test_a_bent_road_that_cannot_be_as_short_as_asked_says_so(kind: str, line: dict[str, Any], failed: list[str]) -> None:
    road = {"kind": kind, "alignment": {"shape": "curve", **line}}
    first = build_spec(MapSpec.model_validate({"road": road}), {})
    built = build_spec(MapSpec.model_validate(first.account["spec"]), {})  # as an edit finds it, with all fields
    assert built.account["failed"] == first.account["failed"]
    assert [sentence[: len(begun)] for sentence, begun in zip(built.account["failed"], failed, strict=True)] == failed
