"""Vehicles that stand or drive one behind another."""

from drivegen.asked._said import Said, What
from drivegen.asked._tokens import Tags

_BUMPER = ("bumper to bumper", "nose to tail")
_RULES = (
    "(DRIVE|BE|STANDING|ADV|FOLLOW)* QUEUED (IN DET? ADV? QUEUE)?",
    "(DRIVE|BE|STANDING|ADV|FOLLOW)* (IN|AND) (DET|ADV|WORD)? QUEUE(?!OF)",
    "(DRIVE|BE|ADV)* DENSE",
    "WORD DET QUEUE(?!OF)",
    "QUEUE(?!OF|WITH)",
)


def queues(tags: Tags) -> list[Said]:
    """All such phrases."""
    found = []
    for rule in _RULES:
        for begin, end in tags.find(rule):
            if "DENSE" in rule and tags.tokens[end - 1].words not in _BUMPER:
                continue
            if rule == _RULES[-2] and not tags.words(begin, begin + 1).startswith(("form", "build")):
                continue
            if rule == _RULES[-1] and tags.tag(begin - 1) not in ("NP", "USED"):
                continue  # a verb: "three cars queue"
            while tags.tag(begin) == "STANDING" and not tags.tokens[begin].words.startswith("stand"):
                begin += 1
            found.append(Said(What.QUEUE, True, begin, end))
            tags.mark(begin, end)
    return found
