"""Whether words for a junction mean one that was mentioned before: "the junction", "it is a four-legged one"."""

from drivegen.maps.writers._control import one_for_all
from drivegen.maps.writers._facts import Facts, JunctionWords
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._sentence import Sentence

_FEWEST = 3


def mentioned(s: Sentence, facts: Facts, phrase: Phrase) -> JunctionWords | None:
    """The junction that was mentioned before, where these words mean it again."""
    form = "roundabout" if phrase.value == "roundabout" else "crossing"
    known = [j for j in facts.junctions if j.form == form]
    if facts.has("staggered") and form == "crossing":
        facts.control = facts.control or one_for_all(phrase)
        if phrase.gap:
            facts.lengths.setdefault("offset", phrase.gap)
        return JunctionWords("crossing", phrase.first)
    if not known:
        return facts.junctions[-1] if facts.junctions and form == "crossing" and _refers_back(s, phrase) else None
    if (again := _named_again(s, facts, phrase)) is not None:
        return again
    if (phrase.number or 1) > 1 and phrase.number == known[-1].count and not s.between(known[-1].at, phrase.first, "and", "seq"):
        return known[-1]
    if (phrase.number or 1) > 1 or phrase.det == "another" or s.between(known[-1].at, phrase.first, "seq", "later"):
        return None
    if _refers_back(s, phrase):
        return known[-1]
    if known[-1].count > 1 and phrase.det == "a" and phrase.number is None and any(t.text == "between" for t in s.tokens):
        return None
    return known[-1] if not _is_listed(s, facts, known[-1].at, phrase) and _says_again(s, known[-1], phrase) else None


def _named_again(s: Sentence, facts: Facts, phrase: Phrase) -> JunctionWords | None:
    """The only junction of its kind that a new sentence comes back to: "...; T-junction with stop sign"."""
    form = "roundabout" if phrase.value == "roundabout" else "crossing"
    shape = phrase.value if phrase.value in ("t", "y") else ""
    alike = [j for j in facts.junctions if j.form == form and j.shape == shape and j.count == 1]
    since = max((i for i in range(phrase.first) if s.tokens[i].kind in ("comma", "stop")), default=-1)
    new = since < 0 or len(alike) != 1 or len(facts.junctions) < 2 or phrase.det in ("a", "another") or (phrase.number or 1) > 1
    if new or since + 1 != phrase.first or not s.word(phrase.head + 1, "with") or s.between(alike[0].at, phrase.first, "row"):
        return None
    listed = s.tokens[phrase.first - 2].kind == "place" if phrase.first > 1 else False
    return None if listed else alike[0]


def _says_again(s: Sentence, known: JunctionWords, phrase: Phrase) -> bool:
    """Whether a phrase without "the" means the junction that was mentioned right before it."""
    if phrase.value in ("t", "y") and known.shape in ("", phrase.value) and known.arms in (None, _FEWEST):
        return not s.between(known.at, phrase.first, "and")
    if any(t.text in ("mean", "called", "namely", "aka", "ie") for t in s.tokens[known.at : phrase.first]):
        return True
    if phrase.value == "roundabout" and s.between(known.at + 1, phrase.first, "det", "comma", "stop"):
        return False
    same = phrase.value in ("crossing", "roundabout") and (phrase.det != "a" or phrase.arms in (None, known.arms or phrase.arms))
    return same and (_is_explained(s, known.at, phrase) or not s.between(known.at, phrase.first, "and", "number"))


def _is_listed(s: Sentence, facts: Facts, at: int, phrase: Phrase) -> bool:
    """Whether the phrase is the next of a list along one road: "T-junction, crossroads, T-junction, 120 m apart"."""
    row = "spacing" in facts.lengths or any(True for _ in s.of_kind("row"))
    before = next((p for p in s.said("place") if p.first == at), None)
    between = [t.kind for t in s.tokens[before.head + 1 : phrase.first]] if before is not None else []
    if between[-2:] == ["length", "spacing"]:
        return True  # "a crossroads 200 m from a T-junction"
    return row and bool(between) and phrase.det != "the" and all(kind in ("comma", "and") for kind in between)


def _is_explained(s: Sentence, at: int, phrase: Phrase) -> bool:
    """Whether the phrase says what the junction before it is: "the junction is a four-legged, signalised one"."""
    before = s.tokens[at + 1 : phrase.head]
    return any(t.kind == "is" for t in before[:3]) and not any(t.kind in ("stop", "seq", "later", "spacing") for t in before)


def _refers_back(s: Sentence, phrase: Phrase) -> bool:
    near = s.tokens[max(0, phrase.first - 1) : phrase.head + 1]
    return phrase.det == "the" or any(t.text in ("each", "every", "all", "both", "its") for t in near)
