"""Junctions in words: grids, roundabouts, T and Y junctions, crossings, and how many roads meet at them."""

import re
from dataclasses import replace

from drivegen.maps.writers._facts import Facts, JunctionWords
from drivegen.maps.writers._reading import Reading

_CROSSING = r"(?:crossings?|cross ?roads?|crossways|intersections?|junctions?)"
_SIZES = r"(?:(?:mini|small|large|big|modern|urban|compact|simple) )*"
_RING = rf"{_SIZES}(?:roundabouts?|traffic circles?|rotar(?:y|ies)|circular (?:junction|intersection)s?|gyrator(?:y|ies))"
ARMS = (
    r"(?:ways?|arms?|legs?|roads?|streets?|exits?|branch(?:es)?|approach(?:es)?|spokes?|entries|entrances|avenues|"
    r"directions|highways)"
)
_SIGNALS = r"(?:(?:un)?signali[sz]ed|(?:(?:traffic|stop) )?light controlled|signal controlled)"
_MEET = r"(?:meet|join|cross|intersect|come together|converge|crossing|meeting|intersecting|joined|connected|linked)"
_REFERS_BACK = re.compile(r"\b(?:the|this|that|each|every|all|both|its|these|those|such)(?: \w+)?$")
_STAGGERED = (
    rf"(?:staggered|off ?set|dog ?leg)(?: t)?(?: (?:{_CROSSING}|t s))?(?! (?:by|of|from) )",
    rf"{_CROSSING} (?:that is |which is )?(?:staggered|off ?set)",
)


def refers_back(reading: Reading, match: re.Match[str], words: int = 2) -> bool:
    """Whether the matched noun is "the ..." or "each ...": something that was mentioned before, or all of them."""
    return bool(_REFERS_BACK.search(reading.before(match, words)))


def read_junctions(reading: Reading, facts: Facts) -> None:
    """Find all junctions, in the order of the text."""
    _read_staggered(reading, facts)
    _read_grid(reading, facts)
    _read_roundabouts(reading, facts)
    _read_shaped(reading, facts)
    _read_crossings(reading, facts)
    _read_loose_arms(reading, facts)
    facts.junctions.sort(key=lambda junction: junction.at)


def _read_staggered(reading: Reading, facts: Facts) -> None:
    for pattern in _STAGGERED:
        for match in list(reading.all(pattern)):
            if reading.negated(match):
                reading.take(match, "not staggered")
                continue
            facts.features.setdefault("staggered", match.start())
            reading.take(match, "staggered junction")


def _read_grid(reading: Reading, facts: Facts) -> None:
    size = r"(\d+) ?(?:x|by|times) ?(\d+)"
    many = r"(?:streets|roads|blocks|crossings|intersections|junctions)"
    grid = (
        r"(?:(?:street|road|city|regular|square|rectangular|manhattan|style|downtown) )*"
        rf"(?:grid|blocks?|checkerboard|lattice|mesh)(?: (?:network|plan|layout))?(?: of (?:city )?{many})?(?: streets)?"
    )
    patterns = (
        rf"{size} {grid}",
        rf"{grid} (?:of |with )?{size}(?: {many})?",
        rf"{grid} (?:of |with |, )*(\d+) (?:rows|horizontal {many}|streets) (?:and|by|x) (\d+) \w+(?: streets| roads)?",
        rf"{size}(?: \w+)? {many}",
        rf"{grid}()()",
    )
    for pattern in patterns:
        for match in list(reading.all(pattern)):
            if reading.negated(match):
                reading.take(match, "no grid")
                continue
            facts.features.setdefault("grid", match.start())
            if match[1] and facts.grid is None:
                facts.grid = (int(match[1]), int(match[2]))
            reading.take(match, f"grid of {match[1]} x {match[2]} streets" if match[1] else "street grid")
    alone = reading.first(size) if facts.has("grid") and facts.grid is None else None
    if alone is not None:
        facts.grid = (int(alone[1]), int(alone[2]))
        reading.take(alone, f"grid of {alone[1]} x {alone[2]} streets")


def _read_roundabouts(reading: Reading, facts: Facts) -> None:
    joins = (
        r"(?: ?,? ?(?:with|of|has|having|where|joining|connecting|linking|serving|that|which|joins|connects|links|and|from"
        r"|for|between))* "
    )
    patterns = (
        rf"(\d+) (?:way|arm(?:ed)?|leg(?:ged)?|exit|branch|road) {_RING}()",
        rf"{_RING}{joins}(\d+) (?!lane)(?:\w+ )?{ARMS}()",
        rf"(\d+) (?!lane)(?:\w+ )?{ARMS} (?:(?:are|that|which|all) )*{_MEET}(?: \w+){{0,2}}? an? {_RING}()",
        rf"()(?:(\d+) )?{_RING}",
    )
    for pattern in patterns:
        for match in list(reading.all(pattern)):
            if reading.negated(match):
                reading.take(match, "no roundabout")
                continue
            arms = int(match[1]) if match[1] else None
            count = int(match[2]) if match[2] else 1
            known = any(junction.form == "roundabout" for junction in facts.junctions)
            if not (known and refers_back(reading, match)):
                facts.junctions.append(JunctionWords("roundabout", match.start(), arms, count=count))
            said = f" that {arms} roads meet" if arms else ""
            reading.take(match, f"roundabout{said}" if count == 1 else f"{count} roundabouts")


