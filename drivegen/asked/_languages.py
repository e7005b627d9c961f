"""Which clauses of a German or Chinese text are about traffic, and those in English words; grammar is left to the reader.

The reader gives what is said in a clause to the vehicle of that clause in whatever order, so that a translation word by word
will do, once verbs in two parts are put together.
"""

import re

from drivegen.asked import _chinese, _german

_ROAD = re.compile(
    r"限速|车道数|路口|环岛|匝道|高速|kreuzung|kreisverkehr|kreisel|stra(?:ß|ss)e|ampel|tempo|\bspur|fahrstreifen", re.IGNORECASE
)
_CLAUSES = re.compile(r"((?<!\d)[,.](?!\d)|(?<=\d)[,.](?= |$)|[;:\n，。；：、！？!?])")


def vehicle_clauses(text: str) -> tuple[str, str]:
    """The clauses that may be about traffic, in English, and the others as they are; an English text is one clause."""
    language = _chinese if _chinese.SIGN.search(text) else _german if _german.SIGN.search(text.lower()) else None
    if language is None:
        return text, ""
    about: list[str] = []
    others: list[str] = []
    for clause, end in _cut(text):
        mine = language.TRAFFIC.search(clause.lower())
        if mine and (language.VEHICLE.search(clause.lower()) or not _ROAD.search(clause)):
            about.append(language.in_english(clause) + (" . " if end in ".。！!？?" else " , "))
        else:
            others.append(clause)
    if not about:
        return "", text
    return "".join(about).rstrip(" ,."), ", ".join(others)


def _cut(text: str) -> list[tuple[str, str]]:
    """Clauses with the mark that ends each."""
    parts = [*_CLAUSES.split(text), ","]
    return [(clause.strip(), end) for clause, end in zip(parts[::2], parts[1::2], strict=False) if clause.strip()]
