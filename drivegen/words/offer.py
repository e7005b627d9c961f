"""The nearest sentence that would be drawn, for a text that is declined."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, combinations, islice, takewhile, zip_longest

from drivegen.words.choices import Choices
from drivegen.words.cover import Cover, Item
from drivegen.words.read import SAME, Words, best, covers_of, grammar, meaning
from drivegen.words.saying import Sentence, say
from drivegen.words.table import WORD, table, words
from drivegen.words.things import Unfit
from drivegen.words.tokens import Token, tokenise
from drivegen.words.traffic import request_sentences

EXAMPLES = (
    "a four-way crossing with traffic lights, two lanes in each direction and left-turn lanes, 50 km/h",
    "a T-junction where a one-lane side road meets a main road with two lanes in each direction",
    "a Y-junction of three country roads",
    "a roundabout with four arms, 40 m in diameter",
    "a road with three crossings 200 m apart, all signalised",
    "a straight road, 600 m long, one lane in each direction, 80 km/h",
    "a road that turns 90 degrees to the left",
    "a mountain road with a hairpin bend, 40 km/h",
    "a residential street with three side streets, 30 km/h",
    "a dead end of 150 m",
    "a 3 by 3 grid of streets 120 m apart",
    "a motorway with three lanes in each direction, 120 km/h, with an on-ramp and an off-ramp 500 m later",
    "a motorway where four lanes narrow to three",
    "a motorway with a weaving section of 300 m",
    "a fork of three lanes, two lanes to the left and one to the right",
    "a diamond interchange",
    "a cloverleaf",
    "a one-way street with two lanes crosses a one-way street with one lane",
    "a road with ten cars and two trucks, one of them cutting in",
    "a road with dense traffic",
)
"""One description of each kind of road, and of traffic; all of them are read."""

_TRIES, _COVERS, _LOOKED_AT = 160, 4, 2000
"""Variants that are tried, covers that they are of, and ways to leave something out of each of which those are the nearest."""

_STREET, _CROSSING = (next(p for p in table("roads") if p.name == name and not p.facts) for name in ("street", "crossing"))
_LIGHTS = next(phrase for phrase in table("roads") if phrase.name == "control" and phrase.value == "signals")
_EACH = next(phrase for phrase in table("roads") if phrase.name == "lanes_each")
_STOPS = frozenset({",", ".", "(", ":", "and"})


@dataclass(frozen=True)
class Offer:
    """A sentence that is drawn, and what the text says that it does not hold."""

    sentence: str
    left_out: tuple[str, ...]


def offered(tokens: Sequence[Token], covers: Sequence[Cover], choices: Choices) -> Offer:
    """The sentence for what can be read of one of the covers; the most alike example where that is nothing."""
    tries = [_variants(_clear(cover.items)) for cover in covers[:_COVERS] if cover.cost <= covers[0].cost + SAME]
    for variants in zip_longest(*tries, fillvalue=()):
        for items in chain(*variants):
            try:
                words = meaning(items, choices)
            except Unfit:
                continue
            if (words.road is not None or words.traffic) and (sentence := _shortest(words, items, choices)):
                return Offer(sentence, _left_out(covers[0], {i for item in items for i in range(item.start, item.end)}, sentence))
    return Offer(_alike(tokens), _left_out(covers[0], set(), _alike(tokens)))


def _left_out(cover: Cover, held: set[int], sentence: str) -> tuple[str, ...]:
    """What is said by tokens that are not `held`, and not by the sentence otherwise."""
    said = {(item.phrase.name, item.value) for item in covers_of(tokenise(sentence))[0].items}
    items = [item for item in cover.items if item.phrase is not WORD and item.phrase.kind != "cannot"]
    return tuple(item.raw for item in items if item.start not in held and (item.phrase.name, item.value) not in said)


def _clear(items: Sequence[Item]) -> list[Item]:
    """What can be read, without what stands beside an unread word that turns its meaning: "no", "only", a side, a number."""
    gone: set[int] = set()
    for i, item in enumerate(items):
        number = item.raw[:1].isdigit() or item.text == "#"
        if item.phrase.kind == "cannot" or (item.unread and (number or item.text in words("turning"))):
            gone |= {i - 1} if i and item.unread and items[i - 1].phrase.kind == "fact" else set()
            gone |= set() if item.unread else set(takewhile(lambda j: _leads(items[j]), range(i - 1, -1, -1)))
            gone |= set(takewhile(lambda j: items[j].text not in _STOPS, range(i, len(items))))
    return [item for i, item in enumerate(items) if i not in gone and not item.unread]


def _variants(items: Sequence[Item]) -> Iterator[list[Sequence[Item]]]:
    """As it is, with lanes counted otherwise, with a street where no road is named; with one or two items less, fewest first."""
    spoken = [i for i, item in enumerate(items) if item.phrase is not WORD]
    front = Item(_STREET, (), -1, -1, "road", "road")
    sets = chain.from_iterable(combinations(spoken[::-1], number) for number in range(3))
    less = (_gone(items, left_out) for left_out in islice(sets, _LOOKED_AT))
    for gone in sorted((gone for gone in less if not gone.issuperset(spoken)), key=len)[: _TRIES // _COVERS]:
        kept = [item for i, item in enumerate(items) if i not in gone]
        yield [kept, _counted(kept), [front, *_counted(kept)], _with_lights(kept)]


def _gone(items: Sequence[Item], left_out: Sequence[int]) -> set[int]:
    """Items that are left out by their places, and what would then be said of another noun than the one that is."""
    gone = set(left_out)
    for i in left_out:
        if _is_noun(items, i):
            gone |= {j for j in takewhile(lambda j: _leads(items[j]), range(i - 1, -1, -1)) if items[j].phrase is not WORD}
            gone |= {j for j in takewhile(lambda j: _follows(items[j]), range(i + 1, len(items))) if items[j].phrase is not WORD}
    return gone


def _is_noun(items: Sequence[Item], i: int) -> bool:
    """Whether the item i is a noun, or a number that stands for one: "and one turns left"."""
    behind = next((item.phrase.kind for item in items[i + 1 :] if item.phrase.kind != "fact"), "")
    return items[i].phrase.kind == "thing" or (items[i].phrase.name == "count" and behind != "thing")


def _leads(item: Item) -> bool:
    """Whether an item right before a noun is said of it, or of somebody as seen from it: "a 300 m long tunnel"."""
    return item.phrase.kind == "fact" or (item.phrase is WORD and item.text in words("determiners"))


def _follows(item: Item) -> bool:
    return item.phrase.kind == "fact" or (item.phrase is WORD and item.text not in (",", ".", "(", ":"))


def _with_lights(items: Sequence[Item]) -> list[Item]:
    """The crossing with traffic lights, another one where none is named, for those who stand at one."""
    if not any(item.phrase.name == "at_light" for item in items):
        return []
    lights, crossing = (Item(phrase, (), -1, -1, "", phrase.name) for phrase in (_LIGHTS, _CROSSING))
    there = next((i for i, item in enumerate(items) if item.phrase.name == "crossing"), None)
    if there is None:
        return [crossing, lights, Item(WORD, (), -1, -1, ".", "."), *items]
    return [*items[: there + 1], lights, *items[there + 1 :]]


def _counted(items: Sequence[Item]) -> list[Item]:
    """Lanes in each direction: half of an even number of four or more, which most who say it mean for both."""

    def counted(item: Item) -> Item:
        phrase = item.phrase
        if phrase.name not in ("lanes", "lane_road"):
            return item
        both = item.value >= 4 and item.value % 2 == 0
        return replace(item, phrase=replace(_EACH, place=phrase.place), values=(item.value // 2,) if both else item.values)

    return [counted(item) for item in items]


def _shortest(words: Words, items: Sequence[Item], choices: Choices) -> str:
    """Sentences for these words without what they would have anyway and the items do not state; "" where none reads the same."""
    road = say(words.road) if words.road is not None and words.road.road.kind != "graph" else []
    traffic = request_sentences(words.traffic)
    phrases = [(item.phrase, item.values) for item in items if item.phrase is not WORD]
    stated = {name for phrase, _ in phrases for name in (phrase.name, *phrase.facts)}
    stated |= {str(value) for phrase, values in phrases for value in (*values, phrase.value) if value not in (None, True)}
    if not _same(_joined(road, traffic), words, choices):
        return ""
    for number in range(len(road) - 1, -1, -1):
        for fact in range(len(road[number].facts) - 1, -1, -1):
            facts = road[number].facts
            shorter = [*road[:number], replace(road[number], facts=(*facts[:fact], *facts[fact + 1 :])), *road[number + 1 :]]
            name, value = facts[fact]
            open_to_all = stated.isdisjoint((name, *map(str, value if isinstance(value, tuple) else (value,))))
            if open_to_all and _same(_joined(shorter, traffic), words, choices):
                road = shorter
    return _joined(road, traffic)


def _joined(road: Sequence[Sentence], traffic: Sequence[str]) -> str:
    kept = [str(sentence) for i, sentence in enumerate(road) if sentence.facts or i == 0]
    return " ".join([*kept, *traffic])


def _same(text: str, words: Words, choices: Choices) -> bool:
    return best(covers_of(tokenise(text)), choices)[0] == words


def _alike(tokens: Sequence[Token]) -> str:
    """The example that shares most words with the text, a straight road where none shares any."""
    keys = {token.key for token in tokens}
    return max(EXAMPLES, key=lambda example: (len(keys & _rare(example)), "straight" in example, -len(example)))


def _rare(text: str) -> set[str]:
    return {token.key for token in tokenise(text) if token.text not in grammar().silent and len(token.text) > 1}
