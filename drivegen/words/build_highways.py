"""From a scene to a highway with what happens along it, or a fork."""

from drivegen.words.build_events import EVENTS, Event, events_of, fit
from drivegen.words.build_lines import alignment
from drivegen.words.choices import FAST, Choices, is_one_way, lanes_of, speed_of, usual_speed
from drivegen.words.things import Road, Scene, Thing, Unfit, merged, only

_PER_CARRIAGEWAY = frozenset({"motorway", "motorways", "freeway", "freeways", "autobahn", "mainline"})
"""Of these "a four-lane motorway" has four lanes in each direction; "a four-lane highway" may have two."""

_FAST_NAMES = frozenset({"highway", "motorway", "freeway", "expressway", "interstate"})
_EACH_WAY = (" direction", " directions", " way", " ways", " side")
"""Ends of "widens to two lanes per direction", which is said of both carriageways; "to two lanes" is said of one."""


def highway(scene: Scene, choices: Choices) -> Road:
    """A road with carriageways of its own, and its events in the order in which they are said."""
    scene.one_road("highway")
    scene.one_road("street", "main")
    names = [thing.name for thing in scene.things]
    crossed = "crosses" in scene.links or ("meets" in scene.links and not scene.there(*EVENTS))
    if crossed and "highway" in names and scene.there("street", "main"):
        raise Unfit("a motorway that another road meets or crosses is drawn as an interchange: say of which form")
    fast = any(_is_fast(thing) for thing in scene.things) or not {"highway", "main", "street"} & set(names)
    road = scene.merged("highway", "street", "main")
    if any(value not in (None, 1) for value in road.values("count")):
        raise Unfit("one highway is drawn at a time")
    carriageway = road.value("carriageways") == 1
    if carriageway and any(thing.text.endswith("carriageways") for thing in scene.things):
        raise Unfit("say 'one carriageway', or 'dual carriageway'")
    one_way = is_one_way(road) or carriageway
    road.accept("no_junctions", "signals")
    divided = bool(road.value("divided"))
    median = road.value("median")
    _no_ramps(road, scene)
    clear = all(_PER_CARRIAGEWAY & set(thing.text.split()) for thing in scene.things if thing.name == "highway") and not divided
    lanes = lanes_of(road, one_way=one_way, per_carriageway=True, most=4 if clear else 3)
    if lanes is not None and lanes[1] not in (0, lanes[0]):
        raise Unfit("both carriageways of a highway have the same number of lanes")
    events, start = events_of(scene, road, lanes[0] if lanes else None)
    ways = [fact for fact in road.facts if fact.name == "two_way" and fact.text.endswith("both directions")]
    if events and ways and not road.has("both"):
        raise Unfit("say 'the same in both directions' of what happens on both carriageways")
    number = lanes[0] if lanes else start or (3 if fast and not divided else 2)
    speed = speed_of(road) or (FAST if fast else usual_speed([road]))
    if road.values("has_auxiliary") and not any(event["kind"] in ("on_ramp", "off_ramp") for event in events):
        raise Unfit("a lane for speeding up or slowing down belongs to a ramp")
    _share_out(events, road)
    both = _on_both(events, road, one_way, "highway" in names)
    line = alignment(road, choices, (800, 1200), radius=250.0)
    fixed = road.has("length", "straights")
    limit = _ramp_limit(scene, road)
    if limit is not None and not any("ramp" in event["kind"] or event["kind"] == "weaving" for event in events):
        raise Unfit("a limit of ramps is said, and no ramp")
    built, line = fit(events, speed, line, fixed, limit)
    fields: Road = {"kind": "highway", "alignment": line, "lanes": number, "speed": speed, "carriageways": 1 if one_way else 2}
    return fields | {"median": None if one_way else median, "both": both or road.value("both"), "events": built}


def _is_fast(thing: Thing) -> bool:
    """Whether who speaks of it so means a motorway: a dual carriageway may be a street, a divided highway is none."""
    called = bool(_FAST_NAMES & set(thing.text.split()))
    return (thing.name == "highway" and (called or not thing.has("divided"))) or (thing.name in EVENTS and called)


def _on_both(events: list[Event], road: Thing, one_way: bool, of_highway: bool) -> bool:
    """Whether all that happens is said to happen on both carriageways. Raises Unfit where some of it is."""
    on_each = [merged(event["thing"]).value("on_each") for event in events]
    each_way = any(fact.name == "change_to" and fact.text.endswith(_EACH_WAY) for fact in road.facts)
    if each_way and not of_highway:
        raise Unfit("lanes that begin or end in both directions are drawn of highways only: say 'a divided road'")
    if (any(on_each) and (one_way or not all(on_each))) or (each_way and (one_way or len(events) > 1)):
        raise Unfit("say 'the same on both carriageways', or what is on one of them")
    return any(on_each) or each_way


