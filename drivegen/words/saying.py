"""A specification said back in plain sentences, by the phrase table: whoever reads them gets the same specification.

Sayable is every specification but a free graph, in the form in which words build it: what has no effect (the radius of a straight
road, turn lanes' length where there are none) has its default, angles of arms lie between 0 and 360 degrees.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

from pydantic import BaseModel

from drivegen.layouts.alignment import Alignment
from drivegen.layouts.crossings import Arm, Crossing, Roundabout
from drivegen.layouts.highways import Fork, Highway, HighwayEvent, Interchange
from drivegen.layouts.quadrants import QUADRANTS, QuadrantInterchange
from drivegen.layouts.spec import MapSpec
from drivegen.layouts.streets import Corridor, Grid, Junction
from drivegen.words.forms import speak
from drivegen.words.slots import SLOTS
from drivegen.words.table import table

FieldValue = tuple[str, Any]
"""A field and its value."""


@dataclass(frozen=True)
class Sentence:
    """What is said of one subject."""

    subject: str
    facts: tuple[FieldValue, ...]

    def __str__(self) -> str:
        spoken = [fact_in_words(name, value) for name, value in self.facts]
        return f"{self.subject} {', '.join(spoken)}." if spoken else f"{self.subject.removesuffix(' with')}."


def sentence(subject: str, *facts: FieldValue) -> Sentence:
    """A sentence of those facts that have a value: what is None is not said."""
    return Sentence(subject, tuple(fact for fact in facts if fact[1] is not None))


def fact_in_words(name: str, value: Any, tables: Sequence[str] = ("roads", "lines")) -> str:
    """One fact as it is spoken."""
    if name == "thing":
        return counted(*value)
    if name == "every side":
        return ", ".join(fact_in_words("sides", side) for side in value)
    phrases = [p for each in tables for p in table(each) if p.kind == "fact" and p.name == name and p.place != "pre"]
    exact = [p for p in phrases if p.value is not None and p.value == value and isinstance(value, type(p.value))]
    phrase = (exact or [p for p in phrases if p.value is None])[0]
    slots = () if phrase.value is not None else value if isinstance(value, tuple) and name != "grid_size" else (value,)
    return speak(phrase.forms[0], slots)


def noun(name: str, **facts: Any) -> str:
    """A thing's name as it is spoken."""
    return speak(next(p for p in table("roads") if p.kind == "thing" and p.name == name and p.facts == facts).forms[0], ())


def counted(number: int, name: str, **facts: Any) -> str:
    """So many things of a name: "a crossing", "3 crossings"."""
    word = noun(name, **facts)
    return f"{'an' if word[0] in 'aeio' else 'a'} {word}" if number == 1 else f"{number} {word}s"


def say(spec: MapSpec) -> list[Sentence]:
    """The sentences. Raises ValueError for a free graph, which words cannot hold."""
    says = {Crossing: _crossing, Roundabout: _roundabout, Corridor: _corridor, Grid: _grid, Highway: _highway, Fork: _fork,
            Interchange: _interchange, QuadrantInterchange: _quadrants}  # fmt: skip
    if type(spec.road) not in says:
        raise ValueError(f"a {spec.road.kind} cannot be said in words")
    hand = [Sentence("There is", (("left_hand", True),))] if spec.left_hand else []
    width = getattr(spec.road, "lane_width", None)
    usual = (None, type(spec.road).model_fields["lane_width"].default) if width else (None,)
    wide = [] if width in usual else [Sentence("There are", (("lane_width", width),))]
    return [*says[type(spec.road)](spec.road), *wide, *hand]  # type: ignore[operator]


def sentences(spec: MapSpec) -> list[str]:
    """The same as text."""
    return [str(sentence) for sentence in say(spec)]


def _fields(part: BaseModel, *names: str) -> list[FieldValue]:
    """Fields of a part of a specification that are said under their own names."""
    return [(name, getattr(part, name)) for name in names]


def _lanes(ahead: int, back: int) -> list[FieldValue]:
    if back == 0:
        return [("one_way", True), ("lanes", ahead)]
    return [("lanes_each", ahead) if ahead == back else ("lanes_pair", (ahead, back))]


