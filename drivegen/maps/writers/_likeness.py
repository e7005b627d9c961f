"""Which of our own described examples a description is most like: TF-IDF over the terms of the lexicon and unknown words.

The examples (`described.jsonl`) are descriptions in many people's words with the kind of road that each one is, "none" where it
is to be refused. They are a second opinion where the rules left much over, and an answer where the rules have none, if the
nearest example is nearer by a margin than any of another kind. The margin was measured (docs/maps.md).
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from drivegen.maps.spec_quadrants import QUADRANTS
from drivegen.maps.writers._languages import in_english
from drivegen.maps.writers._reading import normalise
from drivegen.maps.writers._tokens import Token, tokens

MARGIN = 0.3
"""By how much the nearest example must be nearer than any of another kind (difference of cosines) to answer."""

NONE = "none"
"""The kind of examples that describe no road that can be drawn."""

_SAYS_LITTLE = frozenset(
    (
        *("comma", "stop", "length", "speed", "det", "is", "that", "with", "small", "and", "or", "noise", "driving"),
        *("surroundings", "left_hand", "speed_word", "long"),
    )
)
_STAGGERED = 90.0
TYPICAL: dict[str, str] = {
    "crossing": "a crossing of 4 roads",
    **{f"crossing of {n} roads": f"a crossing of {n} roads" for n in (5, 6, 7, 8)},
    "t": "a t junction",
    "y": "a y junction",
    "staggered": "a staggered junction",
    "roundabout": "a roundabout",
    "grid": "a street grid",
    "straight": "a straight road",
    "one_way": "a one way street",
    "curve": "a curve",
    "s_curve": "an s curve",
    "hairpin": "a hairpin",
    "dead_end": "a cul de sac",
    "side_streets": "a street with 3 side streets",
    "highway": "a highway",
    "on_ramp": "a highway with an on ramp",
    "off_ramp": "a highway with an off ramp",
    "entrance and exit": "a highway with an on ramp and then an off ramp",
    "exit and entrance": "a highway with an off ramp and then an on ramp",
    "weaving": "a highway with a weaving section",
    "lane_drop": "a highway with a lane drop",
    "lane_gain": "a highway with a lane gain",
    "fork": "a highway that splits",
    "interchange diamond": "a diamond interchange",
    "interchange cloverleaf": "a cloverleaf interchange",
    "interchange trumpet": "a trumpet interchange",
}
"""How the rules are told of a kind that was found by likeness."""


@dataclass(frozen=True)
class Nearest:
    """The example that a description is most like: its kind and text, the cosine, and how far the next kind is behind."""

    kind: str
    text: str
    cosine: float
    margin: float


@dataclass(frozen=True)
class Example:
    """A description and the kind of road that it is."""

    kind: str
    text: str


@cache
def examples() -> tuple[Example, ...]:
    """Our own described examples."""
    text = (files("drivegen.maps.writers") / "described.jsonl").read_text(encoding="utf-8")
    return tuple(Example(row["kind"], row["text"]) for row in map(json.loads, text.splitlines()))


def nearest(text: str) -> Nearest:
    """The nearest of all examples."""
    return _index(examples()).nearest(text)


class Index:
    """Examples as TF-IDF vectors."""

    def __init__(self, among: tuple[Example, ...]) -> None:
        """Fit the weights; scikit-learn is imported here, because most descriptions never need it."""
        from sklearn.feature_extraction.text import TfidfVectorizer

        self._among = among
        self._vectors = TfidfVectorizer(analyzer=_terms, sublinear_tf=True)
        self._known: Any = self._vectors.fit_transform([example.text for example in among])

    def nearest(self, text: str) -> Nearest:
        """The nearest example; of equals the first."""
        return self.nearest_among(self.likeness(text))

    def likeness(self, text: str) -> list[float]:
        """The cosine with every example."""
        return [float(v) for v in (self._vectors.transform([text]) @ self._known.T).toarray()[0]]

    def nearest_among(self, cosines: list[float]) -> Nearest:
        """The nearest example by these cosines, which may hide some examples behind a negative one."""
        best = max(range(len(cosines)), key=lambda i: (cosines[i], -i))
        kind = self._among[best].kind
        behind = max((c for c, e in zip(cosines, self._among, strict=True) if e.kind != kind), default=0.0)
        return Nearest(kind, self._among[best].text, cosines[best], cosines[best] - max(behind, 0.0))


@cache
def _index(among: tuple[Example, ...]) -> Index:
    return Index(among)


def _terms(text: str) -> list[str]:
    """What a description speaks of: kinds and values of its terms, how many, and words that the lexicon lacks."""
    return [term for token in tokens(normalise(in_english(text))) if (term := _term(token))]


def _term(token: Token) -> str:
    if token.kind == "unknown":
        return token.text
    if token.kind == "number":
        return "#many" if token.number > 1 else "#1"
    return "" if token.kind in _SAYS_LITTLE else f"<{token.kind} {token.value}>"


def kind_of(road: Mapping[str, Any]) -> str:
    """The kind, as the examples name it, of a road as fields of a specification."""
    named = _KINDS.get(road["kind"])
    return named(road) if named else str(road["kind"])


def _crossing(road: Mapping[str, Any]) -> str:
    angles = sorted(arm["angle"] % 360.0 for arm in road["arms"])
    if len(angles) == 3:
        return "t" if any(abs(b - a - 180.0) < 1.0 for a in angles for b in angles) else "y"
    return "crossing" if len(angles) == 4 else f"crossing of {len(angles)} roads"


def _highway(road: Mapping[str, Any]) -> str:
    kinds = [event["kind"] for event in road["events"]]
    if sorted(set(kinds)) == ["off_ramp", "on_ramp"]:
        return "entrance and exit" if kinds[0] == "on_ramp" else "exit and entrance"
    return str(kinds[0]) if kinds else "highway"


def _corridor(road: Mapping[str, Any]) -> str:
    junctions = road.get("junctions") or ()
    if not junctions:
        shape = str(road["alignment"]["shape"])
        straight = "one_way" if road["lanes_back"] == 0 else "straight"
        return "dead_end" if road.get("dead_end") else straight if shape == "straight" else shape
    if junctions[0].get("form") == "roundabout":
        return "roundabouts in a row"
    if any(len(junction["sides"]) > 1 for junction in junctions):
        return "crossings in a row"
    apart = junctions[-1]["position"] - junctions[0]["position"]
    beside = len(junctions) == 2 and junctions[0]["sides"] != junctions[1]["sides"] and apart <= _STAGGERED
    return "staggered" if beside else "side_streets"


def _quadrants(road: Mapping[str, Any]) -> str:
    ramps = [road[name] for name in QUADRANTS]
    if not (road.get("north_leg", True) and road.get("south_leg", True)):
        return "interchange trumpet"
    return "interchange cloverleaf" if set(ramps) == {"both"} else "interchange with loops"


_KINDS: dict[str, Callable[[Mapping[str, Any]], str]] = {
    "crossing": _crossing,
    "highway": _highway,
    "corridor": _corridor,
    "interchange": lambda road: f"interchange {road['form']}",
    "quadrant_interchange": _quadrants,
    "fork": lambda road: "merge of roads" if road.get("joins") else "fork",
}
