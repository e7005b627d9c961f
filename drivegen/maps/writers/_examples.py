"""Worked examples for a language model: descriptions with their specifications, and which of them are most like a request."""

import math
import re
from collections import Counter
from typing import Any

import orjson

_KMH = 1 / 3.6


def _arms(*angles: float, **fields: Any) -> list[dict[str, Any]]:
    return [{"angle": angle, **fields} for angle in angles]


EXAMPLES: tuple[tuple[str, dict[str, Any]], ...] = (
    (
        "A signal-controlled intersection of two avenues, two lanes each way, left-turn pockets, 50 km/h.",
        {
            "kind": "crossing",
            "control": "signals",
            "arms": _arms(0, 90, 180, 270, lanes_in=2, lanes_out=2, left_turn_lanes=1, speed=50 * _KMH),
        },
    ),
    (
        "A lane ends at a larger road in a T-junction; who comes from the lane gives way.",
        {"kind": "crossing", "control": "yield", "arms": [{"angle": 0}, {"angle": 180}, {"angle": 270, "main": False}]},
    ),
    (
        "Five country roads come together, everybody has to stop.",
        {"kind": "crossing", "control": "all_way_stop", "arms": _arms(0, 70, 145, 215, 290, speed=70 * _KMH)},
    ),
    (
        "A traffic circle 50 m wide with two circulating lanes where four roads with two lanes each way meet.",
        {"kind": "roundabout", "ring_lanes": 2, "diameter": 50, "arms": _arms(0, 90, 180, 270, lanes_in=2, lanes_out=2)},
    ),
    ("A small rotary with three exits.", {"kind": "roundabout", "diameter": 30, "arms": _arms(0, 120, 240)}),
    (
        "A main street with three traffic lights every 200 m, two lanes per direction, limit 60.",
        {
            "kind": "corridor",
            "lanes": 2,
            "lanes_back": 2,
            "speed": 60 * _KMH,
            "alignment": {"length": 700},
            "junctions": [{"position": p, "control": "signals"} for p in (150, 350, 550)],
        },
    ),
    (
        "Two roundabouts in a row on a straight road, 300 m from each other.",
        {
            "kind": "corridor",
            "alignment": {"length": 700},
            "junctions": [{"position": p, "form": "roundabout"} for p in (200, 500)],
        },
    ),
    (
        "A road with a staggered junction: side streets on the left and, 60 m on, on the right.",
        {
            "kind": "corridor",
            "alignment": {"length": 500},
            "junctions": [{"position": 200, "sides": ["left"]}, {"position": 260, "sides": ["right"]}],
        },
    ),
    (
        "A winding mountain road that turns back on itself in a tight hairpin, 40 km/h.",
        {"kind": "corridor", "speed": 40 * _KMH, "alignment": {"shape": "hairpin", "length": 500, "angle": 180, "radius": 20}},
    ),
    (
        "A one-way street with two lanes bending 90 degrees to the right.",
        {
            "kind": "corridor",
            "lanes": 2,
            "lanes_back": 0,
            "alignment": {"shape": "curve", "length": 500, "angle": -90, "radius": 60},
        },
    ),
    (
        "A residential dead end of 200 m, 30 km/h.",
        {"kind": "corridor", "speed": 30 * _KMH, "alignment": {"length": 200}, "dead_end": True},
    ),
    (
        "City blocks: four streets cross three others, all signalised, 100 m apart.",
        {"kind": "grid", "rows": 4, "columns": 3, "spacing": 100, "control": "signals"},
    ),
    (
        "A freeway with three lanes where cars enter over a ramp and leave 500 m further on, 120 km/h.",
        {
            "kind": "highway",
            "lanes": 3,
            "speed": 120 * _KMH,
            "alignment": {"length": 1300},
            "events": [{"kind": "on_ramp", "position": 300}, {"kind": "off_ramp", "position": 800}],
        },
    ),
    (
        "A motorway that loses its left lane: four become three. Weaving before that.",
        {
            "kind": "highway",
            "lanes": 4,
            "alignment": {"length": 1200},
            "events": [
                {"kind": "weaving", "position": 250, "length": 300},
                {"kind": "lane_drop", "position": 800, "side": "left"},
            ],
        },
    ),
    (
        "A three-lane expressway splits, two lanes go left and one right.",
        {"kind": "fork", "lanes": 3, "left_lanes": 2, "right_lanes": 1, "speed": 80 * _KMH},
    ),
    (
        "A diamond interchange: a street with two lanes each way over a three-lane motorway, lights where ramps end.",
        {"kind": "interchange", "form": "diamond", "lanes": 3, "speed": 120 * _KMH, "road_lanes": 2, "control": "signals"},
    ),
    (
        "Two three-lane motorways cross in a full cloverleaf, loops of 50 m radius, 40 km/h on the loops.",
        {
            "kind": "quadrant_interchange",
            "lanes": 3,
            "road_lanes": 3,
            "road_speed": 120 * _KMH,
            "loop_radius": 50,
            "loop_speed": 40 * _KMH,
        },
    ),
    (
        "A trumpet interchange: a country road, 80 km/h, comes from the south and ends at a motorway.",
        {
            "kind": "quadrant_interchange",
            "north_leg": False,
            "north_west": "both",
            "north_east": "none",
            "south_west": "direct",
            "south_east": "direct",
            "road_lanes": 1,
            "road_speed": 80 * _KMH,
        },
    ),
    (
        "A partial cloverleaf: an arterial with two lanes each way over a freeway, two loop ramps, lights where ramps end.",
        {
            "kind": "quadrant_interchange",
            "north_west": "direct",
            "south_east": "direct",
            "road_lanes": 2,
            "road_speed": 60 * _KMH,
            "control": "signals",
        },
    ),
    (
        "A triangle of roads with a road to the outside at each corner.",
        {
            "kind": "graph",
            "nodes": [
                *({"name": n, "x": x, "y": y} for n, x, y in (("a", 0, 0), ("b", 200, 0), ("c", 100, 170))),
                *({"name": n, "x": x, "y": y} for n, x, y in (("p", -150, -80), ("q", 350, -80), ("r", 100, 340))),
            ],
            "roads": [{"name": s + e, "start": s, "end": e} for s, e in ("ab", "bc", "ca", "pa", "qb", "rc")],
        },
    ),
)
"""Words of a description, and the `road` of its specification."""

