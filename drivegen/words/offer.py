"""The nearest sentence that would be drawn, for a text that is declined."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

from drivegen.words.choices import Choices
from drivegen.words.cover import Cover, Item
from drivegen.words.phrase import Phrase
from drivegen.words.read import Words, best, covers_of, grammar, meaning
from drivegen.words.saying import Sentence, say
from drivegen.words.scene import Unfit
from drivegen.words.table import table
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

_TRIES = 160
_STREET = next(phrase for phrase in table("roads") if phrase.name == "street")
_CROSSING = next(phrase for phrase in table("roads") if phrase.name == "crossing" and not phrase.facts)
_LIGHTS = next(phrase for phrase in table("roads") if phrase.name == "control" and phrase.value == "signals")
_EACH = next(phrase for phrase in table("roads") if phrase.name == "lanes_each")


@dataclass(frozen=True)
class Offer:
    """A sentence that is drawn, and what the text says that it does not hold."""

    sentence: str
    left_out: tuple[str, ...]


def offered(tokens: Sequence[Token], cover: Cover, choices: Choices) -> Offer:
    """The sentence for what can be read of a cover; the most alike example where that is nothing."""
    items = [i for i in cover.items if not i.unread and (i.phrase is None or i.phrase.kind != "cannot")]
    if any(item.phrase is not None for item in items):
        for left_out, kept in _variants(items):
            try:
                words = meaning(kept, choices)
            except Unfit:
                continue
            if (words.road is not None or words.traffic) and (sentence := _shortest(words, choices)):
                return Offer(sentence, tuple(item.raw for item in left_out))
    return Offer(_alike(tokens), tuple(item.raw for item in items if item.phrase is not None))


def _variants(items: Sequence[Item]) -> Iterator[tuple[tuple[Item, ...], list[Item]]]:
    """What is left out, and the rest: as it is, with lanes counted in each direction, with a street where no road is named."""
    spoken = [item for item in items if item.phrase is not None]
    front = Item(_STREET, (), 0, 0, "road", "road")
    tried = 0
    for number in range(3):
        for left_out in combinations(spoken[::-1], number):
            kept = [item for item in items if item not in left_out]
            for variant in (kept, _in_each_direction(kept), [front, *_in_each_direction(kept)], _with_lights(kept)):
                tried += 1
                yield left_out, variant
            if tried > _TRIES:
                return


def _with_lights(items: Sequence[Item]) -> list[Item]:
    """The crossing with traffic lights, another one where none is named, for those who stand at one."""
    if not any(item.phrase is not None and item.phrase.name == "at_light" for item in items):
        return []
    lights, crossing = (Item(phrase, (), 0, 0, "", phrase.name) for phrase in (_LIGHTS, _CROSSING))
    there = next((i for i, item in enumerate(items) if item.phrase is not None and item.phrase.name == "crossing"), None)
    if there is None:
        return [crossing, lights, Item(None, (), 0, 0, ".", "."), *items]
    return [*items[: there + 1], lights, *items[there + 1 :]]


def _in_each_direction(items: Sequence[Item]) -> list[Item]:
    def each(phrase: Phrase | None) -> Phrase | None:
        return replace(_EACH, place=phrase.place) if phrase is not None and phrase.name in ("lanes", "lane_road") else phrase

    return [replace(item, phrase=each(item.phrase)) for item in items]


def _shortest(words: Words, choices: Choices) -> str:
    """Sentences for these words without what they would have anyway; "" where nothing that is said reads the same."""
    road = say(words.road) if words.road is not None and words.road.road.kind != "graph" else []
    traffic = request_sentences(words.traffic)
    if not _same(_joined(road, traffic), words, choices):
        return ""
    for number in range(len(road) - 1, -1, -1):
        for fact in range(len(road[number].facts) - 1, -1, -1):
            facts = road[number].facts
            shorter = [*road[:number], replace(road[number], facts=(*facts[:fact], *facts[fact + 1 :])), *road[number + 1 :]]
            if _same(_joined(shorter, traffic), words, choices):
                road = shorter
    return _joined(road, traffic)


def _joined(road: Sequence[Sentence], traffic: Sequence[str]) -> str:
    kept = [str(sentence) for i, sentence in enumerate(road) if sentence.facts or i == 0]
    return " ".join([*kept, *traffic])


def _same(text: str, words: Words, choices: Choices) -> bool:
    return best(covers_of(tokenise(text)), choices)[0] == words


def _alike(tokens: Sequence[Token]) -> str:
    """The example that shares most words with the text."""
    said = {token.key for token in tokens}
    return max(EXAMPLES, key=lambda example: (len(said & _rare(example)), -len(example)))


def _rare(text: str) -> set[str]:
    return {token.key for token in tokenise(text) if token.text not in grammar().silent and len(token.text) > 1}
