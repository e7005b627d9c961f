"""The values that a form can hold: each slot reads one from tokens and speaks it. Metres, metres per second, degrees, seconds."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from drivegen.words.tokens import Token

KMH, MPH = 1 / 3.6, 0.44704
_SPEEDS = {"kmh": KMH, "mph": MPH, "mps": 1.0}
_LENGTHS = {"m": 1.0, "km": 1000.0, "ft": 0.3048, "yd": 0.9144, "mile": 1609.344}
ORDINALS = ["first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth", "eleventh", "twelfth"]
_NTH = {f"{i}{ending}": i for i in range(1, 13) for ending in ("st", "nd", "rd", "th")}
_NTH |= {word: i for i, word in enumerate(ORDINALS, 1)} | {"last": -1, "final": -1, "middle": 0}
_AROUND = ("east", "north east", "north", "north west", "west", "south west", "south", "south east")
_COMPASS = {name: 45.0 * i for i, name in enumerate(_AROUND)}
_ENDINGS = ("", "ern", "erly")

Match = tuple[Any, int]
"""A value and the token behind it."""


@dataclass(frozen=True)
class Slot:
    """Reads a value at a token, None where there is none; speaks it."""

    read: Callable[[Sequence[Token], int], Match | None]
    speak: Callable[[Any], str]


def number(value: float) -> str:
    """A number as it is spoken: whole where it is, else with as few digits as give it back."""
    if value == int(value) and abs(value) < 1e9:
        return str(int(value))
    short = f"{value:.6g}"
    return short if float(short) == value else repr(value)


def _text(tokens: Sequence[Token], i: int) -> str:
    return tokens[i].text if 0 <= i < len(tokens) else ""


def _value(tokens: Sequence[Token], i: int) -> float | None:
    return tokens[i].value if 0 <= i < len(tokens) and _text(tokens, i - 1) not in ("minus", "-", "negative") else None


def _count(tokens: Sequence[Token], i: int) -> Match | None:
    value = _value(tokens, i)
    if value is not None and value == int(value) and value < 1e6:
        return int(value), i + 1
    counts = {"single": 1, "dual": 2, "double": 2, "twin": 2, "triple": 3}
    return (counts[_text(tokens, i)], i + 1) if _text(tokens, i) in counts else None


def _amount(tokens: Sequence[Token], i: int) -> Match | None:
    counted = _count(tokens, i)
    return (1, i + 1) if counted is None and _text(tokens, i) in ("a", "an", "another") else counted


def _measured(units: dict[str, float], digits: int = 99) -> Callable[[Sequence[Token], int], Match | None]:
    def read(tokens: Sequence[Token], i: int) -> Match | None:
        value = _value(tokens, i)
        if value is None or _text(tokens, i + 1) not in units:
            return None
        factor = units[tokens[i + 1].text]
        return (value if factor == 1.0 else round(value * factor, digits)), i + 2

    return read


def _bare_speed(tokens: Sequence[Token], i: int) -> Match | None:
    value, other = _value(tokens, i), {*_SPEEDS, *_LENGTHS, "lane", "degree", "second"}
    return None if value is None or _text(tokens, i + 1) in other else (value * KMH, i + 1)


def _nth(tokens: Sequence[Token], i: int) -> Match | None:
    word = _text(tokens, i)
    return (_NTH[word], i + 1) if word in _NTH else None


def _compass(tokens: Sequence[Token], i: int) -> Match | None:
    words = [_text(tokens, i), _text(tokens, i + 1)]
    for text, behind in ((" ".join(words), i + 2), (words[0], i + 1)):
        for name, degrees in _COMPASS.items():
            if any(text == name + ending for ending in _ENDINGS):
                return degrees, behind
    return None


def _side(tokens: Sequence[Token], i: int) -> Match | None:
    return (tokens[i].text, i + 1) if _text(tokens, i) in ("left", "right") else None


def _size(tokens: Sequence[Token], i: int) -> Match | None:
    rows, columns = _value(tokens, i), _value(tokens, i + 2)
    if rows is None or columns is None or _text(tokens, i + 1) not in ("x", "by", "times") or rows % 1 or columns % 1:
        return None
    return (int(rows), int(columns)), i + 3


def speak_speed(value: float) -> str:
    """A speed with the unit in which it is a round number, to the bit."""
    for unit, name in ((KMH, "km/h"), (MPH, "mph")):
        for rounded in (round(value / unit), round(value / unit, 1)):
            if rounded * unit == value:
                return f"{number(rounded)} {name}"
    return f"{number(value)} m/s"


SLOTS = {
    "n": Slot(_count, str),
    "a": Slot(_amount, lambda n: "a" if n == 1 else str(n)),
    "speed": Slot(_measured(_SPEEDS), speak_speed),
    "limit": Slot(_bare_speed, speak_speed),
    "length": Slot(_measured(_LENGTHS, 6), lambda metres: f"{number(metres)} m"),
    "angle": Slot(_measured({"degree": 1.0}), lambda degrees: f"{number(degrees)} degrees"),
    "nth": Slot(_nth, lambda n: {-1: "last", 0: "middle"}.get(n) or ORDINALS[n - 1]),
    "compass": Slot(_compass, lambda degrees: next(name for name, d in _COMPASS.items() if math.isclose(d, degrees))),
    "side": Slot(_side, str),
    "size": Slot(_size, lambda pair: f"{pair[0]} by {pair[1]}"),
    "seconds": Slot(_measured({"second": 1.0, "s": 1.0}), lambda seconds: f"{number(seconds)} seconds"),
}
"""By the names that stand in forms."""
