"""Ramps, lanes that end or begin, and side streets: what happens along a road, in words."""

import re

from drivegen.maps.spec import Side
from drivegen.maps.writers._facts import EventWords, Facts
from drivegen.maps.writers._junctions import refers_back
from drivegen.maps.writers._reading import Reading

_RAMP = r"(?:ramps?|slip ?roads?|slips?|slip lanes?)"
_LEAVES = r"(?:leav\w+|exit\w*|diverg\w+|off|going off|peel\w+ off)"
_JOINS = r"(?:merg\w+|join\w*|enter\w*|feed\w*|com\w+ in)"
_RAMPS = (
    (("on_ramp", "off_ramp"), rf"(?:on|entry|entrance) (?:and|then|followed by) (?:an )?(?:off|exit) {_RAMP}"),
    (("off_ramp", "on_ramp"), rf"(?:off|exit) (?:and|then|followed by) (?:an )?(?:on|entry|entrance) {_RAMP}"),
    (
        ("off_ramp",),
        rf"(?:off|exit|leaving) ?{_RAMP}|off ?ramps?|{_RAMP}(?: \w+)? (?:that |which )?{_LEAVES}(?: on| at)?|exit lanes?",
    ),
    (
        ("on_ramp",),
        rf"(?:on|entry|entrance|access|merging|entering|joining|feeder) ?{_RAMP}|on ?ramps?"
        rf"|{_RAMP}(?: \w+)? (?:that |which )?{_JOINS}|merg(?:e|ing) lanes?|{_RAMP}",
    ),
)
_MEETS = (
    r"meet(?:s|ing)?|joins?|joining|enter(?:s|ing)?|com(?:es|ing) (?:in )?(?:from|into)|connect(?:s|ed|ing)? (?:to|with)|"
    r"leav(?:es|ing)|branch(?:es|ing) off|runs into|leads? into|teeing into"
)


def read_ramps(reading: Reading, facts: Facts) -> None:
    """Fill in the events along a highway."""
    for kinds, pattern in _RAMPS:
        for match in list(reading.all(rf"(?:(\d+) )?(?:{pattern})")):
            meaning = " and ".join(kinds).replace("_", "-")
            if reading.negated(match):
                reading.take(match, f"no {meaning}")
                continue
            known = any(event.kind == kinds[0] for event in facts.events)
            if not (known and refers_back(reading, match, 1)):
                _add(facts, kinds, match, match[1])
            reading.take(match, meaning)
    if facts.events or facts.has("highway"):
        _read_exits(reading, facts)
    for match in list(reading.all(r"merg(?:es?|ing|ed)(?: into| with| onto)?|diverg(?:es?|ing)(?: from)?")):
        reading.take(match, "")
    _read_lane_changes(reading, facts)
    facts.events.sort(key=lambda event: event.at)


def _add(facts: Facts, kinds: tuple[str, ...], match: re.Match[str], number: str | None) -> None:
    copies = min(int(number), 9) if number else 1
    facts.events += [EventWords(kind, match.start() + 2 * i + j) for i in range(copies) for j, kind in enumerate(kinds)]


def _read_exits(reading: Reading, facts: Facts) -> None:
    """Exits and entrances, and the lanes beside ramps, which are no ramps of their own."""
    rules = (
        ("off_ramp", r"exits?|deceleration lanes?"),
        ("on_ramp", r"entr(?:y|ance|ances|ies)|acceleration lanes?"),
    )
    for kind, pattern in rules:
        for match in list(reading.all(rf"(?:(\d+) )?(?:{pattern})")):
            name = kind.replace("_", "-")
            if reading.negated(match):
                reading.take(match, f"no {name}")
                continue
            if match[1] or not any(event.kind == kind for event in facts.events):
                _add(facts, (kind,), match, match[1])
            reading.take(match, name)


def _read_lane_changes(reading: Reading, facts: Facts) -> None:
    """A lane that ends or begins, where no numbers say so."""
    side = r"(?:(left|right)(?: ?most| hand)? |outer |inner )?"
    some = r"(?:(?:the|a|an|1|one|new|extra|additional|climbing|passing|third|fourth) )*"
    ends = (
        r"(?:drops?|ends?|ending|closes?|closure|closed|disappears?|reduction|is (?:closed|dropped|lost)|that ends|merges|loss)"
    )
    begins = r"(?:gains?|addition|is added|begins?|starts?|opens?|appears?)"
    rules = (
        ("lane_drop", rf"{some}{side}lane {ends}|los(?:es|ing) {some}{side}lane|narrow(?:s|ing)|1 lane fewer|fewer lanes"),
        ("lane_drop", r"(left|right)(?: ?most| hand)? lane(?= [^.;]*\b(?:closes?|ends?|is closed|drops?|disappears?)\b)"),
        ("lane_gain", rf"{some}{side}lane {begins}|gain(?:s|ing) {some}{side}lane|widen(?:s|ing)(?: by {some}lane)?"),
        ("lane_gain", r"(?:climbing|passing|extra|additional) lane()"),
    )
    for kind, pattern in rules:
        for match in list(reading.all(pattern)):
            if reading.negated(match):
                reading.take(match, f"no {kind.replace('_', ' ')}")
                continue
            where: Side = "left" if "left" in match.groups() else "right"
            if not facts.has("lane_drop", "lane_gain", "lane_change"):
                facts.events.append(EventWords(kind, match.start(), side=where))
                facts.features[kind] = match.start()
            reading.take(match, f"{kind.replace('_', ' ')} on the {where}")


def read_side_streets(reading: Reading, facts: Facts) -> None:
    """Side streets along a road, and roads that meet another."""
    kinds = (
        r"(?:side|minor|residential|cross|smaller|branch|local|access) (?:streets?|roads?|lanes?|turnings?)|turnings|driveways"
    )
    for match in list(reading.all(rf"(?:(\d+|several|some|a few|many) )(?:small |short )?(?:{kinds})")):
        if reading.negated(match):
            reading.take(match, "no side streets")
            continue
        count = int(match[1]) if match[1].isdigit() else 3
        if count >= 2 or not facts.junctions:
            facts.side_streets = count
            facts.features.setdefault("side_streets", match.start())
        reading.take(match, f"{count} side street{'s' if count > 1 else ''}")
    for match in list(reading.all(_MEETS)):
        facts.features.setdefault("meets", match.start())
        reading.take(match, "")
