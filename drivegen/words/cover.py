"""The covers of a text: every token in a phrase or on the list of words that say nothing, found by dynamic programming."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any

from drivegen.words.forms import Pattern, first_words, match, stemmed
from drivegen.words.slots import ORDINALS, SLOTS
from drivegen.words.table import WORD, Phrase, words
from drivegen.words.tokens import Token, stem, stems

UNREAD = 50.0
"""What a token costs that nothing reads: any cover without is better."""

_PHRASE, _SLOT, _SILENT, _BEHIND = 1.0, 0.02, 0.3, 0.03
_CLOSE = 0.65
"""Covers that cost so much more than the best are looked at where the best makes no sense."""

_MOST = 60
_COUNTED = stems("way lane arm leg armed legged road street")
"""Words behind a number that is part of an adjective: "two one-way streets"."""

_BEFORE_NUMBERS = ("queue", "place", "size", "skew", "undivided", "arterial")
_BENDS = stems("bend curve corner")
_ORDINALS = stems(" ".join((*ORDINALS, "last", "final")))
_STOPS = stems(", . ( : and with at on in of for to from that where which is are has per each") | {""}


@dataclass(frozen=True)
class Item:
    """A stretch of the text: a phrase with the values of its slots, or one word without (`phrase` is WORD)."""

    phrase: Phrase
    values: tuple[Any, ...]
    start: int
    end: int
    text: str
    raw: str
    unread: bool = False

    @property
    def value(self) -> Any:
        """Of a phrase: its own, or that of its slots, a tuple where there are several."""
        if not self.values:
            return self.phrase.value
        return self.values[0] if len(self.values) == 1 else self.values


@dataclass(frozen=True)
class Cover:
    """Items from the first token to the last, what they cost, and a number for the phrases among them."""

    items: tuple[Item, ...]
    cost: float
    reading: int = 0

    @property
    def unread(self) -> list[str]:
        """The words that nothing reads."""
        return [item.raw for item in self.items if item.unread]


class Grammar:
    """A table of phrases, ready to be looked for in texts."""

    def __init__(self, phrases: Iterable[Phrase], silent: frozenset[str]) -> None:
        self.phrases, self.silent = tuple(phrases), frozenset(map(stem, silent))
        self._by_first: defaultdict[str, list[tuple[Phrase, Pattern]]] = defaultdict(list)
        for phrase in self.phrases:
            for pattern in map(stemmed, phrase.forms):
                for first in first_words(pattern)[0]:
                    self._by_first[first].append((phrase, pattern))

    def covers(self, tokens: Sequence[Token]) -> list[Cover]:
        """The best covers, cheapest first; all have unread words or none has."""
        best: list[list[Cover]] = [[Cover((), 0.0)], *([] for _ in tokens)]
        readings: dict[tuple[Any, ...], int] = {}
        for i, token in enumerate(tokens):
            for item, cost in [*self._said(tokens, i), self._alone(token, i)]:
                for cover in best[i]:
                    reading = cover.reading
                    if item.phrase is not WORD or item.unread:
                        reading = readings.setdefault(
                            (reading, item.phrase, item.values, item.raw if item.unread else ""), len(readings) + 1
                        )
                    best[item.end].append(Cover((*cover.items, item), cover.cost + cost, reading))
            best[i + 1] = _few(best[i + 1])
        return _few(best[-1])

    def _alone(self, token: Token, i: int) -> tuple[Item, float]:
        unread = token.text not in self.silent and token.text not in (",", ".", "(", ":")
        return Item(WORD, (), i, i + 1, token.text, token.raw, unread), UNREAD if unread else _SILENT

    def _said(self, tokens: Sequence[Token], i: int) -> Iterable[tuple[Item, float]]:
        matches: dict[tuple[Phrase, tuple[Any, ...], int], None] = {}
        firsts = [tokens[i].key, *(f"{{{name}}}" for name, slot in SLOTS.items() if slot.read(tokens, i) is not None)]
        for phrase, pattern in chain.from_iterable(self._by_first.get(first, ()) for first in firsts):
            for values, end in match(pattern, tokens, i):
                if end > i and _fits(phrase, tokens, end) and not _names(phrase, tokens, i):
                    matches[phrase, values, end] = None
        for phrase, values, end in matches:
            raw = " ".join(token.raw for token in tokens[i:end])
            late = phrase.name == "member" or (phrase.place == "post" and tokens[end - 1].raw == "lane")
            cost = _PHRASE + _SLOT * len(values) + (_BEHIND if late else 0.0)
            yield Item(phrase, values, i, end, tokens[end - 1].text, raw), cost


def _names(phrase: Phrase, tokens: Sequence[Token], i: int) -> bool:
    """Whether a thing is named where `phrase` would have somebody do something: "every crossing", "with bends to the left"."""
    before = tokens[i - 1].text if i else ""
    if phrase.name in ("turn_to", "turn_angle"):
        return tokens[i].plural and tokens[i].text in _BENDS and before in words("qualities")
    return phrase.kind == "link" and (tokens[i].raw.endswith("ings") or before in words("determiners") or before in _ORDINALS)


def _fits(phrase: Phrase, tokens: Sequence[Token], end: int) -> bool:
    """Whether a phrase that must stand before its noun, or must not, can stand there."""
    if phrase.name in ("main", "side", "east_west", "north_south") and phrase.slots and tokens[end - 1].value is not None:
        return end == len(tokens) or tokens[end].text in _STOPS  # "the side road has one", not "has one turn lane"
    if phrase.name == "lights":
        return tokens[end - 1].plural
    last, following = tokens[end - 1], tokens[end].text if end < len(tokens) else ""
    if phrase.name == "member":  # a number alone is some of them only where they do something: "two turning left"
        return following in words("doing") if phrase.slots and last.value is not None else following not in words("moved")
    if phrase.name == "line" and phrase.value in ("curve", "winding") and last.text in _BENDS:
        return bool(phrase.value == "winding") == _several(tokens, end - 1)
    if phrase.name == "bends" and last.text == "turn" and end > 1 and (count := tokens[end - 2].value) is not None:
        return last.plural == (count != 1)  # "two turns"; in "two turn left, one turns right" it is a verb
    road = tokens[end - 2] if phrase.name == "crossing" and end > 1 and _ends_road(tokens[: end - 1]) else None
    if road is not None and (following in ("a", "an", "another") or (road.plural and not last.plural)):
        return False  # "a one-way street crossing another one", "two streets crossing", "three lanes each way crossing a street"
    if phrase.place != "pre":
        return last.text not in ("minor", "major") or following in _STOPS or tokens[end].value is not None
    counted = end + 1 < len(tokens) and tokens[end].value is not None
    counts = counted and phrase.name in ("count", "lane_road") and tokens[end + 1].text in _COUNTED
    before_noun = following not in _STOPS and (not counted or counts or phrase.name in _BEFORE_NUMBERS)
    noun = last.plural and phrase.name != "place"  # in "the ego follows two cars" it is a verb
    return not noun and (before_noun or (following == "," and phrase.name not in ("count", "nth")))


def _several(tokens: Sequence[Token], i: int) -> bool:
    """Whether a plural is meant, "tight bends, 60 km/h", and not what a road does, "a road that bends to the left"."""
    before, following = tokens[i - 1].text if i else "", tokens[i + 1].text if i + 1 < len(tokens) else ""
    does = before in words("subjects") or before.endswith("ly") or following.endswith("ly")
    return tokens[i].plural and not does


def _ends_road(tokens: Sequence[Token]) -> bool:
    """Whether what is said of a road may end here: "street", "lanes each way"."""
    each = len(tokens) > 1 and tokens[-2].text in ("each", "per", "either", "every")
    return tokens[-1].text in ("road", "street", "avenue") or (each and tokens[-1].text in ("way", "direction"))


def _few(covers: list[Cover]) -> list[Cover]:
    """The cheapest covers; one of those that differ only in words that say nothing, inside a phrase or beside it."""
    ordered = sorted(covers, key=lambda cover: cover.cost)
    near: dict[int, Cover] = {}
    for cover in ordered:
        if cover.cost <= ordered[0].cost + _CLOSE:
            near.setdefault(cover.reading, cover)
    return list(near.values())[:_MOST]
