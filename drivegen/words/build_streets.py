"""From a scene to a street with junctions along it, side streets, or a staggered junction."""

from itertools import pairwise
from typing import Any

from drivegen.words.build_crossings import control_of
from drivegen.words.build_lines import BEND_FIELDS, alignment
from drivegen.words.choices import Choices, is_one_way, lanes_of, speed_of, usual_speed
from drivegen.words.things import Scene, Thing, Unfit, merged

Road = dict[str, Any]

_MOST = 12
_SHORTEST_END = 60.0
_SMALLEST_RING, _BETWEEN_RINGS = 28.0, 25.0
_ROADS = ("street", "dead_end")


def street(scene: Scene, choices: Choices) -> Road:
    """A road with whatever joins it."""
    scene.one_road("street", "main")
    if not scene.there("crossing", "roundabout", "staggered", "side", "cross") and scene.links & {"meets", "crosses"}:
        raise Unfit("it is not clear what meets or crosses the road")
    mains = [thing for thing in scene.things if thing.name == "main"]
    road = scene.merged(*_ROADS, "main")
    road.values("count")
    dead_end = bool(road.value("dead_end")) or scene.there("dead_end")
    one_way = is_one_way(road)
    lanes = lanes_of(road, one_way=one_way) or (2 if road.has("arterial") else 1,) * 2
    speed = speed_of(road)
    speed = usual_speed([road]) if speed is None else speed
    for thing in (road, *scene.things):
        thing.values("row")
        if thing.name not in ("roundabout", ""):
            thing.values("size")
    base = {"kind": "corridor", "lanes": lanes[0], "lanes_back": 0 if one_way else lanes[1], "speed": speed}
    road.values("no_junctions"), road.values("no_events")
    junctions, gaps, first = _junctions(scene, road, base, choices, bool(mains and lanes))
    if not junctions:
        if road.value("signals") is True or road.has("control", "left_turn_lane", "right_turn_lane"):
            raise Unfit("there is no crossing that could be controlled or have turn lanes")
        road.values("signals")
        line = alignment(road, choices, (120, 180) if dead_end else (400, 600))
        return {**base, "alignment": line, "dead_end": dead_end}
    line = _line(road, choices, gaps, first)
    start = line.pop("start")
    for i, junction in enumerate(junctions):
        junction["position"] = start + sum(gaps[:i])
    return {**base, "alignment": line, "junctions": junctions, "dead_end": dead_end}


def _line(road: Thing, choices: Choices, gaps: list[float], first: float | None) -> Road:
    """The road's line with the place `start` of its first junction on it."""
    between = sum(gaps)
    if road.has(*(name for name in BEND_FIELDS if name not in ("radius", "sharpness"))):
        if first is None:
            raise Unfit("say where along a road with bends its junctions lie")
        return {**alignment(road, choices, (400, 600)), "start": first}
    road.values("straight")
    length = road.value("length")
    ends = choices.length("road before the first and after the last junction", 120, 160)
    if length is not None:
        ends = max(_SHORTEST_END, (length - between) / 2) if first is None else length - between - first
        if ends < 20.0 or (first is None and length < between + 40.0):
            raise Unfit(f"a road of {length:.0f} m is too short for what lies along it")
    start = ends if first is None else first
    return {"shape": "straight", "length": length or start + between + ends, "start": start}


def _junctions(
    scene: Scene, road: Thing, base: Road, choices: Choices, main: bool
) -> tuple[list[Road], list[float], float | None]:
    """What joins the road, the gaps between, and where the first one lies if that is said."""
    things = [thing for thing in scene.named("crossing", "roundabout", "staggered") if thing.which is None]
    references = [thing for thing in scene.things if thing.name in ("crossing", "roundabout") and thing.which is not None]
    sides = scene.named("side", "cross")
    if scene.there("staggered"):
        return _staggered(road, base, things, sides, choices)
    if things:
        return _row(road, base, things, references, sides, choices, main)
    streets = [thing for thing in sides if thing.value("count") != 0]
    return _side_streets(road, base, streets, references, choices) if streets else ([], [], None)


