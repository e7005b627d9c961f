"""Speed limits and the roads that they belong to."""

from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._owners import holds_for_all_of_a_ring, is_close, owner, role
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._sentence import Sentence

_KMH = 1 / 3.6
_LEAST_BARE_SPEED = 10
_MOST_BARE_SPEED = 130
_CLOSE = 4


def read_speeds(s: Sentence, facts: Facts) -> None:
    """Speed limits, with or without a unit; the speeds of cars are left to whoever reads vehicles."""
    for i, token in enumerate(s.tokens):
        if i in s.used:
            continue
        if token.kind == "speed" and _is_second_of_two(s, i):
            before = s.tokens[i - 2].amount[0]
            facts.speeds.setdefault("main", before * token.amount[0] / float(token.text.split()[0]))
            facts.speeds.setdefault("side", token.amount[0])
            s.use(i - 2, i, f"speed limits {before:g} and {_shown(token.text)}")
        elif token.kind == "speed" and not _is_driven(s, i):
            _give_speed(s, facts, i, token.amount[0], f"{_shown(token.text)}")
        elif token.kind == "number" and token.amount[0] >= _LEAST_BARE_SPEED and _is_bare_speed(s, facts, i):
            _give_speed(s, facts, i, token.amount[0] * _KMH, f"{token.amount[0]:g} km/h")


def _is_second_of_two(s: Sentence, i: int) -> bool:
    """Whether the limits of two roads are told at once: "limits of 70 and 50 km/h"."""
    two = s.word(i - 1, "and") and s.word(i - 2, "number") and s.tokens[i - 2].number >= _LEAST_BARE_SPEED
    return bool(two) and (any(s.said("place")) or any(s.verbs("cross", "meet"))) and not any(s.said("place", "roundabout"))


def _shown(text: str) -> str:
    return text.replace("kmh", "km/h").replace("mps", "m/s")


def _is_driven(s: Sentence, i: int) -> bool:
    clause = s.tokens[s.clause(i) : i]
    return any(t.kind == "driving" for t in clause) and not any(t.kind == "speed_word" for t in clause)


def _is_bare_speed(s: Sentence, facts: Facts, i: int) -> bool:
    following = s.tokens[i + 1] if i + 1 < len(s.tokens) else None
    if following is not None and following.kind == "speed_word":
        return True
    if following is not None and following.kind in ("lane", "arm", "place", "road", "driving"):
        return False
    if any(t.kind == "speed_word" for t in s.tokens[s.clause(i) : i]):
        return True
    return (bool(facts.speeds) and s.governed(i) is not None) or (not facts.speeds and _stands_alone(s, i))


def _stands_alone(s: Sentence, i: int) -> bool:
    """Whether a round number that is left by itself can only be a limit: "two lanes each way, 90"."""
    ends = i + 1 == len(s.tokens) or s.tokens[i + 1].kind in ("comma", "stop")
    begins = i > 0 and s.tokens[i - 1].kind in ("comma", "stop", "each")
    return ends and begins and s.tokens[i].number % 10 == 0 and 20 <= s.tokens[i].number <= _MOST_BARE_SPEED


def _give_speed(s: Sentence, facts: Facts, i: int, speed: float, shown: str) -> None:
    who = "main" if holds_for_all_of_a_ring(s, i) else _speed_role(s, facts, i)
    phrase = owner(s, i, i, "ramp")
    if who == "ramp" and phrase is not None and phrase.speed is None:
        phrase.speed = speed
    if (who or "main") == "main" and "main" in facts.speeds and _names_the_road_again(s, facts, i):
        facts.speeds["ramp"] = facts.speeds.pop("main")  # the earlier one was said of the ramp
        s.notes[:] = [(at, words, f"{m} on the ramp" if m.startswith("speed limit") else m) for at, words, m in s.notes]
    facts.speeds.setdefault(who or "main", speed)
    if holds_for_all_of_a_ring(s, i):
        facts.speeds.setdefault("ring", speed)
    first = i
    while (first > 0 and s.tokens[first - 1].kind in ("speed_word", "is")) or (
        first > 0 and s.tokens[first - 1].text in ("of", "at", "to")
    ):
        first -= 1
    last = i + 1 if s.word(i + 1, "speed_word") else i
    s.use(first, last, f"speed limit {shown}" + (f" on the {who}" if who and who != "main" else ""))


def _names_the_road_again(s: Sentence, facts: Facts, i: int) -> bool:
    """Whether the speed at i stands right behind a highway, and one before it behind words on a ramp."""
    highways = (p for p in s.said("road") if p.words.get("class") == "highway" and p.head < i)
    highway = next((p for p in highways if i - p.head <= _CLOSE and is_close(s, p, i)), None)
    ramp = next((p for p in s.said("ramp") if p.head < i), None)
    return highway is not None and ramp is not None and "ramp" not in facts.speeds


def _speed_role(s: Sentence, facts: Facts, i: int) -> str:
    inside = next((p for p in s.phrases if p.first <= i < p.head and p.kind in ("road", "ramp", "ring", "place")), None)
    governed = s.governed(i)
    if governed is None and s.word(i + 1, "speed_word"):
        governed = s.governed(i + 1)
    if governed is not None and ((governed.det == "" and (governed.number or 0) > 1) or _all(s, governed)):
        return "main"
    beside = next((p for p in s.said("road") if p.first == p.head == i + 1 and p.role), None)  # "60 km/h main, 40 minor"
    phrase = inside or governed or beside
    if phrase is not None and phrase.value == "roundabout" and phrase.det == "the" and phrase.text.endswith("circle"):
        return "ring"
    if phrase is not None:
        return role(s, phrase)
    before = s.last_before(i, "road", "ramp", "ring", "place")
    if before is None or before.kind == "place" or (before.value.endswith("_or_arm") and any(s.said("place"))):
        return "main"
    who = role(s, before)
    if (
        who in ("ramp", "side", "ring")
        and not (is_close(s, before, i) or _is_subject(s, before, i))
        and "main" not in facts.speeds
    ):
        return "main"
    told = before.role or before.words.get("label") or (before.det == "another" and "main" in facts.speeds)
    if who == "side" and not told and not is_close(s, before, i):
        return "main"
    return who


def _is_subject(s: Sentence, phrase: Phrase, i: int) -> bool:
    """Whether the speed at i is the last of what the phrase is said to have: "both ramps have one lane and 60 km/h"."""
    return s.word(phrase.head + 1, "with") and not s.between(phrase.head, i, "comma", "stop", "verb", "road")


def _all(s: Sentence, phrase: Phrase) -> bool:
    near = s.tokens[max(0, phrase.first - 1) : phrase.head + 1]
    return any(t.text in ("all", "both", "each", "every") for t in near)
