"""Vehicles that beset the target stand beside, before and across its way where the map has such places, else anywhere."""

import numpy as np

from drivegen.core.geometry import to_vehicle_frame, wrap_angle
from drivegen.core.relation import Relation
from drivegen.core.scenario import TARGET
from drivegen.placement.beset import AROUND, besetting
from drivegen.placement.place import Placer
from drivegen.placement.slots import Slots
from drivegen.placement.where import Wish, standing
from tests.placement.test_placement_place import SETTINGS, table
from tests.scenes import straight_road


def placed(lanes: int, wishes: list[Wish], seed: int = 7):
    slots = Slots(straight_road(500, lanes))
    placer = Placer(slots, table(), SETTINGS)
    return slots, placer.place([0] * len(wishes), np.random.default_rng(seed), wishes=wishes)


def test_every_place_is_wished_for_in_turn_and_the_target_wishes_nothing():
    wishes = besetting(len(AROUND) + 3)
    assert wishes[0] == Wish()
    assert [wish.relation for wish in wishes[1:]] == [*AROUND, *AROUND[:2]]
    assert set(AROUND) == set(Relation)
    assert besetting(1) == [Wish()]


def test_lanes_beside_and_before_the_target_are_taken_on_a_three_lane_road():
    for seed in range(5):
        _, placement = placed(3, besetting(16), seed)
        vehicles, number = placement.vehicles, placement.number.tolist()
        x, y = to_vehicle_frame(vehicles.position, vehicles.position[TARGET], vehicles.heading[TARGET]).T
        ahead = number.index(1)
        assert abs(y[ahead]) < 1
        assert x[ahead] > 0
        beside = (np.abs(y) > 2) & (np.abs(y) < 5.5) & (np.abs(x) < 12)
        assert beside.sum() >= 1
        assert (np.abs(wrap_angle(vehicles.heading - vehicles.heading[TARGET])) < 0.1).all()


def test_who_finds_no_such_place_stands_anywhere_unless_it_insists():
    slots, placement = placed(1, besetting(4))  # nobody can stand beside the target on one lane
    assert placement.rejected == {}
    assert not standing(slots, int(np.flatnonzero(slots.lane == placement.lane[0])[0]), Relation.LEFT, None).any()
    insists = [Wish(), Wish(relation=Relation.LEFT)]
    assert placed(1, insists)[1].rejected == {"does-not-fit": 1}
