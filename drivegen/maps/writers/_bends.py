"""Bends that are told one by one, and a bend between two straights: "300 m of straight, a curve to the left, another 300 m"."""

from drivegen.maps.writers._facts import Facts
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._sentence import Sentence

_ELSE = ("place", "ramp", "weaving", "extra", "interchange")
_TWO = 2
_OTHER_CUES = ("radius", "diameter", "median", "spacing", "total", "speed", "lane")


def read_arcs(s: Sentence, facts: Facts) -> None:
    """Bends told one by one: "an arc of 90 degrees to the left with radius 50 m, followed by one of 70 degrees to the right"."""
    angles, turns = list(s.of_kind("angle")), [i for i in s.of_kind("turn") if i not in s.used]
    radii = [i for i in s.of_kind("length") if i not in s.used and _is_radius(s, i)]
    bent = any(s.said("shape", "curve", "s_curve"))
    if not bent or len(angles) < _TWO or len(turns) != len(angles) or len(radii) not in (0, 1, len(angles)):
        return
    if any(p.kind in _ELSE and not p.negated for p in s.phrases):
        return
    sizes = [s.tokens[i].amount[0] for i in radii] * (len(angles) if len(radii) == 1 else 1)
    for k, (i, turn) in enumerate(zip(angles, turns, strict=True)):
        angle = s.tokens[i].amount[0] * (1 if s.tokens[turn].value == "left" else -1)
        facts.arcs.append((angle, sizes[k] if sizes else None))
        s.use(i, i, f"bend {k + 1}: {abs(angle):g} degrees to the {s.tokens[turn].value}")
        s.use(turn, turn, "")
    for i in radii:
        s.use(i, i, f"radius {s.tokens[i].text}")


def _is_radius(s: Sentence, i: int) -> bool:
    before = s.tokens[max(0, i - 2) : i]
    return s.word(i + 1, "radius") or any(t.kind == "radius" for t in before)


def read_straights(s: Sentence, facts: Facts) -> None:
    """Lengths before and behind the only bend of a road."""
    bends = list(s.said("shape", "curve", "hairpin"))
    if not bends or any(p.kind in _ELSE and not p.negated for p in s.phrases) or any(s.said("shape", "s_curve")):
        return
    told_apart = sum(1 for _ in s.of_kind("angle")) > 1
    if facts.arcs or (told_apart and any(p.value == "curve" and _is_another(s, bends[0], p) for p in bends[1:])):
        return
    plain = [i for i in s.of_kind("length") if i not in s.used and i not in s.aside and not _measures_else(s, i)]
    if len(plain) != _TWO:
        return
    around = any(plain[0] < bend.head < plain[1] for bend in bends)
    if around or _is_told_before(s, plain[0]):
        for name, i in (("before", plain[0]), ("behind", plain[1])):
            facts.lengths[name] = s.tokens[i].amount[0]
            s.use(i, i, f"{s.tokens[i].text} {name} the bend")


def _is_told_before(s: Sentence, i: int) -> bool:
    """Whether the length at i lies before a bend that is named first: "a curve after 350 m of straight, then 350 m more"."""
    return any(t.text == "after" or t.kind == "before" for t in s.tokens[max(0, i - 3) : i])


def _is_another(s: Sentence, first: Phrase, bend: Phrase) -> bool:
    """Whether a second bend is spoken of, and not the first one again."""
    return s.between(first.head, bend.first, "seq", "and") and bend.det in ("a", "another")


def _measures_else(s: Sentence, i: int) -> bool:
    """Whether the length at i is a radius, a distance, or that of the whole road."""
    near = [*s.tokens[max(0, i - 3) : i][::-1], *s.tokens[i + 1 : i + 2]]
    for token in near[:3]:
        if token.kind in ("comma", "stop", "length", "shape") or token.text in ("after", "for"):
            break
        if token.kind in _OTHER_CUES:
            return True
    return any(t.kind in (*_OTHER_CUES, "long") for t in s.tokens[i + 1 : i + 2])