def _row(
    road: Thing, base: Road, things: list[Thing], references: list[Thing], sides: list[Thing], choices: Choices, main: bool
) -> tuple[list[Road], list[float], float | None]:
    words = [thing for thing in things for _ in range(_counted(thing))]
    if len(words) > _MOST:
        raise Unfit(f"a road can have at most {_MOST} junctions along it")
    side = merged(sides)
    lanes = lanes_of(side, arms=True)
    usual = (base["lanes"] if not main else 1,) if lanes is None else lanes
    spacing = spacing_of(road, [*things, *sides]) or choices.length("spacing", 150, 250)
    shared = [thing for thing in references if thing.which == "all"]
    junctions = []
    for i, thing in enumerate(words):
        like = [ref for ref in shared if ref.name == thing.name]
        fit = [ref for ref in references if ref.which not in (None, "all") and _is(ref, i, words)]
        facts = Thing("", facts=[f for t in (road, thing, *like, *fit, side) for f in t.facts if _of_junction(f.name)])
        junctions.append(_junction(facts, thing, [road, side, *like], fit, i, base, usual[0], spacing))
    for ref in references:
        if ref.which != "all" and not any(_is(ref, i, words) for i in range(len(words))):
            raise Unfit(f"there is no {ref.text!r} along the road")
    return junctions, *_places(words, references, spacing)


def _of_junction(name: str) -> bool:
    return name in ("left_turn_lane", "right_turn_lane", "both_turn_lanes", "pocket", "no_turn_lanes")


def _is(reference: Thing, i: int, words: list[Thing]) -> bool:
    """Whether an ordinal means the junction i: the n-th of its form."""
    like = [j for j, word in enumerate(words) if word.name == reference.name]
    n = int(reference.which)
    return bool(like) and (n == -1 or n <= len(like)) and like[n - 1 if n > 0 else -1] == i


def _counted(thing: Thing) -> int:
    """How many are asked for. Raises Unfit where several are, and no number is said."""
    count = thing.value("count")
    if count is None and thing.text.endswith("s") and not thing.definite and not thing.text.endswith(("ss", "crossroads")):
        raise Unfit(f"say how many {thing.text}")
    return int(count or 1)


def _junction(
    turning: Thing, thing: Thing, shared: list[Thing], own: list[Thing], i: int, base: Road, side_lanes: int, spacing: float
) -> Road:
    """One junction of a row: what is said of it goes before what is said of all."""
    levels = [merged(own), thing, merged(shared)]
    shape = _first(levels, "shape")
    arms = _first(levels, "arms") or (3 if shape == "t" else 4)
    if arms not in range(3, 9):
        raise Unfit("junctions in a row can have three to eight arms")
    named_sides = next((values for level in levels if (values := level.values("sides"))), None)
    side = _first(levels, "side") or "right"
    sides = tuple(named_sides or (("left", "right") * 3)[: arms - 2] if arms > 3 or named_sides else (side,))
    if _first(levels, "alternate") and arms == 3:
        sides = (("left", "right")[i % 2],)
    speed = _first(levels, "side_speed") or speed_of(merged([t for t in shared if t.has("speed") and t is not shared[0]]))
    control = next((control_of(level, False) for level in levels if level.has("control")), None)
    if any(level.value("signals") is False for level in levels) and control == "signals":
        raise Unfit("traffic lights are asked for and ruled out")
    fields: Road = {"form": thing.name, "sides": sides, "control": control or "yield", "side_speed": speed or base["speed"]}
    fields |= {"side_lanes": _first(levels, "side_lanes") or side_lanes}
    fields |= {name: v for name in ("side_length", "pocket") if (v := _first(levels, name))}
    if (length := shared[1].value("length")) is not None:
        fields["side_length"] = length
    for turn in ("left", "right"):
        if turning.values(f"{turn}_turn_lane") or turning.values("both_turn_lanes"):
            fields[f"{turn}_turn_lane"] = True
    fields |= {"dead_end": True} if _first(levels, "side_dead_end") else {}
    if thing.name == "roundabout":
        ring = _first(levels, "ring_lanes") or next(
            (v for level in levels[:2] for n in ("lane_road", "lanes") for v in level.values(n)), 1
        )
        usual = max(_SMALLEST_RING, min(36.0 + 8 * ring, spacing - _BETWEEN_RINGS))
        usual = _SMALLEST_RING if _first(levels, "size") in ("small", "mini") and ring == 1 else usual
        fields |= {"ring_lanes": ring, "diameter": _first(levels, "diameter") or usual, "control": "yield"}
    return fields


def _first(levels: list[Thing], name: str) -> Any:
    values = [level.value(name) for level in levels]
    return next((value for value in values if value is not None), None)


