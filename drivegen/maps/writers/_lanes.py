"""How many lanes, of which road. Lanes count per direction unless the description says they are the total."""

from drivegen.errors import UnusableInput
from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._owners import arm_role, is_close, owner, role
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._quantities import Lanes
from drivegen.maps.writers._sentence import Sentence

_OWNERS = ("road", "ramp", "ring", "place", "arm")
_MOST = 8
_LEAST_TOTAL = 4


def read_lanes(s: Sentence, facts: Facts) -> None:
    """Fill in the lane numbers."""
    said = [item for item in s.lanes if item.first not in s.used]
    explicit = {item.count for item in said if item.per == "each"}
    doubled = {2 * count for count in explicit}
    in_all = any(_is_total(s, facts, item, owner(s, item.first, item.last, *_OWNERS)) for item in said)
    for item in said:
        phrase = owner(s, item.first, item.last, *_OWNERS)
        count = item.count
        if (
            in_all
            and item.inside
            and not item.per
            and count == _LEAST_TOTAL // 2
            and phrase is not None
            and phrase.kind == "road"
        ):
            item.per = "total"  # "a four-lane arterial and a two-lane street"
        _refuse_other_number(s, item, phrase, said)
        if item.per == "total" or _runs_both_ways(s, item, phrase) or _is_total(s, facts, item, phrase):
            count = max(1, count // 2) if count else 0
        elif item.per == "" and count not in explicit and count in doubled and _same_road(s, item, said) and not _of_ring(phrase):
            s.use(item.first, item.last, f"{_count(count // 2)} per direction")
            continue
        _give(s, facts, item, phrase, count)
    _read_elliptic(s, facts)


def _of_ring(phrase: Phrase | None) -> bool:
    return phrase is not None and (phrase.kind == "ring" or phrase.value == "roundabout")


def _refuse_other_number(s: Sentence, item: Lanes, phrase: Phrase | None, said: list[Lanes]) -> None:
    """Raise UnusableInput at "a one-lane motorway with five lanes in each direction"."""
    if not item.inside or item.per or item.value or phrase is None or phrase.kind != "road":
        return
    for other in said:
        same = (
            other.per == "each"
            and not other.value
            and other.first > item.last
            and owner(s, other.first, other.last, "road") is phrase
        )
        if same and not s.between(phrase.head, other.first, "verb") and item.count not in (other.count, 2 * other.count):
            raise UnusableInput(
                f"a road of {_count(item.count)} cannot have {_count(other.count)} per direction", reason="impossible-map"
            )


def _runs_both_ways(s: Sentence, item: Lanes, phrase: Phrase | None) -> bool:
    """Whether "two-lane, two-way road" counts both directions."""
    if item.per or item.value:
        return False
    if item.inside and phrase is not None and phrase.words.get("two_way"):
        return True
    after = [t.kind for t in s.tokens[item.last + 1 : item.last + 3]]
    return after[:1] == ["two_way"] or (after == ["comma", "two_way"])


def _is_total(s: Sentence, facts: Facts, item: Lanes, phrase: Phrase | None) -> bool:
    """Whether "six-lane boulevard" counts both directions, as roads are named; not where lanes or ramps come and go, of which
    one carriageway is spoken.
    """
    if item.per or item.value or not item.inside or item.count < _LEAST_TOTAL or item.count % 2 or phrase is None:
        return False
    halves = any(other.per == "each" and 2 * other.count == item.count for other in s.lanes)  # told apart by `read_lanes`
    changes = facts.has("lane_drop", "lane_gain", "lane_change", "fork") or any(s.verbs("merge"))
    along = any(s.said("ramp")) or any(s.said("weaving")) or any(s.said("extra")) or any(s.of_kind("keeps"))
    one_way = (
        any(True for _ in s.of_kind("one_way"))
        or any(s.said("road", "one_way"))
        or s.tokens[phrase.head].text.endswith("carriageway")
    )
    halves = (
        halves or s.word(phrase.head + 1, "each") or s.word(phrase.head + 2, "each")
    )  # "a four-lane motorway (per direction)"
    return phrase.kind == "road" and not (halves or changes or along or one_way)


def _same_road(s: Sentence, item: Lanes, said: list[Lanes]) -> bool:
    here = owner(s, item.first, item.last, *_OWNERS)
    halves = [other for other in said if other.per == "each" and 2 * other.count == item.count]
    return any(
        (there := owner(s, o.first, o.last, *_OWNERS)) is None or here is None or role(s, there) == role(s, here) for o in halves
    )


def _give(s: Sentence, facts: Facts, item: Lanes, phrase: Phrase | None, count: int) -> None:
    who = _role(s, facts, item, phrase)
    if who == "ramp" and phrase is not None:
        phrase.lanes = count
    if who and who not in facts.lanes:
        facts.lanes[who] = count
    elif not who:
        facts.other_lanes.append((item.first, count))
    where = f" on the {who}" if who in ("side", "ring", "ramp") else ""
    s.use(item.first, item.last, f"{_count(count)}{where} per direction" if not where else f"{_count(count)}{where}")


def _role(s: Sentence, facts: Facts, item: Lanes, phrase: Phrase | None) -> str:
    if item.value or item.per == "back":
        return item.value or "back"
    if _is_before_a_fork(s, item):
        return "main"
    if phrase is None:
        return ""
    if own := _role_of_arms(s, phrase):
        return own
    if item.per in ("arms", "all") and phrase.kind in ("place", "ring", "arm"):
        return "arms"
    if phrase.kind == "arm" and phrase.number in (None, 1) and s.tokens[phrase.head].text.startswith(("direction", "way")):
        return ""
    if phrase.kind == "arm":
        loose = item.per == "" and item.first > phrase.head and (s.word(item.first - 1, "comma") or s.word(item.first - 1, "and"))
        return "" if loose and any(s.said("place", "roundabout")) else "arms"
    if phrase.kind == "place":
        governed = s.governed(item.last) is phrase
        return "ring" if phrase.value == "roundabout" and (governed or phrase.first <= item.first <= phrase.head) else ""
    who = role(s, phrase) if not _is_aside(s, item, phrase) else ""
    inside = phrase.first <= item.first < phrase.head or s.governed(item.last) is phrase
    told = who == "ramp" and any(other.value == "main" for other in s.lanes)
    if who in ("ramp", "ring") and not (inside or told or is_close(s, phrase, item.first) or "main" in facts.lanes):
        return "main" if who == "ramp" else "arms" if item.per else ""
    return who


def _role_of_arms(s: Sentence, phrase: Phrase) -> str:
    """Whose arms the phrase names: of "the minor leg", "the north and south arms", or "single-lane entries", all."""
    if phrase.value.endswith("_or_arm") and any(s.said("place")):
        return "arms"
    return (phrase.role or arm_role(s, phrase)) if phrase.kind == "arm" else ""


def _is_aside(s: Sentence, item: Lanes, phrase: Phrase) -> bool:
    """Whether the road is only where something else stands, and the lanes are those of the next clause: "stop signs on the
    side streets; two lanes per direction".
    """
    behind = item.first > phrase.head and s.word(phrase.first - 1, "prep") and s.word(phrase.head + 1, "comma")
    return behind and item.first == phrase.head + 2 and role(s, phrase) == "side"


def _is_before_a_fork(s: Sentence, item: Lanes) -> bool:
    """Whether the lanes are those of "five lanes before the fork"."""
    return any(s.verbs("split")) and s.word(item.last + 1, "before") and not any(s.said("place"))


def _read_elliptic(s: Sentence, facts: Facts) -> None:
    """Numbers whose lanes were said before: "three lanes on the main road, two on the side road", "minor one"."""
    if not s.lanes:
        return
    taken = {i for item in s.lanes for i in range(item.first, item.last + 1)}
    for i in s.of_kind("number"):
        if i in taken or i in s.used or not 1 <= s.tokens[i].number <= _MOST:
            continue
        phrase = s.governed(i)
        if phrase is None and _ends_here(s, i):
            phrase = s.last_before(i, "road", "ramp", "ring", "place")
            phrase = phrase if phrase is not None and is_close(s, phrase, i) else None
        if phrase is None or phrase.kind not in _OWNERS:
            continue
        who = "ring" if phrase.kind == "place" and phrase.value == "roundabout" else role(s, phrase)
        if who and who not in facts.lanes:
            facts.lanes[who] = s.tokens[i].number
            if phrase.kind == "ramp":
                phrase.lanes = s.tokens[i].number
            s.use(i, i, f"{_count(s.tokens[i].number)} on the {who}")


def _ends_here(s: Sentence, i: int) -> bool:
    following = s.tokens[i + 1] if i + 1 < len(s.tokens) else None
    return following is None or following.kind in ("comma", "stop", "and", "each", "seq", "but")


def _count(lanes: int) -> str:
    return "1 lane" if lanes == 1 else f"{lanes} lanes"
