"""What a network must have, in the names of the shared benchmark's judge (`check_map.py`), held against `Structure`.

arms (some crossing joins exactly so many roads), max_arms, signals (any or none), signals_min, approach_lanes (of at least half
of the roads into the largest crossing, turn lanes apart), lanes and speed_kmh (most common by length), max_lanes, roundabout,
roundabouts, roundabout_arms, ring_lanes, merge and diverge (at least so many places), oneway, junctions, junctions_min, length_m
(longest way through), turn_deg (at least), lane_drop.
"""

from collections.abc import Callable, Mapping
from typing import Any

from drivegen.maps.structure import Structure

_SPEED, _LENGTH = 0.10, 0.30


def _exactly(value: Callable[[Structure], Any]) -> Callable[[Structure, Any], tuple[Any, bool]]:
    return lambda structure, want: (value(structure), value(structure) == want)


def _least(value: Callable[[Structure], Any]) -> Callable[[Structure, Any], tuple[Any, bool]]:
    return lambda structure, want: (value(structure), value(structure) >= want)


def _about(value: Callable[[Structure], float], share: float) -> Callable[[Structure, Any], tuple[Any, bool]]:
    return lambda structure, want: (value(structure), abs(value(structure) - want) <= share * want)


_JUDGES: dict[str, Callable[[Structure, Any], tuple[Any, bool]]] = {
    "arms": lambda structure, want: (list(structure.arms), want in structure.arms),
    "max_arms": lambda structure, want: (list(structure.arms), max(structure.arms, default=0) <= want),
    "signals": _exactly(lambda structure: structure.signals > 0),
    "signals_min": _least(lambda structure: structure.signals),
    "approach_lanes": lambda structure, want: (
        list(structure.approach_lanes),
        2 * sum(lanes == want for lanes in structure.approach_lanes) >= len(structure.approach_lanes) > 0,
    ),
    "lanes": _exactly(lambda structure: structure.lanes),
    "max_lanes": _exactly(lambda structure: structure.max_lanes),
    "roundabout": _exactly(lambda structure: bool(structure.roundabouts)),
    "roundabouts": _exactly(lambda structure: len(structure.roundabouts)),
    "roundabout_arms": lambda structure, want: (list(structure.roundabouts), want in structure.roundabouts),
    "ring_lanes": _exactly(lambda structure: structure.ring_lanes),
    "merge": _least(lambda structure: structure.merges),
    "diverge": _least(lambda structure: structure.diverges),
    "oneway": _exactly(lambda structure: structure.one_way),
    "junctions": _exactly(lambda structure: structure.junctions),
    "junctions_min": _least(lambda structure: structure.junctions),
    "speed_kmh": _about(lambda structure: structure.speed * 3.6, _SPEED),
    "length_m": _about(lambda structure: structure.length, _LENGTH),
    "turn_deg": _least(lambda structure: structure.turn),
    "lane_drop": _exactly(lambda structure: structure.lane_drops > 0),
}
EXPECTATIONS = frozenset(_JUDGES)
"""All names."""


def lacking(expect: Mapping[str, Any], structure: Structure) -> list[str]:
    """What a network lacks of what is expected, as sentences. Raises KeyError for a name that is none."""
    judged = {name: _JUDGES[name](structure, want) for name, want in expect.items()}
    return [f"{name}: asked {expect[name]}, got {got}" for name, (got, right) in judged.items() if not right]
