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
    return lambda found, want: (value(found), value(found) == want)


def _least(value: Callable[[Structure], Any]) -> Callable[[Structure, Any], tuple[Any, bool]]:
    return lambda found, want: (value(found), value(found) >= want)


def _about(value: Callable[[Structure], float], share: float) -> Callable[[Structure, Any], tuple[Any, bool]]:
    return lambda found, want: (value(found), abs(value(found) - want) <= share * want)


_JUDGES: dict[str, Callable[[Structure, Any], tuple[Any, bool]]] = {
    "arms": lambda found, want: (list(found.arms), want in found.arms),
    "max_arms": lambda found, want: (list(found.arms), max(found.arms, default=0) <= want),
    "signals": _exactly(lambda found: found.signals > 0),
    "signals_min": _least(lambda found: found.signals),
    "approach_lanes": lambda found, want: (
        list(found.approach_lanes),
        2 * sum(lanes == want for lanes in found.approach_lanes) >= len(found.approach_lanes) > 0,
    ),
    "lanes": _exactly(lambda found: found.lanes),
    "max_lanes": _exactly(lambda found: found.max_lanes),
    "roundabout": _exactly(lambda found: bool(found.roundabouts)),
    "roundabouts": _exactly(lambda found: len(found.roundabouts)),
    "roundabout_arms": lambda found, want: (list(found.roundabouts), want in found.roundabouts),
    "ring_lanes": _exactly(lambda found: found.ring_lanes),
    "merge": _least(lambda found: found.merges),
    "diverge": _least(lambda found: found.diverges),
    "oneway": _exactly(lambda found: found.one_way),
    "junctions": _exactly(lambda found: found.junctions),
    "junctions_min": _least(lambda found: found.junctions),
    "speed_kmh": _about(lambda found: found.speed * 3.6, _SPEED),
    "length_m": _about(lambda found: found.length, _LENGTH),
    "turn_deg": _least(lambda found: found.turn),
    "lane_drop": _exactly(lambda found: found.lane_drops > 0),
}
EXPECTATIONS = frozenset(_JUDGES)
"""All names."""


def lacking(expect: Mapping[str, Any], found: Structure) -> list[str]:
    """What a network lacks of what is expected, as sentences. Raises KeyError for a name that is none."""
    judged = {name: _JUDGES[name](found, want) for name, want in expect.items()}
    return [f"{name}: asked {expect[name]}, got {got}" for name, (got, right) in judged.items() if not right]
