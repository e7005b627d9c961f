"""What the backends have in common that ask a vendor, or a server that speaks a vendor's protocol, through pydantic-ai."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from drivegen.lm.backends.base import Reply, Request
from drivegen.lm.batch import call_batch
from drivegen.lm.client import Line, call
from drivegen.lm.keys import secret
from drivegen.lm.prompt import NoAnswer
from drivegen.lm.settings import RoleSettings

if TYPE_CHECKING:
    from pydantic_ai.models import Model


class Hosted(ABC):
    """A model behind HTTP.

    Attributes:
        URL: the vendor's own address. NAME: the vendor, as price lists have it.
    """

    URL: ClassVar[str]
    NAME: ClassVar[str]

    def __init__(self, settings: RoleSettings) -> None:
        self._settings = settings
        self._url = settings.base_url or self.URL
        self._key = secret(settings.key, self._url)

    @abstractmethod
    def model(self, line: Line) -> "Model":
        """pydantic-ai's model over the vendor's own client, which sends through `line`."""

    def batch_model(self, line: Line) -> "Model":
        """The same model as its vendor's batch endpoint is reached; `model` where that is the same."""
        return self.model(line)

    def client_options(self, line: Line) -> dict[str, Any]:
        """What every vendor's client is made with."""
        return {
            "base_url": self._url,
            "api_key": line.key,
            "timeout": self._settings.timeout,
            "max_retries": self._settings.retries,
            "http_client": line.http,
        }

    def reply(self, request: Request) -> Reply:
        """See `Backend.reply`."""
        return call(self.model, request, self._settings, self._key, self._url)

    def replies(self, requests: Sequence[Request]) -> list[Reply | NoAnswer]:
        """See `Backend.replies`: through the vendor's batch endpoint."""
        return call_batch(self.batch_model, requests, self._key, self._url)

    @classmethod
    def vendor(cls, base_url: str) -> str:
        """See `Backend.vendor`."""
        return cls.NAME if base_url in ("", cls.URL) else ""
