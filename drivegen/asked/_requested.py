"""The typed request out of subjects and what is said of them, with an account of every word that was understood."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeVar

from pydantic import ValidationError

from drivegen.asked._clauses import apart
from drivegen.asked._groups import fields, settled
from drivegen.asked._said import ACROSS, Role, Subject, What
from drivegen.asked._tokens import Tags, Token
from drivegen.asked.request import Density, Group, Kind, Manoeuvre, TrafficRequest
from drivegen.errors import UnusableInput

_Model = TypeVar("_Model", Group, TrafficRequest)
_FILLERS = {"DET", "BE", "AND", "WITH", "REL", "IN", "OF", "APPROX", "DRIVE", "OUR", "ITS", "COME", "HAND", "TO", "FROM", "ADV",
            "AWAY", "MAKE", "FURTHER", "BY", "HARD", "IT", "AROUND", "TARGET", "EGO", "NUMBER", "AHEAD", "MANOEUVRE"}  # fmt: skip
_SILENT = {
    "there",
    "moving",
    "driving",
    "travelling",
    "going",
    "coming",
    "waiting",
    "approaching",
    "suddenly",
    "please",
    "otherwise",
}
"""Words that add nothing to what is understood on both sides of them."""

_KEPT = {"fast", "slowly", "aggressively", "recklessly", "tightly", "quickly", "swiftly", "rapidly"}


@dataclass(frozen=True)
class Outcome:
    """What was asked for, what was understood as what, and the spans of the text that were."""

    request: TrafficRequest
    notes: tuple[tuple[str, str], ...]
    spans: tuple[tuple[int, int], ...]

    def rest(self, text: str) -> str:
        """The text without what was understood."""
        letters = list(text)
        for begin, end in self.spans:
            letters[begin:end] = " " * (end - begin)
        left = re.sub(r"(?:\s*,)+", " ,", re.sub(r"\s+", " ", "".join(letters)))
        return re.sub(r"[ ,.]*\.(?=[ ,.]*\.)", "", left).strip(" ,.")


def requested(
    tags: Tags, subjects: Sequence[Subject], densities: Sequence[tuple[Density, int, int]], kinds: Sequence[tuple[Kind, int, int]]
) -> Outcome:
    """The request that all subjects make together. Raises UnusableInput, reason `impossible-traffic`."""
    account = _Account(tags)
    groups = settled(subjects)
    told = [fields(group) for group in groups]
    overall = _speeds(tags, subjects, groups, told)
    target = _target(subjects, account)
    for density, begin, end in densities:
        if density is densities[0][0]:
            account.take(range(begin, end), f"{density.value} traffic")
    for kind, begin, end in kinds:
        account.take(range(begin, end), f"the target is a {kind.value}")
        target.setdefault("target_kind", kind)
    for group, said in zip(groups, told, strict=True):
        account.group(group, said)
    for subject in subjects:
        if subject.role is Role.ALL and subject.heard:
            account.take(subject.own, "")
            account.heard(subject)
    account.fillers()
    speed = {"speed": overall} if "speed" not in target else {}
    request = _build(TrafficRequest, groups=tuple(_build(Group, **said) for said in told),
                     density=densities[0][0] if densities else None, **speed, **target)  # fmt: skip
    return Outcome(request, tuple(account.notes), tuple((t.begin, t.end) for t in account.understood()))


def _speeds(tags: Tags, subjects: Sequence[Subject], groups: Sequence[Subject], told: Sequence[dict[str, Any]]) -> float | None:
    """Everybody's speed; groups that have their own get it. One of vehicles that nothing tells apart is everybody's."""
    everybody = next((s.value(What.SPEED) for s in subjects if s.role is Role.ALL and s.value(What.SPEED) is not None), None)
    several = sum(group.value(What.SPEED) is not None for group in groups) > 1
    for number, (group, said) in enumerate(zip(groups, told, strict=True)):
        speed = group.value(What.SPEED)
        last = number == len(groups) - 1
        listed = last and (group.count > 1 or (tags.tag(group.begin - 1) == "AND" and len(groups) > 1))
        if speed is None:
            continue
        if apart(group) or several or not listed or everybody is not None:
            said["speed"] = speed
        else:
            everybody = speed
    return everybody


def _target(subjects: Sequence[Subject], account: "_Account") -> dict[str, Any]:
    """What the target is and does."""
    found: dict[str, Any] = {}
    for subject in subjects:
        if subject.role is not Role.TARGET:
            continue
        subject.forget(What.WITHIN)
        does = subject.value(What.MANOEUVRE)
        if does is Manoeuvre.TURN_LEFT_ACROSS:
            does = Manoeuvre.TURN_LEFT
        if does == ACROSS or ("target_does" in found and found["target_does"] is not does):
            subject.forget(What.MANOEUVRE)
            does = None
        if does is not None:
            found["target_does"] = does
        if subject.value(What.SPEED) is not None:
            found["speed"] = subject.value(What.SPEED)
        if subject.heard:
            if subject.kind is not Kind.VEHICLE:
                found["target_kind"] = subject.kind
            account.take(subject.own, "the target")
            account.heard(subject)
    return found


class _Account:
    """Which tokens are understood, and as what."""

    def __init__(self, tags: Tags) -> None:
        self.tags = tags
        self.notes: list[tuple[str, str]] = []
        self._taken: set[int] = set()

    def take(self, tokens: Sequence[int], meaning: str) -> None:
        """Tokens are understood; an empty meaning notes nothing."""
        words = " ".join(self.tags.tokens[i].words for i in tokens)
        self._taken.update(tokens)
        if meaning and words:
            self.notes.append((words, meaning))

    def heard(self, subject: Subject) -> None:
        """All that is said of a subject."""
        for said in subject.heard:
            if said.end > said.begin:
                self.take(range(said.begin, said.end), _meaning(said.what, said.value))

    def group(self, group: Subject, said: dict[str, Any]) -> None:
        """A group with its number and kind."""
        count, kind = said["count"], said["kind"].value
        self.take(group.own, f"{count} {kind}{'' if count == 1 else 'es' if kind == 'bus' else 's'}")
        for inner in group.heard:
            inside = group.begin <= inner.begin < group.end
            self.take(
                [i for i in range(inner.begin, inner.end) if not inside or i in group.own], _meaning(inner.what, inner.value)
            )

    def understood(self) -> list[Token]:
        """The tokens that are."""
        return [self.tags.tokens[i] for i in sorted(self._taken)]

    def fillers(self) -> None:
        """Words that add nothing, between what is understood and the ends of its clause."""
        tokens = self.tags.tokens
        cuts = [-1, *(i for i, token in enumerate(tokens) if token.tag in ("COMMA", "DOT")), len(tokens)]
        for before, after in pairwise(cuts):
            if not any(i in self._taken for i in range(before + 1, after)):
                continue
            run: list[int] = []
            for i in range(before + 1, after + 1):
                if i < after and i not in self._taken:
                    run.append(i)
                    continue
                if all(self._adds_nothing(tokens[j]) for j in run):
                    self._taken.update(run)
                run = []

    @staticmethod
    def _adds_nothing(token: Token) -> bool:
        return (token.tag in _FILLERS or token.words in _SILENT) and token.words not in _KEPT


def _meaning(what: What, value: Any) -> str:
    shown = f"{value:.4g}" if isinstance(value, float) else str(getattr(value, "value", value)).replace("_", " ")
    units = {What.DISTANCE: f"{shown} m away", What.SPEED: f"at about {shown} m/s", What.WITHIN: f"within {shown} s"}
    side = shown if shown.startswith("from") else f"to the {shown}"
    return units.get(what, {What.QUEUE: "in a queue", What.SIDE: side}.get(what, shown))


def _build(model: type[_Model], **values: Any) -> _Model:
    try:
        return model(**values)
    except ValidationError as error:
        raise UnusableInput(f"this traffic cannot be placed: {_first(error)}", reason="impossible-traffic") from None


def _first(error: ValidationError) -> str:
    """The first complaint, without pydantic's words around it."""
    detail = error.errors(include_url=False)[0]
    place = " ".join(str(part) for part in detail["loc"] if not isinstance(part, int)).replace("_", " ")
    message = detail["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
    return f"{place} {message}".strip()
