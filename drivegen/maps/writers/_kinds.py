"""The words that decide what kind of road it is: junctions, ramps, bends, grids; and who goes first there."""

import re

from drivegen.maps.spec import Side
from drivegen.maps.writers._facts import EventWords, Facts, JunctionWords
from drivegen.maps.writers._reading import Reading

_CROSSING = r"(?:crossings?|cross ?roads?|crossways|intersections?|junctions?|crossroads intersections?)"
_RING = r"(?:mini |small |large |big |modern |urban |compact )*(?:roundabouts?|traffic circles?|rotar(?:y|ies)|circular junctions?|circular intersections?|gyrator(?:y|ies))"
_ARMS = r"(?:ways?|arms?|legs?|roads?|streets?|exits?|branch(?:es)?|approach(?:es)?|spokes?|entries|entrances|avenues|directions)"
_SIGNALS = r"(?:(?:un)?signali[sz]ed|(?:traffic |stop )?light(?:s|ed)? controlled|signal(?: |-)controlled|lit)"
_REFERS_BACK = re.compile(r"\b(?:the|this|that|each|every|all|both|its|these|those|such)(?: \w+)?$")

_SIMPLE: tuple[tuple[str, str, str], ...] = (
    # feature, pattern, meaning
    (
        "staggered",
        r"(?:staggered|off ?set|dog ?leg)(?: t)?(?: (?:crossing|junction|intersection|crossroads?|t s))?s?",
        "staggered junction",
    ),
    ("weaving", r"weav(?:ing|e)(?: (?:section|area|segment|zone|lane))?s?", "weaving section"),
    (
        "hairpin",
        r"hair ?pin(?: (?:bend|turn|curve|corner))?s?|switch ?back|u shaped (?:road|bend|curve|turn)|180 degrees? (?:turn|bend|curve)|u bend",
        "hairpin",
    ),
    (
        "s_curve",
        r"s (?:curve|bend|turn|shape)d?s?|s shaped(?: \w+)?|double (?:bend|curve)|chicane|reverse curve|serpentine|winding|zig ?zags?(?:ging)?|(?:bends?|curves?|turns?) (?:to the )?(?:left|right)(?: ,)? (?:and )?then (?:to the )?(?:left|right)",
        "S-curve",
    ),
    (
        "fork",
        r"(?:y shaped )?forks?(?:ing|ed)?|(?:splits?|divid\w+|separat\w+|branch\w*|part(?:s|ing)) (?:up )?(?:in)?to (?:2|two|left and right)(?: (?:branches|roads|directions|parts|streets|carriageways))?|bifurcat\w+|splits? (?:apart|up)|y split",
        "road that splits into two",
    ),
    (
        "curve",
        r"curv(?:e|es|ed|ing|y)|bend(?:s|ing)?|bent|arc(?:s|ing)?|turns?(?= (?:left|right|to|through|by|\d+ degrees?))|swe+p(?:s|ing)|corner",
        "curve",
    ),
    (
        "cul_de_sac",
        r"culs? de sacs?|dead ?end(?:s|ed)?(?: (?:street|road))?|no through roads?|blind alley|turning circle",
        "dead end",
    ),
    (
        "highway",
        r"(?:dual carriage ?ways?|(?:divided |controlled access )?(?:high ?ways?|motor ?ways?|free ?ways?|express ?ways?|inter ?states?|auto ?bahn(?:en)?|turnpikes?|thruway|parkway|autoroute|divided roads?|divided (?:two way |urban )?(?:arterial|carriageway)))",
        "highway",
    ),
    (
        "divided",
        r"divided|with a (?:wide |narrow |grass |grassy |raised |green )*(?:median|central reservation)|median|central reservation|separated carriageways",
        "divided",
    ),
    ("straight", r"(?:dead |perfectly |completely )?straight(?: line)?", "straight"),
    ("arterial", r"arterials?|boulevards?", "arterial road"),
    (
        "main_road",
        r"(?:main|major|primary|priority|through) (?:road|street|route|line|carriageway|highway)s?|mainline",
        "main road",
    ),
    ("side_road", r"(?:side|minor|secondary|smaller|local|access) (?:road|street)s?|stem", "side road"),
    ("road", r"(?:carriage ?ways?|roads?|streets?|avenues?|lanes?(?= through| in the country)|roadway|alley|drive|route)", ""),
)
_SURROUNDINGS = (
    ("residential", r"residential|neighbou?rhood|housing(?: estate)?|suburban|village|living street|school zone"),
    ("rural", r"rural|country(?:side)?|country lane|mountain(?:ous)?"),
    ("urban", r"urban|city|town|downtown|inner city|village"),
)


