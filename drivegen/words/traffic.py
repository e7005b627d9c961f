"""From a scene to a traffic request, and a request said back."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from pydantic import ValidationError

from drivegen.words.forms import speak
from drivegen.words.request import Group, Kind, TrafficRequest
from drivegen.words.roads import first_complaint
from drivegen.words.saying import Sentence, fact_in_words, sentence
from drivegen.words.table import table, traffic_names
from drivegen.words.things import Scene, Thing, Unfit
from drivegen.words.tokens import stem

_OF_ALL = frozenset({"target_kind"})
_KINDS = ("car", "truck", "bus", "vehicle")


def parted(scene: Scene) -> tuple[Scene, Scene]:
    """What is said of the road, and of the traffic; a limit without any road is the speed of the traffic."""
    road = Scene([t for t in scene.things if t.name not in traffic_names()], Thing("", links=scene.whole.links))
    traffic = Scene([t for t in scene.things if t.name in traffic_names()])
    if link := next((thing for thing in traffic.things if thing.links), None):
        raise Unfit(f"it is not clear what {link.text!r} meets or crosses")
    road.whole.facts = [f for f in scene.whole.facts if f.name not in _OF_ALL]
    traffic.whole.facts = [f for f in scene.whole.facts if f.name in _OF_ALL]
    if traffic.things and not road.things and {f.name for f in road.whole.facts} == {"speed"}:
        traffic.whole.facts += road.whole.facts
        road.whole.facts = []
    return road, traffic


@dataclass
class _Group:
    """A group while it is put together; `asks` is what is said of it, by the names of a request's fields.

    `is_part`: some of another group, which do something of their own.
    """

    kind: str
    count: int
    asks: dict[str, Any] = field(default_factory=dict)
    is_part: bool = False


def request(scene: Scene) -> TrafficRequest:
    """The traffic of a scene. Raises Unfit."""
    groups: list[_Group] = []
    fields: dict[str, Any] = {}
    for thing in scene.things:
        thing.used = True
        if thing.name == "traffic":
            _note(fields, "density", thing.value("density"))
            _note(fields, "speed", thing.value("pace", "speed"))
        elif thing.name == "target":
            _target(thing, fields)
        else:
            _group(thing, groups)
    _note(fields, "target_kind", scene.whole.value("target_kind"))
    _note(fields, "speed", scene.whole.value("speed"))
    groups = [group for group in groups if group.count]
    counts = [group.count for group in groups if group.kind != "vehicle"]
    if len(counts) > 1 and any(group.kind == "vehicle" and group.count == sum(counts) for group in groups):
        raise Unfit(f"{sum(counts)} vehicles can be those that are named, or as many more")
    if len(groups) == 1 and groups[0].count > 1 and "speed" in groups[0].asks and not groups[0].asks.get("queue"):
        _note(fields, "speed", groups[0].asks.pop("speed"))
    if left := scene.unused():
        raise Unfit(f"{left[0]!r} cannot be asked for here")
    if fields.get("density") == "none" and (groups or len(fields) > 1 + ("target_kind" in fields)):
        raise Unfit("no traffic is asked for, and some")
    try:
        return TrafficRequest(groups=tuple(built for group in groups for built in _built(group)), **fields)
    except ValidationError as error:
        raise Unfit(f"this traffic cannot be placed: {first_complaint(error)}") from None


def _target(thing: Thing, fields: dict[str, Any]) -> None:
    if thing.has("within"):
        raise Unfit("no time can be said of the target")
    _note(fields, "target_does", thing.value("does"))
    _note(fields, "target_speed", thing.value("pace", "speed"))


def _note(fields: dict[str, Any], name: str, value: Any) -> None:
    if value is None:
        return
    if fields.setdefault(name, value) != value:
        raise Unfit(f"two different values are said of the traffic's {name.replace('_', ' ')}")


def _group(thing: Thing, groups: list[_Group]) -> None:
    """Add what a thing asks for: a new group, or one member of the last one that does something of its own."""
    count = thing.value("count")
    vague = thing.name in _KINDS and stem(thing.text.split()[-1]) != thing.text.split()[-1] and count is None
    if count is None and (vague or thing.which == "all"):
        raise Unfit(f"say how many {thing.text}")
    if count == 0:
        raise Unfit("ruling out some vehicles cannot be asked for")
    asks = _asks(thing)
    if thing.name == "rest":
        if not groups:
            raise Unfit(f"it is not clear who {thing.text!r} are")
        groups[0].asks |= asks
    elif thing.name == "member":
        source = _source(thing, groups, count or 1)
        others = any(source.asks.get(name, value) != value for name, value in asks.items())
        if others and "of" not in thing.text.split():  # "two cars from the left, one from the right"
            raise Unfit(f"it is not clear whether {thing.text!r} is among the {source.count} that are named before")
        source.count -= count or 1
        kind = thing.value("as") or source.kind
        place = {"place": source.asks["place"]} if "place" in source.asks else {}
        groups.append(_Group(kind, count or 1, place | asks, is_part=True))
    else:
        groups.append(_Group(thing.name, 1 if count is None else int(count), asks))


def _source(thing: Thing, groups: list[_Group], count: int) -> _Group:
    """The group of which `count` do something of their own: the last that is large enough. Raises Unfit where there is none."""
    last = thing.text.split()[-1]
    becomes: str | None = thing.value("as")  # "two of them trucks"
    named = "" if becomes else next((kind for kind in ("car", "truck", "bus") if last in (kind, f"{kind}s", f"{kind}es")), "")
    kinds = ("vehicle", becomes) if becomes else (named,) if named else _KINDS
    idle = [group for group in groups if group.count > 1 and "manoeuvre" not in group.asks]
    several = [group for group in idle if group.kind in kinds and (named or not group.is_part)]
    other = thing.beside is not None and thing.beside.name != "member" and last != "them"  # "two cars and one turning left"
    if not several or other:
        raise Unfit(f"it is not clear who {thing.text!r} is: one of those that are named is 'one of them'")
    if enough := [group for group in several if group.count >= count]:
        return enough[-1]
    raise Unfit(f"there are not so many as {thing.text!r}")


def _asks(thing: Thing) -> dict[str, Any]:
    asks: dict[str, Any] = {}
    thing.accept("around")
    if thing.has("setting", "left_hand"):
        raise Unfit(f"it is not clear what {thing.text!r} has")
    for fact in thing.facts:
        if fact.name.startswith("far_"):
            fact.used = True
            _note(asks, "place", fact.name.removeprefix("far_"))
            _note(asks, "distance", fact.value)
    _note(asks, "speed", thing.value("pace", "speed"))
    for name, field_name in (("place", "place"), ("queue", "queue"), ("manoeuvre", "does"), ("within", "within")):
        _note(asks, name, thing.value(field_name))
    if thing.value("at_light"):
        _note(asks, "place", "ahead")
        _note(asks, "speed", 0.0)
        asks["queue"] = True
    if "within" in asks and "manoeuvre" not in asks:
        raise Unfit("a time is said of nothing that is done")
    return asks


def _built(group: _Group) -> list[Group]:
    """The groups that are asked for: of several vehicles in one group only one does something, so each has a group of its own."""
    asks = dict(group.asks)
    if group.count == 1:
        asks.pop("queue", None)
    if group.count == 1 or "manoeuvre" not in asks:
        return [Group(count=group.count, kind=Kind(group.kind), **asks)]
    if "queue" in asks or "distance" in asks:
        raise Unfit(f"what {group.count} vehicles of one place do cannot be asked for: say it of each")
    return [Group(kind=Kind(group.kind), **asks)] * group.count


def say_request(asked: TrafficRequest) -> list[Sentence]:
    """The sentences that ask for a request."""
    spoken = []
    for group, count in _together(asked.groups):
        are, plural = ("is", "") if count == 1 else ("are", "es" if group.kind is Kind.BUS else "s")
        place = ("place", group.place) if group.distance is None else (f"far_{group.place}", group.distance)
        facts = (place, ("pace", group.speed), ("does", group.manoeuvre), ("within", group.within))
        spoken.append(sentence(f"There {are} {count} {group.kind}{plural}", ("queue", group.queue or None), *facts))
    of_target = sentence("There is", ("target_kind", asked.target_kind)), sentence("The target is", ("does", asked.target_does))
    at_speed = sentence("The target is", ("pace", asked.target_speed))
    spoken += [said for said in (*of_target, at_speed) if said.facts]
    if asked.density is not None or asked.speed is not None:
        words = {None: "traffic"} | {d: speak(p.forms[0], ()) for p in table("traffic") if (d := p.facts.get("density"))}
        spoken.append(sentence(f"There is {words[asked.density]}", ("pace", asked.speed)))
    return spoken


def _together(groups: Sequence[Group]) -> list[tuple[Group, int]]:
    """Groups and how many vehicles are said of each at once: several that do the same, each a group, are one sentence."""
    spoken: list[tuple[Group, int]] = []
    for group in groups:
        alone = group.count == 1 and group.manoeuvre is not None and group.distance is None and not group.queue
        if alone and spoken and group == spoken[-1][0]:
            spoken[-1] = group, spoken[-1][1] + 1
        else:
            spoken.append((group, group.count))
    return spoken


def request_sentences(asked: TrafficRequest) -> list[str]:
    """The same as text."""
    return [
        f"{s.subject} {' '.join(fact_in_words(n, v, ('traffic',)) for n, v in s.facts)}".strip() + "." for s in say_request(asked)
    ]
