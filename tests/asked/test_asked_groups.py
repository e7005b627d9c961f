"""Of vehicles that are asked for together one does something: the others stand where they are asked for all the same."""

import numpy as np
import pytest

from drivegen.asked.account import first_frame
from drivegen.asked.start import Settings, start
from drivegen.asked.wishes import cast
from drivegen.placement.where import Relation
from drivegen.words.request import Group, Kind, Manoeuvre, TrafficRequest

SETTINGS = Settings({}, placements=12, starts=2)


@pytest.mark.parametrize(
    ("place", "manoeuvre", "where"),
    [
        (Relation.LEFT, Manoeuvre.CUT_IN, "2 x car left ahead, left"),
        (Relation.BEHIND, Manoeuvre.OVERTAKE, "2 x car left behind, behind"),
    ],
)
def test_each_is_judged_by_where_it_was_to_stand_itself(initialiser, tools, place, manoeuvre, where):
    equipment, generation = tools
    request = TrafficRequest(groups=(Group(count=2, kind=Kind.CAR, place=place, manoeuvre=manoeuvre),))
    for seed in range(3):
        made = start(initialiser, "asked", request, SETTINGS, 4, equipment.selector, generation, seed)
        [place_item] = [item for item in first_frame(request, made, {}) if item.kind == "place"]
        assert (place_item.what, place_item.got) == (where, True)


@pytest.mark.parametrize("place", [None, Relation.BEHIND])
@pytest.mark.parametrize(("left_hand", "beside"), [(False, Relation.LEFT_BEHIND), (True, Relation.RIGHT_BEHIND)])
def test_only_who_overtakes_begins_in_the_lane_to_overtake_in(place, left_hand, beside):
    request = TrafficRequest(groups=(Group(count=3, place=place, manoeuvre=Manoeuvre.OVERTAKE),))
    wishes = cast(request, {}, 4, np.random.default_rng(0), left_hand=left_hand).wishes[1:]
    assert [wish.relation for wish in wishes] == [beside, place, place]
