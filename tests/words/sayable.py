"""Specifications with sayable values, drawn by hypothesis: rounded numbers, and defaults where a field has no effect.

Left out is what words cannot say, or say of all alike: free graphs; arms in another order than around the crossing, or more than
four degrees from an even spread; hairpins given bend by bend; a highway's event nearer than 500 m to the one before, and a lane
change of several lanes (both are said, too, but would rarely be drawn); a junction's pocket without turn lanes; one of several
vehicles in a group that does something.
"""

from hypothesis import strategies as st

from drivegen.core.relation import Relation
from drivegen.layouts.spec import MapSpec
from drivegen.words.request import Density, Group, Kind, Manoeuvre, TrafficRequest

KMH, MPH = 1 / 3.6, 0.44704
CONTROLS = ("signals", "all_way_stop", "stop", "yield", "uncontrolled")
lanes = st.integers(1, 4)
speeds = st.one_of(st.integers(10, 150).map(lambda v: v * KMH), st.integers(10, 90).map(lambda v: v * MPH))
lengths = st.integers(60, 900).map(float)
controls = st.sampled_from(CONTROLS)
bans = st.sampled_from(((), (), ("left",), ("right",), ("left", "right")))
medians = st.sampled_from((0, 0, 2, 7.5))
widths = st.sampled_from((3.2, 3.5, 3.0, 2.75))


@st.composite
def turnings(draw):
    turned = draw(st.dictionaries(st.sampled_from(("left_turn_lanes", "right_turn_lanes")), st.integers(1, 2)))
    return turned | ({"pocket": float(draw(st.integers(20, 90)))} if turned else {})


@st.composite
def arms(draw, count, pockets=True):
    step = 360 / count
    ways = []
    for i in range(count):
        one_way = draw(st.sampled_from((None, None, "in", "out"))) if 0 < i < count - 1 else None
        n = draw(lanes)
        around = {"angle": float(draw(st.integers(round(i * step), round(i * step) + 4))), "speed": draw(speeds)}
        around |= {
            "length": draw(lengths),
            "main": draw(st.booleans()),
            "lanes_in": n,
            "lanes_out": draw(st.sampled_from((n, 1))),
        }
        around |= {f"lanes_{'out' if one_way == 'in' else 'in'}": 0} if one_way else {}
        around |= {"median": float(draw(medians))} if pockets and not one_way else {}
        ways.append(around | (draw(turnings()) | {"turn_bans": draw(bans)} if pockets else {}))
    return tuple(ways)


@st.composite
def crossings(draw):
    road = {"kind": "crossing", "lane_width": draw(widths), "control": draw(controls)}
    return road | {"arms": draw(st.integers(3, 6).flatmap(arms))}


@st.composite
def roundabouts(draw):
    ring = {"ring_lanes": draw(st.integers(1, 3)), "diameter": float(draw(st.integers(60, 120))), "ring_speed": draw(speeds)}
    return {"kind": "roundabout", "arms": draw(st.integers(3, 6).flatmap(lambda n: arms(n, False))), **ring}


@st.composite
def lines(draw, least=400):
    shape = draw(st.sampled_from(("straight", "curve", "s_curve", "hairpin")))
    length = {"length": float(draw(st.integers(least, 9000)))}
    if shape == "straight":
        return {"shape": shape, **length}
    side, radius = draw(st.sampled_from((-1, 1))), float(draw(st.integers(20, 80)))
    if draw(st.booleans()) and shape != "hairpin":
        bends = draw(st.lists(st.tuples(st.integers(10, 90).map(float), st.integers(20, 60).map(float)), min_size=2, max_size=3))
        return {"shape": shape, "arcs": [(side * angle, size) for angle, size in bends], **length}
    return {
        "shape": shape,
        "angle": float(side * (180 if shape == "hairpin" else draw(st.integers(10, 80)))),
        "radius": radius,
        **length,
    }


@st.composite
def corridors(draw):
    back = draw(lanes)
    width = {"lane_width": draw(widths)}
    road = {"kind": "corridor", "lanes": draw(lanes), "lanes_back": back, "speed": draw(speeds), "alignment": draw(lines(3000))}
    if draw(st.booleans()):
        return {**road, **width, "lanes_back": draw(st.sampled_from((0, back))), "alignment": draw(lines())}
    places = [200.0 + 180.0 * i + draw(st.integers(0, 60)) for i in range(draw(st.integers(1, 4)))]
    road["median"] = float(draw(medians))
    return {**road, "junctions": [draw(junctions(place)) for place in places], "dead_end": draw(st.booleans())}


@st.composite
def junctions(draw, position):
    ring = draw(st.booleans())
    sides = draw(st.sampled_from((("left",), ("right",), ("left", "right"), ("right", "left"), ("left", "left", "right"))))
    found = {
        "position": position,
        "sides": sides,
        "side_lanes": draw(lanes),
        "side_speed": draw(speeds),
        "side_length": draw(lengths),
    }
    if ring:
        return found | {"form": "roundabout", "ring_lanes": draw(st.integers(1, 3)), "diameter": float(draw(st.integers(40, 60)))}
    found |= {"turn_bans": draw(bans), "side_turn_bans": draw(bans)}
    return found | {"control": draw(controls), "dead_end": draw(st.booleans()), **draw(turnings())}


@st.composite
def grids(draw):
    beyond = draw(st.one_of(st.none(), st.integers(20, 200).map(float)))
    size = {"rows": draw(st.integers(1, 8)), "columns": draw(st.integers(1, 8)), "spacing": float(draw(st.integers(40, 400)))}
    rest = {"lanes": draw(lanes), "speed": draw(speeds), "control": draw(controls), "one_way": draw(st.booleans())}
    return {"kind": "grid", **size, **rest, "beyond": beyond, "lane_width": draw(widths)}