def _grouped(each: str, one: str, items: Sequence[list[FieldValue]]) -> list[Sentence]:
    """What is said of every item in one sentence, and the rest one by one; `one` holds a place for the ordinal or is a list."""
    common = [fact for fact in items[0] if all(fact in other for other in items)] if len(items) > 1 else []
    spoken = [sentence(each, *common)]
    for i, item in enumerate(items):
        spoken.append(sentence(one.format(SLOTS["nth"].speak(i + 1)), *(fact for fact in item if fact not in common)))
    return [said for said in spoken if said.facts]


def _arms(arms: Sequence[Arm], angles: Sequence[float], main: Sequence[bool]) -> list[Sentence]:
    items = []
    for arm, angle, priority in zip(arms, angles, main, strict=True):
        same = arm.lanes_in == arm.lanes_out
        facts: list[FieldValue] = [("angle", arm.angle if arm.angle != angle else None)]
        facts += [("lanes_each", arm.lanes_in)] if same else _fields(arm, "lanes_in", "lanes_out")
        facts += [
            *_fields(arm, "speed", "length"),
            ("median", arm.median or None),
            *_turn_lanes(arm),
            *(("turn_bans", side) for side in arm.turn_bans),
        ]
        items.append([*facts, ("priority", arm.main if arm.main != priority else None)])
    return _grouped("Every arm has", "The {} arm has", items)


def _turn_lanes(road: Arm | Junction) -> list[FieldValue]:
    counts = {"left": road.left_turn_lanes, "right": road.right_turn_lanes}
    facts: list[FieldValue] = [("turn_lanes", side) if n == 1 else ("turn_lanes_n", (n, side)) for side, n in counts.items() if n]
    return [*facts, ("pocket", road.pocket)] if facts else []


def _crossing(road: Crossing) -> list[Sentence]:
    angles, count = [arm.angle for arm in road.arms], len(road.arms)
    even = [i * 360.0 / count for i in range(count)]
    shape, base = None, even
    if count == 3:
        stem = 90.0 if angles[2] < 180.0 and angles[0] == 180.0 and angles[1] == 0.0 else 270.0
        shape, base = ("t", [180.0, 0.0, stem]) if angles[:2] == [180.0, 0.0] else ("y", [180.0, 35.0, -35.0])
    main = [i != 2 for i in range(3)] if shape == "t" else [True] * count
    head = noun("crossing", arms=3, shape=shape) if shape else noun("crossing")
    arms, side = ("arms", None if shape else count), ("side", "left" if shape == "t" and base[2] == 90.0 else None)
    none = ("no_turn_lanes", None if any(arm.left_turn_lanes or arm.right_turn_lanes for arm in road.arms) else True)
    return [sentence(f"A {head} with", arms, ("control", road.control), side, none), *_arms(road.arms, base, main)]


def _roundabout(road: Roundabout) -> list[Sentence]:
    count = len(road.arms)
    even = [i * 360.0 / count for i in range(count)]
    facts = (("arms", count), *_fields(road, "diameter", "ring_lanes", "ring_speed"))
    return [Sentence("A roundabout with", facts), *_arms(road.arms, even, [True] * count)]


def _line(line: Alignment) -> list[FieldValue]:
    if line.shape == "straight":
        return [("straight", True), ("length", line.length)]
    facts: list[FieldValue] = [("line", line.shape)]
    if line.arcs:
        facts += [("arc", (abs(angle), "left" if angle > 0 else "right", radius)) for angle, radius in line.arcs]
        arc = sum(abs(math.radians(angle)) * radius for angle, radius in line.arcs)
    else:
        angle, number = abs(line.angle), len(line.curves)
        facts += [("turn", (angle, "left" if line.angle > 0 else "right")), *_fields(line, "radius", "bends")]
        arc = math.radians(angle) * line.radius * number
    straights = round(line.length - arc, 3)
    return [*facts, ("straights", straights) if arc + straights == line.length else ("length", line.length)]


def _corridor(road: Corridor) -> list[Sentence]:
    facts = [*_lanes(road.lanes, road.lanes_back), ("speed", road.speed), *_line(road.alignment)]
    road_itself = sentence("A road with", *facts, ("median", road.median or None), ("dead_end", road.dead_end or None))
    return [road_itself, *_along_it([(junction.form, _junction(junction)) for junction in road.junctions])]


