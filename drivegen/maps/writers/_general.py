"""What holds for the whole description: kinds of road, bends, who goes first, one-way, surroundings, the side of traffic."""

from drivegen.maps.spec_values import Side
from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._owners import is_turning_place, roads, role
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._rows import meant_of_a_row, pockets_of_a_row, read_control_of_each, use_number_of_others
from drivegen.maps.writers._sentence import Sentence

_MOST_BENDS = 8
_NEAR = 6
_CONTROLS = {
    "signals": "traffic lights",
    "unsignalled": "no traffic lights",
    "all_way_stop": "all-way stop",
    "stop": "stop signs",
    "uncontrolled": "no signs: right before left",
    "yield": "side roads yield",
}


def read_hand(s: Sentence, facts: Facts) -> None:
    """Left- or right-hand traffic."""
    for i in s.of_kind("left_hand"):
        facts.left_hand = s.tokens[i].value == "left" or facts.left_hand
        s.use(i, i, f"{s.tokens[i].value}-hand traffic")


def read_roads(s: Sentence, facts: Facts) -> None:
    """Classes and roles of roads, one-way, surroundings, medians."""
    for phrase in s.said("road"):
        for name in (phrase.words.get("class"), phrase.words.get("surroundings")):
            if name in ("highway", "arterial"):
                facts.features.setdefault(name, phrase.first)
        facts.features.setdefault("road", phrase.first)
        if phrase.role:
            facts.features.setdefault(f"{phrase.role}_road", phrase.first)
    for phrase in s.phrases:
        if phrase.kind in ("road", "place", "shape", "dead_end") and not phrase.negated and not facts.surroundings:
            facts.surroundings = phrase.words.get("surroundings", "")
    for i in s.of_kind("surroundings"):
        facts.surroundings = facts.surroundings or s.tokens[i].value
        s.use(i, i, f"{s.tokens[i].value} road")
    _read_divided(s, facts)
    _read_ways(s, facts)


def note_roads(s: Sentence, _facts: Facts) -> None:
    """Note the roads that nothing else has noted; read last, because a number of roads may make a junction."""
    meaning = {"highway": "highway", "arterial": "arterial road", "main": "main road", "side": "side road"}
    for phrase in s.said("road"):
        if phrase.head not in s.used:
            s.use(phrase.head, phrase.head, meaning.get(phrase.words.get("class") or phrase.role, ""))


def _read_divided(s: Sentence, facts: Facts) -> None:
    for i in s.of_kind("divided"):
        if s.negated_at(i):
            s.use(i, i, "no median")
            continue
        facts.features.setdefault("divided", i)
        if s.tokens[i].text.startswith(("dual", "2 carriage")):
            facts.features.setdefault("highway" if "carriage" in s.tokens[i].text else "divided", i)
        s.use(i, i, "divided road")


def _read_ways(s: Sentence, facts: Facts) -> None:
    for i in s.of_kind("one_way"):
        if s.negated_at(i):
            facts.two_way = True
            s.use(i, i, "two-way")
            continue
        phrase = next((p for p in s.phrases if p.first <= i <= p.head and p.kind == "road"), None)
        number = phrase.number if phrase is not None else None
        if facts.one_way and phrase is not None and phrase.det == "the":
            s.use(i, i, "")
            continue
        facts.one_way += [i] * max(1, min(2, number or 1))
        s.use(i, i, "one-way")
    facts.one_way_role = _role_of_only_one_way(s)
    for phrase in s.said("road", "one_way"):
        if phrase.head not in facts.one_way:
            facts.one_way.append(phrase.head)
            s.use(phrase.head, phrase.head, "one-way")
    facts.two_way |= any(_is_both_ways(s.tokens[i].text.split()) for i in s.of_kind("each", ""))
    for i in s.of_kind("two_way"):
        facts.two_way = True
        s.use(i, i, "two-way")


