"""Speeds, lengths, angles and what each belongs to."""

import re

from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._reading import Reading

NUMBER = r"(\d+(?:\.\d+)?)"

_SPEED_UNITS = {"kmh": 1 / 3.6, "mph": 0.44704, "mps": 1.0}
_LENGTH_UNITS = {"m": 1.0, "km": 1000.0, "ft": 0.3048, "yd": 0.9144, "mile": 1609.344}
_LENGTH = rf"{NUMBER} ?(m|km|ft|yd|mile)"
_BESIDE = r"(?:acceleration|deceleration|auxiliary|merg\w+|weaving)"
_LIMIT = r"(?:speed|limit|limited|posted|maximum|max|signed|restricted|design)"
_DRIVING = re.compile(r"\b(?:cars?|trucks?|bus(?:es)?|vehicles?|vans?|lorr(?:y|ies)|traffic (?:moving|driving|flowing)|driver)\b")


def read_speeds(reading: Reading, facts: Facts) -> None:
    """Speed limits, with or without a unit; the speeds of cars are left to whoever reads vehicles."""
    with_unit = rf"(?:(?:{_LIMIT}|of|is|at|to|a|are|roads?|zone|set|up) )*{NUMBER} ?(kmh|mph|mps)(?: {_LIMIT})*(?: zone)?"
    bare = rf"(?:{_LIMIT} )+(?:(?:of|is|at|to|set|being|the) )*{NUMBER}(?! ?(?:m|km|ft|yd|mile|lanes?|degrees)\b)|{NUMBER} zone"
    for pattern in (with_unit, bare):
        for match in list(reading.all(pattern)):
            clause = re.split(r"[.,;]", reading.text[: match.start()])[-1]
            if _DRIVING.search(clause) and "limit" not in match.group():
                continue
            groups = [g for g in match.groups() if g is not None]
            unit = groups[1] if len(groups) > 1 else "kmh"
            role = _speed_role(reading, match)
            facts.speeds.setdefault(role, float(groups[0]) * _SPEED_UNITS[unit])
            where = "" if role == "main" else f" on the {role}"
            shown = {"kmh": "km/h", "mph": "mph", "mps": "m/s"}[unit]
            reading.take(match, f"speed limit {groups[0]} {shown}{where}")


def _speed_role(reading: Reading, match: re.Match[str]) -> str:
    near = f"{reading.before(match, 4)} | {reading.after(match, 5)}"
    if re.search(r"\bramp\b|\bslip\b", near):
        return "ramp"
    if re.search(r"\b(?:side|minor|secondary|cross) (?:road|street)s?", near):
        return "side"
    return "ring" if re.search(r"\b(?:ring|circulat\w+)\b", near) else "main"


def read_lengths(reading: Reading, facts: Facts) -> None:
    """Lengths by role; the words beside a number tell what it measures."""
    roles = (
        (
            "spacing",
            rf"(?:every|spacing of|spacing|spaced|intervals? of|blocks? of|distance of|separated by) (?:about )?{_LENGTH}",
        ),
        ("spacing", rf"{_LENGTH} (?:apart|between|spacing|intervals?|from (?:each other|1 another|one another)|blocks?|away)"),
        ("position", rf"{_LENGTH} (?:after|from|beyond|past|into) the (?:start|beginning)"),
        ("spacing", rf"{_LENGTH} before"),
        ("spacing", rf"{_LENGTH}(?: \w+)? (?:later|further on|after (?:that|it))"),
        ("radius", rf"{_LENGTH} radius|radius (?:of |is )?(?:about )?{_LENGTH}"),
        ("diameter", rf"{_LENGTH} (?:in )?(?:diameter|across|wide)|diameter (?:of |is )?(?:about )?{_LENGTH}"),
        ("auxiliary", rf"{_LENGTH}(?: long)? {_BESIDE}(?: (?:lane|section|area))?"),
        (
            "auxiliary",
            rf"{_BESIDE} (?:lane|section|area) (?:, )?(?:\w+ )?(?:of |is )?{_LENGTH}(?: long)?",
        ),
        ("offset", rf"(?:offset|staggered|displaced|shifted)(?: by| of)?(?: about)? {_LENGTH}|{_LENGTH} offset"),
        ("position", rf"(?:after|at)(?: about| the first)? {_LENGTH}"),
        ("side", rf"(?:arms|legs|approaches|side (?:roads?|streets?)) (?:of |are |is )*(?:about )?{_LENGTH}(?: long)?"),
        ("length", rf"(?:length (?:of |is )?|over |for |of |about )*{_LENGTH}(?: (?:in length|long|stretch|length|of))*"),
    )
    for role, pattern in roles:
        for match in list(reading.all(pattern)):
            value, unit = [g for g in match.groups() if g is not None][:2]
            facts.lengths.setdefault(role, float(value) * _LENGTH_UNITS[unit])
            # The words beside an auxiliary lane's length decide the kind of road, so only the number is taken there.
            found = re.compile(_LENGTH).search(reading.text, match.start(), match.end()) if role == "auxiliary" else match
            reading.take(found or match, f"{role.replace('auxiliary', 'auxiliary lane')} {value} {unit}")


def read_angles(reading: Reading, facts: Facts) -> None:
    """One angle: of a bend, a fork or a skew crossing."""
    for match in list(reading.all(rf"(?:(?:through|by|of|at|an angle of|about) )*{NUMBER} degrees?(?: angle)?")):
        facts.angle = float(match[1]) if facts.angle is None else facts.angle
        reading.take(match, f"angle {match[1]} degrees")
    right = reading.first(r"(?:at |a )*right angles?|quarter turn|perpendicular(?:ly)?")
    if facts.angle is None and right is not None:
        facts.angle = 90.0
        reading.take(right, "angle 90 degrees")
