"""The protocol of a backend: one request in, one reply out, both plain; whether the reply is usable is not its business."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Protocol

from drivegen.lm.prompt import Image, NoAnswer

if TYPE_CHECKING:
    from drivegen.lm.settings import RoleSettings

Output = Literal["native", "tool", "prompted"]
"""How the answer's schema reaches the model: the vendor's structured output, a tool that it must call, or words."""


@dataclass(frozen=True)
class Turn:
    """An earlier reply in the same conversation, and what was wrong with it."""

    reply: str
    complaint: str


@dataclass(frozen=True)
class Request:
    """Everything that a reply depends on. `schema` is JSON Schema; `sample` counts answers to the same question."""

    model: str
    prompt_version: str
    instructions: str
    parts: tuple[str | Image, ...]
    turns: tuple[Turn, ...]
    schema: dict[str, Any]
    output: Output
    max_tokens: int
    sample: int


@dataclass(frozen=True)
class Reply:
    """What came back: text, the tokens it took (None unknown), how often the transport had to try again.

    Of the attempts before, `lost` were sent and had no response: they may be billed, too.
    """

    text: str
    input_tokens: int | None
    output_tokens: int | None
    retries: int
    lost: int = 0


class Backend(Protocol):
    """Made from a role's settings: `Plugin(settings)`, which raises MissingTool without its key."""

    def __init__(self, settings: "RoleSettings") -> None: ...

    def reply(self, request: Request) -> Reply:
        """Ask once. Raises NoAnswer, in words that hold nothing the server said."""

    def replies(self, requests: Sequence[Request]) -> list[Reply | NoAnswer]:
        """Ask many at once, cheaper and later; a reply or a NoAnswer for each. Raises UnusableInput where that is not offered."""

    @staticmethod
    def vendor(base_url: str) -> str:
        """Whose prices hold at this address ("" the vendor's own), as price lists name it; "" where nobody has a price."""

    @staticmethod
    def image_tokens(width: int, height: int) -> int:
        """About how many tokens a picture of this size [pixels] is."""
