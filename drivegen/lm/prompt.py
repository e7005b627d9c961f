"""What a language model is told and shown, the type that its answer must have, and the ways in which there is none."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Literal, TypeVar

from pydantic import BaseModel

from drivegen.core.errors import DriveGenError

A = TypeVar("A", bound=BaseModel)

Reason = Literal["no-model", "invalid-answer", "refused", "rate-limited", "server-error", "timeout", "unreachable", "too-large"]
"""Why there is no answer: none is configured; what came fails validation; the server said no to the request, asked for
patience until patience ended, failed, was too slow, was not there, sent more than an answer can be."""


@dataclass(frozen=True)
class Image:
    """An encoded picture, such as PNG bytes with media type "image/png"."""

    content: bytes
    media_type: str


@dataclass(frozen=True)
class Prompt(Generic[A]):
    """One question.

    Attributes:
        version: names the wording, e.g. "roads-3"; part of the key under which answers are recorded.
        instructions: the rules, the same for every question of a kind.
        parts: what is asked, texts and pictures in order. What users or files said is data: fence it with `fenced`.
        answer: the type of the answer; its fields' bounds are enforced.
        check: what the type cannot say; raises ValueError whose words go back to the model. None: nothing more.
    """

    version: str
    instructions: str
    parts: tuple[str | Image, ...]
    answer: type[A]
    check: Callable[[A], None] | None = None


class NoAnswer(DriveGenError):
    """No usable answer came: the caller uses its fallback and counts `reason`; `lost` attempts may be billed all the same."""

    def __init__(self, message: str, reason: Reason, lost: int = 0) -> None:
        super().__init__(message)
        self.reason: Reason = reason
        self.lost = lost


class OverBudget(DriveGenError):
    """The next call could cost more than the role may spend: the run stops."""


class DamagedRecord(DriveGenError):
    """A recorded reply is not what was recorded: the run stops, for neither a refusal nor a fallback may stand for it."""

    exit_code = 2


def fenced(name: str, text: str) -> str:
    """`text` between tags that it cannot close itself: data, never instructions.

    >>> fenced("road", "a </road> b")
    '<road>\\na  b\\n</road>'
    """
    text = encodable(text).replace(f"</{name}>", "").replace(f"<{name}>", "")
    if f"<{name}>" in text or f"</{name}>" in text:  # one within another: to go on taking them out could take for ever
        text = text.replace("<", "").replace(">", "")
    return f"<{name}>\n{text}\n</{name}>"


def is_quoted(phrase: str, text: str) -> bool:
    """Whether a phrase that a model says to quote stands in `text`, whatever the case; an empty one does not."""
    return bool(phrase.strip()) and phrase.lower() in text.lower()


def one_line(words: str) -> str:
    """`words` in one line: blanks for line breaks and whatever else cannot be printed, and never two of them."""
    return " ".join("".join(c if c.isprintable() else " " for c in words).split())


def encodable(text: str) -> str:
    """`text` with "?" for halves of characters (lone surrogates), which no file and no request can hold."""
    return text.encode(errors="replace").decode()
