"""A text as tokens: spelling, numbers in words, hyphens, plurals and units are made alike here, once."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction

_SIGNS = {
    "–": " - ", "—": " - ", "−": "-", "‑": "-", "×": " x ", "°": " degrees ", "→": " to ", "½": " 1/2 ", "¼": " 1/4 ", "’": "'",
    "‘": "'",
}  # fmt: skip
_SHORT = {
    "hwy": "highway", "jct": "junction", "pls": "please", "gimme": "give me", "grey": "gray", "cannot": "can not",
    "m'way": "motorway", "aux": "auxiliary", "unsignaled": "unsignalised",
}  # fmt: skip
_UNITS = (
    (r"\bk\.?m\.? ?/ ?h(?:r|our)?\b|\bkm ?h\b|\bkm?ph\b|\bkmph\b|\bk/h\b|\bk(?:m|ilomet(?:re|er)s?) (?:per|an|a) hour\b", "kmh"),
    (r"\bm\.p\.h\b\.?|\bmi ?/ ?h\b|\bmph\b|\bmiles? (?:per|an) hour\b", "mph"),
    (r"\bm ?/ ?s\b|\bmet(?:re|er)s? (?:per|a) second\b|\bmps\b", "mps"),
    (r"\bkilomet(?:re|er)s?\b|\bkms?\b", "km"),
    (r"\bmet(?:re|er)s?\b|\bmtrs?\b", "m"),
    (r"\bfeet\b|(?<!\bon )\bfoot\b|\bft\b", "ft"),
    (r"\byards?\b|\byds?\b", "yd"),
    (r"\bmiles?\b|\bmi\b", "mile"),
    (r"\bdegrees?\b|\bdegs?\b", "degrees"),
    (r"\bseconds\b|\bsecs?\b", "second"),
)  # fmt: skip
_SPELLING = (
    (r"-+>", " to "),
    (r"^(?:a )?cut[- ]in (?=from the (?:left|right)\b)", "a vehicle cutting in "),
    (r"\b(\w+?)i[sz](ed|ation)\b", r"\1is\2"),
    (r"\bcentre", "center"),
    (r"\b(north|south)(east|west)", r"\1 \2"),
    (r"\bw/o\b", "without"),
    (r"\bw/(?=\s)", "with"),
    (r"\b(i|we|you)'d\b", r"\1 would"),
    (r"\bt(junction|intersection)(s?)\b", r"t \1\2"),
    (r"\bstop-?light(s?)\b", r"stop light\1"),
    (r"\bdia\b\.?", "diameter"),
    (r"\b(can|do|does|is|are|was|has|have|should|must|need|would)n't\b", r"\1 not"),
    (r"\b(\w+)'s?\b", r"\1"),
    (r"\b(cul)[- ]de[- ](sac)", r"\1 de \2"),
    (r"\bround about\b(?! \d)", "roundabout"),
    (r"\b(left|right|slip|side|dual|high|free|motor|express)(ramp|turn|road|street|carriageway)(s?)\b", r"\1 \2\3"),
    (r"\b(on|off)[- ]?ramp(s?)\b", r"\1ramp\2"),
    (r"\bdir\b\.?", "direction"),
    (r"\bhalf an? dozen\b", "6"),
    (r"\b(?:a )?dozen\b", "12"),
    (r"\b(?:an? |one )?(mile|km|kilomet(?:re|er)) and a half\b", r"1.5 \1"),
    (r"\ba (?=lane (?:(?:in|per|for) )?(?:each|either|both|every) (?:way|direction))", "1 "),
    (r"@", " at "),
    (r"^(?:please )?(?:start|begin) with ", ""),
    (r", plus (?=an?\b|\w+ \w)", ", and "),
    (r"\bmade up of\b", "made of"),
    (r"\b(one|two|three|four|five|six|\d) ([\d.]+)[- ]?(?:m|met(?:re|er))[- ](?:wide[- ])?lanes\b", r"\1 lanes, lanes \2 m wide"),
    (r"\br(?:nd|d)?a?bt\b", "roundabout"),
    (r"\btempo (\d+)\b(?! ?k)", r"\1 km/h"),
    (r"\br ?= ?(?=\d)", "radius "),
    (r"\bt'?s\b", "t junctions"),
    (r"\b(i|e)\.(e|g)\.", r"\1\2"),
    (r"\ba (?:couple|pair) of\b|\b(?:couple|pair) of\b", "2"),
    (r"\bhalf[- ](?:of )?(?:an? )?(?=mile|km|kilomet)", "0.5 "),
    (r"\b(road|street|arm|leg|approach|direction)(s?) only\b(?= *(?:[,.;]|$))", r"\1\2"),
    (r"\b(?:passing|passes|running|runs|going|goes) through (?=\d|two|three|four|five|six|seven|eight)", "with "),
    (r"\bout (?=in\b|on\b)", ""),
    (r"\b(?:an? )?quarter[- ](?:of )?(?:an? )?(?=mile|km|kilomet)", "0.25 "),
    (r"\ban? (?=hundred|thousand)", ""),
    (r"\ban? (?=(?:mile|km|kilomet(?:re|er))\b(?! ?/| per))", "1 "),
    (r"\bonly (?=\d|(?:a|one|two|three|four|five|six)\b)", ""),
)
_ONES = [
    "zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve", "thirteen",
    "fourteen", "fifteen", "sixteen", "seventeen", "eighteen", "nineteen",
]  # fmt: skip
_TENS = ["twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety"]
NUMBERS = {word: i for i, word in enumerate(_ONES)} | {word: 10 * i for i, word in enumerate(_TENS, 2)}
NUMBERS |= {"hundred": 100, "thousand": 1000}
_LEXEME = re.compile(
    r"\d+/\d+(?![\w/])|\d{1,3}(?:,\d{3})+(?![\w,])|(?:\d+\.\d+|\d+|\.\d+)(?![\w.]*\d*[a-z]*\d)|[a-z]+(?:'[a-z]+)?|\w+|\S"
)
_ENDS = ".;?!"
_MOST_DIGITS = 40
"""A number of more is no number: it would not fit into a float."""


@dataclass(frozen=True)
class Token:
    """One word, number or mark. `text` is made alike and without a plural's "s", `raw` as it was written."""

    text: str
    raw: str
    value: float | None = None
    plural: bool = False

    @property
    def key(self) -> str:
        """What words of forms are compared with: numbers by their value."""
        return self.text if self.value is None else f"={self.value:g}"


