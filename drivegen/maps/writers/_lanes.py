"""How many lanes, of which road. Lanes count per direction unless the description says they are the total."""

import re

from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._reading import Reading

_ROAD = r"(?:roads?|streets?|arms?|legs?|approach(?:es)?|avenues?|carriageways?|lanes?)"
NOUNS = {
    "ring": r"(?:roundabouts?|traffic circles?|rotar(?:y|ies)|rings?|circles?|circulating (?:road|carriageway))",
    "ramp": r"(?:(?:on |off |entry |exit |entrance |access |merging )?(?:ramps?|slip roads?))",
    "side": rf"(?:(?:side|minor|secondary|smaller|cross|crossing|lesser|local|access|branch|joining|other) {_ROAD}|stem)",
    "main": rf"(?:(?:main|major|primary|priority|through|bigger|larger|big|mainline) ?{_ROAD}?|arterial(?: {_ROAD})?|mainline)",
}
_N = r"(\d+)"
_LANES = r"(?:driving |traffic |travel |through |circulating |general purpose )?lanes?"
_EACH = (
    r"(?:(?:going |running )?(?:in |on |for |per |at )?(?:each|either|every|both|per|a)(?: of the)?(?: driving| travel)?"
    r" (?:ways?|directions?|sides?|carriageways?|approach(?:es)?|arms?|legs?)|per direction|each way|apiece)"
)
_NARROWS = (
    r"(?: ?,? ?(?:that|which|and|will|gradually|suddenly|is|are|being|then|later) )* ?"
    r"(?:narrow\w*|merg\w+|reduc\w+|drop\w*|becom\w+|taper\w*|go(?:es|ing)?|shr\w+nk\w*|squeez\w+|converg\w+|clos\w+|turn\w*"
    r"|widen\w*|expand\w*|grow\w*|open\w*|chang\w+|down|up|increas\w+)"
    r"(?: (?:down|up|out))?"
)


def read_lanes(reading: Reading, facts: Facts) -> None:
    """Fill in the lane numbers."""
    _read_pockets(reading, facts)
    _read_changes(reading, facts)
    for role, noun in NOUNS.items():
        _read_role(reading, facts, role, noun)
    total = rf"{_N} {_LANES} (?:in total|total|altogether|overall|both directions together|combined)"
    total += rf"|{_N} {_LANES} (?:undivided|two way|2 way|bidirectional)"
    for match in list(reading.all(total)):
        lanes = int(next(g for g in match.groups() if g))
        facts.other_lanes.append((match.start(), max(1, lanes // 2) if lanes else 0))
        reading.take(match, f"{lanes} lanes in all, {max(1, lanes // 2)} per direction")
    each = rf"{_N} {_LANES},? {_EACH}|{_N} {_EACH}|{_EACH} (?:direction )?(?:has|with|of) {_N} {_LANES}"
    explicit = _read_plain(reading, facts, each)
    plain = rf"{_N} {_LANES}"
    if explicit:
        # "A four-lane road, two lanes each way" says the same thing twice.
        same = {*explicit, *(2 * lanes for lanes in explicit)}
        for match in list(reading.all(plain)):
            if int(match[1]) in same:
                reading.take(match, f"{_count(explicit[0])} per direction")
    _read_plain(reading, facts, plain)


def _read_plain(reading: Reading, facts: Facts, pattern: str) -> list[int]:
    found = []
    for match in list(reading.all(pattern)):
        lanes = int(next(g for g in match.groups() if g))
        facts.other_lanes.append((match.start(), lanes))
        found.append(lanes)
        reading.take(match, f"{_count(lanes)} per direction")
    return found


def _read_role(reading: Reading, facts: Facts, role: str, noun: str) -> None:
    between = r"(?:(?:is|has|having|have|with|of|that|which|carrying|each|only|and a|wide|,) ){0,3}"
    adjectives = r"(?:(?!and\b|with\b|meets?\b|cross\w*\b|from\b|road\b|street\b|highway\b|intersection\b|\d)\w+ ){0,2}?"
    patterns = (
        rf"{_N} {_LANES}(?: {_EACH})? (?:on|in|for|along|at|inside|around|of|to) (?:the |each |its |every |all )*{noun}",
        rf"{noun} {between}{_N} {_LANES}(?: (?:wide|{_EACH}))?",
        rf"{_N} lane,? (?!each|per|in){adjectives}{noun}",
    )
    for pattern in patterns:
        for match in list(reading.all(pattern)):
            if role not in facts.lanes:
                facts.lanes[role] = int(match[1])
            # The noun itself decides the kind of road, so only the lane words are taken here.
            words = re.compile(rf"{_N} {_LANES}(?: {_EACH})?").search(reading.text, match.start(), match.end())
            if words is not None:
                reading.take(words, f"{_count(int(match[1]))} on the {role}")


def _read_changes(reading: Reading, facts: Facts) -> None:
    """A road that narrows or widens from one number of lanes to another."""
    patterns = (
        rf"{_N}(?: {_LANES})?(?: road| highway| street| motorway)?{_NARROWS} (?:in)?to (?:only |just )?{_N}(?: {_LANES})?",
        rf"{_N}(?: {_LANES})? becom\w+ (?:only |just )?{_N}(?: {_LANES})?",
        rf"from {_N}(?: {_LANES})? (?:down |up )?to {_N} ?(?:{_LANES})?",
        rf"{_N} to {_N} {_LANES}",
    )
    for pattern in patterns:
        match = reading.first(pattern)
        if match is not None and facts.from_lanes is None:
            facts.from_lanes, facts.to_lanes = int(match[1]), int(match[2])
            change = "lane_drop" if facts.to_lanes < facts.from_lanes else "lane_gain"
            facts.features[change] = match.start()
            reading.take(match, f"{_count(facts.from_lanes)} become {facts.to_lanes}")
    match = reading.first(rf"{_NARROWS} (?:in)?to (?:only |just )?{_N} {_LANES}")
    if match is not None and facts.from_lanes is None:
        facts.to_lanes = int(match[1])
        facts.features["lane_change"] = match.start()
        reading.take(match, f"becomes {_count(facts.to_lanes)}")


def _read_pockets(reading: Reading, facts: Facts) -> None:
    kinds = r"(?:a |an |separate |dedicated |exclusive |own |extra |protected |additional )*"
    pocket = r"(?:turn(?:ing|s)?) (?:lanes?|pockets?|bays?)"
    for match in list(reading.all(rf"{kinds}(left and right |left or right |left |right )?(?:hand )?{pocket}")):
        if reading.negated(match):
            reading.take(match, "no turn lanes")
            continue
        which = (match[1] or "left and right").strip()
        facts.left_pocket |= "left" in which
        facts.right_pocket |= "right" in which
        reading.take(match, f"turn lanes ({which})")
    for match in list(reading.all(rf"{kinds}lanes? for (?:the )?(left|right) turn(?:s|ing)?")):
        facts.left_pocket |= match[1] == "left"
        facts.right_pocket |= match[1] == "right"
        reading.take(match, f"turn lanes ({match[1]})")


def _count(lanes: int) -> str:
    return "1 lane" if lanes == 1 else f"{lanes} lanes"
