"""Tokens of a description: numbers, measures and the words of `lexicon.txt`; what is none of these is unknown."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

from drivegen.maps.writers._lexicon import terms

SPEED_UNITS = {"kmh": 1 / 3.6, "mph": 0.44704, "mps": 1.0}
LENGTH_UNITS = {"m": 1.0, "km": 1000.0, "ft": 0.3048, "yd": 0.9144, "mile": 1609.344}

_N = r"(\d+(?:\.\d+)?)"
_NUMBERS = (
    ("size", re.compile(r"(\d+) ?(?:x|by|times) ?(\d+)(?! ?(?:m|km|ft|yd)\b)")),
    ("size", re.compile(r"(\d+) rows?(?: and| by|,| ,| x| times| of)? ?(\d+) (?:columns?|cols?)\b")),
    ("size", re.compile(r"(\d+) rows? of (\d+)(?= (?:\w+ )?(?:crossings|intersections|junctions)\b)")),
    ("speed", re.compile(rf"{_N} ?(kmh|mph|mps)\b")),
    ("length", re.compile(rf"{_N} ?(m|km|ft|yd|mile)\b")),
    ("angle", re.compile(rf"{_N} ?degrees\b")),
    ("number", re.compile(rf"{_N}\b")),
    ("stop", re.compile(r"[.]")),
    ("comma", re.compile(r"[,()]")),
)
_KEY_WORDS = (
    *("exit", "ramp", "road", "lane"),
    *("intersection", "junction", "crossing", "crossroads", "roundabout", "traffic", "signal", "signals"),
    *("lights", "highway", "motorway", "freeway", "autobahn", "street", "streets", "avenue"),
    *("lanes", "limit", "speed", "direction", "straight", "curve", "hairpin", "residential"),
    *("signalised", "signalized", "uncontrolled", "staggered", "narrows", "widens", "merges", "crosses"),
    *("interchange", "diameter", "radius", "metres", "approach", "approaches", "carriageway", "expressway"),
    *("weaving", "boulevard", "arterial", "controlled", "unsignalised", "entrance", "exits", "ramps"),
    *("branches", "downtown", "priority", "circulating"),
)
_RIGHT_AS_THEY_ARE = frozenset(("interaction", "interactions"))  # near a key word, but another word


@dataclass(frozen=True)
class Token:
    """A term of a description.

    Attributes:
        kind, value: of `lexicon.txt`, or kind "number", "speed" [m/s], "length" [m], "angle" [degrees], "size", "stop",
            "comma", "unknown".
        amount: of a number or measure; a size has two. text: the words themselves.
    """

    kind: str
    value: str
    text: str
    amount: tuple[float, ...] = ()

    @property
    def number(self) -> int:
        """The amount as a count."""
        return round(self.amount[0])


def tokens(text: str) -> list[Token]:
    """The tokens of a normalised description, in order."""
    return list(_scan(_spelled(text)))


def _scan(text: str) -> Iterator[Token]:
    at = 0
    while at < len(text):
        if text[at] == " ":
            at += 1
            continue
        token = _number(text, at) or _term(text, at) or _unknown(text, at)
        yield token
        at += len(token.text)


def _number(text: str, at: int) -> Token | None:
    for kind, pattern in _NUMBERS:
        if match := pattern.match(text, at):
            groups = match.groups()
            unit = {**SPEED_UNITS, **LENGTH_UNITS}[groups[1]] if kind in ("speed", "length") else 1.0
            amount = tuple(float(g) * unit for g in (groups if kind == "size" else groups[:1]))
            if kind in ("number", "angle") and (term := _term(text, at)) and len(term.text) > len(match.group()):
                return term
            return Token(kind, groups[1] if kind in ("speed", "length") else "", match.group(), amount)
    return None


def _term(text: str, at: int) -> Token | None:
    best: Token | None = None
    for kind, value, pattern in terms():
        match = pattern.match(text, at)
        if match and len(match.group().rstrip()) > (len(best.text) if best else 0):
            best = Token(kind, value, match.group().rstrip())
    return best


def _unknown(text: str, at: int) -> Token:
    match = re.compile(r"\S+").match(text, at)
    assert match is not None
    return Token("unknown", "", match.group())


def _spelled(text: str) -> str:
    """The text with likely typing errors in key words mended."""
    return re.sub(r"(?<!\S)[a-z]{5,}(?!\S)", lambda m: _mended(m.group()), text)


@cache
def _mended(word: str) -> str:
    known = _term(word, 0)
    if word in _RIGHT_AS_THEY_ARE or (known is not None and known.text == word):
        return word
    single = re.sub(r"(.)\1", r"\1", word)
    if single in _KEY_WORDS:
        return single
    near = [key for key in _KEY_WORDS if key[0] == word[0] and _distance(word, key) <= (2 if len(word) >= 9 else 1)]
    return near[0] if near and (len(word) >= 6 or sorted(near[0]) == sorted(word)) else word


def _distance(a: str, b: str) -> int:
    """Edits from a to b: letters added, left out, changed, or two neighbours exchanged."""
    if abs(len(a) - len(b)) > 2:
        return 3
    rows = [list(range(len(b) + 1))]
    for i, x in enumerate(a, 1):
        row = [i]
        for j, y in enumerate(b, 1):
            best = min(rows[-1][j] + 1, row[-1] + 1, rows[-1][j - 1] + (x != y))
            if i > 1 and j > 1 and x == b[j - 2] and a[i - 2] == y:
                best = min(best, rows[-2][j - 2] + 1)
            row.append(best)
        rows.append(row)
    return rows[-1][-1]
