"""How long the single road of a fork is, and its branches."""

from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._sentence import Sentence

_TWO = 2
_SINGLE = frozenset(("single", "common", "shared", "1", "joint"))


def read_fork_lengths(s: Sentence, facts: Facts) -> None:
    """Lengths of the single road and of the branches: "after 500 m it splits into two branches, each 300 m long"."""
    plain = [i for i in s.of_kind("length") if i not in s.used and i not in s.aside]
    if not facts.has("fork") or len(plain) not in (1, _TWO) or any(s.said("place")):
        return
    joining = facts.has("joining")
    branches, stems = [i for i in plain if _is_of_branches(s, i, joining)], [i for i in plain if _is_of_stem(s, i, joining)]
    if len(plain) == _TWO and len(branches) == 1:
        stems = [i for i in plain if i not in branches]
    elif len(plain) == _TWO and len(stems) == 1:
        branches = [i for i in plain if i not in stems]
    if len({*branches, *stems}) != len(plain) or len(branches) > 1:
        return
    for name, places in (("branch", branches), ("stem", stems)):
        for i in places:
            facts.lengths[name] = s.tokens[i].amount[0]
            s.use(i, i, f"{name} {s.tokens[i].text}")


def _is_of_branches(s: Sentence, i: int, joining: bool) -> bool:
    if joining and s.word(i + 1, "before"):
        return True
    near = s.tokens[max(0, i - 3) : i + 3]
    before = s.last_before(i, "road", "arm", "ramp")
    if before is not None and before.number == _TWO and not s.between(before.head, i, "comma", "stop", "verb"):
        return True  # "two one-way roads of 300 m join"
    return any(t.kind in ("each", "arm") or t.text in ("apiece", "both", "branch", "branches") for t in near)


def _is_of_stem(s: Sentence, i: int, joining: bool) -> bool:
    if joining:
        after = s.tokens[i + 1 : i + 2]
        return any(t.value == "after" or t.text in ("behind", "afterwards", "later") for t in after) or _is_of_single_road(s, i)
    before, after = s.tokens[max(0, i - 4) : i], s.tokens[i + 1 : i + 2]
    if _is_of_single_road(s, i):
        return True
    first = any(t.text in ("after", "first", "initial", "common", "stem") for t in before)
    return first or any(t.kind == "before" or t.text in ("before", "in") for t in after)


def _is_of_single_road(s: Sentence, i: int) -> bool:
    """Whether the length at i is said right behind the single road: "a single road of 500 m"."""
    road = s.last_before(i, "road", "arm", "ramp")
    return road is not None and road.head + _TWO == i and (road.number == 1 or bool(_SINGLE & set(road.text.split())))
