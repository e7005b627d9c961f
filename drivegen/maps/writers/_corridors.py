"""Streets from facts: plain and curved ones, several junctions in a row, side streets, staggered junctions."""

import math
from itertools import pairwise
from typing import Any

from drivegen.errors import UnusableInput
from drivegen.maps.writers._bent_rows import BENDS, placed_at_bend, side_at_bend
from drivegen.maps.writers._choices import Choices
from drivegen.maps.writers._control import control_at, control_of
from drivegen.maps.writers._facts import Facts, JunctionWords

Road = dict[str, Any]

_MOST_IN_A_ROW = 12
_SHORTEST_END = 60.0  # [m]
_SHORT = 0.9
_LEAST_HAIRPIN = 135.0  # [degrees]
_SMALLEST_RING, _BETWEEN_RINGS = 28.0, 25.0  # [m]


def row(facts: Facts, choices: Choices) -> Road:
    """Several junctions along one road, in the order of the text."""
    words = [junction for junction in facts.junctions for _ in range(min(junction.count, _MOST_IN_A_ROW + 1))]
    if all(junction.position is not None for junction in words):
        words.sort(key=lambda junction: junction.position or 0.0)
    gaps = [junction.gap for junction in words if junction.gap]
    spacing = facts.lengths.get("spacing") or (gaps[0] if gaps else choices.length("spacing", 150, 250))
    main = choices.lanes(facts, 1, "main", "arms")
    side = facts.lanes.get("side", main if "main" not in facts.lanes else 1)
    nearest = min([spacing, *gaps])
    junctions = [_along(facts, junction, side, choices.speed(facts), nearest) for junction in words]
    if len({junction.side for junction in words if junction.arms == 3}) > 1:
        for junction, word in zip(junctions, words, strict=True):
            junction["sides"] = [word.side] if word.side and word.arms == 3 else junction["sides"]
    elif facts.has("alternate"):
        for i, (junction, word) in enumerate(zip(junctions, words, strict=True)):
            if word.arms == 3:
                junction["sides"] = [("left", "right")[(i + (facts.turn == "right")) % 2]]
    places = [junction.position for junction in words if junction.position is not None]
    if len(places) == len(words) and places == sorted(set(places)):
        return _corridor(facts, choices, main, junctions, [b - a for a, b in pairwise(places)], places[0])
    return _corridor(facts, choices, main, junctions, [junction.gap or spacing for junction in words[1:]])


def _along(facts: Facts, words: JunctionWords, side: int, speed: float, nearest: float) -> Road:
    control = control_at(facts, words, equal_roads=False)
    sides = ["left", "right"] * 3
    if words.arms == 3:
        sides = [words.side or _side(facts, "right")]
    if words.arms not in (None, *range(3, 9)):
        raise UnusableInput("junctions in a row can have three to eight arms", reason="impossible-map")
    ring = facts.lanes.get("ring", 1)
    told = facts.lengths.get("diameter") or (0.0 if facts.has(*BENDS) else 2.0 * facts.lengths.get("radius", 0.0))
    diameter = told or max(_SMALLEST_RING, min(36.0 + 8 * ring, nearest - _BETWEEN_RINGS))
    sides = sides[: (words.arms or 4) - 2]
    form: Road = {"form": words.form, "sides": sides, "side_lanes": side, "ring_lanes": ring, "diameter": diameter}
    form |= {f"{side}_turn_lane": True for side in words.pockets.split()}
    return {**form, "control": control, "side_speed": facts.speeds.get("side", speed)}


