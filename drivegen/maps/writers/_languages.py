"""German and Chinese descriptions, word by word in English, for the rules to read.

No grammar: phrases are replaced, longest first, and what has no entry stays as it is and is listed as ignored.
"""

import re

from drivegen.maps.writers._chinese import from_chinese
from drivegen.maps.writers._german import GERMAN_NUMBERS, GERMAN_WORDS, from_german

_GERMAN = re.compile(
    r"\b(?:ein|eine|einer|eines|einem|mit|ohne|und|kein|keine|der|die|das|zwei|drei|je|pro|kreuzung|kreisverkehr|straße|ampel)\b"
)
_CHINESE = re.compile(r"[一-鿿]")
_ENGLISH_TOO = frozenset(
    ("die", "des", "den", "tempo", "lang", "von", "auf", "raster", "radius", "ring", "alle", "an", "links", "im")
)
_ONLY_GERMAN = (frozenset(GERMAN_WORDS) | frozenset(GERMAN_NUMBERS)) - _ENGLISH_TOO


def in_english(text: str) -> str:
    """`text` with German or Chinese words replaced; an English text comes back as it is."""
    if _CHINESE.search(text):
        return from_chinese(text)
    lower = text.lower()
    if (
        len(_GERMAN.findall(lower)) >= 2
        or len(set(re.findall(r"\w+", lower)) & _ONLY_GERMAN) >= 2
        or re.search(
            r"[äöüß]|(?:kreuzung|kreisverkehr|kreisel|sackgasse|straße|autobahn\w+|\w+kurven?|fahrstreifen|fahrspur(?:en)?|\w+spurige?r?|einbahn\w+)\b",
            lower,
        )
    ):
        return from_german(lower)
    return text
