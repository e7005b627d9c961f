"""Traffic signs, lights and stop lines of 2020a: what holds before entering a lane. 2018b has none of them.

A lanelet that refers to a sign or a light is the way up to it, so it is the lanes behind that lanelet's end that are
guarded; of a light with a direction, only those that turn that way. Signs are known by Germany's and the USA's numbers.
"""

from dataclasses import dataclass
from xml.etree.ElementTree import Element  # the type only: parsing is safe_xml's

import numpy as np
from numpy.typing import NDArray

from drivegen.commonroad.junctions import ways
from drivegen.commonroad.values import Points, identity, number, points, possible_limit, references, refuse, required, value
from drivegen.core.roadmap import LaneControl
from drivegen.core.signals import SignalState

SIGNS = {
    "205": LaneControl.YIELD,
    "R1-2": LaneControl.YIELD,
    "206": LaneControl.STOP,
    "R1-1": LaneControl.STOP,
    "301": LaneControl.FREE,
    "306": LaneControl.FREE,
}
SPEED_SIGNS = ("274", "R2-1")

COLOURS = {
    "green": SignalState.GREEN,
    "yellow": SignalState.YELLOW,
    "red": SignalState.RED,
    "redYellow": SignalState.RED,  # nobody may go yet
    "inactive": SignalState.UNKNOWN,
}

LONGEST_CYCLE = 36_000
"""A light whose cycle takes more steps than this is refused."""


@dataclass(frozen=True)
class Lights:
    """G lights, each over lane `lane[g]`, with its cycle of states, one a step, which is at its beginning at `offset[g]`."""

    lane: NDArray[np.int32]
    cycle: tuple[NDArray[np.uint8], ...]
    offset: tuple[int, ...]

    def shown(self, steps: int, stride: int) -> NDArray[np.uint8]:
        """(G, steps) SignalState at every `stride`-th of the file's time steps."""
        time = np.arange(steps) * stride
        rows = [c[(time - o) % len(c)] for c, o in zip(self.cycle, self.offset, strict=True)]
        return np.array(rows, np.uint8).reshape(-1, steps)


@dataclass(frozen=True)
class Rules:
    """What signs, lights and lines say of L lanes.

    Attributes:
        control: (L,) uint8 LaneControl of entering each lane.
        speed_limit: (L,) float32 [m/s] by signs, the least of several, NaN where there is none.
        stop_lines: (S, 2, 2) float64 [m, source frame]. stop_lane: (S,) int32 the lane entered behind each.
    """

    control: NDArray[np.uint8]
    speed_limit: NDArray[np.float32]
    stop_lines: NDArray[np.float64]
    stop_lane: NDArray[np.int32]
    lights: Lights


def read(root: Element, lanes: list[Element], links: NDArray[np.int32], index: dict[int, int], place: str) -> Rules:
    """The rules for the lanelet elements `lanes` (L), linked by `links` (E, 2); `index` numbers lanes by id."""
    signs = {identity(sign, "id", place): sign for sign in root.iterfind("trafficSign")}
    lights = {identity(light, "id", place): light for light in root.iterfind("trafficLight")}
    turns = {index[name]: word for name, word in ways(root, place).items() if name in index}
    control = np.zeros(len(lanes), np.uint8)
    limit = np.full(len(lanes), np.nan, np.float32)
    lines: list[tuple[Points, int]] = []
    shown: dict[int, Element] = {}
    for i, lane in enumerate(lanes):
        behind = links[links[:, 0] == i, 1].tolist()
        for name in _referred(lane, "trafficSignRef", place):
            guard, speed = _sign(signs.get(name), place)
            control[behind] = np.maximum(control[behind], guard)
            limit[i] = np.fmin(limit[i], speed)
        for name in _referred(lane, "trafficLightRef", place):
            if name in lights:
                meant = [j for j in behind if _means(lights[name], turns.get(j))]
                control[meant] = LaneControl.SIGNAL
                shown.update(dict.fromkeys(meant, lights[name]))
        if lane.find("stopLine") is not None:
            line = _stop_line(lane, place)
            lines += [(line, j) for j in behind]
    cycles = [_cycle(light, place) for _, light in sorted(shown.items())]
    return Rules(
        control,
        limit,
        np.array([line for line, _ in lines], np.float64).reshape(-1, 2, 2),
        np.array([j for _, j in lines], np.int32),
        Lights(np.array(sorted(shown), np.int32), tuple(c for c, _ in cycles), tuple(o for _, o in cycles)),
    )


def _referred(lane: Element, word: str, place: str) -> list[int]:
    """The ids that a lanelet or its stop line refers to: files may name a sign in both, or in either."""
    return [*references(lane, word, place), *references(lane, f"stopLine/{word}", place)]


def _sign(sign: Element | None, place: str) -> tuple[LaneControl, float]:
    """What a sign asks for, and its speed limit [m/s], the least of several, NaN where it has none."""
    guard, speed = LaneControl.UNKNOWN, np.nan
    for part in sign.iterfind("trafficSignElement") if sign is not None else ():
        code = part.findtext("trafficSignID", "").strip()
        guard = max(guard, SIGNS.get(code, LaneControl.UNKNOWN))
        if code in SPEED_SIGNS:
            limit = number(part.findtext("additionalValue"), "a speed limit", place)
            speed = np.fmin(speed, possible_limit(limit, f"{place}: a sign"))
    return guard, speed


def _means(light: Element, turn: str | None) -> bool:
    """Whether a light is for a way that turns like this; one without direction, or a way without turn, always."""
    words = light.findtext("direction", "all").strip()
    return turn is None or words == "all" or turn in words.lower()


def _cycle(light: Element, place: str) -> tuple[NDArray[np.uint8], int]:
    """States, one a step, and the step at which they begin; a light that is off shows UNKNOWN."""
    place = f"{place}: traffic light {light.get('id')}"
    cycle = light.find("cycle")
    if cycle is None or light.findtext("active", "true").strip() == "false":
        return np.zeros(1, np.uint8), 0
    states: list[int] = []
    for part in cycle.iterfind("cycleElement"):
        lasts = required(part, "duration", place)
        if not 0 < lasts <= LONGEST_CYCLE - len(states):
            refuse(f"{place} has a phase of {lasts:g} steps", "out-of-range")
        states += [COLOURS.get(part.findtext("color", "").strip(), SignalState.UNKNOWN)] * int(lasts)
    offset = value(cycle, "timeOffset", place)
    states = states or [0]
    return np.array(states, np.uint8), int(offset or 0) % len(states)


def _stop_line(lane: Element, place: str) -> Points:
    """Both ends (2, 2) [m]: as given, else the ends of the lanelet's bounds."""
    line = points(lane.find("stopLine"), place)
    if len(line) == 2:
        return line
    return np.stack([points(lane.find(word), place)[-1] for word in ("rightBound", "leftBound")])
