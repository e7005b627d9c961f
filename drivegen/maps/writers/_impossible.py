"""What no road can be, whatever else is said of it."""

import re

from drivegen.errors import UnusableInput

_BENDS = r"(?:bends?|bent|curv(?:e|es|ed|ing|y)|turns?|hairpins?|corners?)\b(?! ?(?:lanes?|pockets?|bays?|signs?))"
_FEW = r"(?:(?!(?:no|not|without|zero|then|later|before|after|never)\b)\w+ ){0,3}?"
_PERFECTLY = r"(?:perfectly|completely|totally|absolutely|entirely|dead|arrow|strictly|exactly|100 %) straight"
_NO_BENDS = rf"(?:without|no|not) (?:a single |any )?{_BENDS}(?: at all)?"
_IMPOSSIBLE = {
    r"minus \d+|(?<![\d.] )(?<![\d.])0 (?:m|km|ft|yd|mile)\b": "numbers must be positive",
    r"same (?:bearing|heading|angle|compass direction)": "roads that meet must lie apart",
    rf"(?:{_PERFECTLY}|straight) (?:hairpin|curve|bend)s?\b": "what is straight has no bends",
    r"(?:arms|legs|roads|approaches|branches) (?:\w+ ){0,5}same direction": "roads that meet must lie apart",
    rf"{_PERFECTLY} {_FEW}(?:that|which|with|and it|but it|yet) {_FEW}{_BENDS}": "what is straight has no bends",
    rf"straight (?:\w+ )?(?:road|street|highway|motorway) (?:that|which) {_FEW}{_BENDS}": "what is straight has no bends",
    rf"{_BENDS} (?:\w+ ){{0,8}}?never (?:bends|turns|curves)\b": "bends are asked for and denied",
    rf"{_NO_BENDS} (?:that|which|but|and) {_FEW}{_BENDS}": "bends are asked for and denied",
}


def refuse_impossible(plain: str) -> None:
    """Raise UnusableInput where a normalised description contradicts itself or geometry."""
    for pattern, reason in _IMPOSSIBLE.items():
        if found := re.search(rf"\b(?:{pattern})", plain):
            raise UnusableInput(f"{found.group()!r} makes no road: {reason}", reason="impossible-map")
