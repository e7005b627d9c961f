"""Roads that cross, meet, join or end at one another, and side streets along a road."""

from drivegen.maps.writers._facts import Facts, JunctionWords
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._sentence import Sentence
from drivegen.maps.writers._side_roads import read_dead_ends, read_listed_places, read_side_roads

_FEWEST = 3
_SEVERAL = 2
_OPPOSITE = ("both sides", "opposite sides", "either side", "each side")


def read_relations(s: Sentence, facts: Facts) -> None:
    """Roads that cross, meet, join or end at one another make junctions where none was named."""
    if any(t.text.endswith("same side") for t in s.tokens):
        facts.features.setdefault("same_side", 0)
    if any(t.text.startswith("alternat") for t in s.tokens):
        facts.features.setdefault("alternate", 0)
    for i in s.verbs("cross"):
        if not s.negated_at(i):
            _read_crossing_verb(s, facts, i)
    for i in s.verbs("meet", "join", "end_at"):
        if not s.negated_at(i) and i not in s.used:
            _read_joining_verb(s, facts, i)
    read_dead_ends(s, facts)
    if not _read_opposite_sides(s, facts):
        read_side_roads(s, facts)
    read_listed_places(s, facts)
    if len(facts.junctions) == 1 and facts.junctions[0].position is None and not any(s.said("shape")):
        facts.junctions[0].middle |= any(t.text in ("halfway", "midway", "midpoint") for t in s.tokens)


def _read_opposite_sides(s: Sentence, facts: Facts) -> bool:
    """Two side roads, one from either side: a crossing where they meet the road at one place, else a staggered junction."""
    sides = [p for p in s.said("road") if p.role == "side"]
    two = any(p.number == 2 for p in sides)
    another = any(p.det == "another" for p in s.said("road") if sides and p.head > sides[0].head)
    turns = {t.value for t in s.tokens if t.kind == "turn"}
    another = another or any(i > sides[0].head for i in s.of_kind("ordinal", "2")) if sides else False
    both = turns == {"left", "right"} or any(t.text in _OPPOSITE for t in s.tokens)
    if sum(p.position is not None for p in s.said("road") if p.role == "side") > 1:
        return False  # each has its own place along the road
    if not both or not (two or another) or facts.has("staggered", "grid") or any(j.count > 1 for j in facts.junctions):
        return False
    meaning = _drawn_as(s, facts, sides[0].first, another)
    if not meaning:
        return False
    s.use(sides[0].first, sides[0].head, meaning)
    for i in (*s.of_kind("turn"), *s.of_kind("each"), *s.of_kind("det", "another"), *s.of_kind("number")):
        if i not in s.used and (s.tokens[i].kind != "number" or s.tokens[i].number == 1):
            s.use(i, i, "")
    return True


def _read_crossing_verb(s: Sentence, facts: Facts, i: int) -> None:
    crossing = s.next_after(i, "road")
    many = crossing.number if crossing is not None and not s.between(i, crossing.first, "verb", "comma") else None
    if crossing is not None and many in (None, 1) and (several := _several_cross(s, i, crossing)) is not None:
        crossing, many = several, several.number
    s.use(i, i, "")
    if many and many >= 2 and crossing is not None and not facts.has("grid"):
        rest = [j for j in facts.junctions if j.count > 1 or j.form == "roundabout" or j.arms not in (None, 4)]
        facts.junctions[:] = [*rest, JunctionWords("crossing", crossing.first, 4, "", many, _common_control(facts))]
        s.use(crossing.first, crossing.head, f"{many} crossings")
    elif not facts.junctions and not facts.has("grid", "staggered") and not facts.interchange:
        facts.junctions.append(JunctionWords("crossing", i, 4))
        s.use(i, i, "crossing")
    facts.features.setdefault("verb_cross", i)


