"""The words of roads, as they stand in `lexicon.txt`: what kind of token each is, whatever the sentence around it."""

import re
from functools import cache
from importlib.resources import files

Term = tuple[str, str, re.Pattern[str]]


@cache
def terms() -> tuple[Term, ...]:
    """(kind, value, pattern) in the order of the file; a pattern matches from a given place up to the end of a word."""
    macros: dict[str, str] = {}
    found: list[Term] = []
    text = (files("drivegen.maps.writers") / "lexicon.txt").read_text(encoding="utf-8")
    for line in text.splitlines():
        head, equals, pattern = line.partition(" = ")
        if not equals or line.startswith("#"):
            continue
        kind, _, value = head.partition(" ")
        pattern = re.sub(r"\{([a-z]+)\}", lambda m: macros[m[1]], pattern)
        if kind == "define":
            macros[value] = pattern
        else:
            found.append((kind, "" if value == "-" else value, re.compile(rf"(?:{pattern})(?!\w)")))
    return tuple(found)


def longest(words: dict[str, str]) -> list[str]:
    """Words, longest first, so that none is found inside another."""
    return sorted(words, key=lambda word: (-len(word), word))
