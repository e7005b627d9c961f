"""From facts to one road: which kind they describe, and its parameters."""

import math
from collections.abc import Callable
from typing import Any

from drivegen.errors import UnusableInput
from drivegen.maps.writers._choices import Choices
from drivegen.maps.writers._facts import Facts, JunctionWords
from drivegen.maps.writers._highways import fork, highway

Road = dict[str, Any]

_MOST_IN_A_ROW = 12


def road(facts: Facts, choices: Choices) -> Road | None:
    """The road as fields of `spec.Road`, or None where the facts describe none.

    Raises UnusableInput where they contradict one another.
    """
    _refuse_contradictions(facts)
    for applies, make in _KINDS:
        if applies(facts):
            return make(facts, choices)
    return None


def _refuse_contradictions(facts: Facts) -> None:
    for junction in facts.junctions:
        if junction.shape and junction.arms not in (None, 3):
            raise UnusableInput(
                f"a {junction.shape.upper()}-junction has three arms, not {junction.arms}", reason="impossible-map"
            )
    if facts.control == "signals" and facts.unsignalled:
        raise UnusableInput("the description asks for traffic lights and for none", reason="impossible-map")
    if any(lanes == 0 for lanes in [*facts.lanes.values(), *(n for _, n in facts.other_lanes)]):
        raise UnusableInput("a road needs at least one lane", reason="impossible-map")


def _control(facts: Facts, equal_roads: bool) -> str:
    if facts.control == "stop" and equal_roads:
        return "all_way_stop"
    return facts.control or "yield"


def _junction_control(facts: Facts, words: JunctionWords, equal_roads: bool) -> str:
    """Who goes first at a junction that may itself be called signalised or unsignalised."""
    if words.signals:
        return "signals"
    control = _control(facts, equal_roads)
    return "yield" if words.signals is False and control == "signals" else control


def _arms_at(count: int, shape: str, facts: Facts) -> list[float]:
    """Directions of the arms [degrees]; a T has its stem to one side, a skew crossing crosses at the angle said."""
    if shape == "y":
        return [180.0, 35.0, -35.0]
    if count == 3 and shape != "even":
        return [180.0, 0.0, 90.0 if facts.turn == "left" else 270.0]
    if count == 4 and facts.angle is not None and 20 <= facts.angle <= 160:
        return [0.0, facts.angle, 180.0, 180.0 + facts.angle]
    return [i * 360.0 / count for i in range(count)]


def _crossing(facts: Facts, choices: Choices) -> Road:
    words = facts.junctions[0]
    minor = facts.has("side_road", "meets") or "side" in facts.lanes
    count = words.arms or (3 if minor and not facts.has("verb_cross") and words.shape != "x" else 4)
    shape = words.shape or ("t" if count == 3 and minor else "even" if count == 3 else "")
    if count == 3 and not words.shape and words.arms:
        shape = "t"  # three-way junctions are drawn as a T unless a Y is asked for
    main = choices.lanes(facts, 2 if facts.has("arterial") else 1, "main")
    side = _side_lanes(facts, main)
    length = facts.lengths.get("length") or facts.lengths.get("side") or choices.length("arms", 140, 200)
    speed = choices.speed(facts)
    side_speed = facts.speeds.get("side", speed)
    unequal = (count == 3 and shape == "t") or minor or facts.has("main_road")
    arms = []
    for i, angle in enumerate(_arms_at(count, shape, facts)):
        is_main = i in _main_arms(count, shape)
        lanes = main if is_main else side
        arm: Road = {"angle": angle, "lanes_in": lanes, "lanes_out": lanes, "length": length}
        arm |= {"speed": speed if is_main else side_speed, "main": is_main or not unequal}
        arm |= {"left_turn_lane": facts.left_pocket, "right_turn_lane": facts.right_pocket}
        arms.append(arm)
    _make_one_way(facts, arms, count)
    return {"kind": "crossing", "arms": arms, "control": _junction_control(facts, words, equal_roads=not unequal)}


def _side_lanes(facts: Facts, main: int) -> int:
    if "side" in facts.lanes:
        return facts.lanes["side"]
    others = sorted(facts.other_lanes)
    if "main" in facts.lanes:
        return others[0][1] if others else main
    return others[1][1] if len(others) > 1 else main


def _main_arms(count: int, shape: str) -> set[int]:
    """Which arms belong to the main road."""
    if shape == "t":
        return {0, 1}
    return {0, 2} if count == 4 else set(range(count))


