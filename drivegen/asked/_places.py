"""Where vehicles are, as seen from the target."""

from drivegen.asked._said import BOTH, FROM_SIDE, Said, What
from drivegen.asked._tokens import USED, Tags
from drivegen.assets.where import Relation

_LANE = "(OUR (LANE|PATH)|DET (LANE|PATH) OF TARGET|TARGET (LANE|PATH)|DET? INLANE (AND TARGET)?)"
_ASIDE = (
    "(COME|GO|DRIVE|BE|OUT|FROM|MOVE)* FROM DET ORD? (SIDEROAD|ROAD) (IN|TO|FROM) (DET|OUR|ITS) SIDE HAND?",
    "(COME|GO|DRIVE|BE|OUT|MOVE)* FROM (DET|OUR|ITS)? SIDE HAND? SIDEROAD",
    "(COME|GO|MOVE) (ADV|BE|IN|UP|JUNCTION|ACROSS|OUR|PATH|OUT|DET|OVER)* "
    "FROM (DET|OUR|ITS)? SIDE HAND?(?!LANE) (TO (DET|OUR)? SIDE)? (OF TARGET)?",
    "(BE|ADV)* IN (DET|OUR) SIDEROAD (IN|TO|FROM) (DET|OUR|ITS) SIDE HAND?",
)
_ONCOMING = (
    "(COME|DRIVE|GO|BE|MOVE|ADV)* (COME|DRIVE|GO|MOVE) ADV* TOWARDS TARGET",
    "(COME|DRIVE|GO|BE|MOVE|REL)* ONCOMING",
    "(COME|GO) IN TARGET",
    "TOWARDS TARGET",
)
_SIDES = (
    "(DRIVE|BE)* (IN|TO|INTO|FROM)? DET LANE (IN|TO) (DET|OUR|ITS)? SIDE HAND? (OF TARGET)?",
    "(DRIVE|BE)* (NUM|DET) LANE TO (DET|OUR|ITS) SIDE HAND? (OF TARGET)?",
    "(DRIVE|BE)* (IN|TO|INTO) (DET|OUR|ITS)? SIDE HAND? LANE? (OF TARGET)?",
    "SIDE (HAND|OF)* (OF? TARGET|AWAY)",
    "DET? SIDE HAND? LANE",
    "SIDE (?=AHEAD|BEHIND|BESIDE)",
    "SIDE (?=COMMA|DOT|AND|WITH|$)",
)
_ON = "(IN|TO)? (DET|OUR|ITS)? SIDE HAND? LANE?"
_NEEDS_OBJECT = ("of", "before")


def places(tags: Tags) -> list[Said]:
    """All places; those beside somebody else than the target are left alone."""
    found = [*_corners(tags), *_of_target(tags), *_follows(tags), *_here(tags), *_aside(tags)]
    for rule in _ONCOMING:
        found += [_said(tags, What.ALONG, Relation.ONCOMING, begin, end) for begin, end in tags.find(rule)]
    return [*found, *_from(tags), *_abreast(tags), *_sides(tags), *_along(tags)]


def _aside(tags: Tags) -> list[Said]:
    """On another road, which comes from one side."""
    spans = (span for rule in _ASIDE for span in tags.find(rule))
    return [_said(tags, What.FROM, FROM_SIDE[str(tags.value(begin, end, "SIDE"))], begin, end) for begin, end in spans]


def _from(tags: Tags) -> list[Said]:
    """ "From the right": out of a lane or a road; what is done says which."""
    found = []
    for begin, end in tags.find("(BE|DRIVE|ADV)* FROM (DET|OUR|ITS)? SIDE HAND? LANE? (OF TARGET)?"):
        side = str(tags.value(begin, end, "SIDE"))
        lane = any(tags.tag(i) == "LANE" for i in range(begin, end))
        found.append(_said(tags, What.SIDE, side if lane else f"from {side}", begin, end))
    return found


