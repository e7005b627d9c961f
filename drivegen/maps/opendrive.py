"""OpenDRIVE out and in, by netconvert; and how much of a network is still there when it is read back.

netconvert alone writes every lane that cars may not use as "restricted", whichever vehicles may, and skips such lanes and bicycle
lanes when it reads. Here each lane is written as the kind that our maps give it ("driving", "bus", "biking": lane types of
OpenDRIVE 1.4), and read as such. What a lane type cannot say is lost: which of lorries, taxis or trams share the lane. So is
left-hand traffic: lanes lie where they did and run as they did, but netconvert has no word for the rule. Neither priorities nor
signs are written, and each direction is a road of its own: `losses` says where what is read back differs.
"""

import re
from dataclasses import dataclass
from xml.etree.ElementTree import Element, tostring

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from drivegen.core.geometry import arc_length, interpolate
from drivegen.core.roadmap import NO_LANE, LaneKind, RoadMap
from drivegen.core.safe_xml import parse
from drivegen.core.wording import many
from drivegen.sumo.netconvert import convert
from drivegen.sumo.network import Network

TIMEOUT = 300.0
"""For netconvert [s]: a city takes that long."""

_ASSUMED = 13.89
_UNLIMITED = 45.0
"""Limits where the file has none, and where it says "no limit" [m/s]: no road that we draw has a higher one."""

_NEAR = 1e-3
"""Places along a road this near to one another are one [m]."""

_SAME = 20.0
"""Lanes of two maps are the same one where their ends and middles are no farther apart than this [m], squares added up."""

_DATE = re.compile(rb'(<header[^>]*?\sdate=")[^"]*(")')
_ALLOW = {LaneKind.VEHICLE: ("disallow", "pedestrian"), LaneKind.BUS: ("allow", "bus"), LaneKind.BIKE: ("allow", "bicycle")}
_OTHERS = ("pedestrian", "tram", "rail")
_RAMP = ("entry", "exit", "offRamp", "onRamp", "connectingRamp", "slipLane", "mwyEntry", "mwyExit")
_CAR = ("driving", *_RAMP, "bidirectional")
_NOT_ROAD = (
    "pedestrian rail rail_urban rail_electric rail_fast tram drone aircraft scooter container wheelchair subway cable_car ship"
)
_OF_FOREIGN = {
    "bus": "bus coach taxi",
    "taxi": "taxi",
    "HOV": "hov",
    "biking": "bicycle",
    "roadWorks": "authority",
    "tram": "tram",
}
_BESIDE = ("stop", "parking", "shoulder", "border", "median", "curb", "sidewalk")  # "stop" is a hard shoulder
_NOTHING = ("restricted", "none", *_BESIDE, "special1", "special2", "special3", "rail")
_KEPT = "passenger,bus,truck,delivery,taxi,hov,bicycle"


@dataclass(frozen=True)
class Extent:
    """How much road a map has, in figures that do not depend on where a format lets a junction begin.

    Attributes:
        lanes: of roads, those across junctions left out, by kind (VEHICLE, BUS, BIKE). kilometres: of all lanes, those across
            junctions too. ways: pairs of lanes of which one leads into the other, straight or across a junction.
    """

    lanes: tuple[int, int, int]
    kilometres: float
    ways: int

    @classmethod
    def of(cls, road_map: RoadMap) -> "Extent":
        """Of a map."""
        road = ~road_map.in_junction
        lanes = [int((road & (road_map.kind == kind)).sum()) for kind in (LaneKind.VEHICLE, LaneKind.BUS, LaneKind.BIKE)]
        lines = (road_map.centreline[i].astype(np.float64) for i in range(len(road_map)))
        metres = sum(float(np.hypot(*np.diff(line, axis=0).T).sum()) for line in lines)
        return cls((lanes[0], lanes[1], lanes[2]), metres / 1000, len(_ways(road_map)))

    def holds(self, other: "Extent") -> bool:
        """Whether it has the same lanes and ways as another map; lengths differ where a junction's inside is drawn anew."""
        return (self.lanes, self.ways) == (other.lanes, other.ways)

    def __str__(self) -> str:
        cars, buses, bicycles = self.lanes
        lanes = f"{cars} car, {buses} bus, {bicycles} bicycle lanes"
        return f"{lanes}; {self.ways} ways from lane to lane; {self.kilometres:.2f} lane-km"