def _role_of_only_one_way(s: Sentence) -> str:
    """Whose road it is, "main" or "side", where one of two roads alone is said to be one-way."""
    groups = roads(s)
    said = [group for group in groups if any("one_way" in p.words for p in group)]
    single = len(groups) == 2 and len(said) == 1 and not s.tokens[said[0][0].head].text.endswith("s")
    return role(s, said[0][0]) if single and (said[0][0].number or 1) == 1 else ""


def _is_both_ways(words: list[str]) -> bool:
    return "both" in words and words[-1] in ("directions", "ways")


def read_shapes(s: Sentence, facts: Facts) -> None:
    """Bends, straights, dead ends."""
    for phrase in (*s.denied("shape"), *s.denied("dead_end")):
        turning = is_turning_place(s, phrase)
        told = "no turning place said, one drawn, so that cars find out" if turning else f"no {phrase.value or 'dead end'}"
        s.use(phrase.first, phrase.head, told)
    turns: list[str] = []
    for phrase in s.said("shape"):
        facts.features.setdefault(phrase.value, phrase.first)
        s.use(phrase.head, phrase.head, phrase.value.replace("_", "-"))
        if "loop" in phrase.text.split() and phrase.value == "curve":
            facts.features.setdefault("loop", phrase.first)
            facts.one_way.append(phrase.head)
    for phrase in s.said("dead_end"):
        facts.features.setdefault("cul_de_sac", phrase.first)
        s.use(phrase.head, phrase.head, "dead end")
    for i in s.of_kind("bend_size"):
        facts.features.setdefault(s.tokens[i].value, i)
        s.use(i, i, f"{'small' if s.tokens[i].value == 'sharp' else 'large'} radius")
    for i in s.of_kind("turn"):
        if i in facts.side_turns:
            continue
        turns.append(s.tokens[i].value)
        if i not in s.used:
            facts.turn = facts.turn or (_side(s.tokens[i].value))
            s.use(i, i, f"to the {s.tokens[i].value}")
    _count_bends(s, facts)
    _read_double_bend(s, facts, turns)


def _count_bends(s: Sentence, facts: Facts) -> None:
    """Several bends one after another: hairpins, S-curves, or bends to either side in turn."""
    for phrase in s.said("shape", "hairpin", "s_curve", "curve"):
        times = s.word(phrase.head + 1, "number") and s.tokens[phrase.head + 2 : phrase.head + 3]
        count = s.tokens[phrase.head + 1].number if times and times[0].text == "times" else phrase.number
        if count is not None and 1 <= count <= _MOST_BENDS:
            each = 2 if phrase.value == "s_curve" and phrase.text.endswith("s") else 1
            if phrase.value == "hairpin" or count > 2 or each == 2:
                facts.bends = count * each
            last = phrase.head + 2 if times else phrase.head
            s.use(phrase.first, last, f"{count} bends" if count > 1 else phrase.value.replace("_", "-"))


def _side(value: str) -> Side:
    return "left" if value == "left" else "right"


def _read_double_bend(s: Sentence, facts: Facts, turns: list[str]) -> None:
    """Two bends to opposite sides are an S-curve."""
    bends = list(s.said("shape", "curve"))
    opposite = len(set(turns)) == 2 and not facts.has("fork")
    if bends and (opposite or any((p.number or 0) == 2 for p in bends)):
        facts.features.setdefault("s_curve", bends[0].first)
        s.use(bends[0].first, bends[0].head, "S-curve")


def read_pockets(s: Sentence, facts: Facts) -> None:
    """Turn lanes."""
    for phrase in s.denied("pocket"):
        s.use(phrase.first, phrase.head, "no turn lanes")
    for phrase in (p for p in s.said("pocket") if p.head not in s.used):
        sides = phrase.value
        before = s.tokens[phrase.first - 2 : phrase.first] if phrase.first >= 2 else []
        if phrase.words.get("turn") or (before and before[0].kind == "turn" and before[1].kind in ("and", "or")):
            sides = "left right"
        last = phrase.head
        while last + 1 < len(s.tokens) and (s.tokens[last + 1].kind in ("length", "long") or s.word(last + 2, "length")):
            last += 1  # "turn lanes of 40 m on the main road"
        if own := pockets_of_a_row(s, facts, phrase):
            for one in own:
                one.pockets = f"{one.pockets} {sides}".strip()
            s.use(phrase.first, phrase.head, f"turn lanes ({sides.replace(' ', ' and ')}) at this junction")
            continue
        where = s.governed(last) or _told_before(s, phrase.first)
        facts.pocket_role = role(s, where) if where is not None and where.kind == "road" and (where.det or where.role) else ""
        if any(abs(i - phrase.head) <= _NEAR for i in s.of_kind("ordinal")) and _in_a_row(facts):
            facts.pocket_role = "one"  # of the junctions of a row
        facts.left_pocket |= "left" in sides
        facts.right_pocket |= "right" in sides
        s.use(phrase.first, phrase.head, f"turn lanes ({sides.replace(' ', ' and ')})")