def read_junctions(reading: Reading, facts: Facts) -> None:
    """Roundabouts and crossings with their numbers of roads, in the order of the text."""
    _read_grid(reading, facts)
    _read_roundabouts(reading, facts)
    _read_shaped(reading, facts)
    _read_crossings(reading, facts)
    facts.junctions.sort(key=lambda junction: junction.at)


def read_kinds(reading: Reading, facts: Facts) -> None:
    """Everything else that decides the kind."""
    _read_side_streets(reading, facts)
    _read_ramps(reading, facts)
    _read_lane_changes(reading, facts)
    for feature, pattern, meaning in _SIMPLE:
        for match in list(reading.all(pattern)):
            if reading.negated(match):
                reading.take(match, f"no {meaning or feature}")
                continue
            facts.features.setdefault(feature, match.start())
            reading.take(match, meaning)
    for name, pattern in _SURROUNDINGS:
        if match := reading.first(pattern):
            facts.surroundings = facts.surroundings or name
            reading.take(match, f"{name} road")
    _read_ways(reading, facts)


def read_control(reading: Reading, facts: Facts) -> None:
    """Signals, stop, yield or nothing; left- or right-hand traffic."""
    rules = (
        (
            "all_way_stop",
            r"(?:all|4|3|5|every) way stops?(?: (?:signs?|control(?:led)?))?|stop signs? (?:on|at|for) (?:all|every|each) \w+",
            "all-way stop",
        ),
        (
            "uncontrolled",
            r"uncontrolled|right before left|priority (?:to|from) the right|unmarked|uncontroled",
            "no signs: right before left",
        ),
        (
            "signals",
            r"traffic (?:lights?|signals?)(?: control(?:s|led)?)?|signals?|stop ?lights?|(?:light|signal) controlled|signali[sz]ed|signal controlled|lights",
            "traffic lights",
        ),
        ("stop", r"stop (?:signs?|lines?|control(?:led)?)|stop(?= sign)", "stop signs"),
        (
            "yield",
            r"(?:yield|give way)(?: (?:signs?|lines?|control(?:led)?))?|priority (?:junction|control(?:led)?)|unsignali[sz]ed|without control",
            "side roads yield",
        ),
    )
    for control, pattern, meaning in rules:
        for match in list(reading.all(pattern)):
            negative = reading.negated(match) or match.group().startswith(("unsig", "without"))
            if control == "signals" and negative or match.group().startswith("unsig"):
                facts.unsignalled = True
                reading.take(match, "no traffic lights")
            elif negative:
                reading.take(match, f"no {meaning}")
            else:
                facts.control = facts.control or control  # type: ignore[assignment]
                reading.take(match, meaning)
    hand = r"(left|right) hand(?:ed)? (?:traffic|driving|drive|side)|(?:driv\w+|keeps?|traffic|stays?|on) (?:is |keeps? )?(?:on )?(?:the )?(left)(?: hand)?(?: side)?(?: of the road)?(?= |$)|british|english|japanese|australian|uk|in (?:britain|england|japan|australia|india)"
    for match in list(reading.all(hand)):
        facts.left_hand = (match[1] or match[2] or "left") == "left"
        reading.take(match, "left-hand traffic" if facts.left_hand else "right-hand traffic")