def _along_it(things: Sequence[tuple[str, list[FieldValue]]]) -> list[Sentence]:
    """Things in a row, those of one name that follow one another as a number, and what is said of each."""
    if not things:
        return []
    runs = [(len([*run]), name) for name, run in groupby(name for name, _ in things)]
    spoken = [sentence(f"Along it there {'is' if runs[0][0] == 1 else 'are'}", *(("thing", run) for run in runs))]
    for name in dict.fromkeys(name for name, _ in things):
        items = [facts for other, facts in things if other == name]
        spoken += _grouped(f"Every {noun(name)} has", f"The {{}} {noun(name)} has", items)
    return spoken


def _junction(junction: Junction) -> list[FieldValue]:
    own = ("control",) if junction.form == "crossing" else ("ring_lanes", "diameter")
    facts: list[FieldValue] = [("position", junction.position), ("every side", junction.sides), *_fields(junction, *own)]
    facts += [*_fields(junction, "side_lanes", "side_speed", "side_length"), *_turn_lanes(junction)]
    facts += [("main_turn_bans", side) for side in junction.turn_bans]
    facts += [("side_turn_bans", side) for side in junction.side_turn_bans]
    return [*facts, ("side_dead_end", junction.dead_end or None)]


def _grid(road: Grid) -> list[Sentence]:
    facts = [("grid_size", (road.rows, road.columns)), ("spacing", road.spacing)]
    facts += [*_lanes(road.lanes, 0 if road.one_way else road.lanes), *_fields(road, "speed", "beyond", "control")]
    return [sentence(f"A {noun('grid')} with", *facts)]


def _highway(road: Highway) -> list[Sentence]:
    two = road.carriageways == 2
    facts = [*_lanes(road.lanes, road.lanes if two else 0), ("speed", road.speed), *_line(road.alignment)]
    facts += [("median", road.median if two else None), ("both", road.both or None)]
    return [sentence(f"A {noun('highway')} with", *facts), *_along_it([(event.kind, _event(event)) for event in road.events])]


def _event(event: HighwayEvent) -> list[FieldValue]:
    ramp = event.kind in ("on_ramp", "off_ramp", "weaving")
    nose = event.position + (event.length if event.kind == "off_ramp" else 0.0)
    own = ("auxiliary", event.length) if ramp else ("side", event.side)
    limit = ("ramp_speed", event.ramp_speed if ramp else None)
    return [("position", round(nose, 6)), ("event_lanes", event.lanes), own, limit, ("keeps", event.keeps or None)]


def _fork(road: Fork) -> list[Sentence]:
    lanes = ("lanes", road.lanes), ("branch_lanes", (road.left_lanes, road.right_lanes))
    facts = (("joins", 2 if road.joins else None), *lanes, *_fields(road, "angle", "speed", "length", "stem"))
    return [sentence(f"A {noun('fork')} with", *facts)]


def _interchange(road: Interchange) -> list[Sentence]:
    facts = [("control", road.control), ("ramp_lanes", road.ramp_lanes), ("ramps_limit", road.ramp_speed)]
    return _two_levels(counted(1, "interchange", form=road.form), facts, road, road.road_length)


def _two_levels(name: str, facts: list[FieldValue], road: Interchange | QuadrantInterchange, length: float) -> list[Sentence]:
    """Of an interchange, its highway and the road above it."""
    above = (("lanes_each", road.road_lanes), ("speed", road.road_speed), ("length", length))
    return [
        sentence(f"{name.capitalize()} with", *facts),
        Sentence(f"The {noun('highway')} has", (("lanes_each", road.lanes), ("speed", road.speed))),
        Sentence(f"The {noun('upper')} has", above),
    ]


def _quadrants(road: QuadrantInterchange) -> list[Sentence]:
    facts: list[FieldValue] = [("ramp_lanes", road.ramp_lanes), ("ramps_limit", road.ramp_speed)]
    facts += [*_fields(road, "loop_radius", "loop_speed", "median"), ("leg", None if road.south_leg else "north")]
    facts += _fields(road, "control")
    head = counted(1, "cloverleaf", form="cloverleaf" if road.north_leg else "trumpet")
    ramps = [Sentence(f"The {noun(name)} has", (("ramps", getattr(road, name)),)) for name in QUADRANTS]
    return [*_two_levels(head, facts, road, road.leg_length), *ramps]
