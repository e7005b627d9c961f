"""Turns of phrase that say in a roundabout way what the rules know by a shorter one, in a normalised description.

They stand in `wordings.txt`, a family a line: what is said sideways (denials behind the noun, places told by marks, roads by
their names) is put as the rules read it, and remarks on what was, or what a map is for, are left out.
"""

import re
from functools import cache
from importlib.resources import files

_LISTED = re.compile(r"(?<=\bat )((?:\d+(?:\.\d+)? ?(?:, |and |, and ))+)(\d+(?:\.\d+)?) (m|km|ft|mile)\b")
_NUMBERED = re.compile(r"\b(the [AB]\d{2,4})\b(?! ?(?:road|motorway|autobahn))")
_NO_NAMES = "One|Two|Three|Four|Five|Six|Single|Double|Dual|Each|Every|Multi|Per|The|Third|Extra|Country"
_LANES = "Bus|Bike|Turn|Left|Right|Acceleration|Deceleration|Auxiliary|Through|Exit|Drop"
_OTHER_MEASURES = re.compile(
    r"\b\d{1,2}:\d{2}\b(?: ?(?:a\.?m\.?|p\.?m\.?|h|o'clock))?|\baged? \d+(?: (?:to|and) \d+)?|"
    r"(?<!\w)-?\d+(?:\.\d+)? ?(?:°|degrees?) ?(?:C|F|Celsius|Fahrenheit|celsius)\b"
)
_NAMED = re.compile(rf"\b(?!(?:{_NO_NAMES}|{_LANES})\b)([A-Z][a-z]+) Lane\b")


def reworded(plain: str) -> str:
    """A normalised description with its turns of phrase put shortly."""
    for pattern, words in _wordings():
        plain = re.sub(" +", " ", pattern.sub(words, plain))
    plain = _LISTED.sub(_with_unit, plain)
    return re.sub(r"\s+", " ", plain).strip(" ,")


def without_names(text: str) -> str:
    """A description without times of day, ages and temperatures, in which named lanes ("Mill Lane") and numbered roads ("the
    B480") are called roads.
    """
    text = _OTHER_MEASURES.sub(" ", text)
    return _NAMED.sub(r"\1 Road", _NUMBERED.sub(r"\1 road", text))


@cache
def _wordings() -> tuple[tuple[re.Pattern[str], str], ...]:
    """(pattern, words instead) in the order of the file."""
    macros: dict[str, str] = {}
    found: list[tuple[re.Pattern[str], str]] = []
    for line in (files("drivegen.maps.writers") / "wordings.txt").read_text(encoding="utf-8").splitlines():
        name, defined, macro = line.partition(" = ")
        if defined and name.startswith("define "):
            macros[name.removeprefix("define ")] = _filled(macro, macros)
        elif "=>" in line and not line.startswith("#"):
            pattern, _, words = line.partition("=>")
            found.append((re.compile(_filled(pattern.removesuffix(" "), macros)), f" {words.strip()} "))
    return tuple(found)


def _filled(pattern: str, macros: dict[str, str]) -> str:
    return re.sub(r"\{([a-z]+)\}", lambda m: macros[m[1]], pattern)


def _with_unit(match: re.Match[str]) -> str:
    """ "At 300, 600 and 900 m" with the unit behind each number."""
    return re.sub(r"(\d+(?:\.\d+)?)", rf"\1 {match[3]}", f"{match[1]}{match[2]}")
