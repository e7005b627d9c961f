"""Edits of a specification, as fields: each changes them in place and says in words what it did.

They take the match of their pattern in `refine.py`, whose groups they know, and raise UnusableInput where the road has
nothing of the kind.
"""

import re
from collections.abc import Callable
from typing import Any

from drivegen.errors import UnusableInput

Fields = dict[str, Any]
REMOVES = r"(?:remove|delete|drop|without|no(?: more)?|take (?:away|out)|get rid of|switch off|scrap|lose)"
"""Words that take something away."""

_LANES = ("lanes", "lanes_back", "lanes_in", "lanes_out", "left_lanes")
_LENGTHS = ("length", "leg_length", "road_length")
_UNITS = {"kmh": 1 / 3.6, "mph": 0.44704, "mps": 1.0, "": 1 / 3.6}


def _each(value: Any, change: Callable[[Fields], None]) -> None:
    """Apply a change to every mapping inside `value`."""
    if isinstance(value, dict):
        change(value)
        for item in value.values():
            _each(item, change)
    elif isinstance(value, list):
        for item in value:
            _each(item, change)


def change_lanes(fields: Fields, match: re.Match[str]) -> str:
    """More or fewer lanes in every direction."""
    count = int(match[2]) if match[2] else 1
    step = count if match[1].startswith(("add", "widen", "extra", "put", "give", "1 ", "another")) else -count

    def change(part: Fields) -> None:
        for name in _LANES:
            if part.get(name) and not _is_event(part):
                part[name] += step

    _each(fields["road"], change)
    return f"{'+' if step > 0 else '-'}{abs(step)} lane per direction"


def _is_event(part: Fields) -> bool:
    return "ramp_speed" in part and "position" in part  # interchanges have ramps as well


def set_lanes(fields: Fields, match: re.Match[str]) -> str:
    """So many lanes in every direction."""
    lanes = int(match[1])

    def change(part: Fields) -> None:
        for name in _LANES:
            if part.get(name) and not _is_event(part) and name != "left_lanes":
                part[name] = lanes

    _each(fields["road"], change)
    return f"{lanes} lanes per direction"


def control(control: str, meaning: str) -> Callable[[Fields, re.Match[str]], str]:
    """The edit that puts this control at every crossing."""

    def apply(fields: Fields, _match: re.Match[str]) -> str:
        if not _has(fields["road"], "control"):
            raise UnusableInput("this road has no crossing that could be controlled", reason="impossible-map")

        def change(part: Fields) -> None:
            if part.get("control"):
                part["control"] = control

        _each(fields["road"], change)
        return meaning

    return apply


def _has(value: Any, name: str) -> bool:
    found: list[bool] = []
    _each(value, lambda part: found.append(part.get(name) is not None))
    return any(found)


def set_speed(fields: Fields, match: re.Match[str]) -> str:
    """The limit of all roads; rings, ramps, loops and the road over a highway, which have limits of their own, are not faster."""
    speed = float(match[1]) * _UNITS[match[2] or ""]

    def change(part: Fields) -> None:
        for name in ("speed", "side_speed"):
            if name in part:
                part[name] = speed
        for name in ("ring_speed", "ramp_speed", "loop_speed", "road_speed"):
            if name in part:
                part[name] = min(part[name], speed)

    _each(fields["road"], change)
    return f"speed limit {speed * 3.6:.0f} km/h"


def to_roundabout(fields: Fields, _match: re.Match[str]) -> str:
    """Crossings become roundabouts with the same arms."""
    road = fields["road"]
    if road["kind"] == "crossing":
        arms = [{**arm, "left_turn_lane": False, "right_turn_lane": False} for arm in road["arms"]]
        ring = 2 if max(arm["lanes_in"] for arm in arms) > 1 else 1
        diameter = max(30.0 + 10.0 * ring, 9.0 * len(arms) + 8.0 * ring)
        fields["road"] = {"kind": "roundabout", "arms": arms, "ring_lanes": ring, "diameter": diameter}
    elif road.get("junctions"):
        for junction in road["junctions"]:
            junction["form"] = "roundabout"
    else:
        raise UnusableInput(f"a {road['kind']} cannot become a roundabout", reason="impossible-map")
    return "roundabout"


def to_crossing(fields: Fields, _match: re.Match[str]) -> str:
    """Roundabouts become crossings with the same arms."""
    road = fields["road"]
    if road["kind"] == "roundabout":
        fields["road"] = {"kind": "crossing", "arms": road["arms"]}
    elif road.get("junctions"):
        for junction in road["junctions"]:
            junction["form"] = "crossing"
    else:
        raise UnusableInput(f"a {road['kind']} cannot become a crossing", reason="impossible-map")
    return "crossing"


