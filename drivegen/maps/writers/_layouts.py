"""Whole layouts: street grids, and interchanges of a highway with a road over it."""

from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._quadrants import read_quadrants
from drivegen.maps.writers._sentence import Sentence

_LEAST_STREETS = 2
_ARMS = 4


def read_grid(s: Sentence, facts: Facts) -> None:
    """A grid, its size by "3 x 4" or by counted streets in two directions, and its crossings, which are no others."""
    for phrase in s.denied("place", "grid"):
        s.use(phrase.first, phrase.head, "no grid")
    grids = [p for p in s.said("place", "grid") if not _measures_a_row(s, p)]
    for i in s.of_kind("size"):
        if grids or any(t.kind in ("road", "place") and t.text.endswith("s") for t in s.tokens[i + 1 : i + 3]):
            _take_size(s, facts, i)
        elif s.word(i + 1, "place"):
            s.use(i, i, "")  # "a 4x4 intersection" is one of two roads with that many lanes in all
    _read_two_directions(s, facts)
    if not (grids or facts.grid):
        return
    facts.features["grid"] = grids[0].first if grids else 0
    for phrase in grids:
        s.use(phrase.first, phrase.head, "street grid")
    _count_streets(s, facts)
    for phrase in s.said("place", "crossing"):
        control = phrase.words.get("control")
        if control and control != "unsignalled" and facts.control is None:
            facts.control = control  # type: ignore[assignment]
        s.use(phrase.first, phrase.head, "")


def _measures_a_row(s: Sentence, phrase: Phrase) -> bool:
    """Whether the "blocks" are those between streets that cross a road: "crossed by three streets, 150 m blocks"."""
    return phrase.text == "blocks" and s.word(phrase.head - 1, "length") and any(True for _ in s.verbs("cross"))


def _read_two_directions(s: Sentence, facts: Facts) -> None:
    """Streets counted by direction: "four north-south by four east-west streets"."""
    counted = [(number, i) for i in s.of_kind("label") if (number := _count_of(s, i)) is not None]
    if facts.grid is None and len(counted) == 2 and s.tokens[counted[0][1]].value != s.tokens[counted[1][1]].value:
        facts.grid = (s.tokens[counted[0][0]].number, s.tokens[counted[1][0]].number)
        last = counted[1][1] + 1 if s.word(counted[1][1] + 1, "road") else counted[1][1]
        s.use(counted[0][0], last, f"grid of {facts.grid[0]} x {facts.grid[1]} streets")


def _count_of(s: Sentence, label: int) -> int | None:
    """Where the number of the streets of a direction stands: "four north-south", "4 streets running north-south"."""
    i = label - 1
    while i > label - 4 and i > 0 and s.tokens[i].kind in ("road", "that", "unknown", "is", "prep"):
        i -= 1
    return i if s.word(i, "number") and s.tokens[i].number >= _LEAST_STREETS else None


def _take_size(s: Sentence, facts: Facts, i: int) -> None:
    more = int(s.word(i + 1, "place") and s.tokens[i + 1].text.startswith("block"))  # streets on every side of a block
    facts.grid = (int(s.tokens[i].amount[0]) + more, int(s.tokens[i].amount[1]) + more)
    s.use(i, i, f"grid of {facts.grid[0]} x {facts.grid[1]} streets")
    for j in range(i + 1, min(i + 3, len(s.tokens))):
        if s.tokens[j].kind in ("road", "place") and s.tokens[j].value != "roundabout":
            s.use(j, j, "")


def _count_streets(s: Sentence, facts: Facts) -> None:
    for i in s.of_kind("arm"):
        if s.word(i - 1, "number") and s.tokens[i - 1].number == _ARMS:
            s.use(i - 1, i, "crossings of four arms")
    counted = [p for p in s.said("road") if (p.number or 0) >= _LEAST_STREETS and p.first not in s.used]
    if facts.grid is None and len(counted) == 2:
        facts.grid = (counted[0].number or 0, counted[1].number or 0)
        for phrase in counted:
            s.use(phrase.first, phrase.head, f"{phrase.number} streets")


def read_interchange(s: Sentence, facts: Facts) -> None:
    """Interchange parts: a highway over another road, with ramps between them."""
    for phrase in s.denied("interchange"):
        s.use(phrase.first, phrase.head, "no interchange")
    said = [p for p in s.said("interchange") if p.value] or list(s.said("interchange"))
    fast = any(p.words.get("class") == "highway" for p in s.said("road"))
    ramps = list(s.said("ramp"))
    over = [i for i in s.of_kind("over") if not s.negated_at(i)]
    if form := read_quadrants(s, facts, said[0].value if said else ""):
        facts.interchange = form
    elif said:
        facts.interchange = said[0].value or ("diamond" if over else "unknown")
    elif over and fast and ramps:
        facts.interchange = "diamond"
    elif fast and ramps and _ramp_ends_at_crossing(s, ramps):
        facts.interchange = "terminal"
    if facts.interchange == "half_diamond" and _on_one_carriageway(s, ramps):
        facts.interchange = "side"
    for phrase in said:
        s.use(phrase.first, phrase.head, f"{facts.interchange.replace('_', ' ')} interchange")
    for i in over if facts.interchange else ():
        s.use(i, i, "over or under another road, without a crossing")


def _on_one_carriageway(s: Sentence, ramps: list[Phrase]) -> bool:
    """Whether both ramps of half a diamond are said of one carriageway: an exit and, beyond the bridge, an entry to "it"."""
    kinds = {p.value.split("_")[0] for p in ramps}
    sides = {t.text for t in s.tokens if t.kind == "bound"}
    return kinds >= {"on", "off"} and len(sides) == 1


def _ramp_ends_at_crossing(s: Sentence, ramps: list[Phrase]) -> bool:
    """ "The exit ramp ends at a signalised crossing"."""
    for i in s.verbs("end_at", "end", "join", "meet"):
        place = s.next_after(i, "place")
        if any(p.head < i for p in ramps) and place is not None and place.value in ("crossing", "t", "roundabout"):
            return True
    return False
