"""Real roads in: SUMO networks, OpenStreetMap, OpenDRIVE, Argoverse 2.

What a file is, is decided by its content. Every file is parsed without DTD before netconvert sees it. A window of
scenario size can be cut out of a city; a SUMO network that is not cut keeps its bytes.
"""

import math
from collections import defaultdict
from dataclasses import dataclass
from typing import Any
from xml.etree.ElementTree import Element, tostring

from drivegen.av2.maps import read_map
from drivegen.core.errors import UnusableInput
from drivegen.core.safe_xml import parse, unpack
from drivegen.maps.argoverse2 import to_network
from drivegen.maps.build import BuiltMap
from drivegen.maps.opendrive import against_its_side, read_opendrive
from drivegen.maps.road_graph import for_cars
from drivegen.maps.structure import measure
from drivegen.sumo.netconvert import NetconvertRefused, convert
from drivegen.sumo.network import Network

_CAR = ("--keep-edges.by-vclass", "passenger,bus,truck,delivery")
_OSM = (
    *("--geometry.remove", "true", "--roundabouts.guess", "true", "--ramps.guess", "true", "--junctions.join", "true"),
    *("--tls.guess-signals", "true", "--tls.discard-simple", "true", "--tls.join", "true", "--no-turnarounds", "true"),
    *_CAR,
)
_SOURCES = {"net": "SUMO network", "osm": "OpenStreetMap", "OpenDRIVE": "OpenDRIVE"}
_ASSUMED = {
    "OpenStreetMap": "right-hand traffic; limits and lanes by the kind of road where no tag gives them",
    "OpenDRIVE": "50 km/h where the file gives no limit, 162 km/h where it says that there is none; right of way is guessed",
    "Argoverse 2": "50 km/h where the file gives no limit; nobody has the right of way; roads end where the map is cut. Left "
    "out: crosswalks, which lanes lie in junctions, and oncoming lanes as neighbours",
}
_TIMEOUT = 300.0

_SHOWN = 5
"""Names of junctions in a sentence at most."""


@dataclass(frozen=True)
class Window:
    """A square cut out of a network, `radius` [m] to each side of a place; roads that reach into it stay whole.

    The place is `around` (x, y) [m, network frame], or junction `junction`, or, with neither, the junction with most
    incoming car lanes.
    """

    radius: float
    around: tuple[float, float] | None = None
    junction: str | None = None


def import_map(raw: bytes, place: str, window: Window | None = None) -> BuiltMap:
    """The map in a file's bytes (`place` is its name, for errors), cut to `window`.

    Raises UnusableInput where the file is none of the four formats, is damaged, or the window holds no road.
    """
    data = unpack(raw, place)
    if data.lstrip()[:1] == b"{":
        network, source = to_network(read_map(data, place)), "Argoverse 2"
    else:
        root, data = _without_namespace(parse(data, place), data)
        source = _SOURCES.get(root.tag, "")
        if not source:
            formats = ", ".join(_SOURCES.values())
            raise UnusableInput(
                f"{place} is no map: it holds <{root.tag}>; known are {formats} and Argoverse 2", reason="not-a-map"
            )
        network = data if root.tag == "net" else _converted(data, root, place)
    if window is not None:
        network = cut(network, place, window)
    root = parse(network, place, root="net")
    road_map, structure = Network.of(root, place).map, measure(root, place)
    account: dict[str, Any] = {"text": f"{source}: {place}", "backend": "import", "source": source, "structure": structure}
    assumed = [_ASSUMED[source]] if source in _ASSUMED else []
    account |= {"window": window, "understood": [], "ignored": [], "assumed": assumed, "failed": [], "checks": []}
    return BuiltMap(network, road_map, structure, (), account)


