"""Numbers of lanes in a description, and whether they count one direction, every arm, or all lanes."""

from dataclasses import dataclass

from drivegen.maps.writers._tokens import Token

_MOST = 8
_WAYS = {"": "each", "forth": "each", "back": "back"}


@dataclass
class Lanes:
    """A number of lanes: how many, of which kind of lane, per direction ("each"), on the way back
    ("back"), for every arm ("arms"), in all ("total")."""

    count: int
    first: int
    last: int
    value: str = ""
    per: str = ""
    inside: bool = False


def lanes_in(tokens: list[Token]) -> list[Lanes]:
    """All numbers of lanes, without those left to be guessed ("and the other two")."""
    found: list[Lanes] = []
    for i, token in enumerate(tokens):
        if token.kind == "lane":
            number = _number_before(tokens, i)
            if number is not None:
                found.append(_with_per(tokens, Lanes(tokens[number].number, number, i, token.value)))
            elif (
                i
                and tokens[i - 1].kind == "det"
                and tokens[i - 1].value == "a"
                and i + 1 < len(tokens)
                and (tokens[i + 1].kind == "each" or tokens[i + 1].text in ("wide", "per"))
            ):
                found.append(_with_per(tokens, Lanes(1, i - 1, i, token.value)))
            elif number_after := _number_after(tokens, i):
                found.append(_with_per(tokens, Lanes(tokens[number_after].number, i, number_after, token.value)))
        elif token.kind == "each" and token.value in _WAYS and i and tokens[i - 1].kind == "number" and token.text != "each":
            found.append(Lanes(tokens[i - 1].number, i - 1, i, "", _WAYS[token.value]))
        elif _counts_bound(tokens, i):
            found.append(Lanes(token.number, i, i + 1, "", "each"))
    _tell_bounds_apart(tokens, found)
    return found


def _counts_bound(tokens: list[Token], i: int) -> bool:
    """Whether the number at i leaves the lanes out that are said elsewhere: "three lanes, two northbound, one southbound"."""
    if tokens[i].kind != "number" or not 0 < tokens[i].number <= _MOST or [t.kind for t in tokens[i + 1 : i + 2]] != ["bound"]:
        return False
    return any(t.kind == "lane" for t in tokens) and [t.kind for t in tokens[i + 2 : i + 3]] != ["lane"]


def _tell_bounds_apart(tokens: list[Token], found: list[Lanes]) -> None:
    """ "Two lanes northbound, one southbound": the second number is that of the way back."""
    bound = [(item, near[-1]) for item in found if (near := _bound(tokens, item))]
    if len(bound) == 2 and bound[0][1] != bound[1][1]:
        bound[1][0].per = "back"


def _bound(tokens: list[Token], item: Lanes) -> list[str]:
    return [t.text for t in tokens[max(0, item.first - 1) : item.last + 2] if t.kind == "bound"]


def _number_before(tokens: list[Token], i: int) -> int | None:
    for j in range(i - 1, max(-1, i - 4), -1):
        if tokens[j].kind == "number":
            return j
        if tokens[j].kind == "road" and tokens[j].value == "highway" and j == i - 1:
            continue  # "two freeway lanes"
        if tokens[j].kind not in ("one_way", "small", "unknown", "control", "role", "comma") or tokens[j].text == ",":
            return None
    return None


def _number_after(tokens: list[Token], i: int) -> int | None:
    j = i + 1
    while j < len(tokens) and (tokens[j].kind in ("is", "each", "total") or tokens[j].text in ("of", "count", ":")):
        j += 1
    follows = j + 1 < len(tokens) and tokens[j + 1].kind in ("road", "arm", "ramp", "place", "lane", "role")
    return j if j < len(tokens) and tokens[j].kind == "number" and not follows else None


def _with_per(tokens: list[Token], lanes: Lanes) -> Lanes:
    j = lanes.last + 1
    if j < len(tokens) and tokens[j].text == "," and j + 1 < len(tokens) and tokens[j + 1].kind in ("total", "each"):
        j += 1
    while j < len(tokens) and tokens[j].text in ("wide", "going", "in"):
        j += 1
    if j < len(tokens) and tokens[j].kind in ("each", "total"):
        lanes.per = "total" if tokens[j].kind == "total" else _WAYS.get(tokens[j].value, tokens[j].value)
        lanes.last = j
    elif (
        (lanes.first and tokens[lanes.first - 1].kind in ("each", "bound"))
        or _each_before(tokens, lanes.first)
        or (j < len(tokens) and tokens[j].kind == "bound")
    ):
        lanes.per = "each"
    return lanes


def _each_before(tokens: list[Token], i: int) -> bool:
    if i and tokens[i - 1].kind in ("each", "bound"):
        return True
    near = tokens[max(0, i - 3) : i]
    return (
        bool(near) and near[0].kind == "each" and near[0].value != "arms" and all(t.kind in ("with", "is", "each") for t in near)
    )
