"""A SUMO network (.net.xml, also gzipped) as our road map: https://sumo.dlr.de/docs/Networks/SUMO_Road_Networks.html.

SUMO's internal lanes, the ways across a junction, become lanes `in_junction`; a connection `from -> to via x` becomes
the links `from -> x -> to`, and its right of way or traffic light guards the entry into x. Networks without internal
lanes link directly; with signals they are refused, because one lane would have the lights of all ways into it. Rail,
water and foot lanes are left out, bicycle lanes are BIKE.
"""

from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput, naming
from drivegen.core.geometry import Floats, Polylines
from drivegen.core.roadmap import LaneControl, LaneKind, RoadMap
from drivegen.core.safe_xml import parse
from drivegen.core.signals import Signals
from drivegen.sumo import net_lanes, order, strips
from drivegen.sumo.neighbours import neighbours
from drivegen.sumo.net_lanes import NetLanes
from drivegen.sumo.programs import Program, read_programs

_CONTROL = {
    "M": LaneControl.FREE,
    "m": LaneControl.YIELD,
    "=": LaneControl.YIELD,  # right before left
    "Z": LaneControl.YIELD,  # zipper merge
    "s": LaneControl.STOP,
    "w": LaneControl.STOP,  # all-way stop
}
_SIGNS = (LaneControl.YIELD, LaneControl.STOP)
_STOPPING = (*_SIGNS, LaneControl.SIGNAL)


@dataclass(frozen=True)
class Network:
    """A road map read from SUMO, with the names that SUMO uses.

    Attributes:
        map: RoadMap of L lanes.
        lane_names: L SUMO lane ids.
        signal_name: (G,) str traffic light id, signal_link: (G,) int32 link index in it, signal_lane: (G,) int32 the
            lane whose entry that link guards.
        programs: Program by traffic light id.
        edge_ends: the junctions that each edge (SUMO id) leads from and to. left_hand: whether traffic keeps left.
    """

    map: RoadMap
    lane_names: tuple[str, ...]
    signal_name: NDArray[np.str_]
    signal_link: NDArray[np.int32]
    signal_lane: NDArray[np.int32]
    programs: dict[str, Program]
    edge_ends: dict[str, tuple[str, str]]
    left_hand: bool

    @classmethod
    def read(cls, raw: bytes, place: str) -> "Network":
        """A network from the bytes of a file; `place` names it in errors.

        Raises UnusableInput for anything that is no SUMO network with at least one lane for vehicles or bicycles, and for one
        whose signals stand where there are no internal lanes.
        """
        return cls.of(parse(raw, place, root="net"), place)

    @classmethod
    def of(cls, root: Element, place: str) -> "Network":
        """The same of XML that has been parsed."""
        return _assemble(root, net_lanes.read_lanes(root, place), place)

    def signals(self, time: NDArray[np.float64]) -> Signals:
        """What the network's own programs show at the times (T,) [s]; UNKNOWN for lights without a program."""
        state = np.zeros((len(self.signal_lane), len(time)), np.uint8)
        for name, program in self.programs.items():
            rows = np.flatnonzero(self.signal_name == name)
            rows = rows[self.signal_link[rows] < program.shown.shape[1]]
            state[rows] = program.at(time)[self.signal_link[rows]]
        return Signals(self.signal_lane, state)


def read_network(raw: bytes, place: str) -> RoadMap:
    """The road map of a SUMO network; see `Network.read`, which keeps SUMO's names too."""
    return Network.read(raw, place).map


@dataclass(frozen=True)
class _Connections:
    """Links (E, 2), control (L,), and for each of G signal links: light, link index, lane."""

    links: NDArray[np.int32]
    control: NDArray[np.uint8]
    signals: list[tuple[str, int, int]]
    dangling: int


