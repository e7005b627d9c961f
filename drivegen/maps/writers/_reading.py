"""A description while it is read: plain words and digits, which of them are taken, and what they meant.

Everything is lowercased, numbers in words become digits, units one word each, hyphens spaces; punctuation survives as
commas and full stops, because clauses matter.
"""

import re
from collections.abc import Iterator

from drivegen.maps.writers._key_values import in_prose

_UNITS = (
    (r"(?<=limit )(\d+) ?km\b(?! ?/| per)|(?<=limit of )(\d+) ?km\b(?! ?/| per)", lambda m: f"{m[1] or m[2]} kmh "),
    (r"k\.?m\.? ?/ ?h\b|\bkm ?h\b|kph|kmph|(?:km|kilomet(?:re|er)s?) (?:per|an|a|every) hour|\bkmhr?\b|\bk/h\b", " kmh "),
    (r"m\.?p\.?h\b\.?|mi ?/ ?h\b|miles? (?:per|an|a) hour", " mph "),
    (r"\bm ?/ ?s\b|met(?:re|er)s? (?:per|a) second", " mps "),
    (r"°|\bdeg(?:ree)?s?\b\.?", " degrees "),
    (r"\bkilomet(?:re|er)s?\b|\bkms?\b", " km "),
    (r"\bmet(?:re|er)s?\b", " m "),
    (r"\bfeet\b|\bfoot\b|\bft\b\.?", " ft "),
    (r"\byards?\b|\byds?\b", " yd "),
    (r"\bmiles?\b|\bmi\b", " mile "),
)
_ONES = ("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")
_TEENS = ("thirteen", "fourteen", "fifteen", "sixteen", "seventeen", "eighteen", "nineteen")
_SMALL = {word: i for i, word in enumerate((*_ONES, *_TEENS))}
_DECADES = ("twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety")
_TENS = {word: 10 * i for i, word in enumerate(_DECADES, 2)}
_OTHER_NUMBERS = (
    (r"\b(?:a )?pair of\b|\ba couple of\b|\btwin\b|\bdouble(?= lane)|\bdual(?= lane)", "2"),
    (r"\btriple(?= lane)", "3"),
    (r"\btwice\b", "2 times"),
    (r"\bthrice\b", "3 times"),
    (r"\bdouble(?= (?:mini )?(?:roundabout|junction))", "2"),
    (r"\bround about(?! \d+ ?(?:m|km|ft|yd)\b)", "roundabout"),
    (r"\bsingle(?= (?:\w+ )?lane)", "1"),
    (r"\b(?:a |one |1 )?half (?:a |of a )?(?=km|mile)", "0.5 "),
    (r"\b(?:a |one |1 )?quarter (?:of a |of an )?(?=km|mile)", "0.25 "),
    (r"\ba (?=km|mile)", "1 "),
    (r"\b(?:a |one |1 )?dozen\b", "12"),
    (r"\ba (?=hundred|thousand|million|billion|trillion)", "1 "),
    (r"\b(?:an )?(?:infinite(?:ly many)?|endless|countless|unlimited(?! speed))(?: numbers? of)?(?= \w)", "999999"),
)
_ROAD = "(road|street|highway|layout|section)"
_LARGE = {"thousand": 10**3, "million": 10**6, "billion": 10**9, "trillion": 10**12}
_NUMBER_WORD = "|".join([*_SMALL, *_TENS])
_NEGATOR = re.compile(
    r"\b(?:no|without|not|non|never|lacks|lacking|nor|neither|isn t|aren t|instead of|rather than|free of|any|zero|0)"
    r"((?: \w+){0,3}|(?: \w+){0,3},?(?: \w+){0,3} (?:or|nor)(?: \w+){0,2}) ?$"
)
_STOPS_NEGATION = re.compile(r"\b(?:but|with|has|have|only|just|and a|and an|then)\b")
_NEGATES_ALONE = re.compile(r"\bany (?:\w+ )*$")


class Reading:
    """A normalised description with the spans that rules have taken."""

    def __init__(self, text: str) -> None:
        self.text = normalise(text)
        self.notes: list[tuple[str, str]] = []
        self._taken = bytearray(len(self.text))

    def all(self, pattern: str) -> Iterator[re.Match[str]]:
        """Matches of `pattern` on whole words that touch nothing taken, in order."""
        compiled = re.compile(rf"(?<!\w)(?:{pattern})(?!\w)")
        match = compiled.search(self.text)
        while match is not None:
            free = match.end() > match.start() and not any(self._taken[match.start() : match.end()])
            if free:
                yield match
            # Where a match runs into taken words, a shorter one may begin later in it.
            match = compiled.search(self.text, match.end() if free else match.start() + 1)

    def first(self, pattern: str) -> re.Match[str] | None:
        """The first such match."""
        return next(self.all(pattern), None)

    def take(self, match: re.Match[str], meaning: str) -> None:
        """Mark the matched words as understood, as meaning `meaning`; an empty meaning notes nothing."""
        self._taken[match.start() : match.end()] = b"\1" * (match.end() - match.start())
        if meaning:
            self.notes.append((match.group().strip(" ,."), meaning))

    def set_aside(self, match: re.Match[str]) -> None:
        """Keep rules from the matched words without understanding them: they stay among the words left over."""
        self._taken[match.start() : match.end()] = b"\2" * (match.end() - match.start())

    def negated(self, match: re.Match[str]) -> bool:
        """Whether words such as "no" or "without" stand before the match, in its clause."""
        clause = re.split(r"[.;:]", self.text[: match.start()])[-1]
        found = _NEGATOR.search(clause)
        if found is None or _STOPS_NEGATION.search(found.group(1)):
            return False
        if found.group().startswith("any"):
            return bool(re.search(r"\b(?:without|not|no|free of)\b", clause))
        return True

    def before(self, match: re.Match[str], words: int) -> str:
        """Up to `words` words before the match."""
        return " ".join(self.text[: match.start()].split()[-words:])

    def after(self, match: re.Match[str], words: int) -> str:
        """Up to `words` words after the match."""
        return " ".join(self.text[match.end() :].split()[:words])

    def left_over(self) -> list[str]:
        """The words that nothing has taken, in order."""
        words = re.finditer(r"[^\s,.;:()]+", self.text)
        return [w.group() for w in words if 1 not in self._taken[w.start() : w.end()]]

    def untaken(self) -> str:
        """The description without what rules have taken, for another reader."""
        return "".join(" " if taken == 1 else letter for letter, taken in zip(self.text, self._taken, strict=True))


