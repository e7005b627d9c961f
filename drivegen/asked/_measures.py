"""Numbers with units, and how dense the traffic is."""

from typing import cast

from drivegen.asked._said import Role, Said, Subject, What
from drivegen.asked._tokens import Tags
from drivegen.asked.request import Density

_NO_DISTANCES = ("long", "wide", "tall", "high", "apart", "radius", "diameter", "between", "further", "farther", "beyond", "past")
_BOUNDARIES = ("", "COMMA", "DOT", "AND", "WITH", "BE", "ADV", "IN", "WITHIN", "APPROX")
_STRICT = (
    "dense",
    "densely",
    "congested",
    "jammed",
    "gridlocked",
    "crowded",
    "sparse",
    "packed",
    "very dense",
    "very sparse",
    "medium density",
    "moderately busy",
    "moderately dense",
    "high density",
    "low density",
)


def measures(tags: Tags) -> list[Said]:
    """Times, speeds and distances."""
    return [*_times(tags), *_speeds(tags), *_distances(tags)]


def _times(tags: Tags) -> list[Said]:
    found = []
    for begin, end in tags.find("(WITHIN|IN|BY) (DET|APPROX|ORD)* NUM SECOND"):
        if tags.tag(begin) == "IN" and tags.words(begin, begin + 1) not in ("in", "within"):
            continue
        found.append(Said(What.WITHIN, tags.value(begin, end, "NUM"), begin, end))
        tags.mark(begin, end)
    return found


def _speeds(tags: Tags) -> list[Said]:
    found = []
    for begin, end in tags.find("(IN|WITH|BY)? APPROX* NUM SPEEDUNIT"):
        span = tags.words(max(begin - 3, 0), begin)
        if _range_before(tags, end - 2) or "limit" in span or tags.tag(end) in ("ROAD", "JUNCTION"):
            continue
        value = cast(float, tags.value(begin, end, "NUM")) * cast(float, tags.value(begin, end, "SPEEDUNIT"))
        found.append(Said(What.SPEED, value, begin, end))
        tags.mark(begin, end)
    return found


def _distances(tags: Tags) -> list[Said]:
    found = []
    for begin, end in tags.find("(IN|WITH|BY)? (APPROX|DET)* NUM METRE (AWAY|OFF|OUT)?"):
        if _range_before(tags, tags_index(tags, begin, "NUM")) or tags.words(end, end + 1) in _NO_DISTANCES:
            continue
        value = round(cast(float, tags.value(begin, end, "NUM")) * cast(float, tags.value(begin, end, "METRE")), 2)
        found.append(Said(What.DISTANCE, value, begin, end))
        tags.mark(begin, end)
    return found


def tags_index(tags: Tags, begin: int, tag: str) -> int:
    """The first token from `begin` on that has the tag."""
    while tags.tag(begin) not in (tag, ""):
        begin += 1
    return begin


def _range_before(tags: Tags, number: int) -> bool:
    """Whether the number ends a range: "30 to 50"."""
    return tags.tag(number - 2) == "NUM" and (
        tags.tag(number - 1) in ("TO", "AND", "USED") or tags.words(number - 1, number) in "-–"
    )


_DENSITIES = (
    "(ADV|APPROX)* (HEAVY|LIGHT|DENSE|SOME) DENSITY? OF? TRAFFIC",
    "TRAFFIC (IN ROAD)? (BE|ADV|DRIVE|APPROX)* (HEAVY|LIGHT|DENSE)(?!KIND|ROAD)",
    "DENSITY BE? (HEAVY|LIGHT|DENSE)",
    "DENSE DENSITY",
    "(DET|HEAVY)? JAM",
    "ADV* DENSE",
)


def densities(tags: Tags) -> tuple[list[tuple[Density, int, int]], list[Subject]]:
    """Each density with its tokens, and the traffic as a subject: what is said of it is said of everybody."""
    found, subjects = [], []
    for rule in _DENSITIES:
        for begin, end in tags.find(rule):
            density = _density(tags, begin, end)
            if density is None or (rule == _DENSITIES[-1] and not _alone(tags, begin, end)):
                continue
            if tags.tag(begin - 1) == "NOT" or tags.tag(begin - 2) == "NOT":
                continue
            found.append((density, begin, end))
            subjects.append(Subject(Role.ALL, begin, end))
            tags.mark(begin, end, "ALL" if rule != _DENSITIES[-1] else "USED")
            if rule == _DENSITIES[-1]:
                subjects.pop()
    return found, subjects


def _density(tags: Tags, begin: int, end: int) -> Density | None:
    if tags.value(begin, end, "SOME") is not None:
        return Density.DENSE if tags.value(begin, end, "SOME") == 10 else None  # "a lot of traffic", not "some"
    said = tags.value(begin, end, "DENSE") or tags.value(begin, end, "JAM")
    if said is not None:
        return cast(Density, said)
    return Density.DENSE if tags.value(begin, end, "HEAVY") is not None else Density.SPARSE


def _alone(tags: Tags, begin: int, end: int) -> bool:
    """Whether a density stands in a clause of its own: "ten cars, dense, 40 km/h"."""
    strict = any(token.words in _STRICT for token in tags.tokens[begin:end])
    return strict and tags.tag(begin - 1) in _BOUNDARIES and tags.tag(end) in _BOUNDARIES
