"""Anthropic's models."""

from typing import TYPE_CHECKING

from drivegen.lm.backends._hosted import Hosted
from drivegen.lm.client import Line

if TYPE_CHECKING:
    from pydantic_ai.models import Model

_PIXELS_PER_TOKEN = 750


class Plugin(Hosted):
    """A model behind Anthropic's messages protocol."""

    URL, NAME = "https://api.anthropic.com", "anthropic"

    def model(self, line: Line) -> "Model":
        """See `Hosted.model`."""
        from anthropic import AsyncAnthropic
        from pydantic_ai.models.anthropic import AnthropicModel
        from pydantic_ai.providers.anthropic import AnthropicProvider

        client = AsyncAnthropic(**self.client_options(line))
        return AnthropicModel(self._settings.model, provider=AnthropicProvider(anthropic_client=client))

    @staticmethod
    def image_tokens(width: int, height: int) -> int:
        """See `Backend.image_tokens`: about one per 750 pixels, as the vendor says."""
        return -(-width * height // _PIXELS_PER_TOKEN)
