"""LCTGen told what every vehicle will do: the action fields of its code from the log. An upper bound, no method."""

from drivegen.core.methods import Method
from drivegen.generators import lctgen

ABOUT = Method(
    title="LCTGen, code from the log",
    line="LCTGen told what every vehicle will do.",
    kind="bound",
    goals=None,
    trains_on="the logs",
    places=True,
    additions=(),
)


class Plugin(lctgen.LogCode):
    """As `lctgen`, with its weights."""

    about = ABOUT
