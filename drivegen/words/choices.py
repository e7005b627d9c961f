"""What words leave open: lengths drawn from a random stream of the text and the seed, usual limits, and how lanes are counted."""

from typing import Any

from drivegen.core import seeds
from drivegen.layouts.values import USUAL_MEDIAN
from drivegen.words.slots import KMH
from drivegen.words.things import Thing, Undrawable, Unfit

_SPEEDS = {"residential": 30 * KMH, "rural": 80 * KMH, "urban": 50 * KMH, None: 50 * KMH}
ARTERIAL, FAST = 60 * KMH, 120 * KMH


class Choices:
    """Numbers for what is unsaid; the same text and seed give the same ones, whatever else is asked for."""

    def __init__(self, text: str, seed: int) -> None:
        self._text, self._seed = text, seed

    def length(self, what: str, low: int, high: int, step: int = 10) -> float:
        """A length [m] between `low` and `high`, a multiple of `step`."""
        steps = (high - low) // step
        return float(low + step * int(seeds.rng(self._seed, "maps", self._text, what).integers(steps + 1)))


def usual_speed(things: list[Thing]) -> float:
    """The limit [m/s] of a road of which none is said."""
    settings = {value for thing in things for value in thing.values("setting")}
    arterial = [value for thing in things for value in thing.values("arterial")]
    if len(settings) > 1:
        settings -= {"urban"}
    setting = min(settings) if settings else None
    return ARTERIAL if arterial and setting in (None, "urban") else _SPEEDS[setting]


def lanes_of(
    road: Thing, *, one_way: bool = False, per_carriageway: bool = False, arms: bool = False, most: int = 4
) -> tuple[int, int] | None:
    """Lanes ahead and back that are said of a road, None where nothing is.

    `arms`: of roads that meet at a junction, of which "N lanes" means each direction. `most`: an even number of lanes above
    may be that of both carriageways. Raises Unfit where a number is open to two readings, or two contradict one another.
    """
    pairs: list[tuple[int, int]] = []
    known: tuple[int, ...] = ()
    for name in ("lanes_each", "lanes_total", "lanes_pair", "lanes", "lane_road"):
        if name == "lanes" and pairs:
            known = pairs[0][0], 0 if one_way else sum(pairs[0])  # "an eight-lane highway, four in each direction"
        values = [value for value in road.values(name) if value not in known]
        pairs += [_counted(name, n, one_way=one_way, most=most if per_carriageway else 0, arms=arms) for n in values]
    if one_way and road.has("lanes_each"):
        raise Undrawable("a one-way road has no lanes in the other direction")
    if one_way:
        pairs = [(ahead, 0) for ahead, _ in pairs]
    if len(set(pairs)) > 1:
        raise Undrawable("two different numbers of lanes are said of one road")
    return pairs[0] if pairs else None


def _counted(name: str, value: Any, *, one_way: bool, most: int, arms: bool) -> tuple[int, int]:
    """Lanes ahead and back that one number means."""
    if isinstance(value, tuple):
        return int(value[0]), int(value[1])
    lanes = int(value)
    if one_way or name == "lanes_each" or lanes == 1 or (name == "lanes" and arms):
        return lanes, lanes
    if most and name != "lanes_total" and (lanes <= most or lanes % 2):
        return lanes, lanes
    if name == "lanes":
        raise Unfit(f"{lanes} lanes can mean {lanes} in each direction or {lanes} in total: say which")
    if lanes % 2 or (most and name != "lanes_total"):
        raise Undrawable(f"a road of {lanes} lanes must say how many lanes each direction has")
    return lanes // 2, lanes // 2


def check_lanes(road: Thing) -> None:
    """Raises Unfit for a road that is said to have no lane."""
    if any(fact.value == 0 for fact in road.facts if fact.name.startswith("lane") and fact.name not in ("lanes_in", "lanes_out")):
        raise Unfit("a road needs at least one lane")


def speed_of(road: Thing) -> float | None:
    """The limit [m/s] that is said of a road."""
    speed = road.value("speed")
    return None if speed is None else float(speed)


def median_of(road: Thing) -> float | None:
    """The strip between the directions of a road [m], None where it is not said to be divided."""
    divided, median = road.value("divided"), road.value("median")
    return USUAL_MEDIAN if divided and median is None else median


def is_one_way(road: Thing) -> bool:
    """Whether a road is said to be one-way. Raises Unfit where it is said to be both."""
    one, two = road.value("one_way"), road.value("two_way")
    if one and two:
        raise Unfit("a road is said to be one-way and two-way")
    return bool(one)