def _read_shaped(reading: Reading, facts: Facts) -> None:
    """T and Y junctions, which have three roads, and side roads that end at another road."""
    head = rf"(?:(\d+) (way |arm |leg )?)?(?:{_SIGNALS} )?"
    road = r"(?:(?:main|major|bigger|larger|busy|wide) )*(?:road|street|arterial|avenue|highway)"
    shapes = (
        ("t", rf"{head}(?:t|tee)(?: shaped| style| type)? ?{_CROSSING}", "T-junction"),
        ("t", rf"(?:ends?|ending|terminat\w+|runs|dead ?ends) (?:at|in|into|on) (?:an?|the) {road}()()", "T-junction"),
        ("y", rf"{head}y(?: shaped| style| type)? ?{_CROSSING}", "Y-junction"),
    )
    for shape, pattern, meaning in shapes:
        for match in list(reading.all(pattern)):
            if reading.negated(match):
                reading.take(match, f"no {meaning}")
                continue
            count = int(match[1]) if match[1] and not match[2] else 1
            arms = int(match[1]) if match[2] else 3
            if not (
                facts.junctions and (refers_back(reading, match) or match.group().startswith(("end", "run", "term", "dead")))
            ):
                facts.junctions.append(JunctionWords("crossing", match.start(), arms, shape, count, _lit(match.group())))
            reading.take(match, meaning if count == 1 else f"{count} {meaning}s")


def _read_crossings(reading: Reading, facts: Facts) -> None:
    way = r"(?:way|arm(?:ed)?|leg(?:ged)?|road|branch|street|approach)"
    joins = r"(?: ?,? ?(?:with|of|has|having|where|joining|connecting|that|which|between))+ "
    place = rf"(?: each other)?(?: (?:at|in) (?:a |1 |one |an )?(?:single |same )?(?:point|place|{_CROSSING}))?"
    patterns = (
        rf"(\d+) {way}(?: multi leg)? (?:(?:{_SIGNALS}|urban|rural|star|stop) )*{_CROSSING}()",
        rf"(?:{_SIGNALS} |multi (?:leg|way|arm) |star )?{_CROSSING}{joins}(?:exactly )?(\d+) (?!lane)(?:\w+ )?{ARMS}()",
        rf"(?:where |at which )?(\d+) (?!lane)(?:\w+ ){{0,2}}?{ARMS} (?:all |that |which |are )*{_MEET}{place}()",
        rf"()crossed by (\d+) (?:\w+ )?{ARMS}",
        rf"()(?:(\d+) )?(?:{_SIGNALS} )?{_CROSSING}",
        r"()()(?:roads|streets|country lanes|avenues) (?:that |which )?(?:meet|intersect|cross|join)(?: each other)?",
        r"()()(?:cross(?:es|ed)?|intersects?|intersecting)",
    )
    for pattern in patterns:
        for match in list(reading.all(pattern)):
            if reading.negated(match):
                reading.take(match, "no crossings")
                continue
            _add_crossing(reading, facts, match)


def _add_crossing(reading: Reading, facts: Facts, match: re.Match[str]) -> None:
    arms = int(match[1]) if match[1] else None
    arms = 4 if arms == 2 else arms  # two roads that cross are four arms
    count = int(match[2]) if match[2] else 1
    known = next((i for i, junction in enumerate(facts.junctions) if junction.form == "crossing"), None)
    is_verb = (
        arms is None and re.search(r"(?:cross(?:es|ed|ing)?|intersect(?:s|ing)?|meet|join|other)$", match.group()) is not None
    )
    same = known is not None and count == 1 and (is_verb or (arms is None and refers_back(reading, match)))
    if known is not None and arms is not None and facts.junctions[known].arms in (None, arms):
        facts.junctions[known] = replace(facts.junctions[known], arms=arms)
    elif not same and not (facts.junctions and arms is None and count == 1 and refers_back(reading, match)):
        facts.junctions.append(JunctionWords("crossing", match.start(), arms, "", count, _lit(match.group())))
    said = f" of {arms} arms" if arms else ""
    reading.take(match, f"crossing{said}" if count == 1 else f"{count} crossings")


def _read_loose_arms(reading: Reading, facts: Facts) -> None:
    """A number of arms that stands apart from its junction: "a rotary, 40 m across, four legs"."""
    for match in list(reading.all(rf"(\d+) (?!lane|side|one way|minor|cross)(?:\w+ )?{ARMS}")):
        alone = len(facts.junctions) == 1 and facts.junctions[0].count == 1
        if alone and facts.junctions[0].arms in (None, int(match[1])) and int(match[1]) > 2:
            facts.junctions[0] = replace(facts.junctions[0], arms=int(match[1]))
            reading.take(match, f"{match[1]} roads meet")
    if any(junction.form == "roundabout" for junction in facts.junctions):
        for match in list(reading.all(r"rings?|circles?|circulating|circulatory")):
            reading.take(match, "")


def _lit(phrase: str) -> bool | None:
    """Whether the junction's own name says that it has signals."""
    if re.search(r"\bunsignali", phrase):
        return False
    return True if re.search(_SIGNALS, phrase) else None
