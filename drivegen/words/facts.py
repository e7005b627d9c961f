"""What can be read of free prose, word by word it may be little, and what of it a specification contradicts.

For whoever lets a language model read: the model's specification must hold the numbers, lights and sides that the text states.
"""

import re
from itertools import accumulate
from typing import Any, NamedTuple

from drivegen.layouts.highways import Highway
from drivegen.layouts.spec import MapSpec
from drivegen.words.read import covers_of
from drivegen.words.tokens import tokenise

_SHARE = 0.02
"""Numbers of a text are round: a specification's may differ from them by this share."""

_SPEEDS = {"speed", "ring_speed", "ramp_speed", "ramps_limit", "loop_speed", "side_speed"}
_LENGTHS = {
    "length", "diameter", "radius", "spacing", "auxiliary", "median", "position", "loop_radius", "gap", "lane_width", "pocket",
    "turn_pocket",
}  # fmt: skip
_LANES = {"lanes_each", "ring_lanes", "lanes_in", "lanes_out"}
_LANES_OR_TOTAL = {"lanes", "lane_road", "lanes_total"}

Numbers = dict[str, list[float]]
"""All numbers of a specification by the names of their fields."""


class Statement(NamedTuple):
    """A phrase as it stands in a text, the field that it is about, the things that can hold it, and the value."""

    phrase: str
    field: str
    scope: tuple[str, ...]
    value: Any


def facts(text: str) -> list[Statement]:
    """The facts that the phrase table reads in a text, the rest of which nothing may read."""
    covers = covers_of(tokenise(text))
    return [
        Statement(item.raw, item.phrase.name, item.phrase.scope, item.value)
        for item in covers[0].items
        if item.phrase.kind == "fact"
    ]


def contradictions(text: str, spec: MapSpec) -> list[str]:
    """What of a text a specification contradicts, as sentences."""
    return contradicted(facts(text), spec)


def contradicted(statements: list[Statement], spec: MapSpec) -> list[str]:
    """Sentences on what is stated and the specification has nowhere: limits, lengths, lanes, arms, lights, bans, sizes, sides."""
    numbers: Numbers = {}
    _collect(spec.model_dump(), "", numbers)
    speeds = [value for name, values in numbers.items() if name.endswith("speed") for value in values]
    lengths, lanes = _lengths(numbers), _lanes(numbers)
    if isinstance(spec.road, Highway):
        lanes += accumulate((event.change for event in spec.road.events), initial=spec.road.lanes)
    text = spec.model_dump_json()
    lit, banned = '"control":"signals"' in text, "".join(re.findall(r'turn_bans":\[([^]]*)', text))
    size = sorted([*numbers.get("rows", []), *numbers.get("columns", [])])
    arms = getattr(spec.road, "arms", None)
    counts = {value for _, field, _, value in statements if field == "arms"}
    wrong = []
    for phrase, field, _, values in statements:
        value: Any = next((v for v in values if not isinstance(v, str)), None) if isinstance(values, tuple) else values
        right = (
            (field not in _SPEEDS or _among(value, speeds))
            and (field not in _LENGTHS or _among(value, lengths))
            and (field not in _LANES or _among(value, lanes))
            and (field not in _LANES_OR_TOTAL or _among(value, lanes) or _among(value / 2, lanes))
            and (field != "arms" or arms is None or len(counts) > 1 or value == len(arms))
            and ((field, value) != ("control", "signals") or lit)
            and ((field, value) != ("signals", False) or not lit)
            and (field != "turn_lanes" or any(numbers.get(f"{value}_turn_lanes", [])))
            and (field != "turn_lanes_n" or value in numbers.get(f"{values[1]}_turn_lanes", []))
            and (not field.endswith("turn_bans") or value in banned)
            and (field != "grid_size" or sorted(values) == size)
            and (field != "left_hand" or value == spec.left_hand)
        )
        wrong += [] if right else [f"the description says {phrase!r} ({field.replace('_', ' ')}), the specification does not"]
    return list(dict.fromkeys(wrong))


def _among(value: float, numbers: list[float]) -> bool:
    return any(abs(value - number) <= _SHARE * abs(value) for number in numbers)


def _lengths(numbers: Numbers) -> list[float]:
    """Whatever is no speed and no number of lanes, and how far places along a road are apart, ends of extra lanes included."""
    plain = [v for name, values in numbers.items() if not name.endswith("speed") and "lanes" not in name for v in values]
    places = numbers.get("position", [])
    places = sorted({*places, *(place + length for place in places for length in numbers.get("length", []))})
    return [*plain, *(2 * v for v in numbers.get("radius", [])), *places, *(b - a for a in places for b in places if b > a)]


def _lanes(numbers: Numbers) -> list[float]:
    """Lanes of every direction, and of both together."""
    lanes = [value for name, values in numbers.items() if "lanes" in name and "turn" not in name for value in values]
    both = [sum(numbers.get(name, [0.0])[:1]) for name in ("lanes", "lanes_back")]
    return [*lanes, sum(both)]


def _collect(value: Any, name: str, numbers: Numbers) -> None:
    if isinstance(value, dict):
        for key, item in value.items():
            _collect(item, key, numbers)
    elif isinstance(value, list | tuple):
        for item in value:
            _collect(item, name, numbers)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        numbers.setdefault(name, []).append(float(value))
