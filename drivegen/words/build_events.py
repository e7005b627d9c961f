"""From a scene to what happens along a highway, in order: ramps, lanes that end or begin, and where on the road each lies."""

from collections.abc import Sequence
from typing import Any

from drivegen.words.build_rows import counted
from drivegen.words.slots import KMH
from drivegen.words.things import Fact, Road, Scene, Thing, Undrawable, Unfit, merged

Event = dict[str, Any]
"""Fields of an event, and the things that are said of it: `thing`."""

_FIRST, _BETWEEN, _LAST, _LEAST_BETWEEN, _LEAST_LAST = 250.0, 120.0, 250.0, 45.0, 40.0
AUXILIARY = {"on_ramp": 200.0, "off_ramp": 150.0, "weaving": 300.0}
_SHARES = (0.8, 0.6, 0.45)
SHORTEST = 50.0
_FURTHER = frozenset({"another", "second", "third", "further"})
"""Words that tell a second event from the first one said again."""

EVENTS = ("on_ramp", "off_ramp", "ramp", "weaving", "lane_drop", "lane_gain")
_FEWER = ("narrow", "reduc", "drop", "taper", "shrink", "squeez", "funnel")
_MORE = ("widen", "grow", "expand", "gain", "opens up")
_CHANGES = ("change", "change_to")
EVENT_FACTS = (*_CHANGES, "loses", "loses_side", "gains", "gains_side")


def events_of(scene: Scene, road: Thing, lanes: int | None) -> tuple[list[Event], int | None]:
    """What happens along the carriageway, in order, and the number of lanes at its start where only a change tells it."""
    things = [thing for thing in scene.named(*EVENTS) if thing.which is None]
    references = [thing for thing in scene.things if thing.name in EVENTS and thing.which is not None]
    if any(t.name == "weaving" for t in things) and not references:
        _absorb(things)
    events: list[Event] = []
    for thing in things:
        if thing.name == "ramp":
            thing.name = "on_ramp" if thing.has("merges") else "off_ramp" if thing.has("leaves") else "ramp"
        if thing.name == "ramp":
            raise Unfit("say whether it is an on-ramp or an off-ramp")
        events += [{"kind": thing.name, "thing": [thing]} for _ in range(counted(thing))]
    for kind in ("on_ramp", "off_ramp"):
        same = [thing for thing in things if thing.name == kind]
        if len({t.text for t in same}) > 1 and not all(t.has("position", "gap") for t in same[1:]):
            raise Unfit(f"{' and '.join(repr(thing.text) for thing in same)} can be one ramp or several")
    facts = [fact for fact in road.facts if fact.name in EVENT_FACTS]
    steps = _steps(facts, lanes)
    single: list[Event] = []
    for kind in ("lane_drop", "lane_gain"):
        named = [event for event in events if event["kind"] == kind]
        keeping = any(t.has("keeps") for t in things if t.name == ("off_ramp" if kind == "lane_drop" else "on_ramp"))
        single += _once([s for s in steps if s["kind"] == kind], named, keeping)
    events += sorted(single, key=steps.index)
    changes = [fact.value for fact in facts if fact.name == "change"]
    bare = {thing.name for thing in things if thing.name.startswith("lane_") and not thing.facts}
    if bare and any(step["kind"] not in bare for step in steps):
        raise Unfit(f"{' and '.join(repr(step['text']) for step in steps)} is no {' or '.join(sorted(bare)).replace('_', ' ')}")
    for ref, event in ((r, e) for r in references for e in r.among([event for event in events if event["kind"] == r.name])):
        event["thing"] = [*event["thing"], ref]
    return events, changes[0][0] if changes else None


def _steps(facts: Sequence[Fact], lanes: int | None) -> list[Event]:
    """Each fact as an event, of which `before` is the number of lanes ahead of it where the fact says it. Raises Unfit."""
    steps: list[Event] = []
    for fact in facts:
        fact.used = True
        if fact.name in _CHANGES:
            before, after = fact.value if fact.name == "change" else (lanes, fact.value)
            if before is None or before == after:
                raise Unfit(f"say from how many lanes to how many in {fact.text!r}")
            if lanes is not None and lanes != before:
                raise Unfit(f"a road of {lanes} lanes cannot change from {before}")
            if any(word in fact.text for word in (_FEWER if after > before else _MORE)):
                raise Unfit(f"{fact.text!r} says the opposite of {before} to {after} lanes")
            lanes = int(after)
            kind = "lane_gain" if after > before else "lane_drop"
            step: Event = {"kind": kind, "lanes": abs(after - before), "before": before}
        else:
            step = {"kind": "lane_drop" if fact.name.startswith("loses") else "lane_gain"}
            step |= {"lanes": 1, "side": fact.value} if isinstance(fact.value, str) else {"lanes": int(fact.value)}
        steps.append(step | {"thing": [], "text": fact.text})
    return steps


