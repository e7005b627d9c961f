"""No language model: every question has a typed failure for an answer, so that the caller's fallback is used, and counted."""

from collections.abc import Sequence

from drivegen.lm.backends.base import Reply, Request
from drivegen.lm.prompt import NoAnswer
from drivegen.lm.settings import RoleSettings


class Plugin:
    """The backend that asks nobody."""

    def __init__(self, settings: RoleSettings) -> None:
        self._settings = settings

    def reply(self, request: Request) -> Reply:
        """See `Backend.reply`."""
        raise NoAnswer(f"no language model is configured for {request.prompt_version}", "no-model")

    def replies(self, requests: Sequence[Request]) -> list[Reply | NoAnswer]:
        """See `Backend.replies`."""
        return [NoAnswer(f"no language model is configured for {request.prompt_version}", "no-model") for request in requests]

    @staticmethod
    def vendor(base_url: str) -> str:
        """See `Backend.vendor`: nobody."""
        del base_url
        return ""

    @staticmethod
    def image_tokens(width: int, height: int) -> int:
        """See `Backend.image_tokens`: nothing is sent."""
        del width, height
        return 0
