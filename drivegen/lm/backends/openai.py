"""OpenAI, and every server that speaks its chat protocol (vLLM, Ollama, llama.cpp, ...) by `base_url`."""

import math

from drivegen.lm.backends.base import Reply, Request
from drivegen.lm.client import Line, call
from drivegen.lm.keys import secret
from drivegen.lm.settings import RoleSettings

VENDOR = "https://api.openai.com/v1"

_PATCH, _MOST_PATCHES = 32, 1536


class Plugin:
    """A model behind OpenAI's chat protocol."""

    def __init__(self, settings: RoleSettings) -> None:
        self._settings = settings
        self._url = settings.base_url or VENDOR
        self._key = secret(settings.key, self._url)

    def reply(self, request: Request) -> Reply:
        """See `Backend.reply`."""
        from openai import AsyncOpenAI
        from pydantic_ai.models import Model
        from pydantic_ai.models.openai import OpenAIChatModel
        from pydantic_ai.providers.openai import OpenAIProvider

        def model(line: Line) -> Model:
            client = AsyncOpenAI(
                base_url=self._url,
                api_key=self._key or "none",  # the client insists on one
                timeout=self._settings.timeout,
                max_retries=self._settings.retries,
                http_client=line.http,
            )
            return OpenAIChatModel(self._settings.model, provider=OpenAIProvider(openai_client=client))

        return call(model, request, self._settings, self._key, self._url)

    @staticmethod
    def vendor(base_url: str) -> str:
        """See `Backend.vendor`."""
        return "openai" if base_url in ("", VENDOR) else ""

    @staticmethod
    def image_tokens(width: int, height: int) -> int:
        """See `Backend.image_tokens`: one per patch of 32 x 32 pixels, as the vendor's patch models count."""
        return min(_MOST_PATCHES, math.ceil(width / _PATCH) * math.ceil(height / _PATCH))
