"""LCTGen told what every vehicle will do: the action fields of its code from the log. An upper bound, no method."""

from drivegen.generators import lctgen


class Plugin(lctgen.LogCode):
    """As `lctgen`, with its weights."""