def _read_grid(reading: Reading, facts: Facts) -> None:
    size = r"(\d+) ?(?:x|by|times) ?(\d+)"
    words = r"(?:(?:street |road |city |regular |square |rectangular |manhattan (?:style )?)*(?:grid|blocks?|network|checkerboard|lattice|mesh)(?: of (?:city )?(?:streets|roads|blocks|crossings|intersections))?(?: streets)?)"
    for pattern in (
        rf"{size} {words}|{words} (?:of |with )?{size}|{size}(?: \w+)? (?:crossings|intersections|junctions|streets)",
        rf"{words}",
    ):
        for match in list(reading.all(pattern)):
            numbers = [int(g) for g in match.groups() if g] if match.lastindex else []
            if not numbers and not re.search(r"grid|blocks|checker|lattice|mesh", match.group()):
                continue
            if reading.negated(match):
                reading.take(match, "no grid")
                continue
            facts.features.setdefault("grid", match.start())
            if numbers and facts.grid is None:
                facts.grid = (numbers[0], numbers[1])
            reading.take(match, f"grid of {numbers[0]} x {numbers[1]} streets" if numbers else "street grid")
    if "grid" in facts.features and (
        match := reading.first(
            r"(\d+) (?:rows|horizontal (?:streets|roads)|streets) (?:and|by|x) (\d+) (?:columns|vertical (?:streets|roads)|avenues)"
        )
    ):
        facts.grid = (int(match[1]), int(match[2]))
        reading.take(match, f"grid of {match[1]} x {match[2]} streets")


def _read_roundabouts(reading: Reading, facts: Facts) -> None:
    joins = (
        r"(?: ?,? ?(?:with|of|has|having|where|joining|connecting|linking|serving|that|which|joins|connects|at which|and|from) )*"
    )
    patterns = (
        rf"(\d+) (?:way|arm(?:ed)?|leg(?:ged)?|exit|branch|road) (?:(?:\d+|single|double|multi) lane )?{_RING}()",
        rf"{_RING}{joins}(?:(?:\d+|single|double|multi) lanes? (?:and|with) )?(\d+) {_ARMS}()",
        rf"(\d+) {_ARMS} (?:meet|meeting|join|joined|come together|converge|connect(?:ed)?)(?: \w+){{0,2}} (?:at|in|by|to|into|around|on) an? (?:\w+ )?{_RING}()",
        rf"()(?:(\d+) )?(?:(?:\d+|single|double) lane )?{_RING}",
    )
    for pattern in patterns:
        for match in list(reading.all(pattern)):
            if reading.negated(match):
                reading.take(match, "no roundabout")
                continue
            arms = int(match[1]) if match[1] else None
            back = _REFERS_BACK.search(reading.before(match, 2)) and any(j.form == "roundabout" for j in facts.junctions)
            count = int(match[2]) if match.lastindex and match.lastindex > 1 and match[2] and arms is None else 1
            if not back:
                facts.junctions.append(JunctionWords("roundabout", match.start(), arms, count=count))
            said = f" that {arms} roads meet" if arms else ""
            reading.take(match, f"roundabout{said}" if count == 1 else f"{count} roundabouts")


def _read_shaped(reading: Reading, facts: Facts) -> None:
    """T and Y junctions, which have three roads, and junctions named by their shape."""
    shapes = (
        ("t", rf"(?:(\d+) )?(?:{_SIGNALS} )?(?:t|tee)(?: shaped| style| type)? ?{_CROSSING}", "T-junction"),
        (
            "t",
            r"(?:ends?|ending|terminat\w+|runs|dead ?ends)(?: at| in| into) (?:an?|the) (?:main |major |bigger |larger |\d+ lane )?(?:road|street)()",
            "T-junction",
        ),
        ("y", rf"(?:(\d+) )?(?:{_SIGNALS} )?y(?: shaped| style| type)? ?{_CROSSING}", "Y-junction"),
    )
    for shape, pattern, meaning in shapes:
        for match in list(reading.all(pattern)):
            if reading.negated(match):
                reading.take(match, f"no {meaning}")
                continue
            back = _REFERS_BACK.search(reading.before(match, 2)) and facts.junctions
            count = int(match[1]) if match[1] else 1
            if not back:
                facts.junctions.append(JunctionWords("crossing", match.start(), 3, shape, count, _lit(match.group())))
            reading.take(match, meaning if count == 1 else f"{count} {meaning}s")


