"""What no road can be, where it shows in the words alone: signs of numbers, directions, and comparisons in one breath.

What contradicts another fact, or the road that is built, is found by `_kept.py`.
"""

import re
from collections.abc import Callable

from drivegen.errors import UnusableInput

_ROAD = r"(?:road|street|highway|motorway|freeway|expressway|carriageway|avenue|lane)s?"
_DEAD_END = r"(?:cul de sac|dead end(?: \w+)?|no through road|blind alley)s?"
_PLACE = r"(?:crossings?|intersections?|junctions?|roundabouts?|arms|legs|streets|roads|lanes|ramps|exits)"
_THAT = r"(?:(?:that|which|but|and|yet|,) )*"
_END = r"(?: ?[,.]| at all| whatsoever|$)"
_IMPOSSIBLE = {
    r"minus \d+|(?<![\d.] )(?<![\d.])0 (?:m|km|ft|yd|mile)\b": "numbers must be positive",
    r"half (?:of )?a lane|\d\.\d+ lanes?": "lanes are counted in whole numbers",
    r"same (?:bearing|heading|angle|compass direction)": "roads that meet must lie apart",
    r"(?:arms|legs|roads|approaches|branches) (?:\w+ ){0,5}same direction": "roads that meet must lie apart",
    rf"parallel {_ROAD} {_THAT}(?:cross|intersect|meet)(?= each| 1 another| one another| at| in|{_END})": "parallels never meet",
    rf"straight {_ROAD} (?:that|which) (?:is|forms|makes) an? (?:full )?(?:circle|ring|loop)": "what is straight has no bends",
    rf"{_DEAD_END}\b[^.]*? (?:open|connected|joined|linked)(?: to \w+)? at (?:both|either) ends?": "a dead end has one way out",
    rf"{_DEAD_END}\b[^.]*? (?:both (?:its |of its )?ends\b|either end\b|through traffic)": ("a dead end has one way out"),
    rf"{_DEAD_END} (?:that|which) (?:leads?|runs?|goes|continues) (?:straight |right |on )*(?:through|to)\b": (
        "a dead end has one way out"
    ),
    r"(?:all|every)\b[^.]{0,40}\bone way (?:streets? |roads? )?(?:towards?|into|inwards|away from|out of)": (
        "there must be a way in and a way out"
    ),
}
_N = r"(\d+(?:\.\d+)?)"
_METRES = {"m": 1.0, "km": 1000.0, "ft": 0.3048, "yd": 0.9144, "mile": 1609.344}
_LENGTH = rf"{_N} (m|km|ft|yd|mile)"
_TOO = r"(?:(?:and|but|yet) )?(?:(?:is|it|has|are) )?(?:also|at the same time|simultaneously|likewise)"
_OF_IT = r"(?: (?:is|has|a|an|of|long|length|exactly|the|at|same|time|being|total))*"


def _different(a: str, unit_a: str, b: str, unit_b: str) -> bool:
    first, second = float(a) * _METRES[unit_a], float(b) * _METRES[unit_b]
    return abs(first - second) > 0.05 * max(first, second)


_COMPARED: tuple[tuple[str, Callable[..., bool], str], ...] = (
    (rf"{_LENGTH}(?: apart| long)? {_TOO}{_OF_IT} {_LENGTH}", _different, "lengths differ"),
    (
        rf"{_N} (?:\w+ )?{_PLACE}\b[^.]{{0,60}}? of (?:which|them|these) (?:only )?{_N}(?! (?:m|km|kmh|mph|lanes?|arms?)\b)",
        lambda all_of_them, some: float(some) > float(all_of_them),
        "some are no more than all",
    ),
)


def refuse_impossible(plain: str) -> None:
    """Raise UnusableInput where a normalised description contradicts itself or geometry."""
    for pattern, reason in _IMPOSSIBLE.items():
        if found := re.search(rf"\b(?:{pattern})", plain):
            raise UnusableInput(f"{found.group()!r} makes no road: {reason}", reason="impossible-map")
    for pattern, wrong, reason in _COMPARED:
        for found in re.finditer(rf"(?<![\d.])\b(?:{pattern})", plain):
            if wrong(*found.groups()):
                raise UnusableInput(f"{found.group()!r} makes no road: {reason}", reason="impossible-map")