def _once(steps: Sequence[Event], named: Sequence[Event], keeping: bool) -> list[Event]:
    """The events of one kind that are said, each once: those of a noun ("a lane drop") hold what is said of them besides.

    `keeping`: a ramp takes such lanes along, or brings them. Raises Unfit where two phrases can mean one event or two.
    """
    changes = [step for step in steps if "before" in step]
    single = [step for step in steps if "before" not in step]
    nouns = {thing.text for event in named for thing in event["thing"]}
    sides = [step.get("side") for step in single]
    again = [not _FURTHER & set(step["text"].split()) for step in single[1:]]
    unclear = (len(sides) > len(set(sides) - {None}) and any(again)) or len(nouns) > 1
    groups = [group for group in (named, single, changes) if group]
    if unclear or (keeping and groups) or any(len(group) != len(groups[0]) for group in groups):
        texts = [step["text"] for step in steps] + sorted(nouns)
        raise Unfit(f"it is not clear how many lanes end or begin: {' and '.join(map(repr, texts))} can be one event or several")
    for same in zip(*groups, strict=True):
        counts = {event["lanes"] for event in same if "lanes" in event}
        counts |= {n for event in same for t in event["thing"] for name in ("lanes", "event_lanes") for n in t.values(name)}
        if len(counts) > 1:
            raise Unfit(f"{' and '.join(map(str, sorted(counts)))} lanes are said of one lane change")
        for event in same[1:]:
            same[0].update({name: value for name, value in event.items() if name != "thing"})
    return [] if not groups or groups[0] is named else list(groups[0])


def _absorb(things: list[Thing]) -> None:
    """The ramps that a weaving section is made of are not ramps of their own."""
    weaving = next(thing for thing in things if thing.name == "weaving")
    for thing in [t for t in things if t.name in ("on_ramp", "off_ramp")]:
        if any(t is not thing and t.name == thing.name for t in things):
            raise Unfit("it is not clear which ramps the weaving section lies between")
        weaving.facts += [Fact("length", f.value, f.text, f.scope) for f in thing.facts if f.name in ("gap", "spacing")]
        weaving.facts += [f for f in thing.facts if f.name not in ("gap", "spacing", "side")]
        thing.accept("gap", "spacing", "side")
        things.remove(thing)


def fit(events: list[dict[str, Any]], speed: float, line: Road, fixed: bool, limit: float | None) -> tuple[list[Road], Road]:
    """Events along a road long enough for them; where its length is said, what is unsaid between them is shortened."""
    for share in (1.0, *(_SHARES if fixed else ())):
        placed, needed = _placed([dict(event) for event in events], speed, share, limit, fixed=fixed)
        if not events or line["length"] >= needed:
            return placed, line
    if fixed:
        raise Unfit(f"a road of {line['length']:.0f} m is too short for what happens along it: it needs {needed:.0f} m")
    return placed, {**line, "length": needed}


def _placed(
    events: list[dict[str, Any]], speed: float, share: float, limit: float | None, *, fixed: bool
) -> tuple[list[Road], float]:
    """Events as fields, usual distances times `share`, and the length of road that they need, little behind them if `fixed`."""
    placed: list[Road] = []
    end = 0.0
    usual = max(30 * KMH, min(speed, 60 * KMH)) if limit is None else limit
    given, everywhere = None, True
    for event in events:
        facts = merged(event["thing"])
        ramp = event["kind"] in AUXILIARY
        facts.accept("count", "setting", "merges", "leaves", "one_side", "has_auxiliary", "has_ramps", "row")
        exact, given = given, facts.value("auxiliary") or facts.value("length")
        everywhere = everywhere and (facts.has("position") or (facts.has("gap") and not placed))
        length = given or AUXILIARY.get(event["kind"], 0.0) * share
        here = facts.value("position")
        if facts.has("spacing") and len(events) == 1:
            raise Undrawable("say how many there are so far apart")
        gap = facts.value("gap") or facts.value("spacing")
        if here is None and gap:
            here = gap + (nose_of(placed[-1]) if placed else 0.0)
        if here is not None and event["kind"] == "off_ramp":
            length = given or max(SHORTEST, min(length, here - SHORTEST))
            here = round(here - length, 6)
        if here is None:
            here = end + _BETWEEN * share if placed else _FIRST * share
        if placed and here < end + _LEAST_BETWEEN and placed[-1]["kind"] in AUXILIARY and not exact:
            placed[-1]["length"] = max(SHORTEST, round(here - _LEAST_BETWEEN - placed[-1]["position"], 6))
        counted = facts.value("lane_road", "event_lanes", "lanes", "lanes_each")
        sides = {*facts.values("side"), *([event["side"]] if "side" in event else [])}
        if len(sides) > 1 or (ramp and "left" in sides):
            raise Unfit("ramps are on the outer side of the road" if ramp else "a lane ends or begins on one side")
        road: Road = {"kind": event["kind"], "position": here, "lanes": event.get("lanes") or counted or 1}
        road |= {"side": sides.pop()} if sides else {}  # a specification has the outer side where none is said
        road |= {"ramp_speed": facts.value("speed", "ramp_speed") or usual} if ramp else {}
        road |= {"keeps": facts.value("keeps")}
        placed.append({**road, "length": length if ramp else None})
        end = here + (length if ramp else 0.0)
    return placed, end + (_LEAST_LAST if everywhere and fixed else _LAST * share)


def nose_of(event: Road) -> float:
    """Where an event is said to be [m]: an on-ramp where it has come alongside, an off-ramp where it leaves."""
    return float(event["position"] + (event["length"] if event["kind"] == "off_ramp" else 0.0))
