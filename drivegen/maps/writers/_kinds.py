"""The other words that decide what kind of road it is, who goes first on it, and which side traffic keeps to."""

from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._reading import Reading

_THEN = r"(?: ,)? (?:and )?then "
_BENDS = r"(?:bends?|curves?|turns?)"
_NEAR_BEND = r"(?= (?:\w+ ){0,2}(?:curv|bend|turn|corner|sweep))"

_RULES: tuple[tuple[str, str, str], ...] = (
    # feature, pattern, meaning; the first that fits takes the words
    ("weaving", r"weav(?:ing|e)(?: (?:section|area|segment|zone|lane))?s?", "weaving section"),
    (
        "hairpin",
        r"hair ?pin(?: (?:bend|turn|curve|corner))?s?|switch ?back|u shaped (?:road|bend|curve|turn|street)"
        r"|180 degrees? (?:turn|bend|curve)|u bend",
        "hairpin",
    ),
    (
        "s_curve",
        r"s (?:curve|bend|turn|shape)d?s?|s shaped(?: \w+)?|double (?:bend|curve)|chicane|reverse curve|serpentine|winding"
        r"|zig ?zag(?:s|ging)?|2 (?:opposite )?(?:bends|curves)"
        rf"|{_BENDS} (?:to the )?(?:left|right){_THEN}(?:to the )?(?:left|right)",
        "S-curve",
    ),
    (
        "fork",
        r"(?:y shaped )?fork(?:s|ed|ing)?(?: into (?:2|two))?"
        r"|(?:splits?|divid\w+|separat\w+|branch\w*|part(?:s|ing)) (?:up )?(?:in)?to (?:2|two|left and right)"
        r"(?: (?:branches|roads|directions|parts|streets|carriageways|arms))?|bifurcat\w+|splits?(?: apart| up)?|y split",
        "road that splits into two",
    ),
    ("sharp", rf"(?:sharp|tight){_NEAR_BEND}", "small radius"),
    ("gentle", rf"(?:gentl[ey]|long|wide|slight(?:ly)?|smooth(?:ly)?|large|big){_NEAR_BEND}", "large radius"),
    (
        "curve",
        r"curv(?:e|es|ed|ing|y)|bend(?:s|ing)?|bent|arc(?:s|ing)?|turns?(?= (?:left|right|to|through|by|\d+ degrees?))"
        r"|swe+p(?:s|ing)|corner",
        "curve",
    ),
    (
        "cul_de_sac",
        r"culs? de sacs?|dead ?end(?:s|ed)?(?: (?:street|road)s?)?|no through (?:road|street)s?|blind alley|turning circle",
        "dead end",
    ),
    ("divided", r"(?:with |by )?an? (?:(?:wide|narrow|grass|grassy|raised|green) )*(?:median|central reservation)", "divided"),
    ("divided", r"divided|separated carriageways|(?:median|central reservation)", "divided"),
    ("straight", r"(?:dead |perfectly |completely )?straight(?: line)?", "straight"),
    ("arterial", r"arterials?|boulevards?", "arterial road"),
    ("main_road", r"(?:main|major|primary|priority|through) (?:road|street|route|line|carriageway)s?|mainline", "main road"),
    ("side_road", r"(?:side|minor|secondary|smaller|local|access) (?:road|street)s?|stem", "side road"),
    ("road", r"carriage ?ways?|roads?|streets?|avenues?|roadway|alley|drive|route", ""),
)
_FAST_ROADS = (
    r"(?:high ?ways?|motor ?ways?|free ?ways?|express ?ways?|inter ?states?|auto ?bahn(?:en)?|turnpikes?|thruway|parkway"
    r"|autoroute)"
)
_HIGHWAY = (
    rf"dual carriage ?ways?|(?:(?:divided|controlled access|limited access) )*{_FAST_ROADS}"
    r"|divided (?:two way |urban )?(?:roads?|arterial)"
)
_SURROUNDINGS = (
    ("residential", r"residential|neighbou?rhood|housing(?: estate)?|suburban|village|living street|school zone"),
    (
        "rural",
        r"rural|countryside|country(?= (?:road|lane|highway|cross|junction|inter|street|t |y ))|mountain(?:ous)?|"
        r"(?:in|through) the country",
    ),
    ("urban", r"urban|city|town|downtown|inner city"),
)
_CONTROLS = (
    (
        "all_way_stop",
        r"(?:all|4|3|5|every) way stops?(?: (?:signs?|control(?:led)?))?|stop signs? (?:on|at|for) (?:all|every|each) \w+",
        "all-way stop",
    ),
    ("uncontrolled", r"uncontrolled|right before left|priority (?:to|from) the right|unmarked", "no signs: right before left"),
    ("unsignalled", r"(?:un|non )signali[sz]ed", "no traffic lights"),
    (
        "signals",
        r"traffic (?:lights?|signals?)|signals?|stop ?lights?|(?:light|signal) controlled|signali[sz]ed|lights",
        "traffic lights",
    ),
    ("stop", r"stop (?:signs?|lines?|control(?:led)?)", "stop signs"),
    (
        "yield",
        r"(?:yield|give way)(?: (?:signs?|lines?|control(?:led)?))?|priority (?:junction|control(?:led)?)",
        "side roads yield",
    ),
)
_HAND = (
    r"(?:(left|right) hand(?:ed)? (?:traffic|driving|drive|side)"
    r"|(?:driv\w+|keeps?|stays?|traffic (?:is|runs|keeps)) (?:on |to )*the (left|right)|(left|right) side of the road)"
    r"(?: hand)?(?: side)?(?: of the (?:road|street))?"
    r"|british|english|japanese|australian|uk|in (?:britain|england|japan|australia|india|the uk)"
)