def tokenise(text: str) -> list[Token]:
    """The tokens of a text."""
    text = "".join(_SIGNS.get(sign, sign) for sign in text.lower())
    text = re.sub(r"[\w']+", lambda m: _SHORT.get(m[0], m[0]), text)
    for pattern, spelt in _SPELLING:
        text = re.sub(pattern, spelt, text)
    text = re.sub(r"(?<![\w.,/-])(\d+(?:\.\d+)?)(?=(?:k\.?m|kph|m\.?p|m\b|ft\b|mi\b|yd|kmh|x\d))", r"\1 ", text)
    text = re.sub(r"\b(\d+) ?x ?(?=\d)", r"\1 x ", text)
    text = re.sub(r"(?<=\d),(?=\d{1,2}(?!\d))", ", ", text)
    text = re.sub(r"(?<=[a-z0-9])-(?=[a-z])|(?<=[a-z])-(?=[0-9])|(?<=[a-z])-(?= (?:and|or)\b)", " ", text)
    for pattern, unit in _UNITS:
        text = re.sub(pattern, f" {unit} ", text)
    text = re.sub(r"(?<=[a-z])\.(?=[a-z]\b)|\b(approx|st|ave|vs|incl|max|min|no)\.(?= )", r"\1", text)
    text = re.sub(r"\s-+\s|\n\s*[-*]?\s*\n?", lambda m: " , " if "\n" not in m[0] else " . ", text)
    return list(_joined([_token(lexeme) for lexeme in _LEXEME.findall(text)]))


def _token(lexeme: str) -> Token:
    if len(lexeme) <= _MOST_DIGITS and re.fullmatch(r"[\d.,]*\d|\d+/0*[1-9]\d*", lexeme):
        above, _, below = lexeme.replace(",", "").partition("/")
        return Token("#", lexeme, float(Fraction(above) / int(below or 1)))
    if lexeme in NUMBERS:
        return Token("#", lexeme, float(NUMBERS[lexeme]))
    if lexeme in _ENDS:
        return Token(".", lexeme)
    if lexeme in "()[]":
        return Token("(" if lexeme in "([" else ",", lexeme)
    if lexeme == "&":
        return Token("and", lexeme)
    return Token(stem(lexeme), lexeme, plural=stem(lexeme) != lexeme)


def stems(text: str) -> frozenset[str]:
    """The words of a text, each without the "s" of plurals."""
    return frozenset(map(stem, text.split()))


def stem(word: str) -> str:
    """A word without the "s" of plurals and verbs; forms and tokens are compared so."""
    if len(word) < 4 or not word.endswith("s") or word.endswith("ss"):
        return word
    if word.endswith("ies"):
        return f"{word[:-3]}y"
    return word[:-2] if word.endswith(("shes", "ches", "xes", "sses")) else word[:-1]


def _joined(tokens: list[Token]) -> Iterator[Token]:
    """Numbers of several words as one: "one hundred and twenty", "twenty five"."""
    i = 0
    while i < len(tokens):
        token, i = _spelled(tokens, i) if _is_spelled(tokens[i]) else (tokens[i], i + 1)
        yield token


def _spelled(tokens: list[Token], i: int) -> tuple[Token, int]:
    total, last, raw = 0.0, 1e9, list[str]()
    while i < len(tokens):
        token = tokens[i]
        if token.text == "and" and total >= 100 and i + 1 < len(tokens) and _is_spelled(tokens[i + 1]) and last == 100:
            i += 1
            continue
        if not _is_spelled(token) or token.value is None:
            break
        value = token.value
        if value >= 100 and raw and total < value:
            total, last = total * value, 100.0
        elif not raw or (value < last and last >= 20 and value < (100 if last == 100 else 10)):
            total, last = total + value, 100.0 if value >= 100 else value
        else:
            break
        raw.append(token.raw)
        i += 1
    return replace(tokens[i - 1], raw=" ".join(raw), text="#", value=total), i


def _is_spelled(token: Token) -> bool:
    return token.value is not None and not token.raw[0].isdigit() and token.raw[0] != "."
