"""From a scene to an interchange: a diamond or a part of one, a cloverleaf or a part of one, a trumpet."""

from typing import Any

from drivegen.words.build_crossings import control_of
from drivegen.words.choices import FAST, Choices, lanes_of, speed_of
from drivegen.words.slots import KMH
from drivegen.words.things import Road, Scene, Thing, Unfit, merged, only

_ONE = "one interchange is drawn at a time"
_OFF, _ON = ("south_east", "north_west"), ("north_east", "south_west")
"""Quadrants whose loops leave the lower highway where traffic keeps right, and those whose loops join it."""

_LOOPS: dict[tuple[str, int], tuple[str, ...]] = {
    ("partial_cloverleaf", 1): _OFF[:1],
    ("partial_cloverleaf", 2): _ON,
    ("partial_cloverleaf", 3): (*_ON, *_OFF[:1]),
    ("cloverleaf", 4): (*_ON, *_OFF),
    ("trumpet", 1): ("north_west",),
}
_USUAL = {"cloverleaf": 4, "partial_cloverleaf": 2, "trumpet": 1}


def interchange(scene: Scene, _: Choices) -> Road:
    """A highway and a road over it, joined by ramps that end at crossings."""
    whole, main, upper, ramp = _parts(scene, "interchange")
    forms = set(whole.values("form")) or {"diamond"}
    whole.accept("has_roads")
    forms -= {"terminal"} if "diamond" in forms else set()
    forms -= {"diamond"} if len(forms) > 1 else set()
    form = only(forms, _ONE)
    lanes = lanes_of(main, per_carriageway=True) or lanes_of(whole, per_carriageway=True) or (2, 2)
    above = lanes_of(upper, arms=True) or (1, 1)
    speed = speed_of(main) or speed_of(whole) or FAST
    fields: Road = {"kind": "interchange", "form": form, "lanes": lanes[0], "speed": speed, "road_lanes": above[0]}
    fields |= {"ramp_lanes": _ramp_lanes(whole, ramp), "road_speed": speed_of(upper) or 50 * KMH}
    fields |= {"ramp_speed": speed_of(ramp) or whole.value("ramps_limit", "ramp_speed") or 50 * KMH}
    fields["road_length"] = upper.value("length")
    both = Thing("", facts=[*whole.facts, *upper.facts])
    usual = "yield" if both.value("signals") is False else "signals"
    return fields | {"control": control_of(both, False, usual)}


def _parts(scene: Scene, name: str) -> tuple[Thing, Thing, Thing, Thing]:
    """What is said of the whole, the highway, the road above it, and the ramps."""
    highways = scene.named("highway")
    upper = scene.named("upper", "street", "main", "cross", "arm")
    ramps = scene.named("ramp", "on_ramp", "off_ramp", "crossing")
    if any(thing.has("count") for thing in ramps if thing.name != "crossing"):
        raise Unfit("an interchange has the ramps of its form: their number cannot be said")
    if max(sum(int(thing.value("count") or 1) for thing in group) for group in (highways, upper, ramps)) > 2:
        raise Unfit("two roads meet at an interchange, at two crossings at most")
    whole = scene.merged(name)
    crossings = [fact for thing in ramps if thing.name == "crossing" for fact in thing.facts]
    ramp = merged([thing for thing in ramps if thing.name != "crossing"])
    return Thing("", facts=[*whole.facts, *crossings]), merged(highways), merged(upper), ramp


def cloverleaf(scene: Scene, _: Choices) -> Road:
    """Two roads on different levels with loops and direct ramps in the quadrants between their legs."""
    motorways = sum(int(next(iter(t.values("count")), 1)) for t in scene.things if t.name == "highway")
    street = scene.there("upper", "street", "main", "cross")
    whole, main, upper, ramp = _parts(scene, "cloverleaf")
    loop = merged(scene.named("loop"))
    form, count = _form_and_loops(str(only(whole.values("form"), _ONE)), [*whole.values("loops"), *loop.values("count")])
    controlled = whole.has("control") or upper.has("control")
    if controlled and (form == "trumpet" or motorways > 1):
        raise Unfit("trumpets, and cloverleaves between two highways, have no crossings")
    lanes = lanes_of(main, per_carriageway=True) or lanes_of(whole, per_carriageway=True) or (2, 2)
    speed = speed_of(main) or speed_of(whole) or FAST
    both = not street and not controlled
    above = lanes_of(upper, arms=True) or ((lanes[0],) if both else (1,))
    fields: Road = {"kind": "quadrant_interchange", "lanes": lanes[0], "speed": speed, "road_lanes": above[0]}
    fields |= {name: _ramps(form, name, _LOOPS[form, count]) for name in (*_OFF, *_ON)}
    legs = whole.values("leg")
    fields |= {"north_leg": form != "trumpet" and "south" not in legs, "south_leg": "north" not in legs}
    slower = min(speed, 50 * KMH if controlled else 80 * KMH)
    fields["road_speed"] = speed_of(upper) or (speed if both else slower)
    fields |= _ramps_and_loops(whole, ramp, loop, speed)
    fields |= {"median": merged((whole, main)).value("median") or None, "leg_length": upper.value("length")}
    for quadrant in scene.named(*_OFF, *_ON):
        if (ramps := quadrant.value("ramps")) is not None:
            fields[quadrant.name] = ramps
    if controlled:
        fields["control"] = control_of(Thing("", facts=[*whole.facts, *upper.facts]), False)
    else:
        for thing in (whole, main, upper):
            thing.accept("signals")
    return fields


def _form_and_loops(form: str, numbers: list[Any]) -> tuple[str, int]:
    """The form, by the number of loops where one is said, and that number."""
    count = numbers[0] if numbers else _USUAL[form]
    form = "partial_cloverleaf" if form == "cloverleaf" and count in (1, 2, 3) else form
    if (form, count) not in _LOOPS:
        raise Unfit(f"I cannot draw a {form.replace('_', ' ')} with {count} loops")
    return form, count


def _ramps_and_loops(whole: Thing, ramp: Thing, loop: Thing, speed: float) -> Road:
    """Limits, lanes and radius of the ramps of a road with the limit `speed` [m/s]."""
    limit = speed_of(ramp) or whole.value("ramps_limit", "ramp_speed") or min(speed, 60 * KMH)
    own, usual = whole.value("radius"), min(speed, limit, 40 * KMH)
    return {
        "ramp_speed": limit,
        "loop_speed": speed_of(loop) or whole.value("loop_speed") or usual,
        "loop_radius": whole.value("loop_radius") or loop.value("radius", "loop_radius") or own or 45.0,
        "ramp_lanes": _ramp_lanes(whole, ramp),
    }


def _ramp_lanes(whole: Thing, ramp: Thing) -> int:
    own = lanes_of(ramp, one_way=True)
    return int(own[0] if own else whole.value("ramp_lanes") or 1)


def _ramps(form: str, name: str, loops: tuple[str, ...]) -> str:
    """What lies in a quadrant: direct ramps wherever they lead somewhere, and the loops."""
    direct = (form, name) != ("trumpet", "north_east")
    return ("both" if direct else "loop") if name in loops else "direct" if direct else "none"