def _read_crossings(reading: Reading, facts: Facts) -> None:
    way = r"(?:way|arm(?:ed)?|leg(?:ged)?|road|branch|street|approach)"
    joins = r"(?: ?,? ?(?:with|of|has|having|where|joining|connecting|that|which|between) )+"
    patterns = (
        rf"(\d+) {way}(?: multi leg)? (?:(?:{_SIGNALS}|\d+ lane|urban|rural|star) )*{_CROSSING}()",
        rf"(?:{_SIGNALS} |multi (?:leg|way|arm) |star )?{_CROSSING}{joins}(?:exactly )?(\d+) (?!lane)(?:\w+ )?{_ARMS}()",
        rf"(?:where |at which )?(\d+) (?!lane)(?:\w+ ){{0,2}}?(?:roads|streets|avenues|arms|legs|highways) (?:all |that |which )?(?:meet|join|cross|intersect|come together|converge|crossing|meeting|intersecting)(?: each other| (?:at|in) (?:a |1 |one )?(?:single )?(?:point|place|{_CROSSING}))?()",
        rf"()(?:(\d+) )?(?:{_SIGNALS} )?{_CROSSING}",
        r"()()(?:cross(?:es|ed)?|intersects?|intersecting)(?= (?:a |an |another |the |by |with )?)",
    )
    for pattern in patterns:
        for match in list(reading.all(pattern)):
            if reading.negated(match):
                reading.take(match, "no crossings")
                continue
            _add_crossing(reading, facts, match)


def _add_crossing(reading: Reading, facts: Facts, match: re.Match[str]) -> None:
    arms = int(match[1]) if match[1] else None
    if arms == 2:  # two roads that cross are four arms
        arms = 4
    count = int(match[2]) if match[2] else 1
    back = arms is None and count == 1 and _REFERS_BACK.search(reading.before(match, 2))
    verb = match.group().startswith(("cross", "intersect")) and arms is None and count == 1 and not match.group().endswith("s")
    known = next((i for i, j in enumerate(facts.junctions) if j.form == "crossing"), None)
    if known is not None and facts.junctions[known].arms is None and arms is not None and count == 1:
        old = facts.junctions[known]
        facts.junctions[known] = JunctionWords("crossing", old.at, arms, old.shape, old.count, old.signals)
    elif not ((back or verb) and facts.junctions):
        facts.junctions.append(JunctionWords("crossing", match.start(), arms, "", count, _lit(match.group())))
    said = f" of {arms} arms" if arms else ""
    reading.take(match, f"crossing{said}" if count == 1 else f"{count} crossings")


def _lit(phrase: str) -> bool | None:
    if re.search(r"\bunsignali", phrase):
        return False
    return True if re.search(_SIGNALS, phrase) else None


def _read_side_streets(reading: Reading, facts: Facts) -> None:
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
    meets = r"(?:meet(?:s|ing)?|joins?|joining|enter(?:s|ing)?|com(?:es|ing) (?:in )?(?:from|into)|connect(?:s|ed|ing)? (?:to|with)|leav(?:es|ing)|branch(?:es|ing) off|runs into|leads? into|teeing into)"
    for match in list(reading.all(meets)):
        facts.features.setdefault("meets", match.start())
        reading.take(match, "")


