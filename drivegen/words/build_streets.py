"""From a scene to a street with junctions along it, side streets, or a staggered junction."""

from drivegen.words.build_crossings import TURN_LANES, said_control
from drivegen.words.build_lines import BENT, alignment
from drivegen.words.build_rows import Row, counted, each, places, row, spacing_of, turns_at
from drivegen.words.choices import Choices, is_one_way, lanes_of, median_of, speed_of, usual_speed
from drivegen.words.things import Road, Scene, Thing, Unfit, merged

_SHORTEST_END = 60.0
_ROADS = ("street", "dead_end")


def street(scene: Scene, choices: Choices) -> Road:
    """A road with whatever joins it."""
    scene.one_road("street", "main")
    if not scene.there("crossing", "roundabout", "staggered", "side", "cross") and scene.links & {"meets", "crosses"}:
        raise Unfit("it is not clear what meets or crosses the road")
    _name_bans(scene)
    mains = [thing for thing in scene.things if thing.name == "main"]
    road = scene.merged(*_ROADS, "main")
    if any(value not in (None, 1) for value in road.values("count")):
        raise Unfit("one road is drawn at a time")
    dead_end = bool(road.value("dead_end")) or any(counted(thing) for thing in scene.named("dead_end"))
    one_way = is_one_way(road)
    lanes = lanes_of(road, one_way=one_way) or (2 if road.has("arterial", "divided") else 1,) * 2
    speed = speed_of(road) or usual_speed([road])
    for thing in (road, *scene.things):
        thing.accept("row", "evenly")
        if thing.name not in ("roundabout", ""):
            thing.accept("size")
    base = {"kind": "corridor", "lanes": lanes[0], "lanes_back": 0 if one_way else lanes[1], "speed": speed}
    road.accept("no_junctions", "no_events")
    junctions, gaps, first = _junctions(scene, road, base, choices, bool(mains and lanes))
    if not junctions:
        road.accept("nothing_else")
        if road.value("signals") is True or road.has("control", "turn_bans", *TURN_LANES):
            raise Unfit("there is no crossing that could be controlled or have turn lanes")
        road.accept("signals")
        line = alignment(road, choices, (120, 180) if dead_end else (400, 600))
        return {**base, "alignment": line, "dead_end": dead_end, "median": median_of(road)}
    line = _line(road, choices, gaps, first)
    start = line.pop("start")
    for i, junction in enumerate(junctions):
        junction["position"] = start + sum(gaps[:i])
    return {**base, "alignment": line, "junctions": junctions, "dead_end": dead_end, "median": median_of(road)}


def _line(road: Thing, choices: Choices, gaps: list[float], first: float | None) -> Road:
    """The road's line with the place `start` of its first junction on it."""
    between = sum(gaps)
    if road.has(*BENT):
        if first is None:
            raise Unfit("say where along a road with bends its junctions lie")
        return {**alignment(road, choices, (400, 600)), "start": first}
    road.accept("straight")
    length = road.value("length")
    ends = choices.length("road before the first and after the last junction", 120, 160)
    if length is not None:
        ends = max(_SHORTEST_END, (length - between) / 2) if first is None else length - between - first
        if ends < 20.0 or (first is None and length < between + 40.0):
            raise Unfit(f"a road of {length:.0f} m is too short for what lies along it")
    start = ends if first is None else first
    return {"shape": "straight", "length": length or start + between + ends, "start": start}


def _junctions(scene: Scene, road: Thing, base: Road, choices: Choices, main: bool) -> Row:
    """What joins the road, the gaps between, and where the first one lies if that is said."""
    things = [thing for thing in scene.named("crossing", "roundabout", "staggered") if thing.which is None]
    references = [thing for thing in scene.things if thing.name in ("crossing", "roundabout") and thing.which is not None]
    sides = scene.named("side", "cross")
    if scene.there("staggered"):
        return _staggered(road, base, things, sides, choices)
    if things:
        return row(road, base, things, references, sides, choices, main)
    streets = [thing for thing in sides if thing.value("count") != 0]
    return _side_streets(road, base, streets, references, choices) if streets else ([], [], None)


def _name_bans(scene: Scene) -> None:
    """Whose turns are banned stands in a fact's name from here on. Raises Unfit for turn lanes of side roads."""
    for thing in scene.things:
        which = {"main": "main", "side": "side", "cross": "side"}.get(thing.name)
        for fact in thing.facts if which else ():
            fact.name = f"{which}_turn_bans" if fact.name == "turn_bans" else fact.name
            if which == "side" and fact.name in TURN_LANES:
                raise Unfit("side roads along a road have no turn lanes here")


def _side_streets(road: Thing, base: Road, sides: list[Thing], references: list[Thing], choices: Choices) -> Row:
    """Side streets, on the sides that are said, else on both sides in turn; those that cross the road are on both."""
    side = merged([*sides, *(reference for reference in references if reference.which == "all")])
    residential = "residential" in {fact.value for fact in road.facts if fact.name == "setting"}
    words = each(sides)
    spacing = spacing_of(road, sides, len(words)) or choices.length("spacing", 70, 110)
    control = said_control([side, road]) or ("uncontrolled" if residential else "yield")
    road.accept("signals")
    side.accept("signals")
    junction = _joining(side, base) | {"control": control} | turns_at(merged([road, side]))
    both = any(thing.name == "cross" or thing.value("both_sides") for thing in sides)
    side.accept("alternate")
    all_on = road.value("side") or ("right" if side.value("same_side") else None)
    if len(words) == 1:
        side.accept("middle")
    turns = [thing.value("side") or all_on or ("left", "right")[i % 2] for i, thing in enumerate(words)]
    return [{**junction, "sides": ("left", "right") if both else (turn,)} for turn in turns], *places(words, [], spacing)


def _joining(side: Thing, base: Road) -> Road:
    """What a side road is like."""
    lanes = (lanes_of(side, arms=True) or (1,))[0]
    fields = {"side_lanes": lanes, "side_speed": speed_of(side) or base["speed"]}
    return fields | {"side_length": side.value("length"), "dead_end": side.value("dead_end")}


def _staggered(road: Thing, base: Road, things: list[Thing], sides: list[Thing], choices: Choices) -> Row:
    """Two side roads on opposite sides, a little apart."""
    pair = [t for t in things if t.name == "crossing" and t.value("count") == 2 and t.value("shape") == "t"]
    whole, side = merged([*(t for t in things if t.name == "staggered"), *pair]), merged(sides)
    if len(things) > 1 + len(pair) or len(pair) > 1:
        raise Unfit("a staggered junction stands alone along its road")
    offset = spacing_of(road, [whole, side]) or whole.value("gap") or choices.length("offset", 40, 60)
    control = said_control([whole, side, road]) or "yield"
    side.accept("both_sides", "alternate")
    whole.accept("alternate", "arms")
    if sum(side.values("count")) > 2:
        raise Unfit("a staggered junction has two side roads")
    whole.accept("signals", "setting")
    road.accept("signals")
    if (speed := speed_of(whole)) is not None:
        base["speed"] = speed
    common = _joining(side, base) | {"control": control} | turns_at(merged([whole, side, road]))
    first = whole.value("side") or side.value("side") or "right"
    if (through := lanes_of(whole, arms=True)) is not None:
        base |= {"lanes": through[0], "lanes_back": through[1]}
    other = "left" if first == "right" else "right"
    return [{**common, "sides": (first,)}, {**common, "sides": (other,)}], [offset], whole.value("position")