def spacing_of(road: Thing, things: list[Thing]) -> float | None:
    """How far apart junctions are said to be [m]."""
    distances = {value for thing in (road, *things) for value in thing.values("spacing")}
    if len(distances) > 1:
        raise Unfit("two different distances between the junctions are said")
    return distances.pop() if distances else None


def _places(words: list[Thing], references: list[Thing], spacing: float) -> tuple[list[float], float | None]:
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


def _side_streets(
    road: Thing, base: Road, sides: list[Thing], references: list[Thing], choices: Choices
) -> tuple[list[Road], list[float], float | None]:
    """Side streets, on the sides that are said, else on both sides in turn; those that cross the road are on both."""
    side = merged([*sides, *(reference for reference in references if reference.which == "all")])
    residential = "residential" in {fact.value for fact in road.facts if fact.name == "setting"}
    counts = [(thing, _counted(thing)) for thing in sides]
    spacing = spacing_of(road, sides) or choices.length("spacing", 70, 110)
    levels = [side, road]
    control = next((control_of(level, False) for level in levels if level.has("control")), None)
    control = control or ("uncontrolled" if residential else "yield")
    road.values("signals"), side.values("signals")
    lanes = (lanes_of(side, arms=True) or (1,))[0]
    junction: Road = {"side_lanes": lanes, "control": control, "side_speed": speed_of(side) or base["speed"]}
    if (length := side.value("length")) is not None:
        junction["side_length"] = length
    junction |= {"dead_end": True} if side.value("dead_end") else {}
    for turn in ("left", "right"):
        if road.values(f"{turn}_turn_lane") or side.values(f"{turn}_turn_lane"):
            junction[f"{turn}_turn_lane"] = True
    every: list[tuple[str, ...]] = []
    both = any(thing.name == "cross" or thing.value("both_sides") for thing in sides)
    side.values("alternate"), road.values("cross_streets")
    for thing, count in counts:
        own = thing.value("side")
        for _ in range(count):
            turn = ("left", "right")[len(every) % 2]
            same = "right" if thing.value("same_side") else None
            every.append(("left", "right") if both else (own or same or turn,))
    if len(every) > _MOST:
        raise Unfit(f"a road can have at most {_MOST} junctions along it")
    if len(counts) == 1 and counts[0][1] == 1:
        places = [spacing, counts[0][0].value("position")]
        return [{**junction, "sides": every[0]}], [], places[1]
    starts = _starts([thing for thing, count in counts if count == 1])
    if len(starts) == len(counts) and starts:
        return [{**junction, "sides": s} for s in every], [b - a for a, b in pairwise(starts)], starts[0]
    return [{**junction, "sides": s} for s in every], [spacing] * (len(every) - 1), None


def _starts(things: list[Thing]) -> list[float]:
    """Where each lies, as it is said: from the start, or from the one before; none where that is not said of all."""
    starts: list[float] = []
    for thing in things:
        place, gap = thing.value("position"), thing.value("gap")
        if place is None and gap is None:
            return []
        starts.append(float(place if gap is None else gap + (starts[-1] if starts else 0.0)))
    if starts != sorted(starts):
        raise Unfit("the side streets are not said in the order in which they lie along the road")
    return starts


def _staggered(
    road: Thing, base: Road, things: list[Thing], sides: list[Thing], choices: Choices
) -> tuple[list[Road], list[float], float | None]:
    """Two side roads on opposite sides, a little apart."""
    whole, side = merged([t for t in things if t.name == "staggered"]), merged(sides)
    if len(things) > 1:
        raise Unfit("a staggered junction stands alone along its road")
    offset = spacing_of(road, [whole, side]) or whole.value("gap") or choices.length("offset", 40, 60)
    control = next((control_of(level, False) for level in (whole, side, road) if level.has("control")), "yield")
    side.values("count"), whole.values("signals"), road.values("signals"), side.values("both_sides"), whole.values("setting")
    lanes = (lanes_of(side, arms=True) or (1,))[0]
    common = {"side_lanes": lanes, "control": control, "side_speed": speed_of(side) or base["speed"]}
    first = whole.value("side") or side.value("side") or "right"
    speed = speed_of(whole)
    base["speed"] = common["side_speed"] = speed or base["speed"]
    if (through := lanes_of(whole, arms=True)) is not None:
        base |= {"lanes": through[0], "lanes_back": through[1]}
    other = "left" if first == "right" else "right"
    return [{**common, "sides": (first,)}, {**common, "sides": (other,)}], [offset], whole.value("position")
