"""Side streets and dead ends along a road: how many, on which side, where."""

from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._places_along import listed_places
from drivegen.maps.writers._sentence import Sentence

_NEAR = 6


def read_dead_ends(s: Sentence, facts: Facts) -> None:
    """Dead ends that lie beside a road or along it."""
    _read_leaving_dead_ends(s, facts)
    _read_dead_ends(s, facts)


def read_listed_places(s: Sentence, facts: Facts) -> None:
    """Where side streets that were counted lie: "three side streets, at 100 m, 200 m and 350 m"."""
    for phrase in (*s.said("road"), *s.said("dead_end")):
        if facts.side_streets > 1 and phrase.number == facts.side_streets and not facts.side_places:
            facts.side_places = [(facts.turn or _turn_behind(s, phrase), metres) for metres in listed_places(s, phrase)]


def read_side_roads(s: Sentence, facts: Facts) -> None:
    """Side streets along a road."""
    for phrase in s.denied("road"):
        if phrase.role == "side":
            s.use(phrase.first, phrase.head, "no side streets")
    _read_single_side_roads(s, facts)
    counts = [p for p in s.said("road") if p.role == "side" and p.number and p.head not in s.used]
    for phrase in counts:
        count = phrase.number or 0
        if count >= 2 and not facts.has("staggered") and not any(j.count > 1 for j in facts.junctions):
            facts.side_streets = count
            facts.features.setdefault("side_streets", phrase.first)
            crossing = any(t.text.startswith("cross") for t in s.tokens[phrase.first : phrase.head + 1])
            facts.features.update({"cross_streets": phrase.first} if crossing else {})
        elif count == 1 and not facts.junctions:
            facts.side_streets = 1
            facts.features.setdefault("side_streets", phrase.first)
        s.use(phrase.first, phrase.head, f"{count} side street{'s' if count > 1 else ''}")


def _read_single_side_roads(s: Sentence, facts: Facts) -> None:
    """Side streets told one by one or by their places: "a side street on the left at 100 m and another on the right at 150 m"."""
    own = [p for p in s.said("road") if p.role == "side" and p.number in (None, 1) and p.det != "the" and p.head not in s.used]
    own = [p for p in own if s.tokens[p.head].kind == "road" or p.det == "another"]
    joined = own and any(s.word(own[0].first - 1, kind) for kind in ("with", "and", "comma"))
    if not own or not (len(own) > 1 or joined) or not _lie_along_a_road(s, facts):
        return
    if len(own) == 1 and own[0].number is None and s.tokens[own[0].head].text.endswith("s"):
        facts.side_places = [(_turn_behind(s, own[0]), metres) for metres in listed_places(s, own[0])]
        own = own * len(facts.side_places)  # none where nobody says how many
    else:
        for phrase, end in zip(own, [*(p.first for p in own[1:]), len(s.tokens)], strict=True):
            turn = next((s.tokens[i].value for i in range(phrase.first, end) if s.tokens[i].kind == "turn"), "")
            facts.side_places.append((turn, phrase.position))
    for phrase in own:
        facts.side_streets = len(own)
        facts.features.setdefault("side_streets", phrase.first)
        s.use(phrase.first, phrase.head, "side street")


def _lie_along_a_road(s: Sentence, facts: Facts) -> bool:
    """Whether there is a road for side streets to join, and nothing else that says how they do."""
    road = any(p.role in ("", "main") for p in s.said("road")) or any(s.said("shape"))
    told = facts.junctions or facts.side_streets or facts.events or facts.has("staggered", "grid")
    elsewhere = any(s.verbs("meet", "cross", "split", "merge")) or any(s.said("ramp")) or any(s.said("interchange"))
    return road and not told and not elsewhere


def _turn_behind(s: Sentence, phrase: Phrase) -> str:
    """The side that is told behind side streets: "two side streets to the left"."""
    return next((s.tokens[i].value for i in s.of_kind("turn") if phrase.head < i <= phrase.head + _NEAR), "")


def _read_leaving_dead_ends(s: Sentence, facts: Facts) -> None:
    """Dead ends beside a road: "a cul-de-sac leaving a residential road", "a road from which a dead end leaves"."""
    for phrase in s.said("dead_end"):
        after, before = s.next_after(phrase.head + 1, "road"), s.last_before(phrase.first, "road")
        leaves = after is not None and after.first - phrase.head <= _NEAR and _leads_off(s, phrase.head + 1, after.first)
        is_left = before is not None and any(t.kind in ("that", "prep", "with") for t in s.tokens[before.head + 1 : phrase.first])
        end = next((i for i in range(phrase.head + 1, len(s.tokens)) if s.tokens[i].kind in ("comma", "stop")), len(s.tokens))
        is_left = is_left and _leads_off(s, phrase.head + 1, end)
        if (leaves or is_left) and not (facts.junctions or facts.side_streets or facts.has("staggered", "grid")):
            facts.side_streets = phrase.number or 1
            facts.features.setdefault("side_streets", phrase.first)
            s.use(phrase.head, phrase.head, "dead end beside a road")


def _leads_off(s: Sentence, first: int, last: int) -> bool:
    """Whether tokens first to last lead from a dead end to the road it leaves."""
    words = s.tokens[first:last]
    return any(
        t.value in ("leave", "join")
        or t.text in ("turning", "turns", "beside", "side", "attached", "accessed", "reached", "reachable")
        for t in words
        if t.kind in ("verb", "unknown", "small", "role", "ramp", "shape") or t.text.endswith("side")
    )


def _read_dead_ends(s: Sentence, facts: Facts) -> None:
    """Dead ends along a road: "a street with two culs-de-sac"."""
    for phrase in s.said("dead_end"):
        road = s.last_before(phrase.first, "road") or s.next_after(phrase.head, "road")
        along = road is not None and (
            s.between(road.head, phrase.first, "with") or s.between(phrase.head, road.first, "prep", "verb")
        )
        named = phrase.text.split()[-1] not in ("circle", "head", "loop", "place", "bulb", "area", "end")  # no turning places
        if not named or road is None or facts.junctions or facts.has("staggered", "grid") or not along:
            continue
        if (phrase.number or 0) >= 2 or _is_beside(s, road, phrase):
            facts.side_streets = phrase.number or 1
            facts.features.setdefault("side_streets", phrase.first)
            s.use(phrase.first, phrase.head, f"{facts.side_streets} dead ends along a road")


def _is_beside(s: Sentence, road: Phrase, dead_end: Phrase) -> bool:
    """Whether the road has the dead end: "a street with a cul-de-sac", "street with cul-de-sac on the left"."""
    told = dead_end.det == "a" or dead_end.number == 1 or s.word(dead_end.head + 1, "turn")
    return told and s.word(road.head + 1, "with") and road.head + 2 == dead_end.first
