"""Numbers, points and references in CommonRoad's elements: an interval stands for its middle, a region for its centre."""

from math import isfinite
from typing import NoReturn
from xml.etree.ElementTree import Element  # the type only: parsing is safe_xml's

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput

Points = NDArray[np.float64]


def identity(element: Element, name: str, place: str) -> int:
    """A whole number in attribute `name`: an id, or the id that is referred to."""
    text = element.get(name, "")
    if not (text.isascii() and text.isdecimal() and len(text) < 18):
        refuse(f"{place}: <{element.tag}> has no whole number as {name}", "bad-id")
    return int(text)


def references(element: Element, path: str, place: str) -> list[int]:
    """The ids that the elements at `path` refer to."""
    return [identity(child, "ref", place) for child in element.iterfind(path)]


def number(text: str | None, what: str, place: str) -> float:
    """A finite number. Raises UnusableInput, reason `not-a-number`."""
    try:
        value = float(text or "")
    except ValueError:
        value = float("nan")
    if not isfinite(value):
        refuse(f"{place}: {what} is {text!r}, not a number", "not-a-number")
    return value


def possible_limit(limit: float, place: str) -> float:
    """A speed limit [m/s] that a road can have. Raises UnusableInput, reason `out-of-range`, for any other."""
    if not 0 < limit < 1000:
        refuse(f"{place} has the speed limit {limit:g} m/s", "out-of-range")
    return limit


def value(element: Element, name: str, place: str) -> float | None:
    """The number below `element`: exact, plain, or the middle of an interval; None where the element is absent."""
    child = element.find(name)
    if child is None:
        return None
    exact = child.find("exact")
    if exact is not None:
        return number(exact.text, name, place)
    start, end = child.find("intervalStart"), child.find("intervalEnd")
    if start is None or end is None:
        return number(child.text, name, place)
    return (number(start.text, name, place) + number(end.text, name, place)) / 2


def required(element: Element, name: str, place: str) -> float:
    """As `value`, but raises UnusableInput, reason `missing-value`, where the element is absent."""
    result = value(element, name, place)
    if result is None:
        refuse(f"{place}: <{element.tag}> has no <{name}>", "missing-value")
    return result


def pair(element: Element, place: str) -> tuple[float, float]:
    """x and y of a point [m]."""
    return number(element.findtext("x"), "x", place), number(element.findtext("y"), "y", place)


def points(element: Element | None, place: str) -> Points:
    """All points of an element (P, 2) float64 [m]; none where the element is absent."""
    pairs = [] if element is None else [pair(point, place) for point in element.iterfind("point")]
    return np.array(pairs, np.float64).reshape(-1, 2)


def centre(position: Element, place: str) -> tuple[float, float]:
    """Where a state is [m]: its point, or the centre of the region that it is somewhere in."""
    for path in ("point", "rectangle/center", "circle/center"):
        point = position.find(path)
        if point is not None:
            return pair(point, place)
    corners = points(position.find("polygon"), place)
    if not len(corners):
        refuse(f"{place}: a state's position is no point, rectangle, circle or polygon", "missing-value")
    x, y = corners.mean(0)
    return float(x), float(y)


def refuse(sentence: str, reason: str) -> NoReturn:
    """Raise UnusableInput."""
    raise UnusableInput(sentence, reason=reason)
