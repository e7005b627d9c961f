"""Language models as the command line finds them: params.yaml, and `--lm` and `--max-usd` over it."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field
from typer import Option

from drivegen.cli._console import plain
from drivegen.core.settings import read_params
from drivegen.lm.model import LanguageModel
from drivegen.lm.prompt import Prompt
from drivegen.lm.records import Mode
from drivegen.lm.settings import RecordSettings, RoleSettings, overridden

Words = Annotated[
    str | None,
    Option("--lm", metavar="MODEL", help="openai:MODEL, openai:MODEL@BASE_URL (any server), anthropic:MODEL or offline."),
]
"""The option `--lm`."""

MaxUsd = Annotated[
    float | None, Option("--max-usd", min=0.0, help="Stop before the language model costs more dollars than this.")
]
"""The option `--max-usd`."""


def role(name: str, words: str | None, max_usd: float | None) -> RoleSettings:
    """A role's settings from params.yaml, with what the options change."""
    settings = read_params(f"lm.{name}", RoleSettings)
    if words is not None:
        settings = overridden(settings, words)
    return settings if max_usd is None else replace(settings, max_usd=max_usd)


def model(name: str, words: str | None, max_usd: float | None) -> LanguageModel:
    """A role's language model. Who names one with `--lm` wants it called: what is not recorded is asked for, and kept."""
    records = read_params("lm.records", RecordSettings)
    if words is not None and records.mode == Mode.REPLAY:
        records = replace(records, mode=Mode.AUTO)
    return LanguageModel(name, role(name, words, max_usd), records.open())


@contextmanager
def calling(command: str, name: str, words: str | None, max_usd: float | None) -> Iterator[LanguageModel]:
    """A role's language model for one command; its calls are rows of a table of their own, also where the command fails."""
    client = model(name, words, max_usd)
    with client.ledger.kept(command):
        yield client


def announce(client: LanguageModel, questions: Sequence[Prompt[Any]], answer_tokens: int, repairs: int) -> None:
    """One line on stderr before the first call: calls, tokens and dollars of the questions known, and where the run stops."""
    estimate = client.forecast(questions, answer_tokens, repairs=repairs)
    plain(stderr=True).print(f"estimate    {estimate}")


class Two(BaseModel):
    """The answer to one and one."""

    sum: Annotated[Literal[2], Field(description="The sum.")]


def tiny_call(settings: RoleSettings) -> str:
    """Ask the model of a role for one and one, past all records; returns what it took. Raises DriveGenError."""
    client = LanguageModel("doctor", settings, RecordSettings(Mode.OFF, "").open())
    with client.ledger.kept("doctor"):
        client.ask(Prompt("doctor-1", "Answer the question.", ("What is 1 + 1?",), Two))
    calls = client.ledger.calls
    tokens = sum((call.input_tokens or 0) + (call.output_tokens or 0) for call in calls)
    again = f" when asked {len(calls)} times" if len(calls) > 1 else ""
    return f"answers{again}: {calls[-1].latency:.1f} s, {tokens} tokens, cost {calls[-1].cost}"