def read_highway(reading: Reading, facts: Facts) -> None:
    """Whether it is a highway; read before ramps, whose words mean other things elsewhere."""
    _apply(reading, facts, "highway", _HIGHWAY, "highway")


def read_kinds(reading: Reading, facts: Facts) -> None:
    """Bends, forks, dead ends, main and side roads, surroundings."""
    for feature, pattern, meaning in _RULES:
        _apply(reading, facts, feature, pattern, meaning)
    for name, pattern in _SURROUNDINGS:
        for match in list(reading.all(pattern))[:1]:
            facts.surroundings = facts.surroundings or name
            reading.take(match, f"{name} road")
    for match in list(reading.all(r"(?:two|2) ?way|bi ?directional|undivided|single carriage ?way|both (?:ways|directions)")):
        facts.two_way = True
        reading.take(match, "two-way")
    if found := reading.first(r"(?:(?:to|on|from) the )?(left|right)(?: hand)?(?: side| turn)?"):
        facts.turn = "left" if found[1] == "left" else "right"
        reading.take(found, f"to the {found[1]}")


def _apply(reading: Reading, facts: Facts, feature: str, pattern: str, meaning: str) -> None:
    for match in list(reading.all(pattern)):
        if reading.negated(match):
            reading.take(match, f"no {meaning or feature}")
            continue
        facts.features.setdefault(feature, match.start())
        reading.take(match, meaning)


def read_one_way(reading: Reading, facts: Facts) -> None:
    """How many roads are said to be one-way."""
    for match in list(
        reading.all(
            r"(?:(?<!by )(?<!x )(\d+) )?one ?way|single direction|unidirectional|in 1 direction only|only (?:in )?1 direction"
        )
    ):
        if reading.negated(match):
            facts.two_way = True
        else:
            facts.one_way += [match.start()] * min(int(match[1] or 1), 9)
        reading.take(match, "two-way" if reading.negated(match) else "one-way")


def read_control(reading: Reading, facts: Facts) -> None:
    """Signals, stop, yield or nothing."""
    for control, pattern, meaning in _CONTROLS:
        for match in list(reading.all(pattern)):
            if control == "unsignalled" or (control == "signals" and reading.negated(match)):
                facts.unsignalled = True
                reading.take(match, "no traffic lights")
            elif reading.negated(match):
                reading.take(match, f"no {meaning}")
            else:
                facts.control = facts.control or control  # type: ignore[assignment]
                reading.take(match, meaning)


def read_hand(reading: Reading, facts: Facts) -> None:
    """Which side traffic keeps to."""
    for match in list(reading.all(_HAND)):
        facts.left_hand = "right" not in match.groups()
        reading.take(match, "left-hand traffic" if facts.left_hand else "right-hand traffic")