def _several_cross(s: Sentence, i: int, crossed: Phrase) -> Phrase | None:
    """The streets of "two parallel streets that cross a main road"."""
    streets = s.last_before(i, "road")
    if streets is None or (streets.number or 1) < _SEVERAL or s.tokens[i].text.endswith("ed") or crossed.det == "another":
        return None
    near = crossed.first - i == 1 and not s.between(streets.head, i, "comma", "and")
    return streets if near and not crossed.text.endswith("s") else None


def _common_control(facts: Facts) -> str | None:
    return next((j.control for j in facts.junctions if j.control), None)


def _read_joining_verb(s: Sentence, facts: Facts, i: int) -> None:
    """ "A meets B": a T where their roles differ or A ends there, else a crossing."""
    subject, target = s.last_before(i, "road", "ramp", "place", "dead_end"), s.next_after(i, "road", "place", "dead_end")
    verb = s.tokens[i].value
    its = (
        subject is not None and target is None and s.last_before(subject.first, "road", "shape", same_sentence=False) is not None
    )
    if subject is not None and its and subject.role == "side" and verb == "join" and not facts.junctions:
        facts.junctions.append(JunctionWords("crossing", i, _FEWEST, "t", position=subject.position))
        s.use(i, i, "T-junction")  # "a road of 3 km with a side road joining from the right"
        facts.features.setdefault("meets", i)
        return
    if facts.has("grid", "staggered") or target is None or subject is None or subject.kind in ("ramp", "place"):
        return
    if subject.kind == "dead_end":
        if target.kind == "road" and verb == "join":
            facts.side_streets = 1
            facts.features.setdefault("side_streets", i)
            s.use(i, i, "side street")
        return
    if _joins_as_side_street(s, facts, i, subject, target):
        return
    if target.kind == "place" or (subject.number or 1) > 2:
        return
    at_grade = s.tokens[i].text.startswith(("t ", "tee")) or any(s.said("control", "signals", "stop", "yield"))
    if target.words.get("class") == "highway" and not at_grade:
        return
    s.use(i, i, "")
    from_a_side = s.word(target.head + 1, "turn") and s.tokens[target.head + 1].text.startswith("from")
    greater = target.role == "main" or target.words.get("class") == "arterial"
    tee = verb in ("join", "end_at") or from_a_side or subject.role == "side" or greater
    if facts.junctions:
        junction = facts.junctions[-1]
        if tee and junction.form == "crossing" and junction.arms is None and junction.count == 1:
            junction.arms, junction.shape = _FEWEST, "t"
        return
    facts.junctions.append(JunctionWords("crossing", i, _FEWEST if tee else 4, "t" if tee else ""))
    s.use(i, i, "T-junction" if tee else "crossing")
    facts.features.setdefault("meets", i)


def _joins_as_side_street(s: Sentence, facts: Facts, i: int, subject: Phrase, target: Phrase) -> bool:
    """Dead ends that a road is joined by, or streets that join it from one side; a road that ends in a dead end is one itself."""
    several = (subject.number or 1) > 1 and facts.has("same_side") and target.kind == "road"
    if target.kind != "dead_end" and not several:
        return False
    if several or s.tokens[i].value == "join":
        facts.side_streets = (subject.number if several else target.number) or 1
        facts.features.setdefault("side_streets", i)
        s.use(subject.first if several else i, i, "side streets" if several else "side street")
    return True


def _drawn_as(s: Sentence, facts: Facts, at: int, another: bool) -> str:
    """Note the junction of side roads from both sides; "" where the words do not say which it is."""
    if any(t.text in ("same", "opposite", "facing") for t in s.tokens) and "spacing" not in facts.lengths:
        facts.junctions[:] = [JunctionWords("crossing", at, 4)]
        return "crossing"
    for place in s.said("place", "t", "crossing"):
        if another and (apart := place.gap or place.position):
            facts.lengths.setdefault("offset", apart)
    if another or any(name in facts.lengths for name in ("spacing", "offset")):
        facts.junctions.clear()
        facts.features["staggered"] = at
        return "staggered junction"
    return ""
