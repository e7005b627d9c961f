"""Highways and forks from facts: where along the carriageway things happen, and how many lanes there are."""

from collections.abc import Callable
from typing import Any

from drivegen.errors import UnusableInput
from drivegen.maps.spec_values import Side
from drivegen.maps.writers._choices import KMH, Choices
from drivegen.maps.writers._facts import EventWords, Facts

Road = dict[str, Any]

_FIRST, _BETWEEN, _LAST = 250.0, 120.0, 250.0
_LEAST_BETWEEN = 45.0
_AUXILIARY = {"on_ramp": 200.0, "off_ramp": 150.0, "weaving": 300.0}
_BEND_RADIUS = 250.0
_STEM = 180.0
_SHARES = (0.8, 0.6, 0.45)


def highway(facts: Facts, choices: Choices, alignment: Callable[..., Road]) -> Road:
    """A highway with what the description puts along it."""
    fast = facts.has("highway") or (bool(facts.events) and not facts.surroundings)
    speed = choices.speed(facts, highway=fast)
    events = _events(facts)
    lanes = _lanes(facts, choices, 3 if fast and not facts.has("divided") else 2, events)
    line = alignment(facts, choices, (800, 1200), radius=_BEND_RADIUS)
    placed = _fit(facts, choices, events, speed, line)
    one_way = bool(facts.one_way) and not facts.two_way
    median = {"median": facts.lengths["median"]} if "median" in facts.lengths and not one_way else {}
    return {
        **median,
        "kind": "highway",
        "alignment": line,
        "lanes": lanes,
        "speed": speed,
        "carriageways": 1 if one_way else 2,
        "events": placed,
    }


def _fit(facts: Facts, choices: Choices, events: list[EventWords], speed: float, line: Road) -> list[Road]:
    """The events along a road that is long enough for them: where its length is said, what is unsaid between them is shortened.

    Raises UnusableInput where the whole road is said to be shorter than its events need at least.
    """
    placed, needed = _place(facts, events, speed)
    if "rest" in facts.lengths and "length" not in facts.lengths:
        line["length"] = max(needed - _LAST + facts.lengths["rest"], 20.0)
    if not events or line["length"] >= needed:
        return placed
    if "length" in facts.lengths:
        for share in _SHARES:
            closer, least = _place(facts, events, speed, share)
            if line["length"] >= least:
                return closer
        if facts.whole:
            raise UnusableInput(
                f"a road of {line['length']:.0f} m is too short for what happens along it: it needs {least:.0f} m",
                reason="impossible-map",
            )
        choices.assume(f"length {needed:.0f} m, because {line['length']:.0f} m are too short for what happens along the road")
        choices.waived.append(line["length"])
    line["length"] = needed
    return placed


