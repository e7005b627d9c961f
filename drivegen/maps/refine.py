"""A person's edits of a map, in words, on its specification: lanes, signals, limits, kind, ramps, lengths, turn lanes."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import orjson
from pydantic import ValidationError

from drivegen.errors import UnusableInput
from drivegen.maps.build import ACCOUNT, BuiltMap, build_spec
from drivegen.maps.spec import MapSpec
from drivegen.maps.writers._reading import Reading

CAN_EDIT = (
    "add or remove a lane, set the lanes, add or remove traffic lights, stop or yield signs, set the speed limit, make it a "
    "roundabout or a crossing, move a ramp or lane change up- or downstream, make it longer or shorter, add or remove turn "
    "lanes, let traffic keep left or right"
)
"""The edits that are understood."""

Fields = dict[str, Any]
_LANES = ("lanes", "lanes_back", "lanes_in", "lanes_out", "left_lanes")
_UNITS = {"kmh": 1 / 3.6, "mph": 0.44704, "mps": 1.0, "": 1 / 3.6}
_REMOVES = r"(?:remove|delete|drop|without|no|take (?:away|out)|get rid of|switch off)"


def refine_map(folder: Path, text: str) -> BuiltMap:
    """The map in `folder` after one more edit; its account keeps the edits so far, with the specification before each.

    Raises UnusableInput where the folder holds no map made from words, or as `refine` does. Nothing is written.
    """
    file = folder / ACCOUNT
    try:
        account = orjson.loads(file.read_bytes())
        spec = MapSpec.model_validate(account["spec"])
    except FileNotFoundError:
        raise UnusableInput(f"{file} is not there: make the map first", reason="no-map") from None
    except (orjson.JSONDecodeError, KeyError, TypeError, ValidationError):
        raise UnusableInput(f"{file} holds no map specification: imported maps cannot be refined", reason="no-map") from None
    after, understood = refine(spec, text)
    edit = {"edit": text, "understood": [{"phrase": p, "meaning": m} for p, m in understood], "before": account["spec"]}
    kept = {name: account[name] for name in ("text", "seed", "backend", "understood", "assumed", "ignored") if name in account}
    return build_spec(after, {**kept, "history": [*account.get("history", []), edit]})


def refine(spec: MapSpec, text: str) -> tuple[MapSpec, tuple[tuple[str, str], ...]]:
    """The specification after the edit that `text` asks for, and what its phrases were taken to mean.

    Raises UnusableInput where no edit is understood, or the road cannot be drawn after it.
    """
    reading = Reading(text)
    fields = spec.model_dump(mode="json")
    for rule, apply in _EDITS:
        for match in list(reading.all(rule)):
            reading.take(match, apply(fields, match))
    if not reading.notes:
        raise UnusableInput(f"no edit that I know is asked for in {text[:60]!r}; I can {CAN_EDIT}", reason="not-understood")
    try:
        return MapSpec.model_validate(fields), tuple(reading.notes)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        message = first["msg"].removeprefix("Value error, ")
        raise UnusableInput(f"after this edit the road cannot be drawn: {message}", reason="impossible-map") from None


def _each(value: Any, change: Callable[[Fields], None]) -> None:
    """Apply a change to every mapping inside `value`."""
    if isinstance(value, dict):
        change(value)
        for item in value.values():
            _each(item, change)
    elif isinstance(value, list):
        for item in value:
            _each(item, change)


def _change_lanes(fields: Fields, match: re.Match[str]) -> str:
    count = int(match[2]) if match[2] else 1
    step = count if match[1].startswith(("add", "widen", "extra")) else -count

    def change(part: Fields) -> None:
        for name in _LANES:
            if part.get(name) and not _is_event(part):
                part[name] += step

    _each(fields["road"], change)
    return f"{'+' if step > 0 else '-'}{abs(step)} lane per direction"


def _is_event(part: Fields) -> bool:
    return "ramp_speed" in part


def _set_lanes(fields: Fields, match: re.Match[str]) -> str:
    lanes = int(match[1])

    def change(part: Fields) -> None:
        for name in _LANES:
            if part.get(name) and not _is_event(part) and name != "left_lanes":
                part[name] = lanes

    _each(fields["road"], change)
    return f"{lanes} lanes per direction"


def _control(control: str, meaning: str) -> Callable[[Fields, re.Match[str]], str]:
    def apply(fields: Fields, _match: re.Match[str]) -> str:
        if not _has(fields["road"], "control"):
            raise UnusableInput("this road has no crossing that could be controlled", reason="impossible-map")

        def change(part: Fields) -> None:
            if "control" in part:
                part["control"] = control

        _each(fields["road"], change)
        return meaning

    return apply


def _has(value: Any, name: str) -> bool:
    found: list[bool] = []
    _each(value, lambda part: found.append(name in part))
    return any(found)


def _set_speed(fields: Fields, match: re.Match[str]) -> str:
    speed = float(match[1]) * _UNITS[match[2] or ""]

    def change(part: Fields) -> None:
        for name in ("speed", "side_speed"):
            if name in part:
                part[name] = speed
        for name in ("ring_speed", "ramp_speed"):
            if name in part:
                part[name] = min(part[name], speed)

    _each(fields["road"], change)
    return f"speed limit {speed * 3.6:.0f} km/h"


def _to_roundabout(fields: Fields, _match: re.Match[str]) -> str:
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


def _to_crossing(fields: Fields, _match: re.Match[str]) -> str:
    road = fields["road"]
    if road["kind"] == "roundabout":
        fields["road"] = {"kind": "crossing", "arms": road["arms"]}
    elif road.get("junctions"):
        for junction in road["junctions"]:
            junction["form"] = "crossing"
    else:
        raise UnusableInput(f"a {road['kind']} cannot become a crossing", reason="impossible-map")
    return "crossing"


def _move(fields: Fields, match: re.Match[str]) -> str:
    """Move what happens along the road, and what comes after it, so that gaps stay."""
    metres = float(match[2]) * (1000.0 if match[3] == "km" else 1.0)
    metres = -metres if match[4].startswith(("up", "back", "earlier", "closer", "nearer")) else metres
    road = fields["road"]
    kinds = {"on": "on_ramp", "entry": "on_ramp", "off": "off_ramp", "exit": "off_ramp"}
    wanted = next((kind for word, kind in kinds.items() if (match[1] or "").startswith(word)), None)
    parts = [e for e in road.get("events", []) if wanted in (None, e["kind"])] or road.get("junctions", [])
    if not parts:
        raise UnusableInput("there is nothing along this road that could be moved", reason="impossible-map")
    everything = road.get("events") or road["junctions"]
    for part in everything[everything.index(parts[0]) :]:
        part["position"] += metres
    last = everything[-1]["position"] + everything[-1].get("length", 0.0)
    road["alignment"]["length"] = max(road["alignment"]["length"], last + 150.0)
    return f"moved {abs(metres):.0f} m {'down' if metres > 0 else 'up'}stream"


def _set_length(fields: Fields, match: re.Match[str]) -> str:
    road = fields["road"]
    metres = float(match[2]) * (1000.0 if match[3] == "km" else 1.0)
    step = {"longer": metres, "shorter": -metres}.get(match[1] or match[4] or "")

    def change(part: Fields) -> None:
        if "length" in part and not _is_event(part):
            part["length"] = metres if step is None else part["length"] + step

    _each(road.get("alignment", road), change)
    return f"{metres:.0f} m {match[1] or match[4] or 'long'}"


def _turn_lanes(fields: Fields, match: re.Match[str]) -> str:
    wanted = not re.match(_REMOVES, match[1] or "")
    sides = [side for side in ("left", "right") if match[2] is None or side in match[2]]
    if fields["road"]["kind"] != "crossing":
        raise UnusableInput("only a single crossing can have turn lanes", reason="impossible-map")
    for arm in fields["road"]["arms"]:
        arm.update({f"{side}_turn_lane": wanted for side in sides})
    return f"{'with' if wanted else 'no'} turn lanes"


def _keep(fields: Fields, match: re.Match[str]) -> str:
    side = match[1] or match[2]
    fields["left_hand"] = side == "left"
    return f"{side}-hand traffic"


_N = r"(\d+(?:\.\d+)?)"
_SIGNALS = r"(?:the |all |its )*(?:traffic )?(?:lights|signals?)"
_SIGNS = r"(?:the |all |its )*(?:stop|yield|give way)? ?(?:signs?|control)"
_ALONG = r"(downstream|upstream|back|further|forward|later|earlier|closer|nearer|along)"
_MOVED = r"(on |off |exit |entry )?(?:ramp|lane drop|junction|crossing|it|exit|entry)"
_INTO = r"(?:make (?:it|this) |turn (?:it|this) |into |replace (?:it|this) |with |by |a |an )+"
_EDITS: tuple[tuple[str, Callable[[Fields, re.Match[str]], str]], ...] = (
    (r"(?:(?:keep|drive|driving|traffic) (?:on )?(?:the )?(left|right))|(left|right) hand traffic", _keep),
    (
        rf"((?:add|with|give it|{_REMOVES}) ?)?(?:the |a |dedicated )*((?:left and right|left|right) )?turn(?:ing)? lanes?",
        _turn_lanes,
    ),
    (
        r"(add|widen|remove|drop|delete|extra) (?:by )?(?:a |an |1 |one |another |more )*(?:(\d+) )?(?:more )?lanes?"
        r"(?: \w+ direction)?",
        _change_lanes,
    ),
    (r"(\d+) lanes?(?: (?:per|in each|each) (?:direction|way))?", _set_lanes),
    (rf"{_REMOVES} {_SIGNALS}|unsignali[sz]ed", _control("yield", "no traffic lights")),
    (rf"{_REMOVES} {_SIGNS}", _control("uncontrolled", "no signs: right before left")),
    (
        r"(?:add |with |use |install )*(?:\w+ )?(?:traffic lights?|signals?|lights)|signali[sz]e(?:d)?(?: it)?",
        _control("signals", "traffic lights"),
    ),
    (r"(?:all way|4 way) stops?(?: signs?)?", _control("all_way_stop", "all-way stop")),
    (r"(?:add |with |use )*stop signs?", _control("stop", "stop signs")),
    (r"(?:add |with |use )*(?:yield|give way)(?: signs?)?", _control("yield", "side roads yield")),
    (rf"move (?:the |that )?{_MOVED} (?:by )?{_N} ?(m|km) (?:further |farther |more )?{_ALONG}", _move),
    (rf"(longer|shorter) by {_N} ?(m|km)()", _set_length),
    (rf"()(?:by )?{_N} ?(m|km) (longer|shorter|long)", _set_length),
    (rf"(?:speed |limit |limited |maximum |to |of |at |the |set |a |is )*{_N} ?(kmh|mph|mps)", _set_speed),
    (rf"(?:speed |limit |limited |maximum )+(?:to |of |at |is )*{_N}()", _set_speed),
    (rf"{_INTO}(?:roundabout|traffic circle|rotary)", _to_roundabout),
    (rf"{_INTO}(?:crossing|crossroads|intersection|junction)", _to_crossing),
)