def export_opendrive(network: bytes) -> bytes:
    """A SUMO network as OpenDRIVE (.xodr), without the date of writing."""
    arguments = ["-s", "in.net.xml", "--opendrive-output", "out.xodr"]
    made = convert({"in.net.xml": _with_plain_permissions(network)}, arguments, "out.xodr", TIMEOUT)
    made = made.replace(b'type="restricted"', b'type="bus"')  # nothing else is left that netconvert calls so
    return _DATE.sub(rb"\1\2", made)


def keeps_left(network: bytes) -> bool:
    """Whether a SUMO network has left-hand traffic."""
    return parse(network, "network", root="net").get("lefthand") in ("true", "1")


def against_its_side(root: Element) -> str | None:
    """The first lane of an OpenDRIVE file that runs against its side of the road, or both ways, with its road; None without.

    netconvert reads such lanes (1.8's `direction`, the type "bidirectional") as any other one.
    """
    for road in root.iter("road"):
        for lane in road.iter("lane"):
            turned = lane.get("direction") in ("reversed", "both") and lane.get("type") in (*_CAR, *_OF_FOREIGN)
            if turned or lane.get("type") == "bidirectional":
                return f"lane {lane.get('id')} of road {road.get('id')!r}"
    return None


def read_opendrive(xodr: bytes) -> bytes:
    """The SUMO network of an OpenDRIVE file: its lanes for cars, buses and bicycles, in the file's own coordinates (a header's
    <offset> is not added to them). Raises NetconvertRefused.
    """
    flags = ["--type-files", "lanes.typ.xml", "--keep-edges.by-vclass", _KEPT, "--no-turnarounds", "true"]
    flags += ["--offset.disable-normalization", "true"]
    arguments = ["--opendrive-files", "in.xodr", *flags, "-o", "out.net.xml"]
    return convert({"in.xodr": _with_limits(xodr), "lanes.typ.xml": _types()}, arguments, "out.net.xml", TIMEOUT)


def read_back(xodr: bytes, place: str) -> Network:
    """What is there of a map when its OpenDRIVE is read."""
    return Network.read(read_opendrive(xodr), place)


def losses(before: Network, after: Network) -> list[str]:
    """What of a map's ways and roads is not as it was when it is read back: who goes first, which directions are one road."""
    same = _same_lanes(before.map, after.map)
    there, back = _ways(before.map), _ways(after.map)
    found = {way: back.get((same.get(way[0], NO_LANE), same.get(way[1], NO_LANE))) for way in there}
    compared = [control != there[way] for way, control in found.items() if control is not None]
    still = _two_way(after)
    parted = [not still[same[lane]] for lane in np.flatnonzero(_two_way(before)).tolist() if lane in same]
    told = []
    if others := sum(compared):
        told.append(f"right of way at {others} of {many(len(compared), 'way')} compared: the file does not say it, readers guess")
    if alone := sum(parted):
        told.append(f"which two directions are one road, at {alone} of {many(len(parted), 'lane')} of two-way roads")
    return told


def _two_way(network: Network) -> list[bool]:
    """Of each lane outside junctions, whether an edge runs back between the same nodes; False of all others."""
    ends = [network.edge_ends.get(name.rsplit("_", 1)[0], ("", "")) for name in network.lane_names]
    known = set(ends)
    return [one != other and (other, one) in known for one, other in ends]


def _ways(road_map: RoadMap) -> dict[tuple[int, int], int]:
    """The control at the beginning of each way (lane, lane that it leads into)."""
    after: dict[int, list[int]] = {}
    for lane, following in road_map.links.tolist():
        after.setdefault(lane, []).append(following)
    ways: dict[tuple[int, int], int] = {}
    for lane, first in road_map.links[~road_map.in_junction[road_map.links[:, 0]]].tolist():
        reached, seen = [first], set()
        while reached:
            following = reached.pop()
            if not road_map.in_junction[following]:
                ways[lane, following] = max(ways.get((lane, following), 0), int(road_map.control[first]))
            elif following not in seen:
                seen.add(following)
                reached += after.get(following, [])
    return ways


def _same_lanes(before: RoadMap, after: RoadMap) -> dict[int, int]:
    """The lane of another map that lies where a lane does, by lane: each is the other's nearest. Ends move where junctions are
    drawn anew.
    """
    (old, places), (new, others) = _places(before), _places(after)
    (apart, nearest), back = KDTree(others).query(places), KDTree(places).query(others)[1]
    rows = np.flatnonzero((back[nearest] == np.arange(len(old))) & (apart < _SAME)).tolist()
    return {int(old[i]): int(new[nearest[i]]) for i in rows}