def _in_a_row(facts: Facts) -> bool:
    return len(facts.junctions) > 1 or any(junction.count > 1 for junction in facts.junctions)


def read_control(s: Sentence, facts: Facts) -> None:
    """Who goes first. Who denies both lights and signs wants neither."""
    denied = {phrase.value for phrase in s.denied("control")}
    read_control_of_each(s, facts)
    _read_denied_control(s, facts)
    found: list[str] = []
    for phrase in s.said("control"):
        if phrase.head in s.used:
            continue
        if phrase.value == "signs":
            s.use(phrase.head, phrase.head, "")
            continue
        named = meant_of_a_row(s, facts, phrase)
        for one in named:
            one.control = phrase.value
        if not named:
            use_number_of_others(s, phrase)
            found.append(phrase.value)
        if phrase.value in ("stop", "yield") and _is_of_one_road(s, phrase.head):
            facts.features.setdefault("main_road", phrase.head)  # who has no sign goes first
        s.use(phrase.first if phrase.value == "all_way_stop" else phrase.head, phrase.head, _CONTROLS[phrase.value])
    if "stop" in found and any({"priority", "right"} & set(p.text.split()) for p in s.said("control", "yield")):
        facts.features.setdefault("main_road", 0)  # one road has priority, the other one the signs
    found += [i.control for i in facts.junctions if i.control and len(facts.junctions) == 1]
    _decide(facts, found, denied)
    for i in s.of_kind("control"):
        s.use(i, i, "")


def _is_of_one_road(s: Sentence, i: int) -> bool:
    """Whether the sign at i is that of one road only, named by its direction: "stop signs for east-west"."""
    near = s.tokens[i + 1 : i + 4]
    return bool(near) and near[0].kind == "prep" and any(t.kind == "label" for t in near)


def _told_before(s: Sentence, i: int) -> Phrase | None:
    """The road of "on the main road there are left-turn lanes", "the main road has left-turn lanes"."""
    road = s.last_before(i, "road")
    between = [t.kind for t in s.tokens[road.head + 1 : i]] if road is not None else []
    if road is None or not road.role or any(kind in ("comma", "verb", "and", "control", "prep") for kind in between):
        return None
    return road if "with" in between or (road.first and s.word(road.first - 1, "prep")) else None


def _read_denied_control(s: Sentence, facts: Facts) -> None:
    several = len(facts.junctions) > 1 or any(j.count > 1 for j in facts.junctions)
    for phrase in s.denied("control"):
        if phrase.head in s.used:
            continue
        named = meant_of_a_row(s, facts, phrase) if several else []
        for one in named:
            one.control = "unsignalled" if phrase.value == "signals" else one.control
        if not named and phrase.value == "signals":
            facts.unsignalled = True
        s.use(phrase.first, phrase.head, f"no {_CONTROLS.get(phrase.value, 'signs')}")


def _decide(facts: Facts, found: list[str], denied: set[str]) -> None:
    facts.unsignalled |= "unsignalled" in found
    rest = [value for value in found if value != "unsignalled"]
    for value in ("signals", "all_way_stop", "uncontrolled", "stop", "yield"):
        if value in rest and facts.control is None:
            facts.control = value
    if denied & {"signs", "stop"} and "signals" in denied and facts.control is None:
        facts.control = "uncontrolled"