def side_streets(facts: Facts, choices: Choices) -> Road:
    count = facts.side_streets or 3
    spacing = facts.lengths.get("spacing") or facts.lengths.get("offset") or choices.length("spacing", 70, 110)
    side = facts.lanes.get("side", 1)
    control = control_of(facts, equal_roads=False)
    if facts.surroundings == "residential" and facts.control is None and not facts.has("main_road"):
        control = "uncontrolled"
        choices.assume("right before left")
    common: Road = {"side_lanes": side, "control": control, "side_speed": facts.speeds.get("side", choices.speed(facts))}
    if "side" not in facts.lengths and facts.lengths.get("length", math.inf) < spacing * (count - 1) + 2 * _SHORTEST_END:
        facts.lengths["side"] = facts.lengths.pop("length")  # too short for the road, so it is theirs
    if "side" in facts.lengths:
        common["side_length"] = facts.lengths["side"]
    junctions = [{**common, "sides": sides, "dead_end": facts.has("cul_de_sac")} for sides in _sides(facts, count)]
    main = choices.lanes(facts, 1, "main")
    places = [at for _, at in facts.side_places if at is not None]
    if places and len(places) == count and places == sorted(places):
        return _corridor(facts, choices, main, junctions, [b - a for a, b in pairwise(places)], places[0])
    return _corridor(facts, choices, main, junctions, [spacing] * (count - 1))


def _sides(facts: Facts, count: int) -> list[list[str]]:
    """The sides on which side streets join: as told, both for streets that cross, one, or left and right in turn."""
    told = [turn for turn, _ in facts.side_places]
    if facts.has(*BENDS) and not facts.has("cross_streets", "alternate"):
        return [[_side(facts, "")]] * count
    if told and all(told):
        return [[turn] for turn in told]
    if facts.has("cross_streets"):
        return [["left", "right"]] * count
    if facts.has("alternate") and not facts.has("same_side"):
        return [["left" if (i % 2 == 0) != (facts.turn == "right") else "right"] for i in range(count)]
    if facts.turn or facts.has("same_side"):
        return [[facts.turn or "right"]] * count
    return [["left" if i % 2 == 0 else "right"] for i in range(count)]


def _side(facts: Facts, usual: str) -> str:
    """The side on which side roads join: as told, at bends "" where it is not, else the usual one."""
    if facts.has(*BENDS):
        return facts.side_turn
    return facts.turn or usual


def staggered(facts: Facts, choices: Choices) -> Road:
    told = facts.lengths.get("offset") or facts.lengths.get("spacing") or next((j.gap for j in facts.junctions if j.gap), None)
    offset = told or choices.length("offset", 40, 60)
    main = choices.lanes(facts, 1, "main")
    control = control_of(facts, equal_roads=False)
    first = facts.turn or "right"
    common = {"side_lanes": facts.lanes.get("side", 1), "control": control, "side_speed": choices.speed(facts)}
    junctions = [{**common, "sides": [first]}, {**common, "sides": ["left" if first == "right" else "right"]}]
    return _corridor(facts, choices, main, junctions, [offset])


def _corridor(
    facts: Facts, choices: Choices, main: int, junctions: list[Road], gaps: list[float], start: float | None = None
) -> Road:
    """A road with junctions `gaps` [m] apart, the first one `start` [m] from its beginning if that is known."""
    if len(junctions) > _MOST_IN_A_ROW:
        raise UnusableInput(f"a road can have at most {_MOST_IN_A_ROW} junctions along it", reason="impossible-map")
    between = sum(gaps)
    ends = choices.length("road before the first and after the last junction", 120, 160)
    if "length" in facts.lengths:
        ends = max(_SHORTEST_END, (facts.lengths["length"] - between) / 2)
    first = ends if start is None else max(start, 30.0)
    if "length" in facts.lengths and start is not None:
        ends = max(_SHORTEST_END, facts.lengths["length"] - between - first)
    line: Road = {"shape": "straight", "length": first + between + ends}
    if facts.has(*BENDS):
        line = alignment(facts, choices, (400, 600))
        line, first = placed_at_bend(facts, line, between, start)
        junctions = [{**j, "sides": [side_at_bend(line, side) for side in j["sides"]]} for j in junctions]
    all_have = facts.pocket_role in ("", "main")
    turning: Road = {"left_turn_lane": facts.left_pocket and all_have, "right_turn_lane": facts.right_pocket and all_have}
    turning |= {"pocket": facts.lengths["pocket"]} if "pocket" in facts.lengths else {}
    placed = [{**turning, **junction, "position": first + sum(gaps[:i])} for i, junction in enumerate(junctions)]
    one_way = bool(facts.one_way) and not facts.two_way
    return {
        "kind": "corridor",
        "alignment": line,
        "lanes": main,
        "lanes_back": 0 if one_way else facts.lanes.get("back", main),
        "speed": choices.speed(facts),
        "junctions": placed,
    }


