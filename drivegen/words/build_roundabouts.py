"""From a scene to a roundabout: the ring, its size, its arms."""

import math

from drivegen.words.build_crossings import count_of, own_of_arms
from drivegen.words.choices import Choices, lanes_of, speed_of, usual_speed
from drivegen.words.slots import KMH
from drivegen.words.things import Road, Scene, Thing, Undrawable, Unfit, merged

ISLAND = 8.0
"""By how much the island of a roundabout is smaller than its outer edge, per lane of the ring [m]."""
_EVERYWHERE = {"everywhere", "throughout", "overall", "everything"}
"""Of these a limit is the ring's, too."""


def roundabout(scene: Scene, choices: Choices) -> Road:
    """A ring with its arms."""
    whole = scene.merged("roundabout", "street", "ring_")
    arms, rings = scene.named("arm"), scene.named("ring")
    named = [thing for thing in scene.things if thing.name == "street"]
    if any(value not in (None, 1) for thing in scene.named("roundabout") for value in thing.values("count")):
        raise Unfit("one roundabout is not several")
    ring_thing = merged(rings)
    count = count_of(Thing("", facts=[f for f in whole.facts if f.name == "arms"]), arms)
    roads = [int(value) for street in named for value in street.values("count")]
    if count is None and roads and len(named) > 1:
        raise Unfit("say how many arms the roundabout has")
    count = (*roads, 4)[0] if count is None else count
    if count not in range(3, 9):
        raise Unfit(f"3 to 8 roads can meet at a roundabout, not {count}")
    on_ring = [*ring_thing.values("lanes"), *ring_thing.values("lane_road"), *whole.values("ring_lanes")]
    itself = merged(scene.named("roundabout"))
    if size := next((fact for fact in itself.facts if fact.name == "length"), None):
        raise Unfit(f"say whether {size.text!r} is the diameter of the roundabout or the length of its arms")
    on_ring += [*itself.values("lane_road"), *itself.values("lanes")]
    if len(set(on_ring)) > 1:
        raise Undrawable("two numbers of lanes are said of the ring")
    ring = int(on_ring[0]) if on_ring else 1
    of_roads = [fact for fact in whole.facts if fact not in itself.facts or fact.name not in ("lane_road", "lanes")]
    lanes = lanes_of(Thing("", facts=of_roads), arms=True) or (min(ring, 2), 0)
    diameter = _diameter(whole, ring_thing, choices, count, ring)
    length = whole.value("length") or choices.length("arms", 120, 180)
    speed = speed_of(whole) or usual_speed([whole])
    t_shaped = whole.value("shape") == "t"
    angles = [180.0, 0.0, 270.0] if t_shaped else [i * 360.0 / count for i in range(count)]
    whole.accept("evenly")
    if whole.value("signals") is not True and set(whole.values("control")) - {"yield"}:
        raise Unfit("who enters a roundabout gives way")
    built = [{"angle": a, "lanes_in": lanes[0], "lanes_out": lanes[0], "length": length, "speed": speed} for a in angles]
    own_of_arms(built, arms)
    everywhere = any(fact.name == "speed" and _EVERYWHERE & set(fact.text.split()) for fact in whole.facts)
    usual = speed if everywhere else min(speed, 30 * KMH if diameter < 60 else 40 * KMH)
    ring_speed = ring_thing.value("speed") or whole.value("ring_speed") or usual
    return {"kind": "roundabout", "arms": built, "ring_lanes": ring, "diameter": diameter, "ring_speed": ring_speed}


def _diameter(whole: Thing, ring: Thing, choices: Choices, arms: int, lanes: int) -> float:
    sizes = [*whole.values("diameter"), *ring.values("diameter")]
    sizes += [2 * value for value in (*whole.values("radius"), *ring.values("radius"))]
    sizes += [value + ISLAND * lanes for value in (*whole.values("island"), *ring.values("island"))]
    if len({round(value, 3) for value in sizes}) > 1:
        raise Unfit("two sizes are said of the roundabout")
    least = 10 * math.ceil((2 * 9.0 / (2 * math.pi / arms) + 8 * lanes + 6) / 10)
    size = whole.value("size")
    if sizes:
        return float(sizes[0])
    if size in ("mini", "small"):
        return float(max(20 if size == "mini" and lanes == 1 else 30, least if lanes > 1 or arms > 4 else 20))
    if size == "large":
        return float(max(70, least + 20))
    return choices.length("diameter of the roundabout", max(30, least), max(30, least) + 20)