def _make_one_way(facts: Facts, arms: list[Road], count: int) -> None:
    """One-way roads of a crossing: all of them, or the first of two."""
    if not facts.one_way:
        return
    if count == 3:
        through = [(0, 1)] if len(facts.one_way) == 1 else [(0, 1), (2, None)]
    else:
        both = len(facts.one_way) > 1 or (not facts.two_way and not facts.has("crossed_by_another"))
        pairs = [(i, i + count // 2) for i in range(count // 2)]
        through = pairs if both else pairs[:1]
    for way_in, way_out in through:
        arms[way_in]["lanes_out"] = 0
        if way_out is not None:
            arms[way_out]["lanes_in"] = 0


def _roundabout(facts: Facts, choices: Choices) -> Road:
    count = facts.junctions[0].arms or 4
    if facts.junctions[0].arms is None:
        choices.assume("four roads meet the roundabout")
    ring = facts.lanes.get("ring") or (min(facts.other_lanes)[1] if facts.other_lanes and "main" not in facts.lanes else 1)
    lanes = facts.lanes.get("main") or facts.lanes.get("side")
    lanes = lanes or (min(facts.other_lanes)[1] if facts.other_lanes else min(ring, 2))
    diameter = _diameter(facts, choices, count, ring)
    length = facts.lengths.get("length") or facts.lengths.get("side") or choices.length("arms", 120, 180)
    speed = choices.speed(facts)
    angles = [180.0, 0.0, 270.0] if count == 3 and facts.junctions[0].shape == "t" else [i * 360.0 / count for i in range(count)]
    arms = [{"angle": a, "lanes_in": lanes, "lanes_out": lanes, "length": length, "speed": speed} for a in angles]
    ring_speed = facts.speeds.get("ring", min(speed, 30 / 3.6 if diameter < 60 else 40 / 3.6))
    return {"kind": "roundabout", "arms": arms, "ring_lanes": ring, "diameter": diameter, "ring_speed": ring_speed}


def _diameter(facts: Facts, choices: Choices, arms: int, ring: int) -> float:
    if "diameter" in facts.lengths:
        return facts.lengths["diameter"]
    if "radius" in facts.lengths:
        return 2 * facts.lengths["radius"]
    least = 10 * math.ceil((2 * 9.0 / (2 * math.pi / arms) + 8 * ring + 6) / 10)
    return choices.length("diameter of the roundabout", max(30, least), max(30, least) + 20)


def _row(facts: Facts, choices: Choices) -> Road:
    """Several junctions along one road, in the order of the text."""
    words = [junction for junction in facts.junctions for _ in range(min(junction.count, _MOST_IN_A_ROW + 1))]
    spacing = facts.lengths.get("spacing") or choices.length("spacing", 150, 250)
    main = choices.lanes(facts, 1, "main")
    side = facts.lanes.get("side", main if "main" not in facts.lanes else 1)
    junctions = [_along(facts, junction, side, choices.speed(facts)) for junction in words]
    return _corridor(facts, choices, main, junctions, spacing)


def _along(facts: Facts, words: JunctionWords, side: int, speed: float) -> Road:
    control = _junction_control(facts, words, equal_roads=False)
    sides = ["left", "right"]
    if words.arms == 3:
        sides = ["left"] if facts.turn == "left" else ["right"]
    if words.arms not in (None, 3, 4):
        raise UnusableInput("junctions in a row can have three or four arms", reason="impossible-map")
    ring = facts.lanes.get("ring", 1)
    form: Road = {"form": words.form, "sides": sides, "side_lanes": side, "ring_lanes": ring, "diameter": 36.0 + 8 * ring}
    return {**form, "control": control, "side_speed": facts.speeds.get("side", speed)}


def _side_streets(facts: Facts, choices: Choices) -> Road:
    count = facts.side_streets or 3
    spacing = facts.lengths.get("spacing") or choices.length("spacing", 70, 110)
    side = facts.lanes.get("side", 1)
    control = _control(facts, equal_roads=False)
    if facts.surroundings == "residential" and facts.control is None and not facts.has("main_road"):
        control = "uncontrolled"
        choices.assume("right before left")
    sides = [["left"], ["right"]]
    common = {"side_lanes": side, "control": control, "side_speed": facts.speeds.get("side", choices.speed(facts))}
    one_side = [[facts.turn]] * 2 if facts.turn else sides
    junctions = [{**common, "sides": one_side[i % 2], "dead_end": facts.has("cul_de_sac")} for i in range(count)]
    return _corridor(facts, choices, choices.lanes(facts, 1, "main"), junctions, spacing)


def _staggered(facts: Facts, choices: Choices) -> Road:
    offset = facts.lengths.get("offset") or facts.lengths.get("spacing") or choices.length("offset", 40, 60)
    main = choices.lanes(facts, 1, "main")
    control = _control(facts, equal_roads=False)
    first = facts.turn or "right"
    common = {"side_lanes": facts.lanes.get("side", 1), "control": control, "side_speed": choices.speed(facts)}
    junctions = [{**common, "sides": [first]}, {**common, "sides": ["left" if first == "right" else "right"]}]
    return _corridor(facts, choices, main, junctions, offset)


def _corridor(facts: Facts, choices: Choices, main: int, junctions: list[Road], spacing: float) -> Road:
    if len(junctions) > _MOST_IN_A_ROW:
        raise UnusableInput(f"a road can have at most {_MOST_IN_A_ROW} junctions along it", reason="impossible-map")
    between = spacing * (len(junctions) - 1)
    ends = choices.length("road before the first and after the last junction", 120, 160)
    if "length" in facts.lengths:
        ends = max(60.0, (facts.lengths["length"] - between) / 2)
    placed = [{**junction, "position": ends + i * spacing} for i, junction in enumerate(junctions)]
    one_way = bool(facts.one_way) and not facts.two_way
    return {
        "kind": "corridor",
        "alignment": {"shape": "straight", "length": 2 * ends + between},
        "lanes": main,
        "lanes_back": 0 if one_way else main,
        "speed": choices.speed(facts),
        "junctions": placed,
    }


def _street(facts: Facts, choices: Choices) -> Road:
    """A road without junctions: straight, curved, or a dead end."""
    lanes = choices.lanes(facts, 2 if facts.has("arterial") else 1, "main")
    one_way = bool(facts.one_way) and not facts.two_way
    dead_end = facts.has("cul_de_sac")
    return {
        "kind": "corridor",
        "alignment": alignment(facts, choices, (120, 180) if dead_end else (400, 600)),
        "lanes": lanes,
        "lanes_back": 0 if one_way else lanes,
        "speed": choices.speed(facts),
        "dead_end": dead_end,
    }


def alignment(facts: Facts, choices: Choices, usual: tuple[int, int], radius: float = 60.0) -> Road:
    """The line of a road without crossings."""
    shape = next((name for name in ("hairpin", "s_curve", "curve") if facts.has(name)), "straight")
    if shape == "straight":
        return {"shape": shape, "length": facts.lengths.get("length") or choices.length("length", *usual, step=50)}
    angle = facts.angle or {"hairpin": 180.0, "s_curve": 60.0, "curve": 90.0}[shape]
    angle = 180.0 if shape == "hairpin" else angle
    bend = facts.lengths.get("radius") or (20.0 if shape == "hairpin" else radius * _bend(facts))
    arcs = math.radians(angle) * bend * (2 if shape == "s_curve" else 1)
    length = facts.lengths.get("length") or arcs + choices.length("straight roads beside the bend", 200, 300, step=20)
    return {"shape": shape, "length": length, "angle": -angle if facts.turn == "right" else angle, "radius": bend}


def _bend(facts: Facts) -> float:
    return 0.5 if facts.has("sharp") else 2.0 if facts.has("gentle") else 1.0


def _grid(facts: Facts, choices: Choices) -> Road:
    rows, columns = facts.grid or (3, 3)
    if facts.grid is None:
        choices.assume("three by three streets")
    return {
        "kind": "grid",
        "rows": rows,
        "columns": columns,
        "spacing": facts.lengths.get("spacing") or facts.lengths.get("length") or choices.length("spacing", 100, 150),
        "lanes": choices.lanes(facts, 1, "main", "side"),
        "speed": choices.speed(facts),
        "control": _control(facts, equal_roads=True),
        "one_way": bool(facts.one_way),
    }


def _is_highway(facts: Facts) -> bool:
    along = bool(facts.events) or facts.has("weaving", "lane_drop", "lane_gain", "lane_change")
    return along or (facts.has("highway", "divided") and not facts.junctions and not facts.side_streets)


def _is_crossing(facts: Facts) -> bool:
    if (not facts.junctions and facts.has("meets") and facts.has("side_road", "main_road")) or facts.has("verb_cross"):
        facts.junctions.append(JunctionWords("crossing", 0, 3 if facts.has("meets") else 4, "t" if facts.has("meets") else ""))
    if facts.control == "all_way_stop" and not facts.junctions and not facts.has("curve", "s_curve", "hairpin"):
        facts.junctions.append(JunctionWords("crossing", 0, 4))  # "a four-way stop"
    return bool(facts.junctions)


def _in_a_row(facts: Facts) -> bool:
    return len(facts.junctions) > 1 or any(junction.count > 1 for junction in facts.junctions)


_KINDS: tuple[tuple[Callable[[Facts], bool], Callable[[Facts, Choices], Road]], ...] = (
    (lambda facts: facts.has("grid"), _grid),
    (lambda facts: facts.has("staggered"), _staggered),
    (_in_a_row, _row),
    (lambda facts: facts.side_streets > 1 or (facts.has("side_streets") and not facts.junctions), _side_streets),
    (lambda facts: bool(facts.junctions) and facts.junctions[0].form == "roundabout", _roundabout),
    (lambda facts: facts.has("fork") and not facts.junctions, fork),
    (_is_highway, lambda facts, choices: highway(facts, choices, alignment)),
    (_is_crossing, _crossing),
    (lambda facts: facts.has("road", "straight", "curve", "s_curve", "hairpin", "cul_de_sac", "arterial", "main_road"), _street),
)
