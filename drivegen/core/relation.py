"""Where a vehicle stands, as words and placement speak of it."""

from enum import StrEnum


class Relation(StrEnum):
    """Where a vehicle stands, as seen from the target.

    AHEAD, BEHIND: in the target's own lane, or in one that it leads to. LEFT, RIGHT: in the lane beside it, same direction;
    with AHEAD or BEHIND in the name before or after it there. ONCOMING: in front, driving towards it. FROM_LEFT, FROM_RIGHT:
    on a road that comes from that side, in front.
    """

    AHEAD = "ahead"
    BEHIND = "behind"
    LEFT = "left"
    RIGHT = "right"
    LEFT_AHEAD = "left_ahead"
    LEFT_BEHIND = "left_behind"
    RIGHT_AHEAD = "right_ahead"
    RIGHT_BEHIND = "right_behind"
    ONCOMING = "oncoming"
    FROM_LEFT = "from_left"
    FROM_RIGHT = "from_right"
