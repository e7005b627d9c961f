"""A description as tokens, phrases and numbers of lanes, with what rules look for around them."""

from collections.abc import Iterator

from drivegen.maps.writers._phrases import Phrase, phrases
from drivegen.maps.writers._quantities import Lanes, lanes_in
from drivegen.maps.writers._tokens import Token, tokens

_BETWEEN = frozenset(["det", "each", "role", "small", "unknown", "one_way", "two_way", "surroundings", "number"])
_IN_ALL = ("in all", "in total", "altogether", "all told", "overall", "in sum")
_FAR = 7


class Sentence:
    """The whole description; `used` are places of tokens that changed the road, `notes` what phrases were taken to mean.

    `aside` are places of measures that are said of what is no road.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        self.tokens: list[Token] = tokens(text)
        self.lanes: list[Lanes] = lanes_in(self.tokens)
        self.phrases: list[Phrase] = phrases(self.tokens, self.lanes)
        self.used: set[int] = set()
        self.notes: list[tuple[int, str, str]] = []
        self.aside: set[int] = set(self._of_noise())
        self._count_behind()

    def _of_noise(self) -> Iterator[int]:
        """Measures of what is no part of the road: "speed humps every 50 m", "bus stops 300 m apart", "a 2 m bicycle lane"."""
        for i in self.of_kind("length"):
            near = self.tokens[max(0, i - 4) : i]
            of_cars = [t.kind == "driving" for t in near]
            told = near and (near[-1].text in ("of", "every") or (near[-1].kind == "is" and of_cars[-2:-1] == [True]))
            if told and any(of_cars):
                yield i  # "lorries of 18 m", "buses stopping every 500 m"
        for phrase in self.phrases:
            if phrase.kind != "noise":
                continue
            yield from (i for i in range(phrase.first, phrase.head) if self.tokens[i].kind == "length")
            for i in range(phrase.head + 1, min(phrase.head + 4, len(self.tokens))):
                if self.tokens[i].kind == "length":
                    yield i
                elif self.tokens[i].kind not in ("prep", "spacing", "unknown", "each", "with", "verb"):
                    break

    def _count_behind(self) -> None:
        """Numbers behind what they count: "T-junctions every 100 m, four of them", "crossings, five in all"."""
        for i in self.of_kind("number"):
            behind = [t.text for t in self.tokens[i + 1 : i + 3]]
            of_them = behind in (["of", "them"], ["of", "these"]) or (self.word(i + 1, "total") and behind[0] in _IN_ALL)
            counted = next((p for p in reversed(self.phrases) if p.head < i and p.number is None), None)
            if not of_them or counted is None or counted.kind not in ("place", "road") or i - counted.head > _FAR:
                continue
            if counted.text.endswith("s") or self.between(counted.head, i, "length"):
                counted.number = self.tokens[i].number
                self.used.update(range(i, i + 1 + (behind[0] == "of")))

    def said(self, kind: str, *values: str) -> Iterator[Phrase]:
        """Phrases of a kind, and of one of the values if any are given, that are not denied."""
        for phrase in self.phrases:
            if phrase.kind == kind and not phrase.negated and (not values or phrase.value in values):
                yield phrase

    def denied(self, kind: str, *values: str) -> Iterator[Phrase]:
        """Phrases that are denied."""
        for phrase in self.phrases:
            if phrase.kind == kind and phrase.negated and (not values or phrase.value in values):
                yield phrase

    def of_kind(self, kind: str, *values: str) -> Iterator[int]:
        """Places of tokens of a kind."""
        for i, token in enumerate(self.tokens):
            if token.kind == kind and (not values or token.value in values):
                yield i

    def verbs(self, *values: str) -> Iterator[int]:
        """Places of verbs."""
        return self.of_kind("verb", *values)

    def negated_at(self, i: int) -> bool:
        """Whether a negation stands up to three words before token i in its clause."""
        for token in reversed(self.tokens[max(0, i - 3) : i]):
            if token.kind in ("stop", "comma", "but", "with"):
                return False
            if token.kind == "neg":
                return True
        return False

    def last_before(self, i: int, *kinds: str, same_sentence: bool = True) -> Phrase | None:
        """The last phrase that ends before token i, of one of the kinds, not denied."""
        for phrase in reversed(self.phrases):
            if phrase.head < i and phrase.kind in kinds and not phrase.negated:
                return phrase if not same_sentence or not self.between(phrase.head, i, "stop") else None
        return None

    def next_after(self, i: int, *kinds: str, same_sentence: bool = True) -> Phrase | None:
        """The first phrase that begins at or after token i, of one of the kinds, not denied."""
        for phrase in self.phrases:
            if phrase.first >= i and phrase.kind in kinds and not phrase.negated:
                return phrase if not same_sentence or not self.between(i - 1, phrase.first, "stop") else None
        return None

    def between(self, i: int, j: int, *kinds: str) -> bool:
        """Whether a token of one of the kinds stands between tokens i and j."""
        return any(token.kind in kinds for token in self.tokens[i + 1 : j])

    def governed(self, i: int) -> Phrase | None:
        """The phrase that a preposition right after token i leads to: "two lanes ON the main road"."""
        j = i + 1
        if j >= len(self.tokens) or self.tokens[j].kind != "prep" or self.tokens[j].value not in ("on", "of"):
            return None
        j += 1
        while j < len(self.tokens):
            for phrase in self.phrases:
                if phrase.first <= j <= phrase.head:
                    return None if phrase.negated else phrase
            if self.tokens[j].kind not in _BETWEEN:
                return None
            j += 1
        return None

    def clause(self, i: int) -> int:
        """Where the clause of token i begins."""
        while i > 0 and self.tokens[i - 1].kind not in ("stop", "comma", "and", "but"):
            i -= 1
        return i

    def word(self, i: int, kind: str) -> bool:
        """Whether token i is there and of the kind."""
        return 0 <= i < len(self.tokens) and self.tokens[i].kind == kind

    def use(self, first: int, last: int, meaning: str) -> None:
        """Note that tokens first to last changed the road, and what they mean; an empty meaning notes nothing."""
        self.used.update(range(first, last + 1))
        if meaning:
            self.notes.append((first, " ".join(t.text for t in self.tokens[first : last + 1]).strip(" ,."), meaning))

    def understood(self) -> tuple[tuple[str, str], ...]:
        """Phrases and their meanings in the order of the text, none twice."""
        return tuple(dict.fromkeys((phrase, meaning) for _, phrase, meaning in sorted(self.notes)))
