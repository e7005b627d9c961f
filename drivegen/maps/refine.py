"""A person's edits of a map, in words, on its specification: lanes, signals, limits, kind, ramps, lengths, turn lanes."""

import re
from collections.abc import Callable
from pathlib import Path

import orjson
from pydantic import ValidationError

from drivegen.errors import UnusableInput
from drivegen.maps.build import ACCOUNT, BuiltMap, build_spec
from drivegen.maps.edits import (
    REMOVES,
    Fields,
    add_ramp,
    change_lanes,
    control,
    keep,
    move,
    remove_ramp,
    set_auxiliary,
    set_lanes,
    set_length,
    set_ramp_lanes,
    set_speed,
    to_crossing,
    to_roundabout,
    turn_lanes,
)
from drivegen.maps.spec import MapSpec
from drivegen.maps.writers._reading import Reading

CAN_EDIT = (
    "add or remove a lane, set the lanes, add or remove traffic lights, stop or yield signs, set the speed limit, make it a "
    "roundabout or a crossing, add, remove or move ramps, move lane changes, make it longer or shorter, add or remove turn "
    "lanes, let traffic keep left or right"
)
"""The edits that are understood."""


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
        field = str(first["loc"][-1]) if first["loc"] else ""
        message = first["msg"].removeprefix("Value error, ").replace("Input should be", f"{field} must be")
        raise UnusableInput(f"after this edit the road cannot be drawn: {message}", reason="impossible-map") from None


_N = r"(\d+(?:\.\d+)?)"
_SIGNALS = r"(?:the |all |its )*(?:traffic )?(?:lights|signals?)"
_SIGNS = r"(?:the |all |its )*(?:stop|yield|give way)? ?(?:signs?|control)"
_ALONG = r"(?:downstream|upstream|back|further|farther|forward|later|earlier|closer|nearer|along|ahead|on|down the road)"
_RAMP = r"(?:(?:on|off|exit|entry|entrance) )?(?:ramp|slip road|slip)|exit|entry|entrance|onramp|offramp"
_MOVED = rf"({_RAMP}|lane drop|lane gain|junction|crossing|roundabout|it)"
_MOVES = r"(?:move|shift|push|pull|slide|put|place|relocate|bring)"
_BY = rf"(?:should be |must be |by |about |{_ALONG} )*"
_INTO = (
    r"(?:(?:make|turn|convert|change|transform|replace|swap|i would rather have|i d rather have|use) )"
    r"(?:(?:it|this|that|all|every|each|the|crossings?|crossroads|intersections?|junctions?|into|to|with|by|for|a|an|one|1) )*"
)
_EDITS: tuple[tuple[str, Callable[[Fields, re.Match[str]], str]], ...] = (
    (r"(?:(?:keep|drive|driving|traffic) (?:on )?(?:the )?(left|right))|(left|right) hand traffic", keep),
    (
        rf"((?:add|with|give (?:it|every \w+|each \w+|all \w+)|{REMOVES}) ?)?(?:the |a |dedicated )*"
        r"((?:left and right|left|right) )?turn(?:ing)? (?:lanes?|pockets?|bays?)",
        turn_lanes,
    ),
    (
        rf"(add|widen|put|give it|extra|1 (?=more|extra)|another|{REMOVES}|take) (?:by )?"
        r"(?:a |an |1 |one |another |more |extra |the )*"
        r"(?:(\d+) )?(?:more |extra )?lanes?(?: away)?"
        r"(?: \w+ direction)?",
        change_lanes,
    ),
    (rf"(\d+) lanes? ({_RAMP})", set_ramp_lanes),
    (rf"{REMOVES} (?:the |this |all |its )*({_RAMP})s?", remove_ramp),
    (rf"(?:add|with|put|give it) (?:a |an |another |1 |one )*({_RAMP})(?: (?:after|behind) \w+(?: \w+){{0,2}})?", add_ramp),
    (r"(?:only |just |fewer lanes(?: ,)? )*(\d+) lanes?(?: (?:per|in each|each) (?:direction|way))?", set_lanes),
    (r"fewer lanes(?: ,)? (?:just |only )*(\d+)", set_lanes),
    (rf"{REMOVES} {_SIGNALS}|unsignali[sz]ed", control("yield", "no traffic lights")),
    (rf"{REMOVES} {_SIGNS}", control("uncontrolled", "no signs: right before left")),
    (
        r"(?:add |with |use |install )*(?:\w+ )?(?:traffic lights?|signals?|lights)|signali[sz]e(?:d)?(?: it)?",
        control("signals", "traffic lights"),
    ),
    (r"(?:all way|4 way) stops?(?: signs?)?", control("all_way_stop", "all-way stop")),
    (r"(?:add |with |use )*stop signs?", control("stop", "stop signs")),
    (r"(?:add |with |use )*(?:yield|give way)(?: signs?)?", control("yield", "side roads yield")),
    (rf"{_MOVES} (?:the |that )?{_MOVED} {_BY}{_N} ?(m|km)(?: {_ALONG})*", move),
    (rf"({_RAMP}) {_BY}{_N} ?(m|km)(?: {_ALONG})+", move),
    (
        r"(acceleration|deceleration|auxiliary|weaving) (?:lane|section|area)(?:,| of| is| to| should be)* "
        rf"{_N} ?(m|km)(?: long)?",
        set_auxiliary,
    ),
    (rf"(extend|lengthen|shorten) (?:it |the road |this |the highway )*by {_N} ?(m|km)()", set_length),
    (rf"(longer|shorter) by {_N} ?(m|km)()", set_length),
    (rf"()(?:by )?{_N} ?(m|km) (longer|shorter|long)", set_length),
    (rf"(?:speed |limit |limited |maximum |to |of |at |the |set |a |is )*{_N} ?(kmh|mph|mps)", set_speed),
    (rf"(?:speed |limit |limited |maximum )+(?:to |of |at |is |should be )*{_N}()", set_speed),
    (rf"(?:make it )?(?:a )?{_N} zone()", set_speed),
    (rf"{_INTO}(?:roundabouts?|traffic circles?|rotary|rotaries)", to_roundabout),
    (rf"{_INTO}(?:crossing|crossroads|intersection|junction)", to_crossing),
)