def _read_ramps(reading: Reading, facts: Facts) -> None:
    both = r"(?:on|entry|entrance) (?:and|then|followed by) (?:an )?(?:off|exit) (?:ramps?|slip roads?|slips?)"
    reverse = r"(?:off|exit) (?:and|then|followed by) (?:an )?(?:on|entry|entrance) (?:ramps?|slip roads?|slips?)"
    ramp = r"(?:ramps?|slip ?roads?|slips?|slip lanes?)"
    rules = (
        (("on_ramp", "off_ramp"), both, "on-ramp and off-ramp"),
        (("off_ramp", "on_ramp"), reverse, "off-ramp and on-ramp"),
        (
            ("off_ramp",),
            rf"(?:off|exit|leaving) ?{ramp}|off ?ramps?|{ramp}(?: \w+)? (?:that |which )?(?:leav\w+|exit\w*|diverg\w+|off|going off)|exit lanes?|deceleration lanes?",
            "off-ramp",
        ),
        (
            ("on_ramp",),
            rf"(?:on|entry|entrance|access|merging|entering|joining|feeder) ?{ramp}|on ?ramps?|{ramp}(?: \w+)? (?:that |which )?(?:merg\w+|join\w*|enter\w*|feed\w*|com\w+ in)|(?:merg(?:e|ing)|acceleration) lanes?|{ramp}",
            "on-ramp",
        ),
    )
    for kinds, pattern, meaning in rules:
        for match in list(reading.all(rf"(?:(\d+) )?(?:\d+ lane )?(?:{pattern})")):
            if reading.negated(match):
                reading.take(match, f"no {meaning}")
                continue
            again = _REFERS_BACK.search(reading.before(match, 1)) or match.group().endswith(("lane", "lanes"))
            if not (again and any(e.kind == kinds[0] for e in facts.events)):
                copies = min(int(match[1]), 9) if match[1] else 1
                found = [EventWords(kind, match.start() + i) for i in range(copies) for kind in kinds]
                facts.events += found
            reading.take(match, meaning)
    if facts.events or facts.has("highway") or re.search(r"\b(?:highway|motorway|freeway|expressway|autobahn)", reading.text):
        _read_exits(reading, facts)
    for match in list(reading.all(r"merg(?:es?|ing|ed)(?: into| with| onto)?|diverg(?:es?|ing)(?: from)?")):
        reading.take(match, "")
    facts.events.sort(key=lambda event: event.at)


def _read_exits(reading: Reading, facts: Facts) -> None:
    for kind, pattern in (("off_ramp", r"exits?"), ("on_ramp", r"entr(?:y|ance|ances|ies)")):
        for match in list(reading.all(rf"(?:(\d+) )?{pattern}")):
            if reading.negated(match):
                reading.take(match, f"no {kind.replace('_', '-')}")
                continue
            copies = min(int(match[1]), 9) if match[1] else 1
            facts.events += [EventWords(kind, match.start() + i) for i in range(copies)]
            reading.take(match, kind.replace("_", "-"))


def _read_lane_changes(reading: Reading, facts: Facts) -> None:
    """A lane that ends or begins, where no numbers say so."""
    side = r"(?:(left|right)(?: ?most| hand)? |outer |inner )?"
    rules = (
        (
            "lane_drop",
            rf"(?:the |a |1 |one )?{side}lane (?:drops?|ends?|ending|closes?|closure|closed|disappears?|reduction|is (?:closed|dropped|lost)|that ends|merges|narrowing|loss)|loses (?:a |1 |one )?{side}lane|narrow(?:s|ing)(?: road)?|1 lane fewer|fewer lanes",
        ),
        (
            "lane_gain",
            rf"(?:the |a |an |1 |one |new |extra |additional |climbing |passing )*{side}lane (?:gains?|addition|is added|begins?|starts?|opens?|appears?)|gains? (?:a |an |1 |one |extra |additional )*{side}lane|widens?(?: by (?:a |1 |one )lane)?|(?:climbing|passing|extra|additional) lane",
        ),
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


def _read_ways(reading: Reading, facts: Facts) -> None:
    for match in list(reading.all(r"one ?way|single direction|unidirectional|only (?:in )?1 direction|in 1 direction only")):
        if reading.negated(match):
            facts.two_way = True
        else:
            facts.one_way.append(match.start())
        reading.take(match, "two-way" if reading.negated(match) else "one-way")
    for match in list(reading.all(r"(?:two|2) ?way|bi ?directional|undivided|single carriage ?way|both (?:ways|directions)")):
        facts.two_way = True
        reading.take(match, "two-way")
    if match := reading.first(r"(?:to the |on the |turns? |bends? |from the )?(left|right)(?: hand)?(?: side| turn)?"):
        facts.turn = "left" if match[1] == "left" else "right"
        reading.take(match, f"to the {match[1]}")