def cut(network: bytes, place: str, window: Window) -> bytes:
    """The part of a SUMO network inside `window`, coordinates kept."""
    if not 10 <= window.radius <= 5000:
        raise UnusableInput(f"the window's radius must be between 10 and 5000 m, not {window.radius:g}", reason="bad-window")
    root = parse(network, place, root="net")
    x, y = _centre(root, place, window)
    box = ",".join(f"{value:.2f}" for value in (x - window.radius, y - window.radius, x + window.radius, y + window.radius))
    arguments = ["-s", "in.net.xml", "--keep-edges.in-boundary", box, *_CAR, "--offset.disable-normalization", "true"]
    arguments += ["--ignore-errors", "true", "-o", "out.net.xml"]
    nothing = UnusableInput(
        f"{place} has no road within {window.radius:g} m of ({x:.0f}, {y:.0f}):"
        f" name a place on its roads{_extent(root)}, or a larger radius",
        reason="empty-window",
    )
    try:
        made = convert({"in.net.xml": network}, arguments, "out.net.xml", _TIMEOUT)
    except NetconvertRefused as refusal:
        raise (nothing if "No edges loaded" in str(refusal) else refusal) from None
    if b"<edge " not in made:
        raise nothing
    return made


def _without_namespace(root: Element, data: bytes) -> tuple[Element, bytes]:
    """An OpenDRIVE file as it is without its standard's namespace, which 1.7 and 1.8 may name; any other as it is."""
    if not root.tag.endswith("}OpenDRIVE"):
        return root, data
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]
    return root, bytes(tostring(root))


def _converted(data: bytes, root: Element, place: str) -> bytes:
    if any(road.get("rule") == "LHT" for road in root.iter("road")):
        raise UnusableInput(
            f'{place} has left-hand roads (rule="LHT"): netconvert lets every lane of theirs run the wrong way',
            reason="left-hand",
        )
    if lane := against_its_side(root):
        raise UnusableInput(
            f"{place}: {lane} runs against its side of the road, or both ways: netconvert reads it as one that does not",
            reason="two-way-lane",
        )
    try:
        if root.tag == "OpenDRIVE":
            return read_opendrive(data)
        return convert({"in.xml": data}, ["--osm-files", "in.xml", *_OSM, "-o", "out.net.xml"], "out.net.xml", _TIMEOUT)
    except NetconvertRefused as refusal:
        raise UnusableInput(f"{place}: {refusal}", reason=refusal.reason) from None


def _centre(root: Element, place: str, window: Window) -> tuple[float, float]:
    if window.around is not None:
        if not all(math.isfinite(value) for value in window.around):
            raise UnusableInput("the window's place must be two finite numbers, as 120,80", reason="bad-window")
        return window.around
    nodes = {j.get("id", ""): j for j in root.iter("junction") if j.get("type") != "internal"}
    name = window.junction if window.junction is not None else _busiest(root, nodes)
    if name not in nodes:
        shown = ", ".join(sorted(nodes)[:_SHOWN]) + (", ..." if len(nodes) > _SHOWN else "")
        raise UnusableInput(f"{place} has no junction {name!r}: name one of its {len(nodes)}, {shown}", reason="bad-window")
    try:
        x, y = float(nodes[name].get("x", "")), float(nodes[name].get("y", ""))
    except ValueError:
        x = y = math.nan
    if not math.isfinite(x + y):
        raise UnusableInput(f"{place}: junction {name!r} has no place (x and y): repair the file", reason="bad-map")
    return x, y


def _extent(root: Element) -> str:
    """Where a network says that it lies, in brackets; nothing where it does not say so in four numbers."""
    location = root.find("location")
    try:
        left, bottom, right, top = map(float, location.get("convBoundary", "").split(",") if location is not None else ())
    except ValueError:
        return ""
    return f" (x from {left:.0f} to {right:.0f}, y from {bottom:.0f} to {top:.0f})"


def _busiest(root: Element, nodes: dict[str, Element]) -> str:
    """The junction with most incoming car lanes; the first by name among equals."""
    lanes: dict[str, int] = defaultdict(int)
    for edge in root.iter("edge"):
        if edge.get("function") is None and edge.get("to") in nodes:
            lanes[edge.get("to", "")] += sum(for_cars(lane) for lane in edge.iter("lane"))
    return min(lanes, key=lambda name: (-lanes[name], name), default="")