def _share_out(events: list[Event], road: Thing) -> None:
    """Give the events what is said of the road and is theirs: a place is that of the one change of lanes that no thing stands
    for, an acceleration lane that of the one ramp. Raises Unfit where several can be meant.
    """
    if len(events) > 1 and (apart := [fact for fact in road.facts if fact.name == "spacing"]):
        for event in events[1:]:
            event["thing"] = [*event["thing"], Thing("", facts=apart)]
    changes = [event for event in events if not event["thing"] or (len(events) == 1 and event["kind"].startswith("lane_"))]
    ramps = [event for event in events if event["kind"] in ("on_ramp", "off_ramp")]
    for names, holders in ((("position", "gap"), changes), (("auxiliary",), ramps)):
        facts = [fact for fact in road.facts if fact.name in names]
        if facts and (len(holders) != 1 or len(facts) != 1):
            raise Unfit(f"it is not clear what {facts[0].text!r} is said of")
        for event in holders if facts else []:
            event["thing"] = [*event["thing"], Thing("", facts=facts)]


def _no_ramps(road: Thing, scene: Scene) -> None:
    ruled_out = {"no_events": ("on_ramp", "off_ramp", "ramp", "weaving"), "no_on": ("on_ramp",), "no_off": ("off_ramp",)}
    for name, kinds in ruled_out.items():
        if road.values(name) and scene.there(*kinds):
            raise Unfit("ramps are asked for and ruled out")
    road.accept("nothing_else")


def _ramp_limit(scene: Scene, road: Thing) -> float | None:
    """The limit of all ramps [m/s], None where none is said."""
    ramps = merged(thing for thing in scene.things if thing.name == "ramp" or thing.which == "all")
    values = (*ramps.values("ramp_speed"), *ramps.values("speed"), *road.values("ramp_speed"))
    return only(values, "two limits are said of the ramps")


def fork(scene: Scene, choices: Choices) -> Road:
    """A one-way road that splits into two, or two that become one."""
    whole = scene.merged("fork", "highway", "street", "main")
    both = [scene.named("left_branch"), scene.named("right_branch")]
    branch, stem = scene.named("branch", "arm"), scene.named("stem")
    merging = {word for fact in whole.facts if fact.name in ("joins", "joins_each") for word in fact.text.split()}
    fast = scene.there("highway") or bool(merging & {"motorways", "freeways", "highways"})
    joins = bool(whole.values("joins")) or whole.has("joins_each")
    if any(fact.value != 2 for fact in whole.facts if fact.name in ("joins", "splits")):
        raise Unfit("a fork has two branches")
    if any(count != 1 for count in whole.values("arms")):
        raise Unfit("a fork is one road and two branches")
    if any(fact.name == "lanes" and fact.text.endswith("each") for fact in whole.facts):
        raise Unfit("each lane of a fork is of a branch")
    if any(count not in (1, 2) for count in whole.values("count")):
        raise Unfit("a fork has two branches")
    whole.accept("splits", "signals", "carriageways")
    is_one_way(whole)  # whatever says so counts as used
    shared = merged(branch)
    shared.accept("count")
    own = [lanes_of(merged(things), one_way=True) for things in both]
    each = [n for name in ("branch_each", "splits_each", "joins_each") for n in (*whole.values(name), *shared.values(name))]
    pairs = [*whole.values("branch_lanes"), *((n, n) for n in each)]
    pairs += [(n[0], n[0]) for n in [lanes_of(shared, one_way=True)] if n]
    pairs += [(own[0][0], own[1][0])] if own[0] and own[1] else []
    if len(set(pairs)) > 1 or bool(own[0]) != bool(own[1]):
        raise Unfit("say the lanes of both branches of the fork, once")
    at_stem = lanes_of(merged(stem), one_way=True)
    before = at_stem or lanes_of(whole, one_way=True)
    lanes = before[0] if before else max(sum(pairs[0]), 1) if pairs and not joins else sum(pairs[0]) if pairs else 2
    left, right = pairs[0] if pairs else ((lanes + 1) // 2, max(1, lanes - (lanes + 1) // 2))
    angle = whole.value("angle")
    lengths = (v for things in (*both, [shared]) for t in things for v in t.values("length"))
    length = only(lengths, "both branches of a fork are of one length")
    length = length or whole.value("length") or choices.length("arms", 140, 200)
    at = [*whole.values("stem"), *(v for t in stem for v in t.values("length")), *whole.values("position")]
    fields = {"kind": "fork", "lanes": lanes, "left_lanes": left, "right_lanes": right, "joins": joins, "length": length}
    speed = speed_of(whole) or (FAST if fast else usual_speed([whole]))
    return fields | {"stem": at[0] if at else None, "angle": float(angle or (40.0 if fast else 50.0)), "speed": speed}