def _corners(tags: Tags) -> list[Said]:
    """ "Front left", "rear right"."""
    found = []
    corners = "((AHEAD|BEHIND|LEADING) SIDE HAND?(?!LANE|TURN)|SIDE LEADING(?!KIND|WORD))"
    for begin, end in tags.find(f"(DRIVE|BE|ADV)* (IN|TO)? DET? {corners} (OF? TARGET)?"):
        behind = tags.value(begin, end, "BEHIND") is not None or tags.value(begin, end, "LEADING") is Relation.BEHIND
        found.append(_said(tags, What.ALONG, Relation.BEHIND if behind else Relation.AHEAD, begin, end))
        found.append(Said(What.SIDE, tags.value(begin, end, "SIDE"), begin, end))
    return found


def _sides(tags: Tags) -> list[Said]:
    found = []
    for begin, end in tags.find("(DRIVE|BE)* IN REL LANE"):
        before = [token.value for token in tags.tokens[:begin] if token.tag == "SIDE"]
        if before:
            found.append(_said(tags, What.SIDE, before[-1], begin, end))
    for begin, end in tags.find(f"(DRIVE|BE)* (EITHERSIDE|{_ON} AND {_ON}) (OF? TARGET)?"):
        sides = {token.value for token in tags.tokens[begin:end] if token.tag == "SIDE"}
        if sides == {"left"} or sides == {"right"}:
            continue
        found.append(_said(tags, What.SIDE, BOTH, begin, end))
    for begin, end in (span for rule in _SIDES for span in tags.find(rule)):
        after = tags.tag(end)
        if after in ("OF", "SIDEROAD", "TURN", "JUNCTION") or tags.value(begin, end, "NUM") not in (None, 1.0):
            continue
        if (tags.tag(begin - 2), tags.tag(begin - 1)) == ("NUM", "LANE"):
            continue  # "two lanes to the left"
        alone = end == begin + 1 and after not in ("AHEAD", "BEHIND", "BESIDE")
        if alone and tags.tag(begin - 1) not in ("NP", USED):
            continue  # "one left, one right", but no other lone word
        found.append(_said(tags, What.SIDE, tags.value(begin, end, "SIDE"), begin, end))
    return found


def _said(tags: Tags, what: What, value: object, begin: int, end: int, *, forward: bool = False) -> Said:
    tags.mark(begin, end)
    return Said(what, value, begin, end, forward)


def _of_target(tags: Tags) -> list[Said]:
    """ "The ego is behind a truck", "the truck that we are following"."""
    found = []
    for begin, end in tags.find("(EGO|TARGET) (BE|DRIVE|ADV|USED)* (FOLLOW|LEADING|BEHIND|AHEAD) BEHIND?(?= NP)"):
        words = tags.words(begin, end)
        ahead = tags.tag(end - 1) == "AHEAD" or "lead" in words
        found.append(_said(tags, What.ALONG, Relation.BEHIND if ahead else Relation.AHEAD, begin, end, forward=True))
    for begin, end in tags.find("NP USED* REL? (EGO|TARGET) (BE|ADV|DRIVE)* (FOLLOW|LEADING|BEHIND)(?!TARGET)"):
        start = next(i for i in range(begin, end) if tags.tag(i) not in ("NP", "USED"))
        found.append(_said(tags, What.ALONG, Relation.AHEAD, start, end))
    for begin, end in tags.find("(EGO|TARGET) USED* (BE|ADV|REL)* (FOLLOW|PRECEDE|LEADING) BY (?= NP)"):
        ahead = any(tags.tag(i) == "PRECEDE" for i in range(begin, end))
        start = begin if tags.tag(begin + 1) != USED else end - 2  # what the target is was said before
        found.append(_said(tags, What.ALONG, Relation.AHEAD if ahead else Relation.BEHIND, start, end, forward=True))
    return found


