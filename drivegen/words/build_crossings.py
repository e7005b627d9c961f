"""From a scene to a crossing: its arms, how many lanes each has, which ways they lead."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from drivegen.layouts.crossings import SIGNS, STRAIGHT, turned
from drivegen.words.choices import Choices, is_one_way, lanes_of, median_of, speed_of, usual_speed
from drivegen.words.slots import SLOTS
from drivegen.words.things import Road, Scene, Thing, Undrawable, Unfit, merged, only

TURN_LANES = ("turn_lanes", "turn_lanes_n", "both_turn_lanes", "turn_pocket", "pocket")
_LANES = ("lanes", "lanes_each", "lanes_total", "lanes_pair", "lane_road")


def control_of(thing: Thing, equal_roads: bool, usual: str = "yield") -> str:
    """Who goes first; stop signs where no road is the main one are for everybody."""
    control, signals = thing.value("control"), thing.value("signals")
    if control == "signals" and signals is False:
        raise Unfit("traffic lights are asked for and ruled out")
    if control == "stop_sign":
        return "all_way_stop" if equal_roads else "stop"
    return control or usual


def said_control(things: Sequence[Thing]) -> str | None:
    """Who goes first by the first of the things of which it is said, None where it is said of none."""
    return next((control_of(thing, False) for thing in things if thing.has("control")), None)


def crossing(scene: Scene, choices: Choices) -> Road:
    """The one place where roads cross or meet."""
    whole = scene.merged("crossing")
    side, main = scene.named("side", "cross"), scene.named("main")
    compass = scene.named("east_west"), scene.named("north_south")
    if any(compass) and (side or main or scene.there("street")):
        raise Unfit("say the roads by their directions, or as the main and the side road")
    streets, arms = scene.named("street"), scene.named("arm")
    joins = {link for thing in streets for link in thing.links} | scene.links
    roads = [*main, *streets, *side]
    if any((road.value("count") or 1) > 1 for road in side):
        raise Unfit("several side roads cross a road at several places")
    shape, count = _shape_and_count(scene, whole, joins, roads)
    even = any([whole.value("evenly"), *(road.value("evenly") for road in roads)])
    _of_y(shape, whole, arms, side, roads)
    angles = _angles(count, shape, whole, [*side, *streets], even)
    first, second = _two_roads(count, shape, main, side, streets, joins)
    if not (first or second):
        _check_one(streets)
    if any(compass):
        several = any(road.value("count") not in (None, 1) for road in (*compass[0], *compass[1]))
        if several or count != 4 or shape is not None or len(compass[0]) > 1 or len(compass[1]) > 1:
            raise Unfit("roads are named by their directions at a crossing of two roads")
        first, second = compass
        roads = [*compass[0], *compass[1]]
    shared = Thing("", facts=[*whole.facts, *(f for road in roads if road not in (*first, *second) for f in road.facts)])
    prior = [bool(merged(road).value("priority")) for road in compass]
    if all(prior):
        raise Unfit("one of two roads has priority, not both")
    unequal = shape == "t" or bool(side or main) or any(prior) or shared.has("main_turn_bans", "side_turn_bans")
    of_main = {0, 1} if shape == "t" else {0, 2} if count == 4 and (first or second or unequal) else set(range(count))
    if prior[1]:  # the road from south to north is the first one then
        first, second, of_main = second, first, {1, 3}
    lengths = [fact.text for road in roads if road not in (*first, *second) for fact in road.facts if fact.name == "length"]
    if lengths:
        raise Unfit(f"say of the arms how long they are, not of the roads: {lengths[0]!r}")
    groups = {True: _group(shared, first, 2), False: _group(shared, second, 2 if count == 4 else 1)}
    built = _arms(angles, groups, of_main, shared, choices)
    for i, arm in enumerate(built):
        arm["main"] = i in of_main or not unequal
    _make_one_way(built, shared, first, second, of_main, count)
    every = [fact for fact in whole.facts if fact.name in ("lanes_in", "lanes_out")]
    own_of_arms(built, [*arms, Thing("arm", which="all", facts=every)])
    shared.facts += [fact for thing in side for fact in thing.facts if fact.name == "control"]
    return {"kind": "crossing", "arms": built, "control": control_of(shared, not unequal)}


def _arms(angles: list[float], groups: dict[bool, Road], of_main: set[int], shared: Thing, choices: Choices) -> list[Road]:
    """The arms, each as its road is said to be, else as both are, else as usual."""
    usual = speed_of(shared) or usual_speed([shared, groups[True]["thing"], groups[False]["thing"]])
    lanes_unsaid = groups[True]["lanes"] or (0, 0)
    if not lanes_unsaid[1]:  # nothing, or a one-way road's, which say nothing of the other
        lanes_unsaid = (2 if shared.has("arterial", "divided") else 1, 0)
    length = shared.value("length") or choices.length("arms", 140, 200)
    arms, median = [], median_of(shared)
    for i, angle in enumerate(angles):
        road = groups[i in of_main]
        lanes = road["lanes"] or lanes_unsaid
        arm: Road = {"angle": angle, "speed": road["speed"] or usual, "length": road["length"] or length}
        arm |= {"lanes_in": lanes[0], "lanes_out": lanes[0], "median": road["median"] or median}
        arm |= {name: value for name in ("lanes_in", "lanes_out") if (value := road["thing"].value(name)) is not None}
        arms.append(arm | turning((shared, road["thing"]), arm, "main_turn_bans" if i in of_main else "side_turn_bans"))
    return arms


def _shape_and_count(scene: Scene, whole: Thing, joins: set[str], roads: list[Thing]) -> tuple[str | None, int]:
    """Which letter the crossing looks like, if any, and how many arms it has."""
    shape, count = whole.value("shape"), count_of(whole, scene.named("arm"))
    alike = count == 3 and whole.value("angle") not in (None, 90.0)  # an angle between each two of three arms
    number = sum(int(road.value("count") or 1) for road in roads if road.name == "street" and road.which is None)
    if scene.there("main") and scene.there("side") and not (joins or whole.facts or scene.there("crossing", "cross")):
        raise Unfit("say whether the side road crosses the main road or ends at it")
    texts = [road.text for road in roads if road.name == "street" and road.which is None and road.value("count") is None]
    if number > 2 and len(set(texts)) < len(texts):
        raise Unfit(f"say whether {max(texts, key=texts.count)!r} is one road or several")
    if count is None and shape is None:
        meets = "meets" in joins and "crosses" not in joins and not scene.there("cross")
        named = [thing.text for thing in scene.things if thing.name == "crossing"]
        joined = scene.there("side") and not any("cross" in text for text in named)  # "joins it at an intersection"
        t_like = meets and len(roads) >= 2 and (not named or joined or "ends" in joins)
        count = number if number > 2 and not scene.there("side", "cross") else 3 if t_like else 4
    count = 3 if shape in ("t", "y") and count is None else count
    if shape in ("t", "y") and count != 3:
        raise Unfit(f"a {shape.upper()}-junction has three arms, not {count}")
    if count is None or count not in range(3, 9):
        raise Unfit(f"3 to 8 roads can meet at a crossing, not {count}")
    if whole.value("star") and count < 5:
        raise Unfit("a star has five arms or more")
    return ("t" if count == 3 and shape is None and not (alike or whole.value("evenly")) else shape), count


def _of_y(shape: str | None, whole: Thing, arms: list[Thing], side: list[Thing], roads: list[Thing]) -> None:
    """Of a Y an angle of the branches is that between them, and the stem is the first arm."""
    for arm in arms if shape == "y" else ():
        angles = [fact for fact in arm.facts if fact.name == "angle" and arm.which in (None, "all")]
        whole.facts += angles
        arm.facts = [fact for fact in arm.facts if fact not in angles]
    for stem in [road for road in side if shape == "y" and "stem" in road.text]:
        side.remove(stem)
        roads.remove(stem)
        arms.append(replace(stem, name="arm", which=1))


def _check_one(streets: list[Thing]) -> None:
    """Raises Unfit where something is said of one of the roads that cross, and not which one: "with a one-way street"."""
    for road in streets:
        one = road.which is None and road.value("count") in (None, 1) and not road.text.endswith("s")
        if one and road.has("one_way", "speed", "divided", "median", *_LANES):
            raise Unfit(f"say what the other road is like, or of which roads {road.text!r} is one")


def count_of(whole: Thing, arms: list[Thing]) -> int | None:
    """How many arms are asked for, None where it is not said."""
    counts = {int(value) for value in whole.values("arms")}
    counts |= {int(value) for arm in arms if arm.which in (None, "all") for value in arm.values("count")}
    facts = [fact for fact in whole.facts if fact.name in ("arms", "angle")]  # "where two roads", "cross at 60 degrees"
    said = " ".join(fact.text for fact in facts)
    crossed = whole.has("skew", "angle") or any(word in said for word in ("cross", "intersect", "of ", "between "))
    counts = {4 if count == 2 and crossed else count for count in counts}
    count = only(counts, f"{' and '.join(map(str, sorted(counts)))} arms contradict one another")
    if any(value != 1 for value in whole.values("count")):
        raise Unfit("one crossing is not several")
    return count


def _two_roads(
    count: int, shape: str | None, main: list[Thing], side: list[Thing], streets: list[Thing], joins: set[str]
) -> tuple[list[Thing], list[Thing]]:
    """The things that are the first road (of a T: the one that goes through) and the second one."""
    if len(main) > 1 or len(side) > 1 or any(road.several for road in main):
        raise Unfit("there is one main road and one side road at a crossing")
    if (count > 4 or shape == "y") and any(road.has("speed", *_LANES) for road in (*main, *side)):
        raise Unfit(f"say by their numbers which of the {count} arms are of the main road")
    single = [road for road in streets if road.which is None]
    if main or side:
        rest = single if single and (not main or not side) else []
        if rest and not (joins or side) and main[0].definite:
            raise Unfit(f"say whether {rest[0].text!r} is the main road")
        if len(rest) > 1 or (main and side and single):
            return main, side
        return main or rest, side or rest
    if count in (3, 4) and len(single) == 2 and shape != "y":
        return (single[1:], single[:1]) if "meets" in joins and count == 3 else (single[:1], single[1:])
    return [], []


def _group(shared: Thing, roads: list[Thing], arms: int) -> dict[str, Any]:
    """Lanes and limit that are said of one of two roads, or of both, and the length of each of its arms."""
    own = merged(roads)
    own.accept("count")
    one_way = own.has("one_way") or shared.has("one_way")
    lanes = lanes_of(own, one_way=own.has("one_way"), arms=True)
    lanes = lanes or lanes_of(shared, one_way=one_way, arms=True)
    if lanes and lanes[1] not in (0, lanes[0]):
        raise Unfit("say of the arms how many lanes lead in and out")
    length = own.value("length")
    return {"lanes": lanes, "speed": speed_of(own), "median": median_of(own), "length": length and length / arms, "thing": own}


def _angles(count: int, shape: str | None, whole: Thing, side: list[Thing], even: bool) -> list[float]:
    """Directions of the arms [degrees]; a T has its stem to one side, a skew crossing crosses at the angle said."""
    angle = whole.value("angle") or next((v for road in side for v in road.values("angle")), None)
    turned = next((v for road in (*side, whole) for v in road.values("side")), "right")
    if whole.value("skew") and angle is None:
        raise Unfit("say at which angle the roads cross")
    if even and shape == "y":
        angle = only([120.0, *([] if angle is None else [angle])], "a Y of equal angles has three of 120 degrees")
    if angle is not None and count * angle == 360.0 and shape is None:
        angle = None
    if angle is not None and (count not in (3, 4) or not 20 <= angle <= 160):
        raise Unfit(f"an angle of {angle:g} degrees can be drawn between two roads that cross, or in a T or Y, from 20 to 160")
    if shape == "y":
        half = (angle or 70.0) / 2
        return [180.0, half, -half if angle is None else 360.0 - half]
    if shape == "t":
        skew = 90.0 if angle is None else float(angle)
        return [180.0, 0.0, skew if turned == "left" else 360.0 - skew]
    if angle is not None and count == 3:
        raise Unfit(f"three roads meet at 120 degrees each, not {angle:g}: say a T or a Y, or at which angle a side road joins")
    if angle is not None:
        return [0.0, angle, 180.0, 180.0 + angle]
    return [i * 360.0 / count for i in range(count)]


def turning(things: Sequence[Thing], arm: Road, bans: str = "turn_bans") -> Road:
    """Turn lanes and bans of a road with those of `arm`, as said of `things`; a length alone is that of lanes to the left."""
    fields: Road = {}
    for thing in things:
        lanes = [*thing.values("turn_lanes_n"), *((1, side) for side in thing.values("turn_lanes"))]
        lanes += [(1, "left"), (1, "right")] if thing.values("both_turn_lanes") else []
        pockets = [*thing.values("pocket")]
        for pair in thing.values("turn_pocket"):
            lanes += [(1, value) for value in pair if isinstance(value, str)]
            pockets += [value for value in pair if not isinstance(value, str)]
        if thing.values("no_turn_lanes") and lanes:
            raise Unfit("turn lanes are asked for and ruled out")
        if len(set(lanes)) > len({side for _, side in lanes}):
            raise Unfit("two numbers of turn lanes are said of one road")
        pocket = only(pockets, "two lengths of turn lanes are said of one road")
        fields |= {f"{side}_turn_lanes": number for number, side in lanes}
        if banned := {*thing.values("turn_bans"), *thing.values(bans)}:
            fields["turn_bans"] = tuple(sorted(banned | set((arm | fields).get("turn_bans", ()))))
        if pocket is not None:
            fields["pocket"] = pocket
            if not any(name.endswith("turn_lanes") and value for name, value in (arm | fields).items()):
                fields["left_turn_lanes"] = 1
    return fields


def _make_one_way(
    arms: list[Road], shared: Thing, first: list[Thing], second: list[Thing], of_main: set[int], count: int
) -> None:
    """One-way roads lead in over their first arm and out over the one opposite."""
    all_one_way = is_one_way(shared)
    for roads, indices in ((first, sorted(of_main)), (second, sorted(set(range(count)) - of_main))):
        ways = [is_one_way(road) for road in roads]
        if not (indices and (all_one_way or any(ways))):
            continue
        if len(indices) > 2 and count != 4:
            raise Unfit("one-way roads can be drawn at crossings of three or four arms")
        pairs = [(0, 2), (1, 3)] if count == 4 and len(indices) == 4 else [tuple(indices[:2])]
        for pair in pairs:
            arms[pair[0]]["lanes_out"] = 0
            for behind in pair[1:]:
                arms[behind]["lanes_in"] = 0


def own_of_arms(built: list[Road], arms: list[Thing]) -> None:
    """What is said of single arms, by ordinal or direction, and of every arm."""
    for arm in sorted(arms, key=lambda arm: isinstance(arm.which, (int, float))):
        for road in _meant(built, arm):
            for name in ("angle", "speed", "length", "pocket", "lanes_in", "lanes_out"):
                if (value := arm.value(name)) is not None:
                    road[name] = value
            if (main := arm.value("priority")) is not None:
                road["main"] = main
            if (median := median_of(arm)) is not None:
                road["median"] = median
            if (lanes := lanes_of(arm, one_way=False, arms=True)) is not None:
                road |= {"lanes_in": lanes[0], "lanes_out": lanes[1]}
            road |= turning((arm,), road)
            check_turns(built, road, arm)
            if arm.value("two_way") and 0 in (road["lanes_in"], road["lanes_out"]):
                raise Unfit("an arm is said to be two-way, and its road one-way")
            if arm.has("control"):
                raise Unfit("signs of single arms cannot be drawn")


def check_turns(arms: Sequence[Road], arm: Road, said: Thing) -> None:
    """Raises Undrawable for turn lanes of one arm, of which they are `said`, to a side to which nobody can or may turn."""
    there = [other for other in arms if other is not arm and other["lanes_out"]] if arm["lanes_in"] else []
    turns = [turned(arm["angle"], other["angle"]) for other in there]
    for side, sign in SIGNS if isinstance(said.which, (int, float)) and said.has(*TURN_LANES) else ():
        may = side not in arm.get("turn_bans", ()) and any(sign * turn > STRAIGHT for turn in turns)
        if arm.get(f"{side}_turn_lanes") and not may:
            which = SLOTS["nth" if isinstance(said.which, int) else "compass"].speak(said.which)
            raise Undrawable(f"who comes over the {which} arm cannot turn {side}")


def _meant(built: list[Road], arm: Thing) -> list[Road]:
    if arm.which in (None, "all"):
        return built
    if isinstance(arm.which, int):
        if not (one := arm.among(built)):
            raise Unfit(f"there is no arm {arm.which}: there are {len(built)}")
        return one
    near = [road for road in built if abs(math.remainder(road["angle"] - arm.which, 360.0)) <= 1.0]
    if len(near) != 1:
        raise Unfit(f"no arm leads to where {arm.text!r} is")
    return near
