"""Build a map and hold it against what was asked: the one way from whatever a writer wrote to a checked network."""

from dataclasses import dataclass, field
from typing import Any

from drivegen.core.roadmap import RoadMap
from drivegen.core.safe_xml import parse
from drivegen.layouts.compile import draw
from drivegen.layouts.spec import MapSpec
from drivegen.maps.checks import Check, check, check_asked, check_sound
from drivegen.maps.overlaps import overlapping
from drivegen.maps.structure import Structure, measure
from drivegen.sumo.netconvert import plain_to_net
from drivegen.sumo.network import Network
from drivegen.sumo.plain import PlainNetwork

NETWORK = "map.net.xml"
"""Name of the network's file, as it stands in errors."""

_LONGEST = 15.0
"""Seconds that netconvert has for a map that somebody wrote; one of scenario size takes 0.1 s."""


@dataclass(frozen=True)
class WrittenNetwork:
    """A network that its writer drew itself, node by node, with what it says was asked for (names of `Structure`)."""

    plain: PlainNetwork
    asked: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Examined:
    """A network that netconvert built: its bytes, the road map of it, what it is, and every check, the failed ones included."""

    network: bytes
    road_map: RoadMap
    structure: Structure
    checks: tuple[Check, ...]


def drawn(written: MapSpec | WrittenNetwork) -> PlainNetwork:
    """The plain network that was written or specified. Raises UnusableInput where a specification cannot be drawn."""
    return draw(written) if isinstance(written, MapSpec) else written.plain


def examine(written: MapSpec | WrittenNetwork) -> Examined:
    """Build and check. Raises UnusableInput where it cannot be drawn, or NetconvertRefused."""
    network = plain_to_net(drawn(written), timeout=_LONGEST)
    root = parse(network, NETWORK, root="net")
    structure = measure(root, NETWORK)
    asked = check(written, structure) if isinstance(written, MapSpec) else check_asked(written.asked, structure)
    checks = (*check_sound(structure, overlapping(root, NETWORK)), *asked)
    return Examined(network, Network.of(root, NETWORK).map, structure, checks)
