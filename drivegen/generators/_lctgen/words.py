"""A scenario code from words by rules, where LCTGen asks a language model (paper, section 4.2 and its prompt).

Offline stand-in: it reads how many vehicles there are, where they are, which way they face, how fast they are and what they
do, clause by clause, and how many lanes a road has. What is not said is filled in by the ranges of the rules. It does not
understand anything else.
"""

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.generators._lctgen.codes import DISTANCE, PARTS, SPEED, Action, Direction
from drivegen.generators._lctgen.maps import JUNCTIONS
from drivegen.generators.shared.vectors import AGENTS

_NUMBERS = {"a": 1, "an": 1, "one": 1, "two": 2, "three": 3, "four": 4, "five": 5, "six": 6, "seven": 7, "eight": 8, "ten": 10}
_CROWDS = {"several": 3, "some": 3, "a few": 3, "many": 8, "busy": 12, "crowded": 14, "heavy": 12, "sparse": 4, "light": 4}

_VEHICLES = re.compile(
    r"\b(\d+|" + "|".join(_NUMBERS) + r"|several|some|a few|many) (?:[a-z]+ )?(?:cars?|vehicles?|trucks?|buses|bus)\b"
)
_LANES = re.compile(r"\b(\d|one|two|three|four)[- ]lanes?\b")

_QUADRANTS = ((r"behind.*right|right.*behind", (2,)), (r"behind.*left|left.*behind", (1,)), (r"behind|follow", (1, 2)),
              (r"(ahead|front).*left", (0,)), (r"(ahead|front).*right", (3,)), (r"ahead|in front|leading", (0, 3)))  # fmt: skip

_DIRECTIONS = (
    (r"oncoming|opposite|towards", (Direction.OPPOSITE,)),
    (r"cross|perpendicular|from the side", (Direction.LEFTWARD, Direction.RIGHTWARD)),
)

_ACTIONS = (
    (r"turn\w* left", Action.TURN_LEFT),
    (r"turn\w* right", Action.TURN_RIGHT),
    (r"(chang|cut|merg)\w* (\w+ )*left", Action.CHANGE_LEFT),
    (r"(chang|cut|merg)\w* (\w+ )*right", Action.CHANGE_RIGHT),
    (r"brak|slow(s|ing)? down|decelerat", Action.SLOW_DOWN),
    (r"accelerat|speed(s|ing)? up", Action.SPEED_UP),
    (r"stop|stand|parked|wait", Action.STOP),
)

_SPEEDS = (
    (r"stopped|standing|parked|waiting", (0.0, 0.3)),
    (r"\bslow(ly)?\b|jam", (1.0, 5.0)),
    (r"fast|speeding|motorway|highway", (18.0, 30.0)),
)

_USUAL_SPEED, _USUAL_DISTANCE = (5.0, 14.0), (8.0, 60.0)
"""[m/s], [m] where nothing is said."""


@dataclass(frozen=True)
class ScenarioCode:
    """What the words ask for: `vehicles` (N, 8), the target first, and `roads` (6,) as in `maps.FIELDS`."""

    vehicles: NDArray[np.int64]
    roads: NDArray[np.int64]


def written(text: str, rng: np.random.Generator) -> ScenarioCode:
    """The code of a description; what it leaves open is drawn. Raises UnusableInput where it speaks of no vehicle or traffic."""
    words = text.lower()
    clauses = [
        clause for clause in re.split(r"[.;,]| while | and (?=(?:\d+|a|an|one|two|three|four|five) )", words) if clause.strip()
    ]
    rows = [_vehicle("", rng)]
    for clause in clauses:
        rows += [_vehicle(clause, rng) for _ in range(_count(clause))]
    if len(rows) == 1:
        crowd = next((count for word, count in _CROWDS.items() if word in words), 0)
        if crowd == 0:
            raise UnusableInput(f"no vehicle and no traffic is described by {text!r}: say how many, or how dense")
        rows += [_vehicle(words, rng) for _ in range(crowd)]
    return ScenarioCode(np.array(rows[:AGENTS], np.int64), _roads(words))


def _count(clause: str) -> int:
    found = _VEHICLES.search(clause)
    if found is None:
        return 0
    word = found.group(1)
    return int(word) if word.isdigit() else _NUMBERS.get(word, _CROWDS.get(word, 1))


def _vehicle(clause: str, rng: np.random.Generator) -> list[int]:
    """The eight fields of one vehicle of which `clause` speaks."""
    quadrants = next((where for pattern, where in _QUADRANTS if re.search(pattern, clause)), (0, 1, 2, 3))
    directions = next((which for pattern, which in _DIRECTIONS if re.search(pattern, clause)), (Direction.SAME,))
    low, high = next((speeds for pattern, speeds in _SPEEDS if re.search(pattern, clause)), _USUAL_SPEED)
    action = next((one for pattern, one in _ACTIONS if re.search(pattern, clause)), Action.KEEP_SPEED)
    speed = rng.uniform(low, high)
    return [
        int(rng.choice(quadrants)),
        int(rng.uniform(*_USUAL_DISTANCE) / DISTANCE),
        int(rng.choice(directions)),
        int(speed / SPEED),
        *[int(action)] * PARTS,
    ]


def _roads(words: str) -> NDArray[np.int64]:
    """The six fields of the map."""
    found = _LANES.search(words)
    lanes = 1 if found is None else _NUMBERS.get(found.group(1), 0) or int(found.group(1))
    one_way = bool(re.search(r"one[- ]way|motorway|highway", words))
    junction = bool(re.search(r"junction|intersection|crossing|crossroads|roundabout|turn", words))
    crossing = lanes if junction else 0
    return np.array([lanes, 0 if one_way else lanes, crossing, crossing, 4 if junction else JUNCTIONS - 1, 0], np.int64)
