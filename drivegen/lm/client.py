"""One request through pydantic-ai: our types in and out, bounded in time and size, every failure a `NoAnswer`.

The vendors' clients try again by themselves (429 with Retry-After, 5xx, timeouts); nothing here does so again. What a server
says in an error is never repeated: it may hold the key. pydantic-ai is imported when a model is called, for it takes a second.
"""

import asyncio
from collections.abc import AsyncIterator, Callable
from typing import TYPE_CHECKING, Any, get_args

from drivegen.core.errors import UnusableInput
from drivegen.lm.backends.base import Output, Reply, Request
from drivegen.lm.keys import endpoint, scrubbed
from drivegen.lm.prompt import Image, NoAnswer, Reason, encodable
from drivegen.lm.settings import RoleSettings

if TYPE_CHECKING:
    import httpx2
    from pydantic_ai.messages import ModelMessage, ModelResponse
    from pydantic_ai.models import Model, ModelRequestParameters

MOST_BYTES = 1_000_000
"""Of one HTTP body; an answer of ours has some thousands."""

_MOST_TOKENS = 2**31
_LONGEST_WAIT = 60.0  # [s] between two attempts, whatever Retry-After says
_TOOL = "answer"

_HEADERS = {
    "host", "connection", "accept", "accept-encoding", "content-type", "content-length", "transfer-encoding", "user-agent",
    "anthropic-version", "anthropic-beta",
}  # fmt: skip
"""What goes out beside the key: the vendors' clients add what variables of the environment hold, for any server."""


class Line:
    """The HTTP client of one call: it counts attempts and hangs up on bodies that are too long or compressed.

    Attributes:
        key: the only secret that is sent. attempts: requests so far; `lost` of them reached a server and had no whole response.
        accepted: whether one was granted.

    A compressed body of allowed length could still unpack to gigabytes, so none is asked for and none is read. Redirects are
    not followed, and no proxy is used for what is not encrypted: they would take the key elsewhere.
    """

    def __init__(self, url: str, key: str, most_bytes: int = MOST_BYTES) -> None:
        import httpx2

        self.key = key or "none"  # the vendors' clients insist on one
        self._most = most_bytes
        self.attempts, self.lost, self.accepted, self.too_large = 0, 0, False, False
        hooks: dict[str, list[Callable[..., Any]]] = {"request": [self._sent], "response": [self._received]}
        self.http: httpx2.AsyncClient = self._counting()(
            event_hooks=hooks,
            headers={"Accept-Encoding": "identity"},
            follow_redirects=False,
            trust_env=url.startswith("https:"),
        )

    def _counting(self) -> "type[httpx2.AsyncClient]":
        import httpx2

        line = self

        class Counting(httpx2.AsyncClient):
            async def send(self, request: httpx2.Request, **options: Any) -> httpx2.Response:
                try:
                    return await super().send(request, **options)
                except BaseException as error:
                    line.lost += not isinstance(error, (httpx2.ConnectError, httpx2.ConnectTimeout, httpx2.PoolTimeout))
                    raise

        return Counting

    async def _sent(self, request: "httpx2.Request") -> None:
        self.attempts += 1
        keys = (self.key, f"Bearer {self.key}")
        for name in [name for name, value in request.headers.items() if name not in _HEADERS and value not in keys]:
            del request.headers[name]
        if not any(value in keys for value in request.headers.values()):  # a variable has put another in its place
            request.headers["Authorization"] = keys[1]

    async def _received(self, response: "httpx2.Response") -> None:
        import httpx2

        self.accepted |= response.is_success
        if response.headers.get("Content-Encoding", "identity") != "identity":
            self.too_large = True
            raise httpx2.DecodingError("compressed, which was not asked for", request=response.request)
        assert isinstance(response.stream, httpx2.AsyncByteStream)
        response.stream = self._bounded(response.stream, response.request)

    def _bounded(self, inner: "httpx2.AsyncByteStream", request: "httpx2.Request") -> "httpx2.AsyncByteStream":
        import httpx2

        line = self

        class Bounded(httpx2.AsyncByteStream):
            async def __aiter__(self) -> AsyncIterator[bytes]:
                length = 0
                async for chunk in inner:
                    length += len(chunk)
                    if length > line._most:
                        line.too_large = True
                        raise httpx2.ReadError("longer than an answer can be", request=request)
                    yield chunk

            async def aclose(self) -> None:
                await inner.aclose()

        return Bounded()


def call(model: Callable[[Line], "Model"], request: Request, settings: RoleSettings, key: str, url: str) -> Reply:
    """The reply of the model that `model` makes on a line of its own.

    Raises NoAnswer, or UnusableInput where the client knows that the model cannot be asked in this way.
    """
    return asyncio.run(_call(model, request, settings, key, url))


