"""Many requests through a vendor's batch endpoint: about half the price, answered within a day instead of at once.

pydantic-ai submits them in as few jobs as the vendor takes, looks after the jobs in growing intervals, and submits again what
expired or failed on the way. Each request has a reply or a reason of its own.
"""

import asyncio
from collections.abc import Callable, Sequence
from datetime import timedelta
from typing import TYPE_CHECKING

from drivegen.core.errors import UnusableInput
from drivegen.lm.backends.base import Reply, Request
from drivegen.lm.client import MOST_BYTES, Line, as_reply, messages_of, parameters_of, reason_of
from drivegen.lm.keys import endpoint
from drivegen.lm.prompt import NoAnswer, Reason

if TYPE_CHECKING:
    from pydantic_ai.messages import ModelResponse
    from pydantic_ai.models import Model

DISCOUNT = 0.5
"""What a request in a batch costs, as a share of its usual price (OpenAI's and Anthropic's price lists)."""

LONGEST = timedelta(hours=24)
"""Vendors answer within this time, or not at all."""

FIRST_LOOK, LAST_LOOK = timedelta(seconds=30), timedelta(minutes=10)
"""Time between two looks at a job, at first and at most."""


def call_batch(model: Callable[[Line], "Model"], requests: Sequence[Request], key: str, url: str) -> list[Reply | NoAnswer]:
    """A reply for each request, or why there is none. Raises UnusableInput where the model has no batch endpoint."""
    return asyncio.run(_call(model, requests, key, url)) if requests else []


async def _call(model: Callable[[Line], "Model"], requests: Sequence[Request], key: str, url: str) -> list[Reply | NoAnswer]:
    from pydantic_ai.direct import model_request_batch
    from pydantic_ai.exceptions import AgentRunError, UserError
    from pydantic_ai.models.batch import BatchRequest
    from pydantic_ai.settings import ModelSettings

    line = Line(url, key, MOST_BYTES * len(requests))
    questions = [
        BatchRequest(
            custom_id=f"q{number}",
            messages=messages_of(request),
            model_settings=ModelSettings(max_tokens=request.max_tokens),
            model_request_parameters=parameters_of(request),
        )
        for number, request in enumerate(requests)
    ]
    reason: Reason
    async with line.http:
        try:
            async with asyncio.timeout(LONGEST.total_seconds()):
                results = await model_request_batch(
                    model(line), questions, poll_interval=FIRST_LOOK, max_poll_interval=LAST_LOOK, max_resubmissions=1
                )
        except (UserError, NotImplementedError):
            raise UnusableInput(f"{requests[0].model} cannot be asked in a batch: ask one by one") from None
        except TimeoutError:
            reason = "timeout"
        except AgentRunError as error:
            reason = "too-large" if line.too_large else reason_of(error)
        except Exception:  # noqa: BLE001 as in `client`
            reason = "invalid-answer"
        else:
            return [_outcome(request, url, key, one) for request, one in zip(requests, results, strict=True)]
    lost = int(line.accepted or line.lost > 0)  # the job may run all the same, and each of its requests be billed
    return [_failure(request, url, reason, lost) for request in requests]


def _outcome(request: Request, url: str, key: str, result: "ModelResponse | Exception") -> Reply | NoAnswer:
    if isinstance(result, Exception):
        return _failure(request, url, reason_of(result), lost=0)
    try:
        return as_reply(result, key)
    except Exception:  # noqa: BLE001 as in `client`
        return _failure(request, url, "invalid-answer", lost=1)


def _failure(request: Request, url: str, reason: Reason, lost: int) -> NoAnswer:
    return NoAnswer(f"{request.model} at {endpoint(url)} gave no answer in a batch: {reason}", reason, lost)
