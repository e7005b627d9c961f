"""From facts to one road: which kind they describe, and its parameters."""

from collections.abc import Callable
from typing import Any

from drivegen.errors import UnusableInput
from drivegen.maps.writers._bent_rows import BENDS
from drivegen.maps.writers._choices import Choices
from drivegen.maps.writers._control import control_of
from drivegen.maps.writers._corridors import alignment, row, side_streets, staggered, street
from drivegen.maps.writers._crossings import crossing, roundabout
from drivegen.maps.writers._facts import Facts, JunctionWords
from drivegen.maps.writers._highways import fork, highway
from drivegen.maps.writers._quadrants import FORMS, quadrants

Road = dict[str, Any]


def road(facts: Facts, choices: Choices) -> Road | None:
    """The road as fields of `spec.Road`, or None where the facts describe none.

    Raises UnusableInput where they contradict one another.
    """
    _refuse_contradictions(facts)
    for applies, make in _KINDS:
        if applies(facts):
            found = make(facts, choices)
            if "back" in facts.lanes and found["kind"] != "corridor" and facts.lanes["back"] != choices.lanes(facts, 1, "main"):
                raise UnusableInput("I can draw other lanes on the way back on a street only, not here", reason="not-understood")
            return found
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


def _grid(facts: Facts, choices: Choices) -> Road:
    if any(junction.form == "roundabout" for junction in facts.junctions):
        raise UnusableInput("I can draw grids of crossings, without roundabouts", reason="not-understood")
    rows, columns = facts.grid or (3, 3)
    if facts.grid is None:
        choices.assume("three by three streets")
    return {
        "kind": "grid",
        "rows": rows,
        "columns": columns,
        "spacing": facts.lengths.get("spacing") or facts.lengths.get("length") or choices.length("spacing", 100, 150),
        "beyond": facts.lengths.get("beyond"),
        "lanes": choices.lanes(facts, 1, "main", "side"),
        "speed": choices.speed(facts),
        "control": control_of(facts, equal_roads=True),
        "one_way": bool(facts.one_way),
    }


def _interchange(facts: Facts, choices: Choices) -> Road:
    if facts.interchange == "unknown":
        raise UnusableInput(
            "I cannot draw 'interchange' without its form; of interchanges I can draw a diamond, half a diamond, a single "
            "ramp terminal, a cloverleaf, a partial cloverleaf and a trumpet",
            reason="not-understood",
        )
    main = choices.lanes(facts, 2, "main")
    return {
        "kind": "interchange",
        "form": facts.interchange,
        "lanes": main,
        "speed": choices.speed(facts, highway=True),
        "ramp_lanes": facts.lanes.get("ramp", 1),
        "ramp_speed": facts.speeds.get("ramp", 50 / 3.6),
        "road_lanes": facts.lanes.get("side", 1),
        "road_speed": facts.speeds.get("side", 50 / 3.6),
        "control": control_of(facts, equal_roads=False) if facts.control or facts.unsignalled else "signals",
    }


def _is_highway(facts: Facts) -> bool:
    along = bool(facts.events) or facts.has("weaving", "lane_drop", "lane_gain", "lane_change")
    return along or (facts.has("highway", "divided") and not facts.junctions and not facts.side_streets)


def _is_crossing(facts: Facts) -> bool:
    if facts.control == "all_way_stop" and not facts.junctions and not facts.has("curve", "s_curve", "hairpin"):
        facts.junctions.append(JunctionWords("crossing", 0, 4))  # "a four-way stop"
    return bool(facts.junctions)


def _in_a_row(facts: Facts) -> bool:
    along_bends = bool(facts.junctions) and facts.has(*BENDS) and not facts.side_streets
    return along_bends or len(facts.junctions) > 1 or any(junction.count > 1 for junction in facts.junctions)


_KINDS: tuple[tuple[Callable[[Facts], bool], Callable[[Facts, Choices], Road]], ...] = (
    (lambda facts: facts.interchange in FORMS, quadrants),
    (lambda facts: bool(facts.interchange), _interchange),
    (lambda facts: facts.has("grid"), _grid),
    (lambda facts: facts.has("staggered"), staggered),
    (_in_a_row, row),
    (lambda facts: facts.side_streets > 1 or (facts.has("side_streets") and not facts.junctions), side_streets),
    (lambda facts: bool(facts.junctions) and facts.junctions[0].form == "roundabout", roundabout),
    (lambda facts: facts.has("fork") and not facts.junctions, fork),
    (_is_highway, lambda facts, choices: highway(facts, choices, alignment)),
    (_is_crossing, crossing),
    (lambda facts: facts.has("road", "straight", "curve", "s_curve", "hairpin", "cul_de_sac", "arterial", "main_road"), street),
    (
        lambda facts: bool(facts.lanes or facts.one_way) and "length" in facts.lengths,
        street,
    ),  # "two lanes one way, one back, 900 m"
)