def move(fields: Fields, match: re.Match[str]) -> str:
    """Move what happens along the road, and what comes after it, so that gaps stay."""
    metres = float(match[2]) * (1000.0 if match[3] == "km" else 1.0)
    towards = match.group()
    back = re.search(r"\b(?:upstream|earlier|closer|nearer|forward to the start)\b", towards) is not None
    # What is pushed back comes later, what is moved back comes sooner.
    back |= re.search(r"\bback\b", towards) is not None and not towards.startswith("push")
    metres = -metres if back else metres
    road = fields["road"]
    wanted = _ramp_kind(match[1])
    parts = [e for e in road.get("events", []) if wanted in (None, e["kind"])] or road.get("junctions", [])
    if not parts:
        raise UnusableInput("there is nothing along this road that could be moved", reason="impossible-map")
    everything = road.get("events") or road["junctions"]
    for part in everything[everything.index(parts[0]) :]:
        part["position"] += metres
    last = everything[-1]["position"] + everything[-1].get("length", 0.0)
    road["alignment"]["length"] = max(road["alignment"]["length"], last + 150.0)
    return f"moved {abs(metres):.0f} m {'down' if metres > 0 else 'up'}stream"


def _ramp_kind(words: str | None) -> str | None:
    kinds = {"on": "on_ramp", "entry": "on_ramp", "entrance": "on_ramp", "off": "off_ramp", "exit": "off_ramp"}
    return next((kind for word, kind in kinds.items() if (words or "").strip().startswith(word)), None)


def remove_ramp(fields: Fields, match: re.Match[str]) -> str:
    """Remove the ramps of a kind, or all."""
    kind, road = _ramp_kind(match[1]), fields["road"]
    gone = [e for e in road.get("events", []) if e["kind"] in ((kind,) if kind else ("on_ramp", "off_ramp", "weaving"))]
    if not gone:
        raise UnusableInput("there is no such ramp along this road", reason="impossible-map")
    road["events"] = [event for event in road["events"] if event not in gone]
    return f"{len(gone)} ramp{'s' if len(gone) > 1 else ''} removed"


def add_ramp(fields: Fields, match: re.Match[str]) -> str:
    """Add a ramp after all that happens along the highway."""
    road, kind = fields["road"], _ramp_kind(match[1]) or "on_ramp"
    if road["kind"] != "highway":
        raise UnusableInput(f"a {road['kind']} can have no ramps", reason="impossible-map")
    last = max((e["position"] + e["length"] for e in road["events"]), default=130.0)
    road["events"].append({"kind": kind, "position": last + 120.0})
    road["alignment"]["length"] = max(road["alignment"]["length"], last + 570.0)
    return f"{kind.replace('_', '-')} added"


def set_ramp_lanes(fields: Fields, match: re.Match[str]) -> str:
    """So many lanes on the ramps of a kind, or on all."""
    lanes, kind = int(match[1]), _ramp_kind(match[2])
    ramps = [e for e in fields["road"].get("events", []) if "ramp" in e["kind"] and kind in (None, e["kind"])]
    if not ramps:
        raise UnusableInput("there is no such ramp along this road", reason="impossible-map")
    for ramp in ramps:
        ramp["lanes"] = lanes
    return f"{lanes} lanes on the ramp"


def set_auxiliary(fields: Fields, match: re.Match[str]) -> str:
    """The length of acceleration or deceleration lanes, or of a weaving section."""
    metres = float(match[2]) * (1000.0 if match[3] == "km" else 1.0)
    kinds = {"acc": ("on_ramp",), "dec": ("off_ramp",), "wea": ("weaving",)}.get(match[1][:3], ("on_ramp", "off_ramp", "weaving"))
    parts = [e for e in fields["road"].get("events", []) if e["kind"] in kinds]
    if not parts:
        raise UnusableInput(f"there is no {match[1]} lane along this road", reason="impossible-map")
    for part in parts:
        part["length"] = metres
    road = fields["road"]
    road["alignment"]["length"] = max(road["alignment"]["length"], road["events"][-1]["position"] + metres + 100.0)
    return f"{match[1]} lane of {metres:.0f} m"


def set_length(fields: Fields, match: re.Match[str]) -> str:
    """The length of the road, of each arm where it has arms, or how much longer or shorter it becomes."""
    road = fields["road"]
    metres = float(match[2]) * (1000.0 if match[3] == "km" else 1.0)
    word = match[1] or match[4] or ""
    step = metres if word.startswith(("longer", "extend", "lengthen")) else -metres if word.startswith("short") else None
    changed: list[str] = []

    def change(part: Fields) -> None:
        for name in _LENGTHS:
            if name in part and not _is_event(part):
                part[name] = metres if step is None else part[name] + step
                changed.append(name)

    _each(road.get("alignment", road), change)
    if not changed:
        raise UnusableInput(f"a {road['kind']} has no length that could be set", reason="impossible-map")
    return f"{metres:.0f} m {match[1] or match[4] or 'long'}"


def turn_lanes(fields: Fields, match: re.Match[str]) -> str:
    """Turn lanes at every arm, or none."""
    wanted = not re.match(REMOVES, match[1] or "")
    sides = [side for side in ("left", "right") if match[2] is None or side in match[2]]
    if fields["road"]["kind"] != "crossing":
        raise UnusableInput("only a single crossing can have turn lanes", reason="impossible-map")
    for arm in fields["road"]["arms"]:
        arm.update({f"{side}_turn_lane": wanted for side in sides})
    return f"{'with' if wanted else 'no'} turn lanes"


def keep(fields: Fields, match: re.Match[str]) -> str:
    """The side that traffic keeps to."""
    side = match[1] or match[2]
    fields["left_hand"] = side == "left"
    return f"{side}-hand traffic"
