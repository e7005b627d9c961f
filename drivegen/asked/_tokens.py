"""A normalised description cut into tokens: one word or phrase of the lexicon each, with its tag."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache

from drivegen.asked._lexicon import LEXICON, LONGEST

UNKNOWN = "WORD"
USED = "USED"
"""Tags of a word that the lexicon does not know, and of one that a chunk has."""


@dataclass(frozen=True)
class Token:
    """Words `text[begin:end]` with their tag; `value` is what the lexicon says of them, a number's value for NUM."""

    words: str
    tag: str
    value: object
    begin: int
    end: int


def tokens(text: str) -> list[Token]:
    """All tokens of `text`, in order."""
    words = [(m.group(), m.start(), m.end()) for m in re.finditer(r"[0-9]+(?:\.[0-9]+)?|[^\W\d_]+|[.,]|\S", text)]
    found: list[Token] = []
    at = 0
    while at < len(words):
        token, length = _token(words[at : at + LONGEST])
        found.append(token)
        at += length
    return [_in_context(found, i) for i in range(len(found))]


def _token(words: Sequence[tuple[str, int, int]]) -> tuple[Token, int]:
    for length in range(len(words), 0, -1):
        phrase = tuple(word for word, _, _ in words[:length])
        if phrase in LEXICON:
            tag, value = LEXICON[phrase]
            return Token(" ".join(phrase), tag, value, words[0][1], words[length - 1][2]), length
    word, begin, end = words[0]
    if re.match("[0-9]", word):
        return Token(word, "NUM", float(word), begin, end), 1
    return Token(word, {",": "COMMA", ".": "DOT", "x": "X"}.get(word, UNKNOWN), "", begin, end), 1


def _in_context(found: Sequence[Token], at: int) -> Token:
    """A token whose tag depends on its neighbours."""
    token = found[at]
    before = found[at - 1].tag if at else ""
    after = found[at + 1].tag if at + 1 < len(found) else ""
    if token.tag == "SECOND" and before != "NUM":
        return replace(token, tag="BE" if token.words == "s" else "ORD")
    if token.words == "crossing" and after not in ("OUR", "TARGET"):
        noun = before in ("DET", "NUM", UNKNOWN, "ORD") and after not in ("KIND", "NUM")
        return replace(token, tag="JUNCTION" if noun else "COME")
    if token.words == "1" and before == "SIDE":
        return replace(token, tag="LANE")  # "the right one"
    if token.words == "have" and before == "TARGET":
        return replace(token, tag="BE")
    if token.tag == "SIDEROAD" and before in ("", "DET", "COMMA", "DOT", "NUM", UNKNOWN) and "side" not in token.words:
        return replace(token, tag="ROAD")
    return token


class Tags:
    """The tags of all tokens as one string that grammar rules are matched on."""

    def __init__(self, found: Sequence[Token]) -> None:
        self.tokens = list(found)
        self._tags = [token.tag for token in found]

    def find(self, rule: str) -> Iterator[tuple[int, int]]:
        """Tokens [i, j) that match the rule, such as "DET? SIDE LANE"; later matches see the tags that are then left."""
        at = 0
        while True:
            string = "".join(f"{tag} " for tag in self._tags[at:])
            match = _compiled(rule).search(string)
            if match is None or match.end() == match.start():
                return
            first = at + string[: match.start()].count(" ")
            last = first + match.group().count(" ")
            yield first, last
            at = first + 1

    def at(self, rule: str, begin: int) -> int | None:
        """Where a match of the rule that begins at token `begin` ends."""
        match = _compiled(rule).match("".join(f"{tag} " for tag in self._tags[begin : begin + 12]))
        return None if match is None else begin + match.group().count(" ")

    def tag(self, at: int) -> str:
        """The tag of a token; "" outside."""
        return self._tags[at] if 0 <= at < len(self._tags) else ""

    def mark(self, begin: int, end: int, tag: str = USED) -> None:
        """Tokens [begin, end) belong to a chunk: the first is tagged `tag` now, the others USED."""
        self._tags[begin:end] = [tag, *[USED] * (end - begin - 1)]

    def value(self, begin: int, end: int, tag: str) -> object:
        """Of the first token in [begin, end) that the lexicon tagged so; None where there is none."""
        return next((token.value for token in self.tokens[begin:end] if token.tag == tag), None)

    def words(self, begin: int, end: int) -> str:
        """Tokens [begin, end) as text."""
        return " ".join(token.words for token in self.tokens[begin:end])


@cache
def _compiled(rule: str) -> re.Pattern[str]:
    named = re.sub(r"[A-Z]+", lambda m: f"(?:{m.group()}~)", rule)
    return re.compile(r"(?:(?<= )|^)" + re.sub(r"\s+", "", named).replace("~", " "))
