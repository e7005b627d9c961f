"""From what is said of a road to its line: straights, bends, lengths."""

import math
import re

from drivegen.words.choices import Choices
from drivegen.words.things import Road, Thing, Unfit, only

_ANGLES = {"hairpin": 180.0, "s_curve": 60.0, "curve": 90.0}
_LEAST_HAIRPIN = 135.0
_SHORT = 0.9
BENT = (
    "line", "turn", "turn_side", "turn_angle", "turn_to", "towards", "bends", "arc", "straights", "hairpins", "s_turn", "s_arc",
)  # fmt: skip
"""Fields of which each makes a road bend."""


def alignment(road: Thing, choices: Choices, usual: tuple[int, int], radius: float = 60.0) -> Road:
    """The line of a road: as said, else straight, between `usual` lengths [m]."""
    shape, hairpins, length = _shape(road), road.value("hairpins"), road.value("length")
    if not shape:
        return {"shape": "straight", "length": length or choices.length("length", *usual, step=50)}
    if arcs := road.values("arc"):
        bends = tuple((angle if side == "left" else -angle, size) for angle, side, size in arcs)
        line: Road = {"shape": shape, "arcs": bends}
        arc = sum(abs(math.radians(angle)) * size for angle, size in bends)
        return line | {"length": _length(road, length, arc, 1.0, choices)}
    angle, side = _turn(road)
    sharpness = road.value("sharpness")
    given = road.value("radius")
    bends = hairpins or road.value("bends")
    if shape == "curve" and bends and bends > 1:
        raise Unfit(f"say of each of the {bends} bends how far it turns, or ask for an S-curve or hairpins")
    angle = angle or _ANGLES[shape]
    if shape == "hairpin" and angle < _LEAST_HAIRPIN:
        raise Unfit(f"a hairpin turns by {_LEAST_HAIRPIN:g} degrees or more, not by {angle:g}")
    factor = {"sharp": 0.5, "gentle": 2.0, None: 1.0}[sharpness]
    size = given or (20.0 if shape == "hairpin" else 45.0 if angle > 180.0 else radius * factor)
    number = bends or (2 if shape == "s_curve" else 1)
    arc = math.radians(angle) * size * number
    share = 1.0 if angle <= 180.0 else 0.0
    line = {"shape": shape, "angle": -angle if side == "right" else angle, "radius": size}
    line |= {"bends": bends} if bends and bends != (2 if shape == "s_curve" else 1) else {}
    return line | {"length": _length(road, length, arc, share * (number + 1) / 2, choices)}


def _shape(road: Thing) -> str:
    """A curve, an S-curve or hairpins; nothing for a straight road. What does not say how often a road bends is declined."""
    shapes = set(road.values("line"))
    several = {fact.value: fact.text for fact in road.facts if fact.name == "line" and re.search(r"\ws$", fact.text)}
    if "hairpin" in several and not road.value("hairpins"):
        raise Unfit(f"say how many {several['hairpin']}")
    if "s_curve" in several:
        raise Unfit(f"say how many bends {several['s_curve']!r} have together: 'an S-curve, 4 bends'")
    if "winding" in several and road.has("turn_to", "towards"):
        raise Unfit(f"say of each of {several['winding']!r} how far and to which side it turns")
    shapes |= {"hairpin"} if road.value("hairpins") else set()
    shapes |= {"s_curve"} if road.has("s_turn", "s_arc") else set()
    bent = road.has("turn", "turn_side", "turn_angle", "arc", "bends", "turn_to")
    if bool(road.value("straight")) and (shapes or bent):
        raise Unfit("a road is said to be straight and to bend")
    if not shapes and not bent:
        return ""
    for vague, meant in (("curve", "curve"), ("winding", "s_curve")):
        shapes = (shapes - {vague} or {meant}) if vague in shapes else shapes
    return only(shapes, "I can draw a curve, an S-curve or hairpins on one road, not several of these") or "curve"


def _length(road: Thing, length: float | None, arc: float, share: float, choices: Choices) -> float:
    if length and length < _SHORT * arc:
        raise Unfit(f"bends that are {arc:.0f} m long together do not fit into a road of {length:.0f} m")
    straights = road.value("straights")
    if length:
        return float(length)
    if straights is not None:
        return float(arc + straights)
    return arc + (choices.length("straight roads beside the bend", 200, 300, step=20) * share if share else 60.0)


def _turn(road: Thing) -> tuple[float | None, str | None]:
    """By how many degrees a road turns, and to which side."""
    angles, sides = list(map(float, road.values("turn_angle"))), [*road.values("turn_to"), *road.values("towards")]
    for pair in (*road.values("turn"), *road.values("turn_side")):
        angles.append(float(next(value for value in pair if not isinstance(value, str))))
        sides.append(next(value for value in pair if isinstance(value, str)))
    for values in (*road.values("s_turn"), *road.values("s_arc")):
        angles += [value for value in values if not isinstance(value, str)]
        first, second = [value for value in values if isinstance(value, str)]
        sides.append(first if first != second else "")
    if len(set(angles)) > 1 or "" in sides or len(set(sides)) > 1:
        raise Unfit("a bend is said to turn in two ways")
    if angles and not 0 < angles[0] <= 280:
        raise Unfit(f"a bend turns by up to 280 degrees, not by {angles[0]:g}")
    return (angles[0] if angles else None), (sides[0] if sides else None)
