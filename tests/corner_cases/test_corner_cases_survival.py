"""What holds among neighbours that react, and who has to be deaf for it."""

from dataclasses import replace

import numpy as np

from drivegen.corner_cases.survival import Reacting, attentions, holds, survival
from drivegen.world.reactive import Reaction
from tests.corner_cases.handmade import LINE, SOUND, Blind, collision
from tests.scenes import drive, stack

LAW = Reaction(delay=0.75, braking=6.0, headway=0.6, min_gap=1.0, acceleration=1.5, comfort=3.0)
ACROSS = np.array([[150.0, -60.0], [150.0, 60.0]])

STANDS = collision(stack([drive(LINE, 20, 12, 101), drive(LINE, 80, 0, 101)]))
CROSSES = stack([drive(LINE, 135, 3, 101), drive(ACROSS, 0, 9.8, 101)])
"""The target is on the other's way from 3.9 s on, the other there at 5.8 s; it could stop within 8 m at 6 m/s2."""


def test_who_comes_from_the_side_holds_as_long_as_it_is_deaf_or_slow_and_who_stands_always_does():
    held = survival([collision(CROSSES), STANDS], Blind(), attentions(LAW))
    crossing = {key: bool(holding[0]) for key, holding in held.items()}
    assert all(holding[1] for holding in held.values())
    assert [crossing[name, Reacting.ALL] for name in ("attentive", "ordinary", "slow")] == [False, False, True]
    assert [crossing[name, Reacting.TO_EGO] for name in ("attentive", "ordinary", "slow")] == [False, False, True]
    assert all(crossing[name, Reacting.BUT_ATTACKER] for name in ("attentive", "ordinary", "slow"))


def test_a_sound_driver_does_not_run_into_who_stands_and_without_an_attacker_the_one_that_was_hit_is_deaf():
    assert not holds([STANDS], SOUND, Reacting.NOBODY, LAW)[0]
    assert holds([collision(CROSSES, attacker=0)], Blind(), Reacting.BUT_ATTACKER, LAW)[0]


def test_ordinary_neighbours_react_by_the_law_itself():
    slower = replace(LAW, delay=1.1)
    assert attentions(slower)["ordinary"] == slower
    assert attentions(slower)["attentive"] == attentions(LAW)["attentive"]
