"""The seam: whoever wants something from a language model asks a `LanguageModel`, and gets a validated answer or a NoAnswer."""

import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, cast

import orjson
from pydantic import BaseModel

from drivegen.core import plugins
from drivegen.lm.backends.base import Backend, Output, Reply, Request, Turn
from drivegen.lm.batch import DISCOUNT
from drivegen.lm.ledger import UNKNOWN, Call, Ledger
from drivegen.lm.prices import estimate, in_dollars, input_tokens, price
from drivegen.lm.prompt import A, NoAnswer, Prompt
from drivegen.lm.reading import InvalidReply, read
from drivegen.lm.records import Mode, Records, key_of
from drivegen.lm.settings import RoleSettings

ASKED_AGAIN = 2
"""How often at most, with what was wrong, after an answer that fails validation."""

_IN_WORDS = "Answer with one JSON object and nothing else. It must satisfy this JSON Schema:\n"
_MEND = "That answer cannot be used:\n{}\nAnswer again, whole, with this mended."


class LanguageModel:
    """One role's language model.

    Attributes:
        role: "maps", "goals" or "corner_cases". description: who answers, as it stands in tables.
        ledger: every call so far.
    """

    def __init__(self, role: str, settings: RoleSettings, records: Records) -> None:
        self.role = role
        self.ledger = Ledger(settings.max_usd, settings.max_calls)
        self._settings, self._records = settings, records
        self._made: Backend | None = None
        self._ahead: dict[str, BaseModel | NoAnswer] = {}

    @property
    def in_batches(self) -> bool:
        """Whether the role's settings want questions that are known together asked together."""
        return self._settings.batch and bool(self._settings.model)

    @property
    def prompt_version(self) -> str:
        """The wording that the role's settings ask for."""
        return self._settings.prompt

    @property
    def description(self) -> str:
        """The model's name, or that there is none."""
        return f"language model {self._settings.model}" if self._settings.model else "no language model"

    def ask(self, prompt: Prompt[A], sample: int = 0) -> A:
        """The answer to `prompt`; another `sample` is another answer to the same question.

        A reply that fails validation is asked for again with the validator's words, twice at most. Raises NoAnswer where no
        usable answer came, OverBudget before a call that may cost too much, MissingTool where a recorded reply or the key is
        missing.
        """
        if self._ahead and (early := self._ahead.get(key_of(self.request(prompt, sample)))) is not None:
            if isinstance(early, NoAnswer):
                raise early
            return cast(A, early)
        turns: tuple[Turn, ...] = ()
        for asked in range(1 + ASKED_AGAIN):
            request = self.request(prompt, sample, turns)
            reply, row = self._reply(request, asked)
            answer = self._noted(prompt, reply, row)
            self._keep([(request, reply, row)])
            if not isinstance(answer, Turn):
                return answer
            turns = (*turns, answer)
        raise NoAnswer(
            f"{self._settings.model} gave no valid answer in {1 + ASKED_AGAIN} attempts (prompt {prompt.version})",
            "invalid-answer",
        )

    def request(self, prompt: Prompt[A], sample: int = 0, turns: tuple[Turn, ...] = ()) -> Request:
        """What is sent for a prompt; also what an estimate is made of."""
        schema = prompt.answer.model_json_schema()
        output = cast(Output, self._settings.output)
        instructions = prompt.instructions
        if output == "prompted":
            instructions = f"{instructions}\n\n{_IN_WORDS}{orjson.dumps(schema, option=orjson.OPT_SORT_KEYS).decode()}"
        return Request(
            model=self._settings.model,
            prompt_version=prompt.version,
            instructions=instructions,
            parts=prompt.parts,
            turns=turns,
            schema=schema,
            output=output,
            max_tokens=self._settings.max_tokens,
            sample=sample,
        )

    def _row(self, request: Request, asked: int) -> Call:
        """The row of a call, as far as it is known before."""
        return Call(
            role=self.role,
            model=request.model,
            prompt_version=request.prompt_version,
            key=key_of(request),
            sample=request.sample,
            asked=asked,
        )

    def _reply(self, request: Request, asked: int) -> tuple[Reply, Call]:
        """The recorded reply, or the model's own, and its row, which lacks the outcome."""
        row = self._row(request, asked)
        if self._settings.model and (kept := self._records.find(request)):
            return kept, _replayed(row, kept)
        return self._call(request, row)

    def _noted(self, prompt: Prompt[A], reply: Reply, row: Call) -> A | Turn:
        """The answer in a reply, or the turn in which it is asked for again; the row is noted, with its outcome."""
        try:
            answer: A | Turn = read(reply.text, prompt)
        except InvalidReply as wrong:
            answer = Turn(reply.text, _MEND.format(wrong))
        again = "asked again" if row.asked < ASKED_AGAIN else "invalid-answer"
        self.ledger.add(replace(row, outcome=again if isinstance(answer, Turn) else "answered"))
        return answer

    def _keep(self, calls: Iterable[tuple[Request, Reply | NoAnswer, Call]]) -> None:
        """Record the replies that are new, all that can be, after their rows: what was paid for is known on a full disk, too."""
        faults = []
        for request, reply, row in calls:
            try:
                if isinstance(reply, Reply) and not row.replayed:
                    self._records.keep(request, reply)
            except OSError as fault:
                faults.append(fault)
        if faults:
            raise faults[0]

    def forecast(self, prompts: Sequence[Prompt[Any]], answer_tokens: int, times: float = 1.0, repairs: int = 0) -> str:
        """A line before a run: calls, tokens and dollars of so many `times` these questions, and where the run would stop.

        See `estimate` for `repairs`.
        """
        role, who = f"lm.{self.role}", self.description
        if not self._settings.model:
            return f"{role}: no language model is configured: nobody is asked"
        if self._records.mode is Mode.REPLAY:
            return f"{role}: recorded answers of {who} are replayed: nobody is asked, nothing is spent"
        requests = [self.request(prompt) for prompt in prompts]
        one = estimate(self._settings, requests, answer_tokens, batch=self.in_batches, repairs=repairs).times(times)
        asked = "in batches" if self.in_batches else "one by one"
        return (
            f"{role}: {who}, {asked}: about {one.calls} calls, {one.input_tokens} tokens in, {one.output_tokens} out, dollars "
            f"{in_dollars(one.usd)}, at most {in_dollars(one.most_usd)}; what is recorded already costs nothing"
            f"{' in mode auto' if self._records.mode is Mode.AUTO else ', but is asked again in this mode'}; the run stops at "
            f"{self._settings.max_usd:g} dollars or {self._settings.max_calls} calls"
        )

    def ask_ahead(self, prompts: Sequence[Prompt[Any]], sample: int = 0) -> None:
        """Where the role is set to batches, ask all of them in one, once each; `ask` then hands out what came.

        Raises as `ask_many`.
        """
        if not self.in_batches or not prompts:
            return
        by_key = {key_of(self.request(prompt, sample)): prompt for prompt in prompts}
        new = {key: prompt for key, prompt in by_key.items() if key not in self._ahead}
        self._ahead |= dict(zip(new, self.ask_many(list(new.values()), sample), strict=True))

    def ask_many(self, prompts: Sequence[Prompt[A]], sample: int = 0) -> list[A | NoAnswer]:
        """The answers to many questions through the vendor's batch endpoint: half the price, within a day.

        As `ask`, but what has no answer stands in the list as its NoAnswer. What is recorded is not asked again; what fails
        validation goes into another batch, twice at most. Raises UnusableInput where the vendor has no batch endpoint.
        """
        answers: dict[int, A | NoAnswer] = {}
        turns: list[tuple[Turn, ...]] = [()] * len(prompts)
        for asked in range(1 + ASKED_AGAIN):
            left = [i for i in range(len(prompts)) if i not in answers]
            requests = [self.request(prompts[i], sample, turns[i]) for i in left]
            calls = [(request, *call) for request, call in zip(requests, self._replies(requests, asked), strict=True)]
            for i, (_, reply, row) in zip(left, calls, strict=True):
                answer = reply if isinstance(reply, NoAnswer) else self._noted(prompts[i], reply, row)
                if isinstance(answer, Turn):
                    turns[i] = (*turns[i], answer)
                else:
                    answers[i] = answer
            self._keep(calls)
        failure = f"{self._settings.model} gave no valid answer in {1 + ASKED_AGAIN} attempts"
        return [
            answers.get(i, NoAnswer(f"{failure} (prompt {prompts[i].version})", "invalid-answer")) for i in range(len(prompts))
        ]

    def _replies(self, requests: Sequence[Request], asked: int) -> list[tuple[Reply | NoAnswer, Call]]:
        """Recorded replies, and those of one batch for the rest; rows lack the outcome, those of failures are noted."""
        rows = [self._row(request, asked) for request in requests]
        kept = [self._records.find(request) if self._settings.model else None for request in requests]
        missing = [i for i, reply in enumerate(kept) if reply is None]
        made = dict(zip(missing, self._batch([requests[i] for i in missing], [rows[i] for i in missing]), strict=True))
        return [made[i] if reply is None else (reply, _replayed(rows[i], reply)) for i, reply in enumerate(kept)]

    def _batch(self, requests: Sequence[Request], rows: Sequence[Call]) -> list[tuple[Reply | NoAnswer, Call]]:
        if not requests:
            return []
        most = [self._set_aside(request, DISCOUNT) for request in requests]
        began = time.perf_counter()
        with self._noting_a_break(rows):
            replies = self._backend().replies(requests)
        latency = (time.perf_counter() - began) / len(requests)  # a share each: sums over calls are the time that passed
        return [
            (reply, self._ended(request, row, usd, reply, latency, DISCOUNT))
            for request, row, usd, reply in zip(requests, rows, most, replies, strict=True)
        ]

    def _call(self, request: Request, row: Call) -> tuple[Reply, Call]:
        most = self._set_aside(request)
        began = time.perf_counter()
        try:
            with self._noting_a_break([row]):
                reply = self._backend().reply(request)
        except NoAnswer as failure:
            self._ended(request, row, most, failure, time.perf_counter() - began)
            raise
        return reply, self._ended(request, row, most, reply, time.perf_counter() - began)

    @contextmanager
    def _noting_a_break(self, rows: Sequence[Call]) -> Iterator[None]:
        """Calls that somebody breaks off are rows, too: they are under way, and may be billed.

        Ctrl-C is a KeyboardInterrupt, and any signal that our command line heeds a SystemExit.
        """
        try:
            yield
        except (KeyboardInterrupt, SystemExit):
            for row in rows:
                self.ledger.add(replace(row, outcome="interrupted"))
            raise

    def _set_aside(self, request: Request, share: float = 1.0) -> float | None:
        """What a call could cost at most, at this share of its usual price; it is set aside now."""
        most = self._price(request, input_tokens(request, type(self._backend())), request.max_tokens, share)
        if self._settings.model:
            self.ledger.set_aside(most)
        return most

    def _ended(
        self, request: Request, row: Call, most: float | None, reply: Reply | NoAnswer, latency: float, share: float = 1.0
    ) -> Call:
        """The row of a call for which `most` was set aside, settled now; it lacks the outcome, but a failure's is noted."""
        if isinstance(reply, NoAnswer):
            paid = None if reply.lost else 0.0
            self.ledger.settle(most, paid, max(reply.lost - 1, 0))
            self.ledger.add(replace(row, outcome=reply.reason, latency=latency, cost=_dollars(paid)))
            return row
        cost = self._price(request, reply.input_tokens, reply.output_tokens, share)
        self.ledger.settle(most, cost, reply.lost)
        entry = replace(row, latency=latency, retries=reply.retries, cost=_dollars(None if reply.lost else cost))
        return replace(entry, input_tokens=reply.input_tokens, output_tokens=reply.output_tokens)

    def _price(self, request: Request, tokens_in: int | None, tokens_out: int | None, share: float) -> float | None:
        usd = price(request.model, self._backend().vendor(self._settings.base_url), tokens_in, tokens_out)
        return None if usd is None else usd * share

    def _backend(self) -> Backend:
        if self._made is None:  # not before it is needed: a replay needs no key
            self._made = plugins.load("lm.backends", self._settings.backend)(self._settings)
        return self._made


def _dollars(usd: float | None) -> str:
    return UNKNOWN if usd is None else f"{usd:.6f}"


def _replayed(row: Call, kept: Reply) -> Call:
    return replace(row, replayed=True, cost=_dollars(0.0), input_tokens=kept.input_tokens, output_tokens=kept.output_tokens)
