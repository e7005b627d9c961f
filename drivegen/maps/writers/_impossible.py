"""What no road can be, where it shows in the words alone: signs of numbers, directions, and comparisons in one breath.

What contradicts another fact, or the road that is built, is found by `_kept.py`.
"""

import math
import re
from collections.abc import Callable

from drivegen.errors import UnusableInput

_ROAD = r"(?:road|street|highway|motorway|freeway|expressway|carriageway|avenue|lane)s?"
_DEAD_END = r"(?:cul de sac|dead end(?: \w+)?|no through road|blind alley)s?"
_PLACE = r"(?:crossings?|intersections?|junctions?|roundabouts?|arms|legs|streets|roads|lanes|ramps|exits)"
_THAT = r"(?:(?:that|which|but|and|yet|,) )*"
_END = r"(?: ?[,.]| at all| whatsoever|$)"
_IMPOSSIBLE = {
    r"(?:minus|negative) \d+|(?<![\d.] )(?<![\d.])0 (?:m|km|ft|yd|mile)\b": "numbers must be positive",
    r"into (?:exactly |just |only )?2 (?:\w+ )?(?:branches|roads|arms|ways|carriageways|parts)\b[^.]*\b(?:left\b[^.]*\bstraight\b"
    r"[^.]*\bright|right\b[^.]*\bstraight\b[^.]*\bleft|straight\b[^.]*\bleft\b[^.]*\bright)\b": "three branches are not two",
    r"half (?:of )?a lane|\d\.\d+ lanes?": "lanes are counted in whole numbers",
    r"same (?:bearing|heading|angle|compass direction)": "roads that meet must lie apart",
    r"(?:arms|legs|roads|approaches|branches) (?:\w+ ){0,5}same direction": "roads that meet must lie apart",
    rf"parallel {_ROAD} {_THAT}(?:cross|intersect|meet)(?= each| 1 another| one another| at| in|{_END})": "parallels never meet",
    rf"{_ROAD} (?:that|which) are parallel (?:and|but|yet) (?:cross|intersect|meet)\b": "parallels never meet",
    rf"straight {_ROAD} (?:that|which) (?:is|forms|makes) an? (?:full )?(?:circle|ring|loop)": "what is straight has no bends",
    rf"{_DEAD_END}\b[^.]*? (?:open|connected|joined|linked)(?: to \w+)? at (?:both|either) ends?": "a dead end has one way out",
    rf"{_DEAD_END}\b[^.]*? (?:both (?:its |of its )?ends\b|either end\b|through traffic)": ("a dead end has one way out"),
    rf"{_DEAD_END} (?:that|which) (?:leads?|runs?|goes|continues) (?:straight |right |on )*(?:through|to)\b": (
        "a dead end has one way out"
    ),
    rf"{_DEAD_END} through which\b": "a dead end has one way out",
    r"(?:number of lanes|lane count) (?:is |that |which )?(?:never|not|without) (?:changes?|changing)\b[^.]*"
    r"\b(?:narrow|widen)(?:s|ing)\b": "a road that narrows or widens changes its number of lanes",
    r"(?:all|every)\b[^.]{0,40}\bone way (?:streets? |roads? )?(?:towards?|into|inwards|away from|out of)": (
        "there must be a way in and a way out"
    ),
}
_OPPOSITE = r"(?:(?:exactly|directly|precisely) opposite|(?:at |in )(?:the )?(?:very |exactly the )?same (?:point|place|spot))"
_N = r"(\d+(?:\.\d+)?)"
_OFF = 0.15
_METRES = {"m": 1.0, "km": 1000.0, "ft": 0.3048, "yd": 0.9144, "mile": 1609.344}
_LENGTH = rf"{_N} (m|km|ft|yd|mile)"
_TOO = r"(?:(?:and|but|yet) )?(?:(?:is|it|has|are) )?(?:also|at the same time|simultaneously|likewise)"
_OF_IT = r"(?: (?:is|has|a|an|of|long|length|exactly|the|at|same|time|being|total))*"


def _different(a: str, unit_a: str, b: str, unit_b: str) -> bool:
    first, second = float(a) * _METRES[unit_a], float(b) * _METRES[unit_b]
    return abs(first - second) > 0.05 * max(first, second)


