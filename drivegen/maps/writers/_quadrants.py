"""Interchanges with loops, in words: cloverleaves, whole or in part, trumpets, and a single loop ramp between two roads."""

from typing import Any

from drivegen.errors import UnusableInput
from drivegen.maps.writers._choices import KMH, Choices
from drivegen.maps.writers._control import control_of
from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._sentence import Sentence

FORMS = ("cloverleaf", "partial_cloverleaf", "trumpet", "loop_off", "loop_on")
"""Values of `Facts.interchange` that are such interchanges."""

_TWO = 2
_ROAD_SPEED, _STREET_SPEED, _LOOP_SPEED, _RAMP_SPEED = 80 * KMH, 50 * KMH, 40 * KMH, 60 * KMH
_OFF, _ON = ("south_east", "north_west"), ("north_east", "south_west")
"""Quadrants whose loops leave the lower highway where traffic keeps right, and those whose loops join it."""

_LOOPS: dict[tuple[str, int], tuple[str, ...]] = {
    ("loop_off", 1): _OFF[:1],
    ("loop_on", 1): _ON[:1],
    ("partial_cloverleaf", 1): _OFF[:1],
    ("partial_cloverleaf", 2): _ON,
    ("partial_cloverleaf", 3): (*_ON, *_OFF[:1]),
    ("cloverleaf", 4): (*_ON, *_OFF),
    ("trumpet", 1): ("north_west",),
}
"""Which quadrants have loops, by form and number."""

_USUAL = {"cloverleaf": 4, "partial_cloverleaf": 2}


def loops_of(s: Sentence) -> list[Phrase]:
    """Loop ramps that are spoken of, by whatever word."""
    return sorted((p for p in (*s.said("shape", "curve"), *s.said("ramp")) if _is_loop(p)), key=lambda p: p.first)


def _is_loop(phrase: Phrase) -> bool:
    return bool(set(phrase.text.split()) & {"loop", "loops", "looping"})


def read_quadrants(s: Sentence, facts: Facts, form: str) -> str:
    """The form, of `FORMS`, that a named `form` or loops beside a highway make, and how many loops are said; "" none."""
    loops = loops_of(s)
    highways = [p for p in s.phrases if p.words.get("class") == "highway" and not p.negated]
    if form not in FORMS and not (loops and highways and not form):
        return ""
    if any(_is_loop(p) for p in s.denied("ramp")):
        raise UnusableInput("of interchanges without loops I can draw diamonds only", reason="not-understood")
    facts.loops = next((p.number for p in loops if p.number), None)
    if form not in FORMS:
        form = f"loop_{_direction(s, loops)}" if (facts.loops or 1) == 1 else "cloverleaf"
    if form == "cloverleaf" and facts.loops in (1, 2, 3):
        form = "partial_cloverleaf"
    if (form, facts.loops or _USUAL.get(form, 1)) not in _LOOPS:
        raise UnusableInput(f"I cannot draw a {form.replace('_', ' ')} with {facts.loops} loops", reason="not-understood")
    _note_roads(s, facts, highways, form)
    _tell_speeds_apart(s, facts, loops)
    for phrase in loops:
        s.use(phrase.first, phrase.head, "loop ramp of 270 degrees")
    return form


def _note_roads(s: Sentence, facts: Facts, highways: list[Phrase], form: str) -> None:
    """Whether both roads are highways, as is said, or as a named form is understood where no other road is spoken of."""
    others = [p for p in s.said("road") if p.words.get("class") != "highway" and not p.words.get("divided")]
    if not form.startswith("loop") and not others:
        facts.features.setdefault("no_street", 0)
    fast = [p for p in highways if p.kind == "road" and p.det != "the"]  # "the motorway" was spoken of before
    if len(fast) >= _TWO or any((p.number or 1) >= _TWO for p in fast):
        facts.features.setdefault("two_highways", fast[0].first)
    for phrase in fast:
        if phrase.number == _TWO:
            s.use(phrase.first, phrase.head, "two highways")


def _tell_speeds_apart(s: Sentence, facts: Facts, loops: list[Phrase]) -> None:
    """A limit that is said of loops is not that of the other ramps."""
    of_loops = next((p.speed for p in loops if p.speed), None)
    if of_loops is None:
        return
    facts.speeds["loop"] = of_loops
    others = [p.speed for p in s.said("ramp") if p.speed and not _is_loop(p)]
    if others:
        facts.speeds["ramp"] = others[0]
    else:
        facts.speeds.pop("ramp", None)


def _direction(s: Sentence, loops: list[Phrase]) -> str:
    """Whether loops lead off the highway or on to it."""
    named = {p.value.split("_")[0] for p in (*s.said("ramp"), *loops) if p.value.split("_")[0] in ("on", "off")}
    said = named or {"off" for _ in s.verbs("leave")} or {"on" for _ in (*s.verbs("join"), *s.verbs("merge"))}
    return "on" if said == {"on"} else "off"


def quadrants(facts: Facts, choices: Choices) -> dict[str, Any]:
    """The interchange as fields of a specification."""
    form = facts.interchange
    ways = {"loop_off": "loop_on", "loop_on": "loop_off"} if facts.left_hand else {}  # a quadrant's loop leads the other way
    loops = _LOOPS[ways.get(form, form), facts.loops or _USUAL.get(form, 1)]
    street = _meets_a_street(facts)
    both = facts.has("two_highways", "no_street") and not street
    lanes, speed = choices.lanes(facts, 2, "main"), choices.speed(facts, highway=True)
    road_lanes = facts.lanes.get("side", lanes if both else 1)
    road = {
        "kind": "quadrant_interchange",
        **{name: _ramps(form, name, loops) for name in (*_OFF, *_ON)},
        "north_leg": form != "trumpet",
        "lanes": lanes,
        "speed": speed,
        "road_lanes": road_lanes,
        "road_speed": facts.speeds.get("side", speed if both else min(speed, _STREET_SPEED if street else _ROAD_SPEED)),
        "ramp_lanes": facts.lanes.get("ramp", 1),
        "ramp_speed": facts.speeds.get("ramp", min(speed, _RAMP_SPEED)),
        "loop_speed": facts.speeds.get("loop", facts.speeds.get("ramp", min(speed, _LOOP_SPEED))),
        "loop_radius": facts.lengths.get("radius", 45.0),
    }
    if street:
        road |= {"control": control_of(facts, equal_roads=False)}
    if "radius" not in facts.lengths:
        choices.assume("loops of 45 m radius")
    if "side" not in facts.lanes:
        choices.assume(f"{road_lanes} lane{'s' if road_lanes > 1 else ''} per direction on the road above")
    return {**road, "median": facts.lengths["median"]} if "median" in facts.lengths else road


def _meets_a_street(facts: Facts) -> bool:
    """Whether ramps end at crossings: where who goes first there, or a crossing, is spoken of."""
    told = facts.control is not None or any(junction.form == "crossing" for junction in facts.junctions)
    if told and (facts.interchange == "trumpet" or facts.has("two_highways")):
        raise UnusableInput(
            "I can draw trumpets, and loops between two highways, without crossings only", reason="not-understood"
        )
    return told


def _ramps(form: str, name: str, loops: tuple[str, ...]) -> str:
    """What lies in a quadrant: named forms have direct ramps wherever they lead somewhere, single loops have none."""
    direct = not form.startswith("loop") and (form, name) != ("trumpet", "north_east")
    return ("both" if direct else "loop") if name in loops else "direct" if direct else "none"
