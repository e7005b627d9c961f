"""Which road a number belongs to: roads told apart by role, direction and "another", and numbers tied to them by position."""

from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._sentence import Sentence

_NEAR = 7
_APART = ("verb", "and", "prep", "comma", "seq", "with")


def roads(s: Sentence) -> list[list[Phrase]]:
    """The roads that are spoken of, each with the phrases that mean it, in order; "the road" is one that was named before."""
    groups: list[list[Phrase]] = []
    for phrase in s.said("road"):
        named = s.governed(phrase.head) if phrase.first == phrase.head and phrase.role == "main" else None
        if named is not None and named.kind == "road" and not named.role:
            named.words["role"] = phrase.role  # "priority for the north-south road"
    for phrase in s.said("road"):
        if known := _known(s, groups, phrase):
            known.append(phrase)
        else:
            groups.append([phrase])
    return groups


def _known(s: Sentence, groups: list[list[Phrase]], phrase: Phrase) -> list[Phrase] | None:
    for name in ("role", "label"):
        said = phrase.words.get(name)
        for group in groups:
            if said and any(p.words.get(name) == said for p in group):
                return group
    if phrase.role or not groups:
        return None
    if phrase.words.get("label") and phrase.det == "a":
        return None
    if phrase.words.get("label"):
        free = [g for g in groups if not any(p.words.get("label") or p.role for p in g) and (g[0].number or 1) == 1]
        labelled = any(p.words.get("label") for g in groups for p in g)
        return None if labelled or not free else free[0]
    noun = phrase.text.split()[-1]
    if phrase.det == "the" and (same := [g for g in groups if any(p.text.split()[-1] == noun for p in g)]):
        return same[0]  # "the boulevard" is the six-lane boulevard
    previous = groups[-1][-1]
    new = phrase.det == "another" or (phrase.det == "a" and s.between(previous.head, phrase.first, *_APART))
    new = new or (phrase.det == "" and phrase.lanes is not None and s.between(previous.head, phrase.first, "verb", "and"))
    if previous.text.endswith("carriageway") and [t.value for t in s.tokens[previous.head + 1 : phrase.first]] == ["of"]:
        new = False  # "one carriageway of a motorway"
    return None if new else groups[0] if groups[0][0].role != "side" else groups[-1]


def role(s: Sentence, phrase: Phrase) -> str:
    """Whose numbers the phrase's are: "main", "side", "ring", "ramp", or "" for all roads alike."""
    if phrase.kind in ("ring", "ramp"):
        return phrase.kind
    if phrase.kind == "auxiliary":
        return "ramp"
    if phrase.kind != "road":
        return ""
    if phrase.role:
        return phrase.role
    if whole := _role_in_layout(s, phrase):
        return whole
    groups = roads(s)
    here = next((g for g in groups if any(p is phrase for p in g)), None)
    if here is None or (phrase.number or 1) > 2:
        return ""
    said = next((p.role for p in here if p.role), "")
    if said:
        return said
    if (told := _by_its_end(s, here)) and len(groups) > 1:
        return told
    named = {p.role for g in groups for p in g if p.role}
    if "main" in named:
        other = "side" not in named and (phrase.det in ("a", "another") or any(p.words.get("label") for p in here))
        other = other and phrase.words.get("class") != "highway"
        return "side" if other else "main"
    rest = [g for g in groups if not any(p.role for p in g)]
    rest.sort(key=lambda g: not any(p.words.get("class") in ("arterial", "highway") for p in g))
    return "main" if here is rest[0] else "side" if here is rest[1] and "side" not in named else ""


def _role_in_layout(s: Sentence, phrase: Phrase) -> str:
    """Roles that the layout decides: the single road of a fork is the main one, the road over a highway the side road."""
    if any(s.verbs("split")) and (phrase.number or 1) == 1 and not any(s.said("place")):
        return "main"
    over = any(p.value for p in s.said("interchange")) and phrase.words.get("class") != "highway"
    return "side" if over else ""


def _by_its_end(s: Sentence, here: list[Phrase]) -> str:
    """The side road ends at the main one: "a one-lane road ends at an east-west road with two lanes"."""
    for i in s.verbs("end_at") if not any(s.said("ramp")) else ():
        subject, target = s.last_before(i, "road"), s.next_after(i, "road")
        if subject is None or target is None or s.negated_at(i) or subject.role or target.role == "side":
            continue
        if any(p is subject for p in here):
            return "side"
        if any(p is target for p in here):
            return "main"
    return ""


def arm_role(s: Sentence, phrase: Phrase) -> str:
    """Whose arms are named by their directions: the main road's first, then those of the other, "the north and south arms"."""
    labelled = [p for p in s.said("arm") if p.words.get("label")]
    if len({p.words["label"] for p in labelled}) < 2 or not phrase.words.get("label"):
        return ""
    return "main" if phrase.words["label"] == labelled[0].words["label"] else "side"


def owner(s: Sentence, first: int, last: int, *kinds: str) -> Phrase | None:
    """The phrase that the numbers in tokens first to last belong to, by position; None where they stand for themselves.

    A number inside a phrase belongs to it; else one before "on the ..." to what follows; else to what is spoken of last.
    """
    for phrase in s.phrases:
        if phrase.first <= first and last < phrase.head and phrase.kind in kinds and not phrase.negated:
            return phrase
    governed = s.governed(last)
    if governed is not None and governed.kind in kinds:
        return governed
    before = s.last_before(first, *kinds)
    if before is not None and before.value.endswith("_or_arm") and any(s.said("place")):
        before = next(p for p in s.said("place"))
    if before is None and first and s.word(first - 1, "stop"):
        return s.last_before(first - 1, *kinds)
    return before


def is_close(s: Sentence, phrase: Phrase, first: int) -> bool:
    """Whether a number right after a phrase is said of it: no comma or other matter stands between, a bracket may."""
    between = s.tokens[phrase.head + 1 : first]
    return len(between) <= 4 and not any(t.text in (",", ".") or t.kind in ("verb", "and", "seq") for t in between)


def holds_for_all_of_a_ring(s: Sentence, i: int) -> bool:
    """Whether the speed is said of ring and arms together: "40 km/h on ring and legs", "ring and arms both 30 km/h"."""
    rings = [p.head for p in s.said("ring") if abs(p.head - i) <= _NEAR]
    arms = [p.head for p in (*s.said("arm"), *s.said("road")) if abs(p.head - i) <= _NEAR]
    joined = [sorted((ring, arm)) for ring in rings for arm in arms if (ring < i) == (arm < i)]
    near = [(a, b) for a, b in joined if not s.between(min(b, i), max(a, i), "comma")]
    return any(_are_joined(s, first, last) for first, last in near)


def _are_joined(s: Sentence, first: int, last: int) -> bool:
    between = [t.kind for t in s.tokens[first + 1 : last]]
    return "and" in between and all(kind in ("and", "prep", "det", "role", "each", "total", "unknown") for kind in between)


def is_turning_place(s: Sentence, phrase: Phrase) -> bool:
    """Whether it is the place to turn at the end of a dead end that is denied, and not the dead end: "without a turning loop"."""
    turning = phrase.kind == "dead_end" and s.tokens[phrase.head].text.startswith("turning")
    return turning and phrase.negated and any(s.said("dead_end"))