def _assemble(root: Element, lanes: NetLanes, place: str) -> Network:
    connections = _read_connections(root, lanes, place)
    origin = np.round((lanes.low + lanes.high) / 2)
    centreline = _centrelines(lanes, connections.links, origin)
    left, right = strips.shifted(centreline, lanes.width / 2), strips.shifted(centreline, -lanes.width / 2)
    neighbour, same, may_change = neighbours(lanes, centreline, connections.control)
    stopping = connections.links[np.isin(connections.control[connections.links[:, 1]], _STOPPING)]
    junctions = {name: shape - origin for name, shape in lanes.junctions.items()}
    road = (lanes.kind != LaneKind.BIKE) & ~_within_junctions(lanes, left, right, junctions)
    area: list[Floats] = [*strips.outlines(left, right, road), *junctions.values()]
    map_ = RoadMap(
        origin=origin,
        lane_id=np.arange(len(lanes), dtype=np.int64),
        kind=lanes.kind,
        centreline=centreline,
        left=left,
        right=right,
        speed_limit=lanes.speed,
        in_junction=lanes.internal,
        control=connections.control,
        links=connections.links,
        yields_to=order.yields_to(root, lanes, np.isin(connections.control, _SIGNS), place),
        neighbour=neighbour,
        same_direction=same,
        may_change=may_change,
        cut=np.zeros((len(lanes), 2), np.bool_),
        drivable=Polylines.of(area),
        crossings=Polylines.of([shape - origin for shape in lanes.crossings]),
        stop_lines=strips.stop_lines(left, right, stopping[:, 0]),
        stop_lane=np.ascontiguousarray(stopping[:, 1]),
        dangling=connections.dangling,
    )
    with naming(place):
        map_.validate()
    names, indices, guarded = zip(*connections.signals, strict=True) if connections.signals else ((), (), ())
    return Network(
        map_,
        lanes.names,
        np.array(names, np.str_),
        np.array(indices, np.int32),
        np.array(guarded, np.int32),
        read_programs(root, place),
        lanes.ends,
        lanes.lefthand,
    )


def _within_junctions(
    lanes: NetLanes, left: Polylines, right: Polylines, junctions: dict[str, NDArray[np.float64]]
) -> NDArray[np.bool_]:
    """(L,) internal lanes whose surface their junction's outline holds anyway: drawing it twice makes maps larger."""
    within = np.zeros(len(lanes), np.bool_)
    for i in np.flatnonzero(lanes.internal).tolist():
        outline = junctions.get(lanes.names[i][1:].rsplit("_", 2)[0])  # SUMO calls them :<junction>_<way>_<lane>
        if outline is not None:
            within[i] = strips.covered(left[i].astype(np.float64), right[i].astype(np.float64), outline)
    return within


def _centrelines(lanes: NetLanes, links: NDArray[np.int32], origin: NDArray[np.float64]) -> Polylines:
    """Local centrelines; an internal lane of no length points where the lane before it ends."""
    before = dict(zip(links[::-1, 1].tolist(), links[::-1, 0].tolist(), strict=True))

    def heading(i: int) -> float:
        line = lanes.shapes[before.get(i, i)]
        return float(np.arctan2(*(line[-1] - line[-2])[::-1]))

    return Polylines.of([strips.cleaned(line, heading(i)) - origin for i, line in enumerate(lanes.shapes)])


def _read_connections(root: Element, lanes: NetLanes, place: str) -> _Connections:
    links: list[tuple[int, int]] = []
    control = np.zeros(len(lanes), np.uint8)
    signals: list[tuple[str, int, int]] = []
    dangling = 0
    through: list[tuple[int, int]] = []
    for element in root.iterfind("connection"):
        ends = [lanes.number.get(f"{element.get(a)}_{element.get(b)}") for a, b in (("from", "fromLane"), ("to", "toLane"))]
        via = lanes.number.get(element.get("via", ""))
        source, target = ends
        if source is None or target is None:
            dangling += net_lanes.names_unknown_lane(element, lanes)
            continue
        entered = target if via is None else via
        links.append((source, entered))
        if via is not None:
            through.append((via, target))
        light = element.get("tl")
        control[entered] = max(control[entered], _control(element.get("state", ""), light))
        if light is not None:
            signals.append((light, net_lanes.whole_number(element, "linkIndex", place), entered))
    onward = {source for source, _ in links}
    links += [(via, target) for via, target in through if via not in onward]  # old files leave the second half out
    _each_light_has_its_lane(signals, lanes, place)
    table = np.unique(np.array(links, np.int32).reshape(-1, 2), axis=0)
    return _Connections(table, control, sorted(set(signals)), dangling)


def _each_light_has_its_lane(signals: list[tuple[str, int, int]], lanes: NetLanes, place: str) -> None:
    """Raise UnusableInput where a light guards the entry into a lane outside junctions, which all ways into it share."""
    if not all(lanes.internal[lane] for _, _, lane in signals):
        raise UnusableInput(
            f"{place} has signals but no lanes within its junctions, so no light can be told from the others: add them with "
            "netconvert -s IN.net.xml --no-internal-links false -o OUT.net.xml",
            reason="no-internal-lanes",
        )


def _control(state: str, light: str | None) -> LaneControl:
    return LaneControl.SIGNAL if light is not None else _CONTROL.get(state, LaneControl.FREE)