def normalise(text: str) -> str:
    """The description in the one form that all patterns are written for."""
    text = in_prose(text).translate({0x2019: "'", 0x2018: "'", 0xD7: " x ", 0x2010: "-", 0x2011: "-", 0x2013: "-", 0x2014: ","})
    text = re.sub(r"(\d)[.,](\d{3})(?!\d)", r"\1\2", text)
    text = re.sub(r"(\d)(?=[a-z°])", r"\1 ", text)
    text = re.sub(r"(?<=\d) x ?(?=\d)", " x ", text)
    text = re.sub(r"\b(\d|one|two|three|four) (?:lanes? )?in(?:,| and|/)? \1 (?:lanes? )?out\b", r"\1 lanes each way", text)
    text = re.sub(r"\b2 ?x ?(\d) ?(?:-?lanes?)\b", r"\1 lanes per direction", text)
    for pattern, unit in _UNITS:
        text = re.sub(pattern, unit, text)
    text = re.sub(r"(?<!\d)\.(?=\d)", "0.", text)
    text = re.sub(r" ?(?:-+>|=+>|→) ?", " to ", text)
    text = re.sub(r"\b(at|after|from) (?:the )?km (\d+(?:\.\d+)?)(?! ?\w)", r"\1 \2 km", text)
    text = re.sub(r"\b(into|in to|splits?|=) (\d) ?\+ ?(\d)\b(?: lanes)?", r"\1 \2 and \3", text)
    text = re.sub(r"\b(\d) ?\+ ?(\d)(?= ?(?:lanes? )?(?:=|become|merge|into|to |form|join))", r"\1 lanes and \2", text)
    text = re.sub(r"\b(\d) ?\+ ?\1\b(?: ?lanes?)?", r"\1 lanes per direction", text)
    text = re.sub(
        rf"\b([234]) ?\+ ?1(?: lane)? {_ROAD}\b", r"\2 with \1 lanes in 1 direction and 1 lane in the other direction , ", text
    )
    text = re.sub(r"(?<![\w.])-(?=\d)", "minus ", text)
    text = re.sub(r"['\"`*_/\\-]", " ", text)
    text = re.sub(r"[([{]", " ( ", re.sub(r"[)\]}]", " ) ", text))
    text = re.sub(r"[;:!?\n\r]", " , ", text)
    text = re.sub(r"(?<!\d)\.|\.(?!\d)", " . ", text)
    text = re.sub(r",", " , ", text)
    return _digits(re.sub(r"\s+", " ", text).strip())


def _digits(text: str) -> str:
    for pattern, number in _OTHER_NUMBERS:
        text = re.sub(pattern, number, text)
    text = re.sub(rf"\b({'|'.join(_TENS)}) ({'|'.join(list(_SMALL)[1:10])})\b", _tens_and_ones, text)
    # "one" stays a word where it is no count: "one way", "that one".
    text = re.sub(rf"\b({_NUMBER_WORD})\b(?! ?way (?:street|road|traffic|system|lane|carriage))(?! by one)", _word, text)
    text = re.sub(r"\b1 way\b", "one way", text)
    text = re.sub(r"\b(\d+) hundred(?: and)?(?: (\d{1,2})\b)?", lambda m: str(int(m[1]) * 100 + int(m[2] or 0)), text)
    for word, value in _LARGE.items():
        text = re.sub(rf"\b(\d+) {word}s?\b", lambda m, v=value: str(int(m[1]) * v), text)  # type: ignore[misc]
    text = re.sub(r"\b(\d+) and 0\.5 |\b(\d+) and a half ", lambda m: f"{m[1] or m[2]}.5 ", text)
    text = re.sub(r"\b(\d+) (km|mile) and (?:a |1 )(half|quarter)\b(?! (?:a |an |of |diamond|circle))", _and_a_half, text)
    return re.sub(r"\s+", " ", text)


def _and_a_half(match: re.Match[str]) -> str:
    return f"{match[1]}.{'5' if match[3] == 'half' else '25'} {match[2]}"


def _tens_and_ones(match: re.Match[str]) -> str:
    return str(_TENS[match[1]] + _SMALL[match[2]])


def _word(match: re.Match[str]) -> str:
    return str(_SMALL.get(match[1], _TENS.get(match[1])))