@st.composite
def highways(draw):
    two = draw(st.booleans())
    road = {"kind": "highway", "lanes": draw(st.integers(3, 8)), "speed": draw(speeds), "carriageways": 2 if two else 1}
    road |= {"median": float(draw(st.integers(2, 20)))} if two else {}
    places = [300.0 + 600.0 * i + draw(st.integers(0, 90)) for i in range(draw(st.integers(0, 4)))]
    kinds = st.sampled_from(("on_ramp", "off_ramp", "weaving", "lane_drop", "lane_gain"))
    events = [draw(kinds.flatmap(lambda kind, at=place: happenings(kind, at))) for place in places]
    drops = [event for event in events if event["kind"] == "lane_drop"]
    events = [event for event in events if event not in drops[2:]]
    return {**road, "events": events, "both": draw(st.booleans()), "alignment": draw(lines(3500)), "lane_width": draw(widths)}


@st.composite
def happenings(draw, kind, position):
    found = {"kind": kind, "position": position}
    if kind in ("lane_drop", "lane_gain"):
        return found | {"side": draw(st.sampled_from(("left", "right")))}
    keeps = {"keeps": draw(st.booleans())} if kind != "weaving" else {}
    found |= {"ramp_speed": draw(speeds), "length": float(draw(st.integers(60, 300)))}
    return found | {"lanes": draw(st.integers(1, 2)), **keeps}


@st.composite
def forks(draw):
    left, right = draw(st.integers(1, 4)), draw(st.integers(1, 4))
    joins, stem = draw(st.booleans()), draw(st.one_of(st.none(), lengths))
    found = {
        "kind": "fork",
        "lane_width": draw(widths),
        "lanes": max(left, right),
        "left_lanes": left,
        "right_lanes": right,
        "joins": joins,
        "stem": stem,
    }
    return found | {"angle": float(draw(st.integers(10, 120))), "speed": draw(speeds), "length": draw(lengths)}


@st.composite
def interchanges(draw):
    form = draw(st.sampled_from(("diamond", "half_diamond", "side", "terminal")))
    found = {"kind": "interchange", "form": form, "lanes": draw(st.integers(1, 6)), "speed": draw(speeds)}
    found |= {"ramp_lanes": draw(st.integers(1, 2)), "ramp_speed": draw(speeds), "road_lanes": draw(lanes)}
    return found | {"road_speed": draw(speeds), "road_length": draw(lengths), "control": draw(controls)}


@st.composite
def quadrants(draw):
    ramps = st.sampled_from(("none", "direct", "loop", "both"))
    found = {"kind": "quadrant_interchange", "lanes": draw(st.integers(1, 6)), "speed": draw(speeds), "road_lanes": draw(lanes)}
    if draw(st.booleans()):
        found |= {"north_leg": False, "north_west": "both", "north_east": "none", "south_west": "direct", "south_east": "direct"}
    else:
        found |= {"north_east": "both", "south_west": draw(ramps), "south_east": draw(ramps), "north_west": draw(ramps)}
        found |= {"control": draw(st.one_of(st.none(), controls))}
    found |= {"road_speed": draw(speeds), "ramp_lanes": draw(st.integers(1, 2)), "ramp_speed": draw(speeds)}
    found |= {
        "loop_radius": float(draw(st.integers(25, 80))),
        "loop_speed": draw(speeds),
        "median": float(draw(st.integers(2, 30))),
    }
    return found | {"leg_length": draw(lengths)}


ROADS = (crossings(), roundabouts(), corridors(), grids(), highways(), forks(), interchanges(), quadrants())


@st.composite
def specifications(draw, roads):
    """A specification, None where these fields are none."""
    fields = {"road": draw(roads), "left_hand": draw(st.booleans())}
    try:
        return MapSpec.model_validate(fields)
    except ValueError:
        return None


@st.composite
def groups(draw):
    manoeuvre = draw(st.one_of(st.none(), st.sampled_from(Manoeuvre)))
    behind = [Relation.LEFT, Relation.RIGHT, *(relation for relation in Relation if relation.endswith("behind"))]
    place = draw(st.one_of(st.none(), st.sampled_from(behind if manoeuvre is Manoeuvre.OVERTAKE else list(Relation))))
    far = place not in (None, Relation.ONCOMING) and draw(st.booleans())
    count, queue = 1 if manoeuvre else draw(st.integers(1, 8)), draw(st.booleans())
    return Group(
        count=count,
        kind=draw(st.sampled_from(Kind)),
        place=place,
        distance=float(draw(st.integers(3, 120))) if far else None,
        speed=draw(speeds) if count == 1 and draw(st.booleans()) else None,
        queue=queue and count > 1,
        manoeuvre=manoeuvre,
        within=float(draw(st.integers(1, 10))) if manoeuvre and draw(st.booleans()) else None,
    )


@st.composite
def requests(draw):
    if draw(st.integers(0, 9)) == 0:
        return TrafficRequest(density=Density.NONE)
    density = draw(st.one_of(st.none(), st.sampled_from([d for d in Density if d is not Density.NONE])))
    does = st.sampled_from((Manoeuvre.TURN_LEFT, Manoeuvre.TURN_RIGHT, Manoeuvre.CHANGE_LEFT))
    return TrafficRequest(
        groups=tuple(draw(st.lists(groups(), max_size=4))),
        density=density,
        speed=draw(speeds) if draw(st.booleans()) else None,
        target_kind=draw(st.one_of(st.none(), st.sampled_from((Kind.CAR, Kind.TRUCK, Kind.BUS)))),
        target_speed=draw(speeds) if draw(st.booleans()) else None,
        target_does=draw(st.one_of(st.none(), does)),
    )
