"""What whoever reads a description of traffic gives back: the request, and an account of what was understood."""

from dataclasses import dataclass

from drivegen.asked.request import TrafficRequest


@dataclass(frozen=True)
class Reading:
    """A description, read.

    Attributes:
        request: what was asked for. understood: phrases and what each was taken to mean.
        rest: the description without those phrases, for whoever reads the road; every word that is ignored stands in it.
        reader: who read it, as it stands in tables.
    """

    request: TrafficRequest
    understood: tuple[tuple[str, str], ...]
    rest: str
    reader: str
