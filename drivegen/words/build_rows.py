"""From a scene to crossings and roundabouts in a row along a road."""

from itertools import pairwise
from typing import Any

from drivegen.words.build_crossings import said_control, turning
from drivegen.words.choices import Choices, lanes_of, speed_of
from drivegen.words.things import Road, Thing, Undrawable, Unfit, merged, only

MOST = 12
Row = tuple[list[Road], list[float], float | None]
"""Junctions along a road, the gaps between them, and where the first one lies if that is said."""

_SMALLEST_RING, _BETWEEN_RINGS = 28.0, 25.0


def row(
    road: Thing, base: Road, things: list[Thing], references: list[Thing], sides: list[Thing], choices: Choices, main: bool
) -> Row:
    """The crossings and roundabouts of a road. Raises Unfit."""
    words = each(things)
    if any(thing.values("middle") for thing in (road, *things, *sides)) and len(words) != 1:
        raise Unfit("it is not clear what lies in the middle")
    if between := next((thing.text for thing in things if thing.text.endswith("between")), None):
        raise Unfit(f"say in which order junctions lie along a road, not {between!r}")
    side = merged(sides)
    lanes = lanes_of(side, arms=True)
    usual = (base["lanes"] if not main else 1,) if lanes is None else lanes
    spacing = spacing_of(road, [*things, *sides], len(words)) or choices.length("spacing", 150, 250)
    shared = [thing for thing in references if thing.which == "all"]
    junctions = []
    for i, thing in enumerate(words):
        like = [ref for ref in shared if ref.name == thing.name]
        fit = [ref for ref in references if ref.which not in (None, "all") and _is(ref, i, words)]
        junctions.append(_junction(thing, [road, side, *like], fit, i, base, usual[0], spacing))
    for ref in references:
        if ref.which != "all" and not any(_is(ref, i, words) for i in range(len(words))):
            raise Unfit(f"there is no {ref.text!r} along the road")
    return junctions, *places(words, references, spacing)


def _is(reference: Thing, i: int, words: list[Thing]) -> bool:
    """Whether an ordinal means the junction i: the n-th of its form."""
    like = [j for j, word in enumerate(words) if word.name == reference.name]
    return isinstance(reference.which, int) and i in reference.among(like)


def counted(thing: Thing) -> int:
    """How many are asked for. Raises Unfit where several are, and no number is said."""
    count, noun = thing.value("count"), thing.text.split(" that ")[0]
    if count is None and noun.endswith("s") and not thing.definite and not noun.endswith(("ss", "crossroads")):
        raise Unfit(f"say how many {thing.text}")
    return int(count or 1)


def each(things: list[Thing]) -> list[Thing]:
    """Things along a road, one by one. Raises Unfit for more than there is room for."""
    words = [thing for thing in things for _ in range(counted(thing))]
    if len(words) > MOST:
        raise Unfit(f"a road can have at most {MOST} junctions along it")
    return words


def _junction(thing: Thing, shared: list[Thing], own: list[Thing], i: int, base: Road, side_lanes: int, spacing: float) -> Road:
    """One junction of a row: what is said of it goes before what is said of all."""
    levels = [merged(own), thing, merged(shared)]
    shape = _first(levels, "shape")
    arms = _first(levels, "arms") or (3 if shape == "t" else 4)
    if arms not in range(3, 9):
        raise Unfit("junctions in a row can have three to eight arms")
    named_sides = next((values for level in levels if (values := level.values("sides"))), None)
    side = _first(levels, "side") or "right"
    sides = tuple(named_sides or (("left", "right") * 3)[: arms - 2] if arms > 3 or named_sides else (side,))
    _first(levels, "same_side")  # as junctions without a word of sides are
    if _first(levels, "alternate") and arms == 3:
        sides = (("left", "right")[i % 2],)
    speed = _first(levels, "side_speed") or speed_of(merged([t for t in shared if t.has("speed") and t is not shared[0]]))
    control = said_control(levels)
    if any(level.value("signals") is False for level in levels) and control == "signals":
        raise Unfit("traffic lights are asked for and ruled out")
    fields: Road = {"form": thing.name, "sides": sides, "control": control or "yield", "side_speed": speed or base["speed"]}
    fields |= {"side_lanes": _first(levels, "side_lanes") or side_lanes}
    fields |= {"side_length": _first(levels, "side_length") or None, "pocket": _first(levels, "pocket") or None}
    if (length := shared[1].value("length")) is not None:
        fields["side_length"] = length
    fields |= {"dead_end": _first(levels, "side_dead_end"), **turns_at(merged([*shared, thing, *own]))}
    if thing.name == "roundabout":
        size, turns = _first(levels, "size"), turns_at(merged([*shared, thing, *own]))
        if control not in (None, "yield") or turns or size == "large":
            raise Unfit("roundabouts along a road have neither lights, signs nor turn lanes, and a diameter in metres")
        ring = _first(levels, "ring_lanes") or next(
            (v for level in levels[:2] for n in ("lane_road", "lanes") for v in level.values(n)), 1
        )
        usual = max(_SMALLEST_RING, min(36.0 + 8 * ring, spacing - _BETWEEN_RINGS))
        usual = _SMALLEST_RING if size in ("small", "mini") and ring == 1 else usual
        fields |= {"ring_lanes": ring, "diameter": _first(levels, "diameter") or usual, "control": "yield"}
    return fields


def turns_at(facts: Thing) -> Road:
    """Turn lanes of a road at a junction, and the bans there."""
    fields = turning([facts], {}, "main_turn_bans")
    bans = {*facts.values("turn_bans"), *facts.values("side_turn_bans")}
    return fields | ({"side_turn_bans": tuple(sorted(bans))} if bans else {})


def _first(levels: list[Thing], name: str) -> Any:
    values = [level.value(name) for level in levels]
    return next((value for value in values if value is not None), None)


def spacing_of(road: Thing, things: list[Thing], number: int = 2) -> float | None:
    """How far apart so many junctions are said to be [m]."""
    distances = {value for thing in (road, *things) for value in thing.values("spacing")}
    if distances and number == 1:
        raise Undrawable("say how many there are so far apart")
    return only(distances, "two different distances between the junctions are said")


def places(words: list[Thing], references: list[Thing], spacing: float) -> tuple[list[float], float | None]:
    """Gaps between the junctions, and the first one's place."""
    positions: list[float | None] = []
    gaps = [spacing] * (len(words) - 1)
    for i, word in enumerate(words):
        refs = [ref for ref in references if ref.which not in (None, "all") and _is(ref, i, words)]
        own = [word] if words.count(word) == 1 else []
        places = [value for thing in (*own, *refs) for value in thing.values("position")]
        gap = [value for thing in (*own, *refs) for value in thing.values("gap")]
        positions.append(places[0] if places else gap[0] if gap and not i else None)
        if gap and i:
            gaps[i - 1] = gap[0]
    if all(place is not None for place in positions):
        at = [float(place or 0.0) for place in positions]
        if at != sorted(at):
            raise Unfit("the junctions are not said in the order in which they lie along the road")
        return [b - a for a, b in pairwise(at)], at[0]
    if any(place is not None for place in positions[1:]):
        raise Unfit("say of every junction where it lies, or of the first one alone")
    return gaps, positions[0]
