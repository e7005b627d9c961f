"""Forms of phrases: words, slots and alternatives, e.g. "({n} lane(s)|{n}) (on|for) each side".

`(a|b)` are alternatives, an empty one leaves them out, `<name>` is one of the macros, `{slot}` a value of `slots.py`. The first
alternative is spoken; "(s)" is a plural there that follows the number before it. Plurals are read everywhere.
"""

import re
from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any

from drivegen.words.slots import SLOTS
from drivegen.words.table import macros
from drivegen.words.tokens import NUMBERS, Token, stem

_PLURALS = ("(s)", "(es)")
_NAMES = {f"={value}": word for word, value in NUMBERS.items()}
_PARTS = re.compile(r"\(s\)|\(es\)|[(|)]|<\w+>|\{\w+\}|[^\s(|){}<>]+")

Part = str | tuple["Pattern", ...]
Pattern = tuple[Part, ...]
"""Words, slots in braces, and alternatives, each of which is a pattern."""


@cache
def parse(form: str) -> Pattern:
    """A form as a pattern, macros put in."""
    while "<" in form:
        form = re.sub(r"<(\w+)>", lambda m: f"({macros()[m[1]]})", form)
    parts = _PARTS.findall(form)
    ways, end = _ways(parts, 0)
    if end != len(parts):
        raise ValueError(f"brackets do not match in {form!r}")
    return ways[0] if len(ways) == 1 else (ways,)


def _ways(parts: Sequence[str], i: int) -> tuple[tuple[Pattern, ...], int]:
    ways: list[list[Part]] = [[]]
    while i < len(parts) and parts[i] != ")":
        if parts[i] == "(":
            inner, i = _ways(parts, i + 1)
            ways[-1].append(inner)
        elif parts[i] == "|":
            ways.append([])
        else:
            ways[-1].append(_key(parts[i]))
        i += 1
    return tuple(tuple(way) for way in ways), i


def _key(part: str) -> str:
    """A number that a form names stands for itself, however it is written."""
    return f"={NUMBERS[part]}" if part in NUMBERS else part


@cache
def stemmed(form: str) -> Pattern:
    """A form as tokens are compared with it."""
    return _stemmed(parse(form))


def _stemmed(pattern: Pattern) -> Pattern:
    parts: list[Part] = []
    for part in pattern:
        if isinstance(part, tuple):
            parts.append(tuple(map(_stemmed, part)))
        elif part.startswith(("{", "=", "(")):
            parts.append(part)
        else:
            parts += map(stem, re.sub(r"\b(on|off)-ramp", r"\1ramp", part.lower()).replace("-", " ").split())
    return tuple(parts)


def match(pattern: Pattern, tokens: Sequence[Token], i: int) -> Iterator[tuple[tuple[Any, ...], int]]:
    """All ways in which the pattern is said from token i on: the values of its slots, and the token behind it."""
    if not pattern:
        yield (), i
        return
    part, rest = pattern[0], pattern[1:]
    if isinstance(part, tuple):
        key = tokens[i].key if i < len(tokens) else ""
        for way in part:
            if way and isinstance(way[0], str) and way[0] != key and way[0][0] not in "{(":
                continue  # most ways end at their first word
            for values, end in match(way, tokens, i):
                yield from ((values + more, last) for more, last in match(rest, tokens, end))
    elif part in _PLURALS:
        yield from match(rest, tokens, i)
    elif part.startswith("{"):
        if (slot := SLOTS[part.strip("{}")].read(tokens, i)) is not None:
            yield from (((slot[0], *more), last) for more, last in match(rest, tokens, slot[1]))
    elif i < len(tokens) and part == tokens[i].key:
        yield from match(rest, tokens, i + 1)


def first_words(pattern: Pattern) -> tuple[frozenset[str], bool]:
    """The words and slots with which the pattern can begin, and whether it can be empty."""
    firsts: frozenset[str] = frozenset()
    for part in pattern:
        if isinstance(part, tuple):
            ways = [first_words(way) for way in part]
            firsts = firsts.union(*(words for words, _ in ways))
            if not any(empty for _, empty in ways):
                return firsts, False
        elif part not in _PLURALS:
            return firsts | {part}, False
    return firsts, True


def _first_way(pattern: Pattern) -> Iterator[str]:
    for part in pattern:
        if isinstance(part, tuple):
            yield from _first_way(part[0])
        else:
            yield part


def speak(form: str, values: Sequence[Any]) -> str:
    """The first way to say the form, with these values in its slots; plurals follow the last number before them."""
    left, words, plural = list(values), list[str](), True
    for part in _first_way(parse(form)):
        if part in _PLURALS:
            words[-1] += part.strip("()") if plural else ""
        elif part.startswith("{"):
            value = left.pop(0)
            plural = value != 1
            words.append(SLOTS[part.strip("{}")].speak(value))
        elif part == "," and words:
            words[-1] += ","
        else:
            words.append(_NAMES.get(part, part))
    return " ".join(words)
