"""What every generator says of itself, read from its own file: what tables, the store and the stages know of methods.

A file in `drivegen/generators` has one `ABOUT = Method(...)` of literals. It is read without running the file
(`plugins.about`): to print a title nobody has to load torch, or to depend on what generators import.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.settings import build

FOLDER = "generators"

OURS, ABLATION, LEARNED, RULES, NO_TRAFFIC, BOUND = KINDS = ("ours", "ablation", "learned", "rules", "no traffic", "bound")
"""Kinds of methods in the order of every table.

DriveGen; DriveGen with a part taken out; traffic learned from logs; traffic by rules, whose few numbers may be fitted to logs;
what only anchors a measure; what is told some of what happened. The last two win nothing.
"""

ADDITIONS = ("exclusion", "checker", "tempo")
"""What may be done to the futures of any model: goals of a scene exclude one another; what the checker turns down is planned
again, or exchanged for another trajectory of the same vehicle; the vehicles of a future share a tempo."""

NOTHING, LOGS = SOURCES = ("nothing", "the logs")
"""What a method may be trained on."""


@dataclass(frozen=True)
class Method:
    """A generator in words.

    Attributes:
        title: its name in tables. line: what it does, in one sentence. kind: one of KINDS.
        goals: the selector whose recorded goals it follows, None where it follows none.
        trains_on: one of SOURCES. places: whether it also places vehicles on a map (`Learned.placements`).
        additions: those of ADDITIONS that are a part of it.
    """

    title: str
    line: str
    kind: str
    goals: str | None
    trains_on: str
    places: bool
    additions: tuple[str, ...]

    def __post_init__(self) -> None:
        for value, choices in ((self.kind, KINDS), (self.trains_on, SOURCES), *((one, ADDITIONS) for one in self.additions)):
            if value not in choices:
                raise UnusableInput(f"the generator {self.title!r} is {value!r}, which is none of {', '.join(choices)}")

    @property
    def ours(self) -> bool:
        """Whether it is DriveGen or a part of it."""
        return self.kind in (OURS, ABLATION)

    @property
    def competes(self) -> bool:
        """Whether it can be the best of several."""
        return self.kind not in (NO_TRAFFIC, BOUND)


def read_methods(first: Iterable[str] = ()) -> dict[str, Method]:
    """Every generator by name, in the order of KINDS; within a kind those of `first` in their order, then the others.

    Raises UnusableInput for a file that does not say what it is.
    """
    order = plugins.names(FOLDER, first)
    methods = {name: build(Method, plugins.about(FOLDER, name), f"drivegen/{FOLDER}/{name}.py: ABOUT") for name in order}
    return dict(sorted(methods.items(), key=lambda item: KINDS.index(item[1].kind)))
