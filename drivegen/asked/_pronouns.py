"""Whom "it" and "its" mean: the target, or somebody else beside whom nobody can be placed."""

from collections.abc import Sequence

from drivegen.asked._said import Role, Subject
from drivegen.asked._tokens import Tags

_PERSONS = ("us", "we", "me", "ourselves", "myself", "you")


def resolve(tags: Tags, subjects: Sequence[Subject]) -> None:
    """Tag every "it" that means the target as the target, and every such "its" as "our"."""
    for at, token in enumerate(tags.tokens):
        if tags.tag(at) not in ("IT", "ITS") or token.value == 2:
            continue
        if _means_target(tags, subjects, at):
            tags.mark(at, at + 1, "TARGET" if tags.tag(at) == "IT" else "OUR")


def _means_target(tags: Tags, subjects: Sequence[Subject], at: int) -> bool:
    """Whether the last mention before token `at`, its own subject left out, is the target."""
    groups = {subject.begin for subject in subjects if subject.role in (Role.GROUP, Role.NOBODY)}
    passed_subject = weak = False
    for i in range(at - 1, -1, -1):
        token = tags.tokens[i]
        if (token.tag == "TARGET" and token.words not in _PERSONS) or (token.tag == "OUR" and token.words not in ("our", "my")):
            if token.tag == "TARGET" and tags.tokens[i + 1].tag not in ("LANE", "PATH"):
                return True
            weak = True
        if i in groups:
            if passed_subject:
                return False
            passed_subject = True
    return weak
