"""What a description says of whom: subjects and what is said, each with its tokens."""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from drivegen.asked.request import Kind
from drivegen.assets.where import Relation

ACROSS = "turns across the target's way"
"""To which side is left open: the left, for who comes the other way."""

BOTH = "both"
"""On the left and on the right."""

FROM_SIDE = {"left": Relation.FROM_LEFT, "right": Relation.FROM_RIGHT}


class What(StrEnum):
    """What is said of a subject."""

    MANOEUVRE = "manoeuvre"
    ALONG = "along the road"
    SIDE = "side"
    FROM = "comes from"
    ABREAST = "beside the target"
    HERE = "in the target's lane"
    DISTANCE = "distance"
    SPEED = "speed"
    WITHIN = "within"
    QUEUE = "queue"


@dataclass(frozen=True)
class Said:
    """One thing said: tokens [begin, end); `forward` if of the subject that follows."""

    what: What
    value: Any
    begin: int
    end: int
    forward: bool = False


class Role(StrEnum):
    """Who a subject is; NOBODY: something that cannot be placed, which keeps what is said of it from others."""

    GROUP = "group"
    TARGET = "target"
    ALL = "all"
    NOBODY = "nobody"


@dataclass
class Subject:
    """Who things are said of: tokens [begin, end), of which `own` are understood.

    `member`: 0, or how many of the group before it are meant; -1: all that are left of it. `bare`: only a number says so.
    `listed`: all members of that group are. `named`: how many there were before members were told apart. `known`: with a
    definite article. `vague`: a plural without a number. `object`: perhaps what another one overtakes
    or stands behind.
    """

    role: Role
    begin: int
    end: int
    kind: Kind = Kind.VEHICLE
    count: int = 1
    member: int = 0
    bare: bool = False
    named: int = 0
    known: bool = False
    listed: bool = False
    vague: bool = False
    object: bool = False
    own: tuple[int, ...] = ()
    heard: list[Said] = field(default_factory=list)

    def value(self, what: What) -> Any:
        """What was said of it; None if nothing."""
        return next((said.value for said in self.heard if said.what is what), None)

    def accepts(self, said: Said) -> bool:
        """Take what is said; False where it cannot be, or contradicts what was said before."""
        if self.role is Role.NOBODY or (self.role is Role.ALL and said.what is not What.SPEED):
            return False
        if self.role is Role.TARGET and said.what not in (What.MANOEUVRE, What.SPEED, What.WITHIN):
            return False
        before = self.value(said.what)
        if before is not None and before != said.value:
            return False
        from_aside = self.value(What.FROM) is not None
        if from_aside and said.what in (What.ALONG, What.SIDE, What.ABREAST):
            return False
        self.heard.append(said)
        return True

    def forget(self, what: What) -> None:
        """What was said so is not understood after all."""
        self.heard = [said for said in self.heard if said.what is not what]
