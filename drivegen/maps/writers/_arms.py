"""How many roads meet at a junction, where the number is told apart from it."""

from drivegen.maps.writers._facts import Facts, JunctionWords
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._sentence import Sentence

_MEET = ("meet", "cross", "join")
_FAR = 22
_FEWEST = 3


def read_arms(s: Sentence, facts: Facts) -> None:
    """A number of roads or arms that meet: at the junction mentioned, or making one."""
    for phrase in (*s.said("arm"), *s.said("road"), *s.said("ramp", "off_or_arm", "on_or_arm")):
        number = phrase.number or _counted_before(s, phrase)
        if phrase.head in s.used or number is None or number < 2:
            continue
        if phrase.role:
            if phrase.kind == "arm" and number == 2 and facts.junctions:
                s.used.update(range(phrase.first, phrase.head))  # "its two main arms"
            continue
        if facts.has("grid") or (phrase.kind == "ramp" and not facts.junctions):
            continue
        if _crosses(s, phrase):
            continue
        _give_arms(s, facts, phrase, number)


def _counted_before(s: Sentence, phrase: Phrase) -> int | None:
    if phrase.first and s.word(phrase.first - 1, "number") and phrase.kind == "arm":
        return s.tokens[phrase.first - 1].number
    return None


def _crosses(s: Sentence, phrase: Phrase) -> bool:
    """Whether the streets cross another one after another: "crossed by four streets", "crosses three roads"."""
    before = s.tokens[max(0, phrase.first - 3) : phrase.first]
    return any(t.kind == "verb" and t.value == "cross" for t in before)


def _give_arms(s: Sentence, facts: Facts, phrase: Phrase, number: int) -> None:
    single = [j for j in facts.junctions if j.count == 1]
    s_meet = _meets(s, phrase)
    if s.word(phrase.first - 2, "each") or s.word(phrase.first - 1, "each"):
        single = facts.junctions  # "two roundabouts, each with four roads"
    if phrase.kind != "arm" and not single and not s_meet:
        return
    if facts.has("staggered", "fork") or (not facts.junctions and _of_a_road(s, phrase)):
        return
    arms = 4 if number == 2 and phrase.kind == "road" else number
    if not facts.junctions:
        if phrase.kind == "road" and not s_meet:
            return
        facts.junctions.append(JunctionWords("crossing", phrase.first, arms))
    else:
        nearest = min(facts.junctions, key=lambda j: abs(j.at - phrase.first))
        if phrase.kind == "road" and number == 2:
            arms = nearest.arms or (4 if nearest.form == "crossing" else None) or 4
            if nearest.form == "roundabout":
                return
        if nearest.arms not in (None, arms) and not (nearest.shape == "y" and number == 2):  # its two branches
            return  # a contradiction: the number stays over, and is refused
        nearest.arms = _FEWEST if nearest.shape == "y" else arms
    s.use(phrase.first, phrase.head, f"{number} roads meet")
    if s.word(phrase.first - 1, "number"):
        s.used.add(phrase.first - 1)


def _of_a_road(s: Sentence, phrase: Phrase) -> bool:
    """Whether the arms are said of a road: "a bypass with six arms"."""
    before = s.last_before(phrase.first, "road")
    return before is not None and phrase.first - before.head <= 2 and s.word(before.head + 1, "with")


def _meets(s: Sentence, phrase: Phrase) -> bool:
    near = s.tokens[max(0, phrase.first - 3) : phrase.first] + s.tokens[phrase.head + 1 : phrase.head + 6]
    for token in near:
        if token.kind == "stop":
            break
        if token.kind == "verb" and token.value in _MEET:
            return True
    return _meet_later(s, phrase)


def _meet_later(s: Sentence, phrase: Phrase) -> bool:
    """Whether the verb of several roads follows what is said of each: "two streets, one with ..., one with ..., cross"."""
    if (phrase.number or 1) < 2:
        return False
    for i in range(phrase.head + 1, min(len(s.tokens), phrase.head + _FAR)):
        if s.word(i, "stop") or s.word(i, "place") or s.word(i, "ramp") or (s.word(i, "road") and s.tokens[i - 1].kind != "lane"):
            return False
        if s.word(i, "verb"):
            return s.tokens[i].value in _MEET
    return False
