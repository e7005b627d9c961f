"""Traffic that besets its target: the lanes beside it, before it, behind it and across its way are taken first.

Logged first frames offer an attacker little: where nobody is near, nobody can get in the way. What is placed so is no sample of
anybody's traffic, so rates can't be told of it.
"""

from itertools import cycle, islice

from drivegen.core.relation import Relation
from drivegen.placement.where import Wish

AROUND = (
    Relation.AHEAD,
    Relation.LEFT,
    Relation.RIGHT,
    Relation.ONCOMING,
    Relation.FROM_LEFT,
    Relation.FROM_RIGHT,
    Relation.LEFT_AHEAD,
    Relation.RIGHT_AHEAD,
    Relation.LEFT_BEHIND,
    Relation.RIGHT_BEHIND,
    Relation.BEHIND,
)
"""The places in the order in which they are taken, again and again while there are vehicles."""


def besetting(vehicles: int) -> list[Wish]:
    """Wishes of so many vehicles, the target first, which has none; who finds no such place stands anywhere near."""
    return [Wish(), *(Wish(relation=place, anywhere=True) for place in islice(cycle(AROUND), vehicles - 1))]