def _follows(tags: Tags) -> list[Said]:
    found = []
    for begin, end in tags.find("(BE|REL|ADV)* (FOLLOW|LEADING|PRECEDE|COME) ADV* BEHIND? (TARGET|BEHIND TARGET?) ADV*"):
        if tags.tag(end) == "NP":
            continue
        led = [token for token in tags.tokens[begin:end] if token.tag in ("LEADING", "PRECEDE")]
        ahead = bool(led) and (led[0].tag == "PRECEDE" or led[0].value is Relation.AHEAD)
        if tags.tag(begin) == "COME" and not any(tags.tag(i) == "BEHIND" for i in range(begin, end)):
            continue
        found.append(_said(tags, What.ALONG, Relation.AHEAD if ahead else Relation.BEHIND, begin, end))
    for begin, end in tags.find("(BE|ADV)* FOLLOW ADV* BEHIND?(?!BY|NP|DET|NUM)"):
        found.append(_said(tags, What.ALONG, Relation.BEHIND, begin, end))
    for begin, end in tags.find("(BE|ADV)* LEADING(?!KIND|NP|DET|NUM|TARGET|WORD|EGO)"):
        found.append(_said(tags, What.ALONG, tags.value(begin, end, "LEADING"), begin, end))
    return found


def _here(tags: Tags) -> list[Said]:
    """In the target's lane; who blocks it is ahead."""
    found = []
    for begin, end in tags.find(f"(BE|REL)* BLOCK ({_LANE}|TARGET|DET (LANE|ROAD|PATH)|OUR LANE)"):
        ours = any(tags.tag(i) in ("OUR", "TARGET", "INLANE") for i in range(begin, end))
        found.append(_said(tags, What.ALONG if ours else What.HERE, Relation.AHEAD if ours else "blocked", begin, end))
    for begin, end in tags.find(f"(DRIVE|BE)* IN {_LANE}"):
        found.append(_said(tags, What.HERE, "our lane", begin, end))
    return found


def _abreast(tags: Tags) -> list[Said]:
    found = []
    for begin, end in tags.find("(DRIVE|BE|ADV)* BESIDE TARGET? (IN? (DET|OUR|ITS)? SIDE HAND? LANE?)?"):
        if tags.tag(end) == "NP":
            continue
        side = tags.value(begin, end, "SIDE")
        found.append(_said(tags, What.SIDE if side else What.ABREAST, side or "left", begin, end))
    return found


def _along(tags: Tags) -> list[Said]:
    found = []
    for begin, end in tags.find(
        f"(DIAGONAL|BE|DRIVE|ADV|AWAY|COME|IN|DET)* (AHEAD|BEHIND) (OF? TARGET|{_LANE}|(IN|BY) {_LANE})? (AND? DIAGONAL)?"
    ):
        at = next(i for i in range(begin, end) if tags.tag(i) in ("AHEAD", "BEHIND"))
        while tags.tag(begin) in ("IN", "DET", "AWAY", "COME") and tags.tag(begin + 1) not in ("AHEAD", "BEHIND"):
            begin += 1
        words, bare = tags.tokens[at].words, end == at + 1
        if bare and _beside_others(tags, words, end):
            continue
        if words == "back" and tags.tag(at - 1) != "USED":
            continue  # "drops back"
        value = Relation.AHEAD if tags.tag(at) == "AHEAD" else Relation.BEHIND
        found.append(_said(tags, What.ALONG, value, begin, end))
    return found


def _beside_others(tags: Tags, words: str, end: int) -> bool:
    """Whether somebody else than the target is meant: "ahead of the bus", "behind a truck", "behind it", "behind that a car"."""
    following = tags.tag(end)
    if (
        words.endswith(_NEEDS_OBJECT)
        or following == "IT"
        or (following == "REL" and tags.tag(end + 1) in ("NP", "COMMA", "BE", "DET"))
    ):
        return True
    return words.startswith("behind") and following in ("NP", "NOBODY", "ROAD", "JUNCTION")
