"""Crossings and roundabouts from facts: their arms, how many lanes each has and which ways it leads."""

import math
from typing import Any

from drivegen.errors import UnusableInput
from drivegen.maps.writers._built import ISLAND
from drivegen.maps.writers._choices import Choices
from drivegen.maps.writers._control import control_at
from drivegen.maps.writers._facts import Facts

Road = dict[str, Any]

_ROUNDED = 0.9
_SHORTEST_ARM = 20.0
_NEARLY = 15.0  # roads that meet at about 120 degrees make a Y, not a T
_LEAST_SKEW = 20.0
_LEAST_Y, _MOST_Y = 20.0, 160.0  # between the branches of a Y [degrees]


def crossing(facts: Facts, choices: Choices) -> Road:
    """The only junction that is spoken of, with its arms."""
    words = facts.junctions[0]
    minor = facts.has("side_road") or (facts.has("meets") and words.shape == "t")
    count = words.arms or (3 if words.shape == "t" else 4)
    shape = words.shape or ("t" if count == 3 and minor else "even" if count == 3 else "")
    if count == 3 and not words.shape and words.arms:
        shape = "t"  # three-way junctions are drawn as a T unless a Y is asked for
    main = choices.lanes(facts, 2 if facts.has("arterial", "divided") else 1, "main", "arms")
    side = _side_lanes(facts, main)
    length = facts.lengths.get("length") or facts.lengths.get("side") or choices.length("arms", 140, 200)
    speed = choices.speed(facts)
    side_speed = facts.speeds.get("side", speed)
    unequal = (count == 3 and shape == "t") or minor or facts.has("main_road")
    arms = []
    for i, angle in enumerate(_arms_at(count, shape, facts)):
        is_main = i in _main_arms(count, shape)
        lanes = main if is_main else side
        if shape == "y" and i and "main" in facts.lanes:
            lanes = facts.lanes.get("arms", main)  # the branches'
        own = facts.lengths.get("side", length) if not is_main and "length" in facts.lengths else length
        arm: Road = {"angle": angle, "lanes_in": lanes, "lanes_out": lanes, "length": own}
        arm |= {"speed": speed if is_main else side_speed, "main": is_main or not unequal}
        pockets = facts.pocket_role in ("", "main" if is_main else "side")
        arm |= {"pocket": facts.lengths["pocket"]} if "pocket" in facts.lengths else {}
        arm |= {"left_turn_lane": facts.left_pocket and pockets, "right_turn_lane": facts.right_pocket and pockets}
        arms.append(arm)
    position = _middle_of(facts) if words.middle else words.position
    if position is not None and count in (3, 4) and shape != "y":
        _place_along(facts, choices, position, arms)
    _make_one_way(facts, arms, count)
    return {"kind": "crossing", "arms": arms, "control": control_at(facts, words, equal_roads=not unequal)}


def _arms_at(count: int, shape: str, facts: Facts) -> list[float]:
    """Directions of the arms [degrees]; a T has its stem to one side, a skew crossing crosses at the angle said."""
    if shape == "y" or (count == 3 and shape == "t" and facts.angle is not None and abs(facts.angle - 120.0) <= _NEARLY):
        half = facts.angle / 2 if facts.angle is not None and _LEAST_Y <= facts.angle <= _MOST_Y else 35.0
        return [180.0, half, -half]
    if count == 3 and shape != "even":
        skew = facts.angle if facts.angle is not None and _LEAST_SKEW <= facts.angle <= 180.0 - _LEAST_SKEW else 90.0
        return [180.0, 0.0, skew if facts.turn == "left" else 360.0 - skew]
    if count == 4 and facts.angle is not None and 20 <= facts.angle <= 160:
        return [0.0, facts.angle, 180.0, 180.0 + facts.angle]
    return [i * 360.0 / count for i in range(count)]


def _middle_of(facts: Facts) -> float | None:
    """Half the length that is said of the whole road [m]."""
    return facts.lengths["length"] / 2 if "length" in facts.lengths else None


