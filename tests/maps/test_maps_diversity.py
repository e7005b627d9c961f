"""The ruler of diversity on maps whose lanes, arms, bends and lengths are known."""

import numpy as np
import pytest

from drivegen.core.roadmap import RoadMap
from drivegen.layouts.alignment import Alignment
from drivegen.layouts.crossings import Crossing
from drivegen.layouts.spec import MapSpec
from drivegen.layouts.streets import Corridor
from drivegen.maps.build import build_spec
from drivegen.maps.diversity import FEATURES, described, junction_arms, summary, windows


def drawn(road) -> RoadMap:
    return build_spec(MapSpec(road=road), {}).road_map


@pytest.mark.parametrize("angles", [(0, 120, 240), (0, 90, 180, 270), (0, 60, 130, 200, 280)])
def test_arms_of_a_crossing_are_counted(angles):
    road = drawn(Crossing.model_validate({"arms": [{"angle": angle, "lanes_in": 2, "lanes_out": 2} for angle in angles]}))
    assert junction_arms(road) == [len(angles)]
    assert described(road)["lanes"] == 2
    assert described(road)["arms"] == len(angles)


def test_a_straight_road_does_not_turn_and_a_curve_does():
    straight = drawn(Corridor(lanes=3, alignment=Alignment(length=500)))
    found = described(straight)
    assert found["lanes"] == 3
    assert found["arms"] == 0
    assert found["curvature"] == pytest.approx(0, abs=0.01)
    assert found["length"] == pytest.approx(2.0, rel=0.02)
    curve = described(drawn(Corridor(alignment=Alignment(shape="curve", length=500, angle=90, radius=80))))
    assert curve["curvature"] * curve["length"] * 10 == pytest.approx(180, rel=0.1)  # a quarter turn per direction


def test_windows_count_what_lies_inside_and_their_summary_holds_every_feature():
    straight = drawn(Corridor(alignment=Alignment(length=1000)))
    found = windows(straight, 5, 100.0, np.random.default_rng(7))
    assert found == windows(straight, 5, 100.0, np.random.default_rng(7))
    assert max(one["length"] for one in found) == pytest.approx(0.4, rel=0.05)
    told = summary(found)
    assert all(told[f"{name}.low"] <= told[name] <= told[f"{name}.high"] for name in FEATURES)
    assert told["windows"] == 5