def _places(road_map: RoadMap) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """The lanes outside junctions (K,), and where each begins, is half way and ends (K, 6) [m, source frame]."""
    lanes = np.flatnonzero(~road_map.in_junction)
    lines = [road_map.centreline[i].astype(np.float64) + road_map.origin for i in lanes.tolist()]
    shares = np.array([0.0, 0.5, 1.0])
    return lanes, np.stack([interpolate(line, arc_length(line)[-1] * shares).ravel() for line in lines])


def _with_plain_permissions(network: bytes) -> bytes:
    """The network with each lane open to what it is for alone, so that netconvert gives it a lane type that says so."""
    root = parse(network, "network", root="net")
    read = Network.read(network, "network")
    kinds = dict(zip(read.lane_names, read.map.kind.tolist(), strict=True))
    for edge in root.iter("edge"):
        for lane in edge.iter("lane"):
            kind = kinds.get(lane.get("id", ""))
            attribute, classes = _of_others(lane) if kind is None else _ALLOW[LaneKind(kind)]
            lane.attrib.pop("allow", None)
            lane.attrib.pop("disallow", None)
            lane.set(attribute, classes)
    for connection in root.iter("connection"):  # a light for a second stop on the way: netconvert refuses its own in windows
        connection.attrib.pop("linkIndex2", None)
    return bytes(tostring(root))


def _of_others(lane: Element) -> tuple[str, str]:
    """Of a lane that is for none of our vehicles: its first user that OpenDRIVE has a lane type for, or nobody."""
    allowed = lane.get("allow", "").split()
    return next((("allow", name) for name in _OTHERS if name in allowed), ("disallow", "all"))


def _with_limits(xodr: bytes) -> bytes:
    """The file with each road's limits given to its lanes that have none of their own: netconvert reads limits of lanes alone."""
    root = parse(xodr, "OpenDRIVE", root="OpenDRIVE")
    for road in root.iter("road"):
        types = [(_number(kind.get("s")), _limit(kind.find("speed"))) for kind in road.iterfind("type")]
        sections = road.findall("lanes/laneSection")
        ends = [*(_number(section.get("s")) for section in sections[1:]), _number(road.get("length"))]
        for section, end in zip(sections, ends, strict=False):  # a damaged road may have no section
            limits = _limits(types, _number(section.get("s")), end)
            for lane in section.iter("lane"):
                if lane.find("speed") is None:
                    lane.extend(limits)
    return bytes(tostring(root))


def _limits(types: list[tuple[float, dict[str, str]]], begin: float, end: float) -> list[Element]:
    """The limits of a road's `types` (s [m], attributes) between two places of it [m], as a lane has them."""
    begun = [limit for s, limit in types if s <= begin + _NEAR]
    within = [(s - begin, limit) for s, limit in types if begin + _NEAR < s < end - _NEAR]
    return [
        Element("speed", {**limit, "sOffset": f"{at:.8f}"}) for at, limit in [*((0.0, limit) for limit in begun[-1:]), *within]
    ]


def _limit(speed: Element | None) -> dict[str, str]:
    """The attributes of a limit; those of the assumed one where the file has none, or one that is none ("undefined")."""
    if speed is not None and speed.get("max") == "no limit":
        return {"max": str(_UNLIMITED)}
    return dict(speed.attrib) if speed is not None and 0 < _number(speed.get("max")) < 1000 else {"max": str(_ASSUMED)}


def _number(text: str | None) -> float:
    """A number; 0 for what is none, as the limit "undefined"."""
    try:
        return float(text or 0)
    except ValueError:
        return 0.0


def _types() -> bytes:
    """Who may use lanes of each OpenDRIVE type, as netconvert reads it; a type's speed and width hold where a file has none."""
    rows = [f'<type id="{name}" priority="1" speed="{_ASSUMED}" width="3.65" disallow="{_NOT_ROAD}"/>' for name in _CAR]
    rows += [
        f'<type id="{name}" priority="1" speed="{_ASSUMED}" width="{1.5 if name == "biking" else 3.65}" allow="{allowed}"/>'
        for name, allowed in _OF_FOREIGN.items()
    ]
    rows += [f'<type id="{name}" priority="0" speed="1.39" width="1.0" disallow="all" discard="true"/>' for name in _NOTHING]
    return ("<types>" + "".join(rows) + "</types>").encode()