def fork(facts: Facts, choices: Choices) -> Road:
    """A road that splits into two: one-way where it is a highway or said so, else a Y of two-way roads."""
    lanes = choices.lanes(facts, 2, "main")
    angle = facts.angle if facts.angle is not None and facts.angle <= 120 else 50.0
    length = facts.lengths.get("branch") or facts.lengths.get("length") or choices.length("arms", 140, 200)
    stem = facts.lengths.get("stem", length)
    fast = facts.has("highway")
    speed = choices.speed(facts, highway=fast)
    if fast or facts.branches or facts.has("carriageway") or (facts.one_way and not facts.two_way) or facts.events:
        left, right = facts.branches or ((lanes + 1) // 2, max(1, lanes - (lanes + 1) // 2))
        told = facts.branches and not (facts.lanes or facts.other_lanes)
        lanes = left + right if told else max(left, right, min(lanes, left + right))
        road = {"kind": "fork", "lanes": lanes, "left_lanes": left, "right_lanes": right, "length": length}
        road |= {"joins": facts.has("joining"), **({"stem": stem} if stem != length else {})}
        return {**road, "angle": min(angle, 40.0) if fast else angle, "speed": speed}
    arm = {"lanes_in": lanes, "lanes_out": lanes, "speed": speed}
    arms = [{**arm, "angle": a, "length": stem if a == _STEM else length} for a in _branches(angle)]
    return {"kind": "crossing", "arms": arms, "control": facts.control or "yield"}


def _branches(angle: float) -> list[float]:
    half = max(angle, 30.0) / 2
    return [_STEM, half, -half]


def _events(facts: Facts) -> list[EventWords]:
    events = list(facts.events)
    change = (facts.to_lanes or 0) - (facts.from_lanes or 0)
    if facts.to_lanes is not None and facts.from_lanes is not None and change:
        kind = "lane_gain" if change > 0 else "lane_drop"
        at = facts.features.get(kind, 0)
        side: Side = "left" if facts.turn == "left" else "right"
        least, more = divmod(abs(change), facts.steps)
        places = facts.step_places if len(facts.step_places) == facts.steps else [None] * facts.steps
        events += [EventWords(kind, at, least + (i < more), side, position=metres) for i, metres in enumerate(places)]
    if facts.has("weaving"):
        # The weaving section is made of the ramps that the description may also name.
        gap = next((e.gap for e in events if e.kind in ("on_ramp", "off_ramp") and e.gap), None)
        events = [e for e in events if e.kind not in ("on_ramp", "off_ramp")]
        events.append(EventWords("weaving", facts.features["weaving"], length=gap or facts.lengths.get("spacing")))
    return sorted(events, key=lambda event: event.at)


def _lanes(facts: Facts, choices: Choices, usual: int, events: list[EventWords]) -> int:
    if facts.from_lanes is not None:
        return facts.from_lanes
    lanes = choices.lanes(facts, usual, "main")
    if facts.to_lanes is not None:  # "a three-lane highway that narrows to two"
        change = facts.to_lanes - lanes
        if change == 0:
            raise UnusableInput(f"a road of {lanes} lanes cannot change to {lanes} lanes", reason="impossible-map")
        events.append(EventWords("lane_gain" if change > 0 else "lane_drop", facts.features.get("lane_change", 0), abs(change)))
        events.sort(key=lambda event: event.at)
    return lanes


def _place(facts: Facts, events: list[EventWords], speed: float, share: float = 1.0) -> tuple[list[Road], float]:
    """Positions along the carriageway, usual distances times `share`; returns the events and the length of road they need."""
    ramp_speed = facts.speeds.get("ramp", max(30 * KMH, min(speed, 60 * KMH)))
    placed: list[Road] = []
    end = 0.0
    for event in events:
        lanes = event.lanes or (facts.lanes.get("ramp", 1) if event.kind in _AUXILIARY else 1)
        length = facts.lengths.get("auxiliary", event.length or _AUXILIARY.get(event.kind, 0.0) * share)
        here = _position(facts, event, placed, end, share)
        if placed and here < end + _LEAST_BETWEEN and placed[-1]["kind"] in _AUXILIARY and "auxiliary" not in facts.lengths:
            placed[-1]["length"] = max(50.0, here - _LEAST_BETWEEN - placed[-1]["position"])  # what was said leaves less room
        road: Road = {"kind": event.kind, "position": here, "lanes": lanes, "side": event.side}
        road["ramp_speed"] = event.speed or ramp_speed
        road |= {"keeps": True} if event.keeps else {}
        placed.append({**road, "length": length} if event.kind in _AUXILIARY else road)
        end = here + length
    return placed, end + _LAST * share


def _position(facts: Facts, event: EventWords, placed: list[Road], end: float, share: float) -> float:
    """Where an event lies: where the description says, or a usual distance from what comes before it."""
    if event.position is not None:
        return event.position
    if not placed:
        return facts.lengths.get("position", event.gap or _FIRST * share)
    gap = event.gap or facts.lengths.get("spacing")
    return max(placed[-1]["position"] + gap, placed[-1]["position"] + 100.0) if gap else end + _BETWEEN * share
