"""What calls cost, before and after: prices of hosted models from genai-prices' own copy of the price lists.

A model that no list knows, such as one on a server of yours, has the price "unknown", never 0. Tokens before a call are an
estimate: bytes of text over 3.5, pictures by the vendor's rule.
"""

import math
import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import orjson

from drivegen.core import plugins
from drivegen.lm.backends.base import Backend, Request
from drivegen.lm.batch import DISCOUNT
from drivegen.lm.prompt import Image
from drivegen.lm.settings import RoleSettings

MAP_TOKENS, TRAFFIC_TOKENS, RANKING_TOKENS = 500, 250, 120
"""Of an answer of ordinary size: a map, the traffic of a description, the ranking of one vehicle's goals."""

_BYTES_PER_TOKEN = 3.5
_PNG = b"\x89PNG\r\n\x1a\n"
_UNKNOWN_IMAGE = (1024, 1024)  # [pixels] where a picture is no PNG


@dataclass(frozen=True)
class Estimate:
    """Of some calls, each answered at the first time of asking: `usd` is None where the price is unknown.

    `most_usd` is what they cost if each answer is as long as it may be, all are asked for twice again, and what is made of them
    needs all repairs that it may have.
    """

    calls: int
    input_tokens: int
    output_tokens: int
    usd: float | None
    most_usd: float | None

    def times(self, share: float) -> "Estimate":
        """Of so many times as many calls."""
        dollars = (None if usd is None else usd * share for usd in (self.usd, self.most_usd))
        calls, *tokens = (round(count * share) for count in (self.calls, self.input_tokens, self.output_tokens))
        return Estimate(calls, *tokens, *dollars)


def price(model: str, vendor: str, input_tokens: int | None, output_tokens: int | None) -> float | None:
    """Dollars; None where the price or the tokens are unknown. `vendor` as genai-prices names it, "" for none."""
    if not vendor or input_tokens is None or output_tokens is None:
        return None
    from genai_prices import Usage, calc_price

    try:
        usage = Usage(input_tokens=input_tokens, output_tokens=output_tokens)
        return float(calc_price(usage, model, provider_id=vendor).total_price)
    except LookupError:
        return None


def input_tokens(request: Request, backend: type[Backend]) -> int:
    """About how many tokens a request is."""
    texts = [request.instructions, *(part for part in request.parts if isinstance(part, str))]
    texts += [text for turn in request.turns for text in (turn.reply, turn.complaint)]
    length = sum(len(text.encode()) for text in texts) + len(orjson.dumps(request.schema))
    images = [part for part in request.parts if isinstance(part, Image)]
    return math.ceil(length / _BYTES_PER_TOKEN) + sum(backend.image_tokens(*_size(image.content)) for image in images)


def estimate(
    settings: RoleSettings, requests: Iterable[Request], answer_tokens: int, *, batch: bool = False, repairs: int = 0
) -> Estimate:
    """What the requests would cost if each answer has about `answer_tokens`, without asking anybody; in a `batch` half.

    So many `repairs` at most may follow an answer: the question again, with the answer and what is wrong with it, in no batch.
    """
    backend: type[Backend] = plugins.load("lm.backends", settings.backend)
    share, longest = DISCOUNT if batch else 1.0, settings.max_tokens

    def dollars(tokens: Sequence[int], answer: int, share: float) -> list[float | None]:
        """Of each call: prices may depend on how long a single one is."""
        costs = (price(settings.model, backend.vendor(settings.base_url), question, answer) for question in tokens)
        return [None if cost is None else cost * share for cost in costs]

    inputs = [input_tokens(request, backend) for request in requests]
    again = [question + k * longest for question in inputs for k in range(3)]  # asked again, a request holds the replies before
    usd = _sum(dollars(inputs, answer_tokens, share))
    repaired = [question + longest for question in again] * repairs
    most = _sum([*dollars(again, longest, share), *dollars(repaired, longest, 1.0)])
    return Estimate(len(inputs), sum(inputs), answer_tokens * len(inputs), usd, most)


def _sum(costs: Sequence[float | None]) -> float | None:
    known = [cost for cost in costs if cost is not None]
    return sum(known) if len(known) == len(costs) else None


def in_dollars(usd: float | None) -> str:
    """For people."""
    return "unknown" if usd is None else f"{usd:.4f}"


def _size(content: bytes) -> tuple[int, int]:
    if content[:8] == _PNG and len(content) >= 24:
        width, height = struct.unpack(">II", content[16:24])
        return width, height
    return _UNKNOWN_IMAGE