async def _call(model: Callable[[Line], "Model"], request: Request, settings: RoleSettings, key: str, url: str) -> Reply:
    from pydantic_ai.direct import model_request
    from pydantic_ai.exceptions import AgentRunError, UserError
    from pydantic_ai.settings import ModelSettings

    line = Line(url, key)
    reason: Reason
    async with line.http:
        try:
            # Each attempt has its own timeout, but a server that sends a byte now and then would never meet it.
            async with asyncio.timeout((1 + settings.retries) * (settings.timeout + _LONGEST_WAIT)):
                response = await model_request(
                    model(line),
                    messages_of(request),
                    model_settings=ModelSettings(max_tokens=request.max_tokens),
                    model_request_parameters=parameters_of(request),
                )
            return as_reply(response, key, max(0, line.attempts - 1), line.lost)
        except UserError:
            others = ", ".join(word for word in get_args(Output) if word != request.output)
            raise UnusableInput(f"{request.model} cannot be asked with lm output {request.output}: try {others}") from None
        except TimeoutError:
            reason = "timeout"
        except AgentRunError as error:
            reason = "too-large" if line.too_large else reason_of(error)
        except Exception:  # noqa: BLE001 whatever the clients' readers make of a reply that is none
            reason = "invalid-answer"
    message = f"{request.model} at {endpoint(url)} gave no answer after {line.attempts} attempts: {reason}"
    raise NoAnswer(message, reason, line.lost + (reason == "invalid-answer")) from None


def as_reply(response: "ModelResponse", key: str, retries: int = 0, lost: int = 0) -> Reply:
    """A response as plain values, without the key that a server may have repeated."""
    return Reply(scrubbed(encodable(_text(response)), key), *_tokens(response), retries, lost)


def reason_of(error: Exception) -> Reason:
    """Why there is no answer, from what pydantic-ai says."""
    from pydantic_ai import exceptions

    kinds: tuple[tuple[type[Exception], Reason], ...] = (  # a class before those that it is one of
        (exceptions.ModelRateLimitError, "rate-limited"),
        (exceptions.ModelQuotaExceededError, "rate-limited"),
        (exceptions.ModelTimeoutError, "timeout"),
        (exceptions.ModelConnectionError, "unreachable"),
        (exceptions.ModelRequestRejectedError, "refused"),
        (exceptions.UnexpectedModelBehavior, "invalid-answer"),  # no reply of the protocol, or a content filter's
    )
    return next((reason for kind, reason in kinds if isinstance(error, kind)), "server-error")


def messages_of(request: Request) -> "list[ModelMessage]":
    """The conversation so far."""
    from pydantic_ai.messages import BinaryContent, ModelRequest, ModelResponse, TextPart, UserPromptPart

    shown = [BinaryContent(p.content, media_type=p.media_type) if isinstance(p, Image) else p for p in request.parts]
    messages: list[ModelMessage] = [ModelRequest([UserPromptPart(shown)], instructions=request.instructions)]
    for turn in request.turns:
        messages.append(ModelResponse([TextPart(turn.reply)]))
        messages.append(ModelRequest([UserPromptPart(turn.complaint)], instructions=request.instructions))
    return messages


def parameters_of(request: Request) -> "ModelRequestParameters":
    """How the schema of the answer is told."""
    from pydantic_ai.models import ModelRequestParameters
    from pydantic_ai.output import OutputObjectDefinition
    from pydantic_ai.tools import ToolDefinition

    if request.output == "native":
        return ModelRequestParameters(output_mode="native", output_object=OutputObjectDefinition(request.schema, name=_TOOL))
    if request.output == "tool":
        tool = ToolDefinition(name=_TOOL, parameters_json_schema=request.schema, kind="output")
        return ModelRequestParameters(output_mode="tool", output_tools=[tool], allow_text_output=False)
    return ModelRequestParameters()


def _text(response: "ModelResponse") -> str:
    from pydantic_ai.messages import TextPart, ToolCallPart

    for part in response.parts:
        if isinstance(part, ToolCallPart):
            return part.args_as_json_str()
    return "".join(part.content for part in response.parts if isinstance(part, TextPart))


def _tokens(response: "ModelResponse") -> tuple[int | None, int | None]:
    """In and out; None where the server says nothing or no number that can be."""
    counts = response.usage.input_tokens, response.usage.output_tokens
    return counts if any(counts) and all(0 <= count < _MOST_TOKENS for count in counts) else (None, None)
