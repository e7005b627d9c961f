"""OpenAI, and every server that speaks its chat protocol (vLLM, Ollama, llama.cpp, ...) by `base_url`."""

import math
from typing import TYPE_CHECKING

from drivegen.lm.backends._hosted import Hosted
from drivegen.lm.client import Line

if TYPE_CHECKING:
    from pydantic_ai.models import Model
    from pydantic_ai.providers.openai import OpenAIProvider

_PATCH, _MOST_PATCHES = 32, 1536


class Plugin(Hosted):
    """A model behind OpenAI's chat protocol."""

    URL, NAME = "https://api.openai.com/v1", "openai"

    def model(self, line: Line) -> "Model":
        """See `Hosted.model`."""
        from pydantic_ai.models.openai import OpenAIChatModel

        return OpenAIChatModel(self._settings.model, provider=self._provider(line))

    def batch_model(self, line: Line) -> "Model":
        """See `Hosted.batch_model`: pydantic-ai batches through the responses protocol, which OpenAI itself offers."""
        from pydantic_ai.models.openai import OpenAIResponsesModel

        return OpenAIResponsesModel(self._settings.model, provider=self._provider(line))

    def _provider(self, line: Line) -> "OpenAIProvider":
        from openai import AsyncOpenAI
        from pydantic_ai.providers.openai import OpenAIProvider

        return OpenAIProvider(openai_client=AsyncOpenAI(**self.client_options(line)))

    @staticmethod
    def image_tokens(width: int, height: int) -> int:
        """See `Backend.image_tokens`: one per patch of 32 x 32 pixels, as the vendor's patch models count."""
        return min(_MOST_PATCHES, math.ceil(width / _PATCH) * math.ceil(height / _PATCH))