def _place_along(facts: Facts, choices: Choices, position: float, arms: list[Road]) -> None:
    """Make the main road's arms as long as the junction's place along it asks for."""
    before, after, *others = sorted(arms, key=lambda arm: [180.0, 0.0].index(arm["angle"]) if arm["angle"] in (180.0, 0.0) else 2)
    before["length"] = position
    if facts.lengths.get("length", 0.0) > position + _SHORTEST_ARM:
        after["length"] = facts.lengths["length"] - position
        for arm in others:
            arm["length"] = facts.lengths.get("side") or choices.length("side roads", 140, 200)


def _side_lanes(facts: Facts, main: int) -> int:
    if "side" in facts.lanes:
        return facts.lanes["side"]
    others = sorted(facts.other_lanes)
    if "main" in facts.lanes or "arms" in facts.lanes:
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
    through: list[tuple[int, int | None]]
    if facts.one_way_role and count in (3, 4):
        ways: dict[str, tuple[int, int | None]] = {"main": (0, 1), "side": (2, None)}
        ways = ways if count == 3 else {"main": (0, 2), "side": (1, 3)}
        through = [ways[facts.one_way_role]]
    elif count == 3:
        through = [(0, 1)] if len(facts.one_way) == 1 else [(0, 1), (2, None)]
    else:
        both = len(facts.one_way) > 1 or (not facts.two_way and not facts.has("crossed_by_another"))
        pairs: list[tuple[int, int | None]] = [(i, i + count // 2) for i in range(count // 2)]
        through = pairs if both else pairs[:1]
    for way_in, way_out in through:
        arms[way_in]["lanes_out"] = 0
        if way_out is not None:
            arms[way_out]["lanes_in"] = 0


def roundabout(facts: Facts, choices: Choices) -> Road:
    """A ring with its arms."""
    count = facts.junctions[0].arms or 4
    if facts.junctions[0].arms is None:
        choices.assume("four roads meet the roundabout")
    ring = facts.lanes.get("ring") or (min(facts.other_lanes)[1] if facts.other_lanes and "main" not in facts.lanes else 1)
    lanes = facts.lanes.get("arms") or facts.lanes.get("main") or facts.lanes.get("side")
    lanes = lanes or (min(facts.other_lanes)[1] if facts.other_lanes else min(ring, 2))
    diameter = _diameter(facts, choices, count, ring)
    length = facts.lengths.get("length") or facts.lengths.get("side") or choices.length("arms", 120, 180)
    speed = choices.speed(facts)
    angles = [180.0, 0.0, 270.0] if count == 3 and facts.junctions[0].shape == "t" else [i * 360.0 / count for i in range(count)]
    arms = [{"angle": a, "lanes_in": lanes, "lanes_out": lanes, "length": length, "speed": speed} for a in angles]
    position = _middle_of(facts) if facts.junctions[0].middle else facts.junctions[0].position
    if position is not None and 180.0 in angles:
        _place_along(facts, choices, position, arms)
    ring_speed = facts.speeds.get("ring", min(speed, 30 / 3.6 if diameter < 60 else 40 / 3.6))
    return {"kind": "roundabout", "arms": arms, "ring_lanes": ring, "diameter": diameter, "ring_speed": ring_speed}


def _diameter(facts: Facts, choices: Choices, arms: int, ring: int) -> float:
    if facts.lengths.get("diameter", math.inf) < 2 * _ROUNDED * facts.lengths.get("radius", 0.0):
        raise UnusableInput("the diameter of a roundabout is twice its radius or more", reason="impossible-map")
    if "diameter" in facts.lengths:
        return facts.lengths["diameter"]
    if "radius" in facts.lengths:
        return 2 * facts.lengths["radius"]
    if "island" in facts.lengths:
        return facts.lengths["island"] + ISLAND * ring
    least = 10 * math.ceil((2 * 9.0 / (2 * math.pi / arms) + 8 * ring + 6) / 10)
    return choices.length("diameter of the roundabout", max(30, least), max(30, least) + 20)
