"""Anthropic's models."""

from drivegen.lm.backends.base import Reply, Request
from drivegen.lm.client import Line, call
from drivegen.lm.keys import secret
from drivegen.lm.settings import RoleSettings

VENDOR = "https://api.anthropic.com"

_PIXELS_PER_TOKEN = 750


class Plugin:
    """A model behind Anthropic's messages protocol."""

    def __init__(self, settings: RoleSettings) -> None:
        self._settings = settings
        self._url = settings.base_url or VENDOR
        self._key = secret(settings.key, self._url)

    def reply(self, request: Request) -> Reply:
        """See `Backend.reply`."""
        from anthropic import AsyncAnthropic
        from pydantic_ai.models import Model
        from pydantic_ai.models.anthropic import AnthropicModel
        from pydantic_ai.providers.anthropic import AnthropicProvider

        def model(line: Line) -> Model:
            client = AsyncAnthropic(
                base_url=self._url,
                api_key=self._key or "none",  # the client insists on one
                timeout=self._settings.timeout,
                max_retries=self._settings.retries,
                http_client=line.http,
            )
            return AnthropicModel(self._settings.model, provider=AnthropicProvider(anthropic_client=client))

        return call(model, request, self._settings, self._key, self._url)

    @staticmethod
    def vendor(base_url: str) -> str:
        """See `Backend.vendor`."""
        return "anthropic" if base_url in ("", VENDOR) else ""

    @staticmethod
    def image_tokens(width: int, height: int) -> int:
        """See `Backend.image_tokens`: about one per 750 pixels, as the vendor says."""
        return -(-width * height // _PIXELS_PER_TOKEN)