_NAMES = {
    "crossing": r"crossing|intersection|junction|crossroads",
    "roundabout": r"roundabout|rotary|traffic circle",
    "corridor": r"in a row|staggered|side streets?|cul-de-sac|dead end|bend|curve|hairpin|winding|crossings|roundabouts",
    "grid": r"grid|blocks?|manhattan",
    "highway": r"motorway|highway|freeway|autobahn|expressway|dual carriageway",
    "fork": r"fork|splits?|bifurcation",
    "interchange": r"diamond|interchange|ramp terminal",
    "quadrant_interchange": r"cloverleaf|parclo|trumpet",
}
"""Words by which descriptions name the kinds."""


def most_like(text: str, count: int) -> list[tuple[str, dict[str, Any]]]:
    """The `count` examples most like `text`, the best last, where a model heeds it most; one of each kind named.

    Likeness is the cosine between counts of letter triples, each weighted by how rare it is among the examples.
    """
    texts = [Counter(_triples(example)) for example, _ in EXAMPLES]
    spread = Counter(triple for triples in texts for triple in triples)
    weights = {triple: math.log((1 + len(EXAMPLES)) / (1 + n)) for triple, n in spread.items()}
    asked = Counter(_triples(text))
    order = sorted(range(len(EXAMPLES)), key=lambda i: (_cosine(asked, texts[i], weights), -i))
    kinds = {name for name, words in _NAMES.items() if re.search(rf"\b({words})s?\b", text.lower())}
    named = {EXAMPLES[i][1]["kind"]: i for i in order if EXAMPLES[i][1]["kind"] in kinds}.values()
    order.sort(key=lambda i: i in named)
    return [EXAMPLES[i] for i in order[-max(count, len(named)) :]]


def shown(examples: list[tuple[str, dict[str, Any]]]) -> str:
    """Examples as a model reads them."""
    return "\n\n".join(f"Description: {text}\nroad: {orjson.dumps(road).decode()}" for text, road in examples)


def _triples(text: str) -> list[str]:
    padded = f" {' '.join(text.lower().split())} "
    return [padded[i : i + 3] for i in range(len(padded) - 2)]


def _cosine(a: Counter[str], b: Counter[str], weights: dict[str, float]) -> float:
    def norm(c: Counter[str]) -> float:
        return math.sqrt(sum((n * weights.get(t, 0.0)) ** 2 for t, n in c.items()))

    product = sum(a[t] * b[t] * weights[t] ** 2 for t in b)
    length = norm(a) * norm(b)
    return product / length if length else 0.0