def street(facts: Facts, choices: Choices) -> Road:
    """A road without junctions: straight, curved, or a dead end."""
    lanes = choices.lanes(facts, 2 if facts.has("arterial") else 1, "main")
    one_way = bool(facts.one_way) and not facts.two_way
    dead_end = facts.has("cul_de_sac")
    return {
        "kind": "corridor",
        "alignment": alignment(facts, choices, (120, 180) if dead_end else (400, 600)),
        "lanes": lanes,
        "lanes_back": 0 if one_way else facts.lanes.get("back", lanes),
        "speed": choices.speed(facts),
        "dead_end": dead_end,
    }


def alignment(facts: Facts, choices: Choices, usual: tuple[int, int], radius: float = 60.0) -> Road:
    """The line of a road without crossings."""
    shape = next((name for name in ("hairpin", "s_curve", "curve") if facts.has(name)), "straight")
    if shape == "straight":
        told = facts.lengths.get("length") or facts.lengths.get("side")
        if facts.has("cul_de_sac"):
            told = told or facts.lengths.get("spacing") or facts.lengths.get("position")  # "ends after 120 m"
        return {"shape": shape, "length": told or choices.length("length", *usual, step=50)}
    loop = facts.has("loop") and shape == "curve"
    if facts.arcs:
        return _arcs(facts, choices, shape, radius)
    angle = facts.angle or {"hairpin": 180.0, "s_curve": 60.0, "curve": 270.0 if loop else 90.0}[shape]
    angle = 180.0 if shape == "hairpin" and angle < _LEAST_HAIRPIN else angle
    bend = facts.lengths.get("radius") or (20.0 if shape == "hairpin" else 45.0 if angle > 180.0 else radius * _bend(facts))
    bends = facts.bends or (2 if shape == "s_curve" else 1)
    arcs = math.radians(angle) * bend * bends
    rest = 60.0 if angle > 180.0 else choices.length("straight roads beside the bend", 200, 300, step=20) * (bends + 1) / 2
    if "straights" in facts.lengths:
        rest = facts.lengths["straights"] * (bends + 1 if shape == "hairpin" else 2)
    if "behind" in facts.lengths:
        rest = _two_straights(facts, choices)
    told = facts.lengths.get("length") or (facts.lengths.get("side") if facts.has("cul_de_sac") and not facts.junctions else None)
    length = told or arcs + rest
    if told and told < _SHORT * arcs:
        raise UnusableInput(
            f"bends that are {arcs:.0f} m long together do not fit into a road of {told:.0f} m", reason="impossible-map"
        )
    line: Road = {"shape": shape, "length": length, "angle": -angle if facts.turn == "right" else angle, "radius": bend}
    return line | {"bends": facts.bends} if facts.bends else line


def _arcs(facts: Facts, choices: Choices, shape: str, radius: float) -> Road:
    """The line of a road whose bends are told one by one."""
    arcs = [(angle, told or radius * _bend(facts)) for angle, told in facts.arcs]
    bent = sum(math.radians(abs(angle)) * size for angle, size in arcs)
    beside = 2 * facts.lengths["straights"] if "straights" in facts.lengths else None
    length = facts.lengths.get("length") or bent + (
        beside or choices.length("straight roads beside the bends", 200, 300, step=20)
    )
    return {"shape": shape, "length": length, "arcs": arcs}


def _two_straights(facts: Facts, choices: Choices) -> float:
    """The straights before and behind a bend together [m]; those that differ are drawn equally long, which is told."""
    before, behind = facts.lengths["before"], facts.lengths["behind"]
    if before != behind:
        choices.assume(f"{(before + behind) / 2:.0f} m before the bend and as much behind it")
        choices.waived += [before, behind]
    return before + behind


def _bend(facts: Facts) -> float:
    return 0.5 if facts.has("sharp") else 2.0 if facts.has("gentle") else 1.0