def _is_less(a: str, unit_a: str, b: str, unit_b: str) -> bool:
    return float(a) * _METRES[unit_a] < 0.98 * float(b) * _METRES[unit_b]


_COMPARED: tuple[tuple[str, Callable[..., bool], str], ...] = (
    (
        r"\ban? (?:\w+ )?(?:curve|bend|turn) to the (left|right) (?:that|which) (?:turns|bends|curves|goes|veers|leads) "
        r"(?:to the )?(left|right)\b",
        lambda first, second: first != second,
        "one bend turns to one side",
    ),
    (
        r"(\d) (?:roads|streets|arms|legs)(?: ,)? (?:where|at which|in which) (?:only |just |exactly |no more than )(\d) "
        r"(?:(?:roads|streets|arms|legs|of them) )?(?:meet|cross|join|come together)\b",
        lambda there, meeting: there != meeting,
        "the roads of a junction are those that meet",
    ),
    (rf"{_LENGTH}(?: apart| long)? {_TOO}{_OF_IT} {_LENGTH}", _different, "lengths differ"),
    (
        rf"{_N} (?:\w+ )?{_PLACE}\b[^.]{{0,60}}? of (?:which|them|these) (?:only )?{_N}(?! (?:m|km|kmh|mph|lanes?|arms?)\b)",
        lambda all_of_them, some: float(some) > float(all_of_them),
        "some are no more than all",
    ),
    (
        rf"(?:road|street|long|of) (?:of |is )?{_LENGTH}\b[^.]*?\b(?:ends|end points|start and (?:its )?end)\b[^.]*? {_LENGTH}"
        r"(?: apart)?(?= ?[,.]|$)",
        _is_less,
        "a road's ends are no farther apart than it is long",
    ),
)


def _refuse_wrong_arc(plain: str) -> None:
    """An arc is as long as its radius times its angle."""
    radius = re.search(rf"radius (?:of |is )?{_LENGTH}|{_LENGTH} radius", plain)
    angle = re.search(rf"{_N} degrees", plain)
    arc = re.search(rf"\barc\b[^.]*?\b(?<!radius )(?:is|measures|being|of|length) (?:exactly )?{_LENGTH}\b(?! radius)", plain)
    if radius and angle and arc:
        metres = math.radians(float(angle[1])) * float(radius[1] or radius[3]) * _METRES[radius[2] or radius[4]]
        said = float(arc[1]) * _METRES[arc[2]]
        if abs(said - metres) > _OFF * max(said, metres):
            told = f"an arc of {said:.0f} m makes no road: radius and angle make it {metres:.0f} m long"
            raise UnusableInput(told, reason="impossible-map")


def _refuse_apart_and_opposite(plain: str) -> None:
    """Side roads at one place are not so many metres apart."""
    apart = re.search(rf"(?:off ?set|apart|stagger\w*)\b[^.]*?{_LENGTH}|{_LENGTH} (?:apart|off ?set)", plain)
    at_once = re.search(rf"\b{_OPPOSITE}(?: (?:to )?(?:each other|1 another))?", plain)
    denied = at_once is not None and re.search(r"\b(?:not|no|never|rather than|instead of) $", plain[: at_once.start()])
    if apart and at_once and not denied and re.search(r"\bside (?:roads|streets)|staggered|off ?set", plain):
        raise UnusableInput(
            f"{apart.group()!r} and {at_once.group()!r} make no road: what is apart is not at one place", reason="impossible-map"
        )


def refuse_impossible(plain: str) -> None:
    """Raise UnusableInput where a normalised description contradicts itself or geometry."""
    _refuse_wrong_arc(plain)
    _refuse_apart_and_opposite(plain)
    for pattern, reason in _IMPOSSIBLE.items():
        if found := re.search(rf"\b(?:{pattern})", plain):
            raise UnusableInput(f"{found.group()!r} makes no road: {reason}", reason="impossible-map")
    for pattern, wrong, reason in _COMPARED:
        for found in re.finditer(rf"(?<![\d.])\b(?:{pattern})", plain):
            if wrong(*found.groups()):
                raise UnusableInput(f"{found.group()!r} makes no road: {reason}", reason="impossible-map")
